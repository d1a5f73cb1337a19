//! Volume of a cavity.

use super::{Quantity, States};
use sinew_energy::Cavity;
use sinew_mesh::{TriangleMesh, boundary_facets};
use sinew_num::{cross, dot3};

/// The space under the surface of a cavity and the cone over its rim to the mean of the rim's nodes, which moves with them.
#[derive(Debug)]
pub(crate) struct CavityVolume {
    state: usize,
    /// Places of the nodes in the image.
    image: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    rim: Vec<usize>,
}

impl CavityVolume {
    pub(crate) fn new(cavity: &Cavity, image: &[[f64; 3]], state: usize) -> Self {
        let triangles = cavity.triangles.clone();
        let surface = TriangleMesh { cells: triangles.clone(), ..TriangleMesh::default() };
        let rim = surface.nodes_of_facets(&boundary_facets(&surface));
        Self { state, image: image.to_vec(), triangles, rim }
    }

    /// Corners of a triangle from the lid's apex.
    fn corners(&self, moved: &[f64], apex: [f64; 3], triangle: &[usize; 3]) -> [[f64; 3]; 3] {
        triangle.map(|node| {
            let place = self.place(moved, node);
            std::array::from_fn(|i| place[i] - apex[i])
        })
    }

    fn place(&self, moved: &[f64], node: usize) -> [f64; 3] {
        std::array::from_fn(|i| self.image[node][i] + moved[3 * node + i])
    }

    fn apex(&self, moved: &[f64]) -> [f64; 3] {
        let count = self.rim.len().max(1) as f64;
        self.rim.iter().fold([0.0; 3], |sum, &node| {
            let place = self.place(moved, node);
            std::array::from_fn(|i| sum[i] + place[i] / count)
        })
    }

    /// The volume with the sign of the triangles' order.
    fn signed(&self, moved: &[f64]) -> f64 {
        let apex = self.apex(moved);
        let six = |triangle: &[usize; 3]| {
            let [a, b, c] = self.corners(moved, apex, triangle);
            dot3(&a, &cross(&b, &c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }
}

impl Quantity for CavityVolume {
    fn value(&self, states: &States) -> f64 {
        self.signed(&states[self.state]).abs()
    }

    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)> {
        let moved = &states[self.state];
        let (apex, sign) = (self.apex(moved), self.signed(moved).signum());
        let (mut gradient, mut whole) = (vec![0.0; moved.len()], [0.0; 3]);
        for triangle in &self.triangles {
            let [a, b, c] = self.corners(moved, apex, triangle);
            let opposite = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
            for (node, area) in triangle.iter().zip(opposite) {
                for i in 0..3 {
                    gradient[3 * node + i] += sign * area[i] / 6.0;
                    whole[i] += sign * area[i] / 6.0;
                }
            }
        }
        // The apex moves with the rim, and the volume against it.
        let count = self.rim.len().max(1) as f64;
        for &node in &self.rim {
            (0..3).for_each(|i| gradient[3 * node + i] -= whole[i] / count);
        }
        vec![(self.state, gradient)]
    }
}

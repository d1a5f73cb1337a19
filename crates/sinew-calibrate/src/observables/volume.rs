//! Volume of a cavity.

use super::{Quantity, States};
use sinew_energy::Cavity;
use sinew_energy::metrics::{deformed_volume, deformed_volume_gradient};
use sinew_mesh::{TriangleMesh, boundary_facets};
use sinew_num::add3;

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

    fn apex(&self, moved: &[f64]) -> [f64; 3] {
        let count = self.rim.len().max(1) as f64;
        self.rim.iter().fold([0.0; 3], |sum, &node| {
            std::array::from_fn(|i| sum[i] + (self.image[node][i] + moved[3 * node + i]) / count)
        })
    }

    /// The volume with the sign of the triangles' order.
    fn signed(&self, moved: &[f64]) -> f64 {
        deformed_volume(&self.image, moved, &self.triangles, self.apex(moved))
    }
}

impl Quantity for CavityVolume {
    fn value(&self, states: &States) -> f64 {
        self.signed(&states[self.state]).abs()
    }

    fn gradients(&self, states: &States) -> Vec<(usize, Vec<f64>)> {
        let moved = &states[self.state];
        let (apex, sign) = (self.apex(moved), self.signed(moved).signum());
        let mut gradient = deformed_volume_gradient(&self.image, moved, &self.triangles, apex);
        gradient.iter_mut().for_each(|slope| *slope *= sign);
        let nodes = gradient.as_chunks::<3>().0.iter();
        let whole = nodes.fold([0.0; 3], |sum, slope| add3(&sum, slope));
        // The apex moves with the rim, and the volume against it.
        let count = self.rim.len().max(1) as f64;
        for &node in &self.rim {
            (0..3).for_each(|i| gradient[3 * node + i] -= whole[i] / count);
        }
        vec![(self.state, gradient)]
    }
}

//! Cavities that pressures act in.

use crate::Body;
use sinew_mesh::{TriangleMesh, boundary_facets};
use sinew_num::{Mat3, cross};

/// The space behind a surface that a pressure acts on, such as the chamber of a ventricle, closed by the cone
/// over its rim to an apex in the middle of the rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Cavity {
    /// The facet set.
    pub name: String,
    /// Triangles that cover the surface, counterclockwise seen from outside the solid.
    pub triangles: Vec<[usize; 3]>,
    /// Point where the lid meets \[length\].
    pub apex: [f64; 3],
}

impl Cavity {
    /// Makes a cavity from the nodes of facets, corners first.
    pub(crate) fn new(
        name: &str,
        facets: &[Vec<usize>],
        corners: usize,
        points: &[[f64; 3]],
    ) -> Self {
        let fan = |nodes: &Vec<usize>| -> Vec<[usize; 3]> {
            (1..corners - 1).map(|k| [nodes[0], nodes[k], nodes[k + 1]]).collect()
        };
        let triangles: Vec<_> = facets.iter().flat_map(fan).collect();
        Self { name: name.into(), triangles, apex: [0.0; 3] }.among(points)
    }

    /// Cavity of the same surface with its nodes at other positions.
    pub(crate) fn among(&self, points: &[[f64; 3]]) -> Self {
        let Self { name, triangles, .. } = self.clone();
        let surface = TriangleMesh { cells: triangles.clone(), ..TriangleMesh::default() };
        let rim = surface.nodes_of_facets(&boundary_facets(&surface));
        let count = rim.len().max(1) as f64;
        let apex =
            std::array::from_fn(|i| rim.iter().map(|&node| points[node][i]).sum::<f64>() / count);
        Self { name, triangles, apex }
    }
}

impl Body {
    /// Volumes of the cavities at a displacement \[length³\].
    pub fn cavity_volumes(&self, displacement: &[f64]) -> Vec<f64> {
        let volume = |Cavity { triangles, apex, .. }: &Cavity| {
            deformed_volume(&self.positions, displacement, triangles, *apex).abs()
        };
        self.cavities.iter().map(volume).collect()
    }

    /// Derivatives of [`Body::cavity_volumes`], for each cavity as long as the displacement \[length²\]: what an objective in the
    /// volume of a chamber needs, and the right-hand side of its adjoint.
    ///
    /// ```
    /// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_mesh::TruncatedEllipsoid;
    ///
    /// let wall = TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra();
    /// let body = Scene::new(wall, NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(1.0) })
    ///     .support(Support::clamped("base"))
    ///     .lower()?;
    /// // Scaled about the lid's apex a volume grows with the third power, so its slope is three times the volume.
    /// let apex = body.cavities[0].apex;
    /// let apart = body.positions.iter().flat_map(|x| [0, 1, 2].map(|i| x[i] - apex[i]));
    /// let rest = vec![0.0; 3 * body.nodes];
    /// let slope: f64 = body.cavity_volume_gradients(&rest)[0].iter().zip(apart).map(|(g, u)| g * u).sum();
    /// assert!((slope / body.cavity_volumes(&rest)[0] - 3.0).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    pub fn cavity_volume_gradients(&self, displacement: &[f64]) -> Vec<Vec<f64>> {
        let gradient = |Cavity { triangles, apex, .. }: &Cavity| {
            // The volume is the absolute value of one with a sign.
            let volume = deformed_volume(&self.positions, displacement, triangles, *apex);
            let slopes = deformed_volume_gradient(&self.positions, displacement, triangles, *apex);
            slopes.iter().map(|slope| volume.signum() * slope).collect()
        };
        self.cavities.iter().map(gradient).collect()
    }
}

/// Volume \[length³\] between a deformed surface and the cone over its rim with the given apex.
///
/// `facets` are counterclockwise seen from outside the volume. The surface of a ventricle's cavity is
/// listed from outside the solid, which is inside the cavity: take the absolute value. With the apex in
/// the plane of a flat rim, this is the volume under the lid.
pub fn deformed_volume(
    points: &[[f64; 3]],
    displacement: &[f64],
    facets: &[[usize; 3]],
    apex: [f64; 3],
) -> f64 {
    let six_volumes = |nodes: &[usize; 3]| {
        Mat3(nodes.map(|node| from_apex(points, displacement, node, apex))).determinant()
    };
    facets.iter().map(six_volumes).sum::<f64>() / 6.0
}

/// Derivative of [`deformed_volume`] in the displacement at a fixed apex \[length²\].
pub fn deformed_volume_gradient(
    points: &[[f64; 3]],
    displacement: &[f64],
    facets: &[[usize; 3]],
    apex: [f64; 3],
) -> Vec<f64> {
    let mut gradient = vec![0.0; displacement.len()];
    for nodes in facets {
        let [a, b, c] = nodes.map(|node| from_apex(points, displacement, node, apex));
        for (node, area) in nodes.iter().zip([cross(&b, &c), cross(&c, &a), cross(&a, &b)]) {
            (0..3).for_each(|i| gradient[3 * node + i] += area[i] / 6.0);
        }
    }
    gradient
}

fn from_apex(points: &[[f64; 3]], u: &[f64], node: usize, apex: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| points[node][i] + u[3 * node + i] - apex[i])
}

#[cfg(test)]
mod tests {
    use crate::laws::NeoHookean;
    use crate::{Load, Magnitude, Parameter, Scene, Support};
    use sinew_mesh::{Biventricle, Mesh};

    /// Truncation of central differences of a cubic with steps of 1e-4 in a body of some 60, and their rounding.
    const DIFFERENCE: f64 = 1e-6;

    fn check<const N: usize>(mesh: Mesh<N>, sets: &[&str])
    where
        crate::Nodes<N>: crate::FiniteElement<N>,
    {
        let mut scene = Scene::new(mesh, NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
            .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
            .support(Support::clamped("base"));
        for facets in sets {
            let (facets, magnitude) = ((*facets).into(), Magnitude::Fixed(1.0));
            scene = scene.load(Load::Pressure { facets, magnitude });
        }
        let body = scene.lower().unwrap();
        let wave = |k: usize, step: f64| {
            (0..3 * body.nodes).map(|i| step * ((k * i + 1) as f64).sin()).collect::<Vec<_>>()
        };
        let (u, along) = (wave(1, 0.3), wave(3, 1.0));
        let gradients = body.cavity_volume_gradients(&u);
        let moved = |step: f64| {
            body.cavity_volumes(
                &u.iter().zip(&along).map(|(u, v)| u + step * v).collect::<Vec<_>>(),
            )
        };
        let (before, after) = (moved(-1e-4), moved(1e-4));
        assert_eq!(gradients.len(), sets.len());
        for (index, gradient) in gradients.iter().enumerate() {
            let slope = (after[index] - before[index]) / 2e-4;
            let exact: f64 = gradient.iter().zip(&along).map(|(g, v)| g * v).sum();
            assert!((slope - exact).abs() < DIFFERENCE * exact.abs(), "{slope} is not {exact}");
        }
    }

    #[test]
    fn gradients_of_volumes_are_their_derivatives() {
        let heart = Biventricle { radius: 20.0, depth: 50.0, wall: 10.0, septum: 10.0 };
        check(heart.tetrahedra(5.5), &["endo_left", "endo_right"]);
        let wall = sinew_mesh::TruncatedEllipsoid::LAND.wall([1, 16, 8]);
        check(wall.hexahedra(), &["endo"]);
        check(wall.quadratic_tetrahedra(), &["endo"]);
    }
}

//! Cavities that pressures act in.

mod closing;
mod pressed_lid;

pub use closing::{CavityPart, Lid, SymmetryPlane};
pub(crate) use closing::{FLAT, Surroundings, sorted};
pub use pressed_lid::PressedLid;

use crate::Body;
use crate::frames::Held;
use closing::{Add, At, moved, projected};
use sinew_mesh::extents;
use sinew_num::{Mat3, connected_cells};

/// The space behind a surface that a pressure acts on, such as the chamber of a ventricle.
///
/// Each rim, a connected loop of boundary edges, has a lid: the cone over it to the mean of the deformed rim, weighted by the lengths
/// of its edges. A rigid motion does not change the volume. Where a rim runs along symmetry planes, in which supports let nodes slide,
/// the planes close the surface, and a lid covers the rest of the rim as if it went on behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Cavity {
    /// The facet set.
    pub name: String,
    /// Connected surfaces of the set.
    pub parts: Vec<CavityPart>,
    /// Sign of the triangles' order: the volume is positive at rest. That of a surface flat at rest grows with a pressure on it.
    pub sign: f64,
}

/// Volume of a surface flat at rest [relative to its size squared times the mesh's], by the digits of files.
const NO_VOLUME: f64 = 1e-6;

impl Cavity {
    /// Makes a cavity from facets of K nodes; `None` where symmetry planes leave the volume undetermined.
    pub(crate) fn new<const K: usize>(
        name: &str,
        facets: &[[usize; K]],
        around: &Surroundings<'_>,
    ) -> Option<Self> {
        let parts = connected_cells(around.points.len(), facets).into_iter();
        let parts = parts.map(|own| CavityPart::new(&own, around)).collect::<Option<_>>()?;
        let mut cavity = Self { name: name.into(), parts, sign: -1.0 };
        let volume = cavity.measure(&|node| around.points[node], &mut |_, _| {});
        let largest = |points: &[[f64; 3]]| extents(points).into_iter().fold(0.0, f64::max);
        let own: Vec<_> = facets.as_flattened().iter().map(|&node| around.points[node]).collect();
        if volume.abs() > NO_VOLUME * largest(around.points) * largest(&own).powi(2) {
            cavity.sign = volume.signum();
        }
        Some(cavity)
    }

    /// Volume at a displacement from the positions of all nodes \[length³\]; negative where the surface has passed through itself.
    pub fn volume(&self, positions: &[[f64; 3]], displacement: &[f64]) -> f64 {
        self.sign * self.measure(&moved(positions, displacement), &mut |_, _| {})
    }

    /// Derivative of [`Cavity::volume`] in the displacement \[length²\].
    pub fn volume_gradient(&self, positions: &[[f64; 3]], displacement: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; displacement.len()];
        self.measure(&moved(positions, displacement), &mut |node, slope| {
            (0..3).for_each(|i| gradient[3 * node + i] += self.sign * slope[i]);
        });
        gradient
    }

    /// Origins of the volumes, at the nodes of their surfaces' corners, and the lids; `None` where symmetry planes move or are parallel.
    pub(crate) fn pressed(
        &self,
        points: &[[f64; 3]],
        held: &Held,
    ) -> Option<(Vec<[f64; 3]>, Vec<PressedLid>)> {
        let (mut origins, mut lids) = (points.to_vec(), Vec::new());
        let at = |node: usize| points[node];
        for part in &self.parts {
            let planes = part.planes.iter().chain(part.lids.iter().flat_map(|lid| &lid.planes));
            let mut resting = planes.map(|p| held.along(p.node, &p.normal));
            let is_whole = part.field == Mat3::from_fn(|i, j| Mat3::IDENTITY[i][j] / 3.0);
            if !is_whole || !resting.all(|moved| moved == Some(0.0)) {
                return None;
            }
            let origin = projected(&part.planes, at(part.triangles[0][0]), &at);
            part.triangles.as_flattened().iter().for_each(|&node| origins[node] = origin);
            lids.extend(part.lids.iter().map(|lid| PressedLid::new(lid, points, &origin)));
        }
        Some((origins, lids))
    }

    /// Volume with the sign of the triangles' order; its derivatives are added node by node.
    fn measure(&self, at: &At<'_>, add: &mut Add<'_>) -> f64 {
        self.parts.iter().map(|part| part.measure(at, add).0).sum()
    }
}

impl Body {
    /// Volumes of the cavities at a displacement \[length³\].
    pub fn cavity_volumes(&self, displacement: &[f64]) -> Vec<f64> {
        self.cavities.iter().map(|c| c.volume(&self.positions, displacement)).collect()
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
    /// // Scaled about any point a volume grows with the third power, so its slope is three times the volume.
    /// let rest = vec![0.0; 3 * body.nodes];
    /// let gradient = &body.cavity_volume_gradients(&rest)[0];
    /// let slope: f64 = gradient.iter().zip(body.positions.as_flattened()).map(|(g, x)| g * (x + 7.0)).sum();
    /// assert!((slope / body.cavity_volumes(&rest)[0] - 3.0).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    pub fn cavity_volume_gradients(&self, displacement: &[f64]) -> Vec<Vec<f64>> {
        self.cavities.iter().map(|c| c.volume_gradient(&self.positions, displacement)).collect()
    }
}

//! Fibres in closed form between two ellipsoids.

use super::CaseError;
use super::mesh::MeshSource;
use super::source::{Exactly, Source};
use serde::Deserialize;
use sinew_energy::Scene;
use sinew_energy::laws::NamedLaw;
use sinew_fem::fibres::{EllipsoidWall, FibreError, FibreRule};

/// Fibres that turn linearly with the depth in the wall of `mesh.ellipsoid`, at every quadrature point: those of
/// problem 3 of Land et al. (2015).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidRule {
    /// Angles to the circumferential direction at the inner and outer surface, positive towards the base \[degrees\].
    pub angles: Exactly<f64, 2>,
    /// Angles of the sheets to the outward direction \[degrees\].
    pub sheet_angles: Option<Exactly<f64, 2>>,
}

/// Depth of a point beyond the surfaces that counts as in the wall \[relative to its thickness\]: flat cells cut the corner of
/// curved ones.
const SLACK: f64 = 0.2;

impl EllipsoidRule {
    /// Directions, as many as the law reads, at each quadrature point of a scene.
    pub(super) fn directions(
        &self,
        law: &NamedLaw,
        made: &MeshSource,
        scene: &Scene,
        source: &Source,
    ) -> Result<Vec<[f64; 3]>, CaseError> {
        let error = |reason: String| source.error(&["fibres", "ellipsoid"], reason);
        let Some(shape) = made.ellipsoid else {
            let reason =
                "it needs the wall of mesh.ellipsoid; give a `field` or a `rule` for other meshes";
            return Err(error(reason.into()));
        };
        let shape = shape.shape(made.scale(source)?);
        let laid = || -> Result<Vec<[f64; 3]>, FibreError> {
            let (wall, mut directions) = (EllipsoidWall::new(shape)?, Vec::new());
            let rule = turning(self.angles, self.sheet_angles)?;
            for point in scene.quadrature_points() {
                directions.extend_from_slice(&wall.frame(point, &rule, SLACK)?[..law.directions]);
            }
            Ok(directions)
        };
        laid().map_err(|why| error(why.to_string()))
    }
}

/// Angles of fibres, and of sheets if they are given.
pub(super) fn turning(
    Exactly([inner, outer]): Exactly<f64, 2>,
    sheets: Option<Exactly<f64, 2>>,
) -> Result<FibreRule, FibreError> {
    let [first, last] = sheets.map_or([0.0; 2], |angles| angles.0);
    FibreRule::new(inner, outer)?.with_sheets(first, last)
}

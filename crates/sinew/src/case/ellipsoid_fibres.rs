//! Fibres in closed form between two ellipsoids.

use super::CaseError;
use super::laws::Row;
use super::mesh::MeshSource;
use super::source::{Source, exactly};
use serde::Deserialize;
use sinew_energy::Scene;
use sinew_fem::fibres::{EllipsoidWall, FibreRule};

/// Fibres that turn linearly with the depth in the wall of `mesh.ellipsoid`, at every quadrature point: those of
/// problem 3 of Land et al. (2015).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidRule {
    /// Angles to the circumferential direction at the inner and outer surface, positive towards the base \[degrees\].
    #[serde(deserialize_with = "exactly")]
    pub angles: [f64; 2],
    /// Angles of the sheets to the outward direction \[degrees\].
    #[serde(default)]
    #[serde(deserialize_with = "exactly")]
    pub sheet_angles: [f64; 2],
}

/// Depth of a point beyond the surfaces that counts as in the wall \[relative to its thickness\]: flat cells cut the corner of
/// curved ones.
const SLACK: f64 = 0.2;

impl EllipsoidRule {
    /// Directions, as many as the law reads, at each quadrature point of a scene.
    pub(super) fn directions(
        &self,
        law: &Row,
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
        let wall = EllipsoidWall::new(shape.shape(made.scale(source)?));
        let wall = wall.map_err(|why| error(why.to_string()))?;
        let [inner, outer] = self.angles;
        let rule = FibreRule::new(inner, outer)
            .and_then(|rule| rule.with_sheets(self.sheet_angles[0], self.sheet_angles[1]))
            .map_err(|why| error(why.to_string()))?;
        let mut directions = Vec::new();
        for point in scene.quadrature_points() {
            let frame = wall.frame(point, &rule, SLACK).map_err(|why| error(why.to_string()))?;
            directions.extend_from_slice(&frame[..law.directions]);
        }
        Ok(directions)
    }
}

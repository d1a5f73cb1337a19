//! Fibres by rule: in the wall of a ventricle, and in closed form between two ellipsoids.

use super::fibres::write;
use super::mesh::MeshSource;
use super::source::{Exactly, Result, Source};
use serde::Deserialize;
use sinew_energy::Scene;
use sinew_energy::laws::NamedLaw;
use sinew_fem::fibres::{
    EllipsoidWall, FibreError, FibreRule as Angles, Surfaces, VentricleCoordinates,
};
use sinew_mesh::AnyMesh;
use std::borrow::Cow;

/// Fibres that turn linearly through the wall of a ventricle.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FibreRule {
    /// Facet set of the inner surface.
    pub endocardium: String,
    /// Facet set of the outer surface.
    pub epicardium: String,
    /// Facet set of the base.
    pub base: String,
    /// Angles to the circumferential direction at the inner and outer surface, positive towards the base \[degrees\].
    pub angles: Exactly<f64, 2>,
    /// Angles of the sheets to the outward direction \[degrees\].
    pub sheet_angles: Option<Exactly<f64, 2>>,
}

/// Largest angle between fibres of two nodes of a cell \[degrees\]: beyond a right angle interpolation turns the other way.
const CLEAR: f64 = 85.0;

impl FibreRule {
    /// Writes fibres, sheets and normals into the cells, or nodes, of a solid mesh with the rule's facet sets.
    ///
    /// # Errors
    /// Why no fibres can be laid, in words.
    pub(crate) fn lay(&self, mesh: &mut AnyMesh) -> Result<(), String> {
        write(&self.frames(mesh)?, mesh);
        Ok(())
    }

    /// Fibre, sheet and normal at each node of a tetrahedral mesh.
    ///
    /// # Errors
    /// Why no fibres can be laid, in words.
    pub fn at_nodes(&self, mesh: &AnyMesh) -> Result<Vec<[[f64; 3]; 3]>, String> {
        let (wall, rule) = self.wall(mesh)?;
        Ok(wall.node_frames(&rule))
    }

    /// Frames of cells; of nodes of hexahedra, whose quadrature points interpolate them, zero on the axis: any direction there would follow the
    /// numbering of the mesh.
    pub(super) fn frames(&self, mesh: &AnyMesh) -> Result<Vec<[[f64; 3]; 3]>, String> {
        let (wall, rule) = self.wall(mesh)?;
        let AnyMesh::Hexahedra(hexahedra) = mesh else {
            return Ok(wall.cell_frames(&rule));
        };
        let turns = (self.angles.0[1] - self.angles.0[0]).abs();
        let turn = |nodes: &[usize; 8]| {
            let depths = nodes.map(|node| wall.thickness[node]);
            turns
                * (depths.into_iter().fold(0.0, f64::max) - depths.into_iter().fold(1.0, f64::min))
        };
        match hexahedra.cells.iter().map(turn).fold(0.0, f64::max) {
            most if most > CLEAR => Err(format!(
                "the fibres turn by {most:.0}° in a hexahedron, more than the {CLEAR}° that can be interpolated; take more layers of cells across the \
                 wall, or tetrahedra"
            )),
            _ => {
                let mut frames = wall.node_frames(&rule);
                wall.axis.iter().for_each(|&node| frames[node] = Default::default());
                Ok(frames)
            }
        }
    }

    fn wall(&self, mesh: &AnyMesh) -> Result<(VentricleCoordinates, Angles), String> {
        let mesh = &match mesh {
            AnyMesh::Tetrahedra(mesh) => Cow::Borrowed(mesh),
            AnyMesh::Hexahedra(mesh) => Cow::Owned(mesh.overlapping_tetrahedra()),
            AnyMesh::QuadraticTetrahedra(mesh) => Cow::Owned(mesh.linear()),
            other => return Err(format!("the rule needs a solid, not {}", other.element().plural)),
        };
        let Self { endocardium, epicardium, base, angles, sheet_angles } = self;
        let surfaces = Surfaces { endocardium, epicardium, base };
        let rule = turning(*angles, *sheet_angles);
        let wall = rule.and_then(|rule| Ok((VentricleCoordinates::new(mesh, &surfaces)?, rule)));
        wall.map_err(|error| error.to_string())
    }
}

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
    ) -> Result<Vec<[f64; 3]>> {
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
) -> Result<Angles, FibreError> {
    let [first, last] = sheets.map_or([0.0; 2], |angles| angles.0);
    Angles::new(inner, outer)?.with_sheets(first, last)
}

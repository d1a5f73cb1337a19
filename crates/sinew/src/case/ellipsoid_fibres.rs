//! Fibres in closed form between two ellipsoids.

use super::CaseError;
use super::laws::Row;
use super::mesh::MeshSource;
use super::source::{Source, exactly};
use serde::Deserialize;
use sinew_energy::{FiniteElement, Nodes, QuadraturePoint};
use sinew_fem::fibres::{EllipsoidWall, FibreRule};
use sinew_mesh::{AnyMesh, Mesh};

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
    /// Directions, as many as the law reads, at each quadrature point of the rule that the body is integrated with, the fine one of
    /// mixed elements or the usual.
    pub(super) fn directions(
        &self,
        law: &Row,
        (made, mesh, fine): (&MeshSource, &AnyMesh, bool),
        source: &Source,
    ) -> Result<Vec<Vec<[f64; 3]>>, CaseError> {
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
        let frame = |point| {
            let frame = wall.frame(point, &rule, SLACK).map_err(|why| error(why.to_string()))?;
            Ok(frame[..law.directions].to_vec())
        };
        quadrature_points(mesh, fine).into_iter().map(frame).collect()
    }
}

/// Places of the quadrature points of a mesh, cell by cell.
fn quadrature_points(mesh: &AnyMesh, fine: bool) -> Vec<[f64; 3]> {
    match mesh {
        AnyMesh::Tetrahedra(mesh) => places(mesh, fine),
        AnyMesh::Triangles(mesh) => places(mesh, fine),
        AnyMesh::QuadraticTetrahedra(mesh) => places(mesh, fine),
        AnyMesh::QuadraticTriangles(mesh) => places(mesh, fine),
        AnyMesh::Hexahedra(mesh) => places(mesh, fine),
    }
}

fn places<const N: usize>(mesh: &Mesh<N>, fine: bool) -> Vec<[f64; 3]>
where
    Nodes<N>: FiniteElement<N>,
{
    let rule: &[QuadraturePoint] =
        if fine { Nodes::<N>::FINE_QUADRATURE } else { Nodes::<N>::QUADRATURE };
    let shapes: Vec<[f64; N]> = rule.iter().map(|point| Nodes::<N>::shape(point.at)).collect();
    let place = |cell: &[usize; N], shape: &[f64; N]| -> [f64; 3] {
        std::array::from_fn(|i| {
            cell.iter().zip(shape).map(|(&node, n)| n * mesh.points[node][i]).sum()
        })
    };
    mesh.cells.iter().flat_map(|cell| shapes.iter().map(|shape| place(cell, shape))).collect()
}

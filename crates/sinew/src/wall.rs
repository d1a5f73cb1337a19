//! A ventricle's wall with fibres, under the names that the built-in ventricle knows.

use crate::case::{Exactly, FibreRule};
use sinew_mesh::{AnyMesh, ChamberWall, Field};

/// The mesh of a wall between surfaces, with fibres by rule (angles to the circumference at the inner and outer surface
/// \[degrees\]) in the field `fibre`, and the names of the scene LeftVentricle: `region:1` for the endocardium, `clamped` for the base.
///
/// Tetrahedra hold fibres per cell, hexahedra per node.
///
/// # Errors
/// Why there are no fibres or no hexahedra, in words.
pub fn ventricle(wall: &ChamberWall, hexahedra: bool, angles: [f64; 2]) -> Result<AnyMesh, String> {
    let rule = FibreRule {
        endocardium: "endocardium".into(),
        epicardium: "epicardium".into(),
        base: "base".into(),
        angles: Exactly(angles),
        sheet_angles: None,
    };
    let mut mesh: AnyMesh = wall.tetrahedra().into();
    if hexahedra {
        let fibres: Vec<_> = rule.at_nodes(&mesh)?.iter().map(|frame| frame[0]).collect();
        mesh = wall.hexahedra().map_err(|error| error.to_string())?.into();
        mesh.point_fields_mut().insert("fibre".into(), Field::vectors(&fibres));
    } else {
        rule.lay(&mut mesh)?;
    }
    let mut held = vec![0; mesh.points().len()];
    mesh.node_sets()["base"].iter().for_each(|&node| held[node] = 1);
    mesh.point_fields_mut().insert("clamped".into(), Field::labels(held));
    let endocardium = mesh.facet_sets()["endocardium"].clone();
    mesh.facet_sets_mut().insert("region:1".into(), endocardium);
    Ok(mesh)
}

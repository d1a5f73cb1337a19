//! Sets in files that only know fields.
//!
//! How they are encoded stands on the crate's page, "Sets in VTK files".
//! The way there and back is exact for sets that ascend without repetition.

use crate::check::check_member;
use crate::{Facet, Field, Mesh, Refusal};
use std::collections::BTreeMap;

const NODE_SET: &str = "node_set:";
const CELL_SET: &str = "cell_set:";
const FACET_SET: &str = "facet_set:";

type Fields = BTreeMap<String, Field>;

/// The point and cell fields of a mesh with its sets among them.
pub(crate) fn fields_with_sets<const N: usize>(
    mesh: &Mesh<N>,
) -> Result<(Fields, Fields), Refusal> {
    let (mut points, mut cells) = (mesh.point_fields.clone(), mesh.cell_fields.clone());
    let names = points.keys().chain(cells.keys());
    names.into_iter().try_for_each(|name| check_name(name))?;
    for (name, members) in &mesh.node_sets {
        let field = marks(mesh.points.len(), members.iter().map(|&node| (node, 1)));
        points.insert(prefixed(NODE_SET, name)?, field);
    }
    for (name, members) in &mesh.cell_sets {
        let field = marks(mesh.cells.len(), members.iter().map(|&cell| (cell, 1)));
        cells.insert(prefixed(CELL_SET, name)?, field);
    }
    for (name, facets) in &mesh.facet_sets {
        let bits = facets.iter().map(|facet| (facet.cell, 1 << facet.opposite));
        cells.insert(prefixed(FACET_SET, name)?, marks(mesh.cells.len(), bits));
    }
    Ok((points, cells))
}

/// Turns the fields that encode sets into sets.
pub(crate) fn sets_from_fields<const N: usize>(mesh: &mut Mesh<N>) -> Result<(), Refusal> {
    for (name, marks) in take_marks(&mut mesh.point_fields, NODE_SET) {
        mesh.node_sets.insert(name, marked(&marks));
    }
    for (name, marks) in take_marks(&mut mesh.cell_fields, CELL_SET) {
        mesh.cell_sets.insert(name, marked(&marks));
    }
    let facets_of_cell = Mesh::<N>::ELEMENT.facets.len();
    for (name, marks) in take_marks(&mut mesh.cell_fields, FACET_SET) {
        let mut facets = Vec::new();
        for (cell, &bits) in marks.iter().enumerate() {
            if bits >> facets_of_cell != 0 {
                let index = 63 - bits.leading_zeros() as usize;
                check_member(&name, index, facets_of_cell)?;
            }
            let in_set = (0..facets_of_cell).filter(|local| bits >> local & 1 == 1);
            facets.extend(in_set.map(|opposite| Facet { cell, opposite }));
        }
        mesh.facet_sets.insert(name, facets);
    }
    Ok(())
}

fn marks(rows: usize, members: impl Iterator<Item = (usize, i64)>) -> Field {
    let mut marks = vec![0; rows];
    for (index, bit) in members {
        marks[index] |= bit;
    }
    Field::labels(marks)
}

fn marked(marks: &[i64]) -> Vec<usize> {
    (0..marks.len()).filter(|&index| marks[index] != 0).collect()
}

fn take_marks(fields: &mut Fields, prefix: &str) -> Vec<(String, Vec<i64>)> {
    let is_set =
        |name: &str, field: &Field| name.starts_with(prefix) && field.as_labels().is_some();
    let taken = fields.extract_if(.., |name, field| is_set(name, field));
    let labels = |field: &Field| field.as_labels().unwrap_or_default().to_vec();
    taken.map(|(name, field)| (name[prefix.len()..].to_string(), labels(&field))).collect()
}

fn prefixed(prefix: &str, name: &str) -> Result<String, Refusal> {
    check_name(name)?;
    Ok(format!("{prefix}{name}"))
}

fn check_name(name: &str) -> Result<(), Refusal> {
    let reserved = [NODE_SET, CELL_SET, FACET_SET].iter().any(|prefix| name.starts_with(prefix));
    let unusable = name.is_empty() || reserved || name.chars().any(char::is_control);
    if unusable { Err(Refusal::name(name)) } else { Ok(()) }
}

//! Supports.

use super::CaseError;
use super::source::{Source, advise, exactly_if_any};
use serde::Deserialize;
use sinew_energy::Prescribed;
use sinew_mesh::AnyMesh;

/// A support: `clamped = "SET"`, or `nodes = "SET"` with how they are held.
///
/// A set is a node set, the nodes of a facet set, or those where a point field is not zero.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Support {
    /// Nodes held in place.
    pub clamped: Option<String>,
    /// Nodes held as the other keys say.
    pub nodes: Option<String>,
    /// Prescribed displacement along x \[mm\]; free where it is left out.
    pub x: Option<f64>,
    /// The same along y.
    pub y: Option<f64>,
    /// The same along z.
    pub z: Option<f64>,
    /// Normal of the plane that the nodes stay in: rollers.
    #[serde(deserialize_with = "exactly_if_any")]
    pub normal: Option<[f64; 3]>,
    /// Direction of an axis that the nodes move radially from.
    #[serde(deserialize_with = "exactly_if_any")]
    pub axis: Option<[f64; 3]>,
    /// A point on the axis \[mm\].
    #[serde(deserialize_with = "exactly_if_any")]
    pub point: Option<[f64; 3]>,
}

impl Support {
    /// Support `number` of the case; its node set is added to the mesh if it has another form there.
    pub(super) fn lower(
        &self,
        number: usize,
        mesh: &mut AnyMesh,
        source: &Source,
    ) -> Result<sinew_energy::Support, CaseError> {
        let at = number.to_string();
        let Self { clamped, nodes, x, y, z, normal, axis, point } = self;
        let components = [*x, *y, *z];
        let (key, name, displacement) = match (clamped, nodes, normal, axis) {
            (Some(name), None, None, None) if components == [None; 3] => {
                ("clamped", name, Prescribed::Uniform([Some(0.0); 3]))
            }
            (None, Some(name), None, None) if components != [None; 3] => {
                ("nodes", name, Prescribed::Uniform(components))
            }
            (None, Some(name), Some(normal), None) if components == [None; 3] => {
                ("nodes", name, Prescribed::Along { direction: *normal, displacement: 0.0 })
            }
            (None, Some(name), None, Some(axis)) if components == [None; 3] => {
                let point = point.unwrap_or([0.0; 3]);
                ("nodes", name, Prescribed::Radial { point, axis: *axis })
            }
            _ => {
                let reason = "write clamped = \"SET\", or nodes = \"SET\" with one of: x, y, z (prescribed displacement, mm); \
                              normal (of the plane that they stay in); axis and point (they move radially from it)";
                return Err(source.error(&["supports", &at], reason.into()));
            }
        };
        add_node_set(mesh, name).map_err(|reason| source.error(&["supports", &at, key], reason))?;
        Ok(sinew_energy::Support { nodes: name.clone(), displacement })
    }
}

/// Makes sure that the mesh has a node set of this name: its own, the nodes of a facet set, or a point field's.
fn add_node_set(mesh: &mut AnyMesh, name: &str) -> Result<(), String> {
    if mesh.node_sets().get(name).is_some_and(|set| !set.is_empty()) {
        return Ok(());
    }
    let mut nodes: Vec<usize> = if let Some(facets) = mesh.facet_sets().get(name) {
        facets.iter().flat_map(|&facet| mesh.nodes_of_facet(facet)).collect()
    } else if let Some(field) = mesh.point_fields().get(name) {
        if field.components != 1 {
            return Err(format!(
                "the point field `{name}` has {} components; name one that marks nodes by one number",
                field.components
            ));
        }
        let marked = field.to_f64();
        (0..marked.len()).filter(|&node| marked[node] != 0.0).collect()
    } else {
        let sets = mesh.node_sets().keys().chain(mesh.facet_sets().keys());
        let known = sets.chain(mesh.point_fields().keys()).map(String::as_str);
        let advice = advise(name, known, "the mesh has");
        return Err(format!(
            "the mesh has neither node set, facet set nor point field `{name}`{advice}"
        ));
    };
    if nodes.is_empty() {
        return Err(format!("`{name}` marks no node"));
    }
    nodes.sort_unstable();
    nodes.dedup();
    mesh.node_sets_mut().insert(name.into(), nodes);
    Ok(())
}

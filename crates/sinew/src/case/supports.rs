//! Supports.

use super::mesh::by_place;
use super::source::{Exactly, Result, Source, advise};
use nalgebra::{Unit, Vector3};
use serde::Deserialize;
use sinew_energy::Prescribed;
use sinew_mesh::AnyMesh;
use sinew_num::ascending;
use std::collections::BTreeSet;

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
    /// Displacement along y \[mm\].
    pub y: Option<f64>,
    /// Displacement along z \[mm\].
    pub z: Option<f64>,
    /// Normal of the plane that the nodes stay in: rollers.
    pub normal: Option<Exactly<f64, 3>>,
    /// Direction of an axis that the nodes move radially from, or turn about.
    pub axis: Option<Exactly<f64, 3>>,
    /// A point on the axis \[mm\].
    pub point: Option<Exactly<f64, 3>>,
    /// Rotation about the axis.
    pub turn: Option<Rotation>,
}

/// Motion along the chord of a turn about an axis, counterclockwise when the axis points at the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Angle of the turn \[degrees\].
    pub degrees: f64,
    /// Share of the way from the reference position to the turned one; 1 is the turn itself.
    #[serde(default = "Rotation::whole")]
    pub share: f64,
}

/// Largest angle of rotation \[degrees\]. Beyond it, a smaller rotation in the other direction gives the same
/// displacements.
const HALF_TURN: f64 = 180.0;

impl Rotation {
    fn whole() -> f64 {
        1.0
    }

    /// The unit vector of its axis, or the key that makes it impossible and why.
    fn about(self, axis: [f64; 3]) -> Result<Unit<Vector3<f64>>, (&'static str, String)> {
        if self.degrees.abs() > HALF_TURN {
            let reason = format!(
                "a turn of {} degrees ends where a smaller one does, and displacements cannot tell them apart; give at most \
                 {HALF_TURN} either way",
                self.degrees
            );
            return Err(("turn", reason));
        }
        if !(0.0..=1.0).contains(&self.share) {
            return Err(("turn", format!("{} is no share of the way; give 0 to 1", self.share)));
        }
        let without = || ("axis", "an axis without length; give its direction".into());
        Unit::try_new(Vector3::from(axis), f64::MIN_POSITIVE).ok_or_else(without)
    }

    /// Displacement of a node at `x` \[mm\].
    fn displacement(self, x: [f64; 3], point: [f64; 3], axis: &Unit<Vector3<f64>>) -> Vector3<f64> {
        let arm = Vector3::from(x) - Vector3::from(point);
        let turned = nalgebra::Rotation3::from_axis_angle(axis, self.degrees.to_radians()) * arm;
        self.share * (turned - arm)
    }
}

impl Support {
    /// Support `number` of the case; its node set is added to the mesh if it has another form there.
    pub(super) fn lower(
        &self,
        number: usize,
        mesh: &mut AnyMesh,
        source: &Source,
    ) -> Result<sinew_energy::Support> {
        let at = number.to_string();
        let Self { clamped, nodes, x, y, z, normal, axis, point, turn } = self;
        let components = [*x, *y, *z];
        let free = components == [None; 3];
        let about = point.map_or([0.0; 3], |point| point.0);
        let held = match (clamped, normal, *axis, turn) {
            (Some(_), None, None, None) if free => Some(Prescribed::Uniform([Some(0.0); 3])),
            (None, None, None, None) if !free => Some(Prescribed::Uniform(components)),
            (None, &Some(Exactly(direction)), None, None) if free => {
                Some(Prescribed::Along { direction, displacement: 0.0 })
            }
            (None, None, Some(Exactly(axis)), None) if free => {
                Some(Prescribed::Radial { point: about, axis })
            }
            // Its displacements follow, once the set is known.
            (None, None, Some(_), Some(_)) if free => Some(Prescribed::PerNode(Vec::new())),
            _ => None,
        };
        let set = match (clamped, nodes) {
            (Some(name), None) => Some(("clamped", name)),
            (None, Some(name)) => Some(("nodes", name)),
            _ => None,
        };
        // A point is one of an axis.
        let held = held.filter(|_| point.is_none() || axis.is_some());
        let (Some((key, name)), Some(mut displacement)) = (set, held) else {
            let reason = "write clamped = \"SET\", or nodes = \"SET\" with one of: x, y, z (prescribed displacement, mm); \
                          normal (of the plane that they stay in); axis and point (they move radially from it); axis, \
                          point and turn (they turn about it)";
            return Err(source.error(&["supports", &at], reason.into()));
        };
        add_node_set(mesh, name)
            .or_else(|reason| add_nodes_of_cells(mesh, name).ok_or(reason))
            .map_err(|reason| source.error(&["supports", &at, key], reason))?;
        if let (Prescribed::PerNode(rows), Some(turn), Some(axis)) = (&mut displacement, turn, axis)
        {
            let axis = turn
                .about(axis.0)
                .map_err(|(key, reason)| source.error(&["supports", &at, key], reason))?;
            let points = mesh.points();
            let moved =
                |&node: &usize| turn.displacement(points[node], about, &axis).map(Some).into();
            *rows = mesh.node_sets()[name].iter().map(moved).collect();
        }
        Ok(sinew_energy::Support { nodes: name.clone(), displacement })
    }
}

/// Makes sure that the mesh has a node set of this name: its own, the nodes of a facet set, a point field's.
pub(super) fn add_node_set(mesh: &mut AnyMesh, name: &str) -> Result<(), String> {
    let has_facets = mesh.facet_sets().contains_key(name);
    if let Some(set) = mesh.node_sets().get(name).filter(|set| !set.is_empty() || !has_facets) {
        let empty = || format!("the set `{name}` is empty: its nodes belong to no cell");
        return if set.is_empty() { Err(empty()) } else { Ok(()) };
    }
    let nodes = if let Some(facets) = mesh.facet_sets().get(name) {
        ascending(facets.iter().flat_map(|&facet| mesh.nodes_of_facet(facet)))
    } else if mesh.point_fields().contains_key(name) {
        mesh.nodes_where_nonzero(name).map_err(|error| error.to_string())?
    } else {
        let sets = mesh.node_sets().keys().chain(mesh.facet_sets().keys());
        let known = sets.chain(mesh.point_fields().keys()).map(String::as_str);
        let advice = advise(name, known, "the mesh has");
        return Err(format!(
            "the mesh has neither node set, facet set nor point field `{name}`{advice}{}",
            by_place(mesh, name)
        ));
    };
    if nodes.is_empty() {
        return Err(format!("`{name}` marks no node"));
    }
    mesh.node_sets_mut().insert(name.into(), nodes);
    Ok(())
}

/// Refuses a name of sets of several kinds, if a member of one has no node in the first. Cells in front of a side, which Abaqus/CAE puts
/// into a set with its nodes, have some.
pub(super) fn check_one_kind(mesh: &AnyMesh, name: &str) -> Result<(), String> {
    let (element, nodes) = (mesh.element(), mesh.element().nodes.len());
    let corners = |&facet| mesh.nodes_of_facet(facet)[..element.facet_corners].to_vec();
    let facets = mesh.facet_sets().get(name).map(|set| set.iter().map(corners).collect());
    let corners = |cell: &usize| mesh.cells()[cell * nodes..][..element.corners].to_vec();
    // A label of cells may be one of facets too.
    let is_label = name.contains(':') || name.parse::<i64>().is_ok();
    let cells = mesh.cells_of(name).filter(|_| !is_label);
    let cells = cells.map(|set| set.iter().map(corners).collect());
    let own = mesh.node_sets().get(name).filter(|set| !set.is_empty());
    let own = own.map(|set| set.iter().map(|&node| vec![node]).collect());
    let kinds = [("nodes", own), ("facets", facets), ("cells", cells)];
    let kinds: Vec<(_, Vec<Vec<usize>>)> =
        kinds.into_iter().filter_map(|(kind, set)| Some((kind, set?))).collect();
    let [(first, all), others @ ..] = &kinds[..] else { return Ok(()) };
    let known: BTreeSet<usize> = all.iter().flatten().copied().collect();
    let is_apart = |member: &Vec<usize>| !member.iter().any(|node| known.contains(node));
    match others.iter().find(|(_, other)| other.iter().any(is_apart)) {
        None => Ok(()),
        Some((kind, other)) => Err(format!(
            "`{name}` is a set of {} {first} and one of {} {kind} elsewhere; give each a name of its own in the mesh file",
            all.len(),
            other.len()
        )),
    }
}

/// Makes a node set of a set or label of cells, if there is one.
fn add_nodes_of_cells(mesh: &mut AnyMesh, name: &str) -> Option<()> {
    let (cells, each) = (mesh.cells_of(name)?, mesh.element().nodes.len());
    let nodes = cells.iter().flat_map(|cell| &mesh.cells()[cell * each..][..each]);
    let nodes = ascending(nodes.copied());
    mesh.node_sets_mut().insert(name.into(), nodes);
    Some(())
}

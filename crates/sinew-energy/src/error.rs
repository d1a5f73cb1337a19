//! Errors in a scene or in θ, with numbers and advice.

use crate::law::POSITIVE;
use sinew_mesh::Defect;
use std::ops::RangeInclusive;
use thiserror::Error;

/// Names or numbers for people: `mu, lambda`.
pub fn listed<T: ToString>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

/// A scene that cannot be lowered to a potential.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SceneError {
    /// The mesh has no cell.
    #[error("the mesh has no cells; read or generate one that has")]
    EmptyMesh,
    /// The mesh violates a rule of [`sinew_mesh::Mesh::check`].
    #[error(transparent)]
    Mesh(#[from] Defect),
    /// A field of factors with missing or invalid values.
    #[error(
        "a field of factors has one finite number for each {place}, {count} in all, above zero for a stiffness and not below for other \
         parameters; {found} were given, and that of {place} {at} is missing or unfit"
    )]
    Factors { place: &'static str, count: usize, found: usize, at: usize },
    /// A tetrahedron without positive volume \[length³\].
    #[error(
        "cell {cell} has the volume {volume:?}, which must be positive; turn inverted cells (sinew_mesh::repair_orientation) \
         and remove flat ones"
    )]
    InvertedCell { cell: usize, volume: f64 },
    /// Two cells on the same side of a facet: one cell listed twice, or folded over its neighbour.
    #[error(
        "cells {} and {} lie on the same side of the facet with nodes {}; {}",
        cells[0], cells[1], listed(facet), overlap_advice(*twice)
    )]
    OverlappingCells { cells: [usize; 2], facet: Vec<usize>, twice: bool },
    /// A quadrature rule whose weights do not add up to the measure of the reference element.
    #[error(
        "the weights of the {points} quadrature points add up to {sum}; give positive ones that add up to {needed}, the measure \
         of the reference element"
    )]
    Quadrature { points: usize, sum: f64, needed: f64 },
    /// A support names a node set that the mesh lacks.
    #[error("there is no node set `{name}`; the mesh has {}", listed(known))]
    UnknownNodeSet { name: String, known: Vec<String> },
    /// A load names a facet set that the mesh lacks.
    #[error("there is no facet set `{name}`; the mesh has {}", listed(known))]
    UnknownFacetSet { name: String, known: Vec<String> },
    /// A load acts on a set without facets.
    #[error(
        "facet set `{name}` is empty, so its load acts on nothing; remove the load or name the facets"
    )]
    EmptyFacetSet { name: String },
    /// A facet, named by the vertex that it leaves out, that a set lists twice: its load would count twice.
    #[error(
        "facet set `{name}` lists the facet of cell {cell} opposite to its vertex {opposite} twice; list it once"
    )]
    RepeatedFacet { name: String, cell: usize, opposite: usize },
    /// A load on a facet, named by the vertex that it leaves out, between two cells.
    #[error(
        "facet set `{name}` names the facet of cell {cell} opposite to its vertex {opposite}, which lies inside the body; \
         loads act on its surface: leave inner facets out"
    )]
    InnerFacet { name: String, cell: usize, opposite: usize },
    /// The body is free along an axis.
    #[error(
        "no support holds the body along {axes}: it is free to move there and has no unique \
         equilibrium; add a support that holds it there"
    )]
    FreeToMove { axes: String },
    /// A node that belongs to no cell and that no support holds.
    #[error(
        "{count} nodes belong to no cell (first: node {first}) and are not held; remove them from the mesh"
    )]
    LooseNodes { count: usize, first: usize },
    /// Two supports prescribe different displacements.
    #[error(
        "supports prescribe both {first} and {second} for component {component} of node {node}; keep one"
    )]
    Contradiction { node: usize, component: usize, first: f64, second: f64 },
    /// Supports of a node that prescribe different displacements along one direction, a unit vector: `first` follows from the
    /// `others`.
    #[error(
        "the support of `{name}` prescribes {second} along ({}) for node {node}, but it is held at {first} \
         there by those of {}; take the node out of one of the sets, or let the supports agree",
        listed(direction),
        listed(others)
    )]
    Conflict {
        node: usize,
        name: String,
        others: Vec<String>,
        direction: [f64; 3],
        first: f64,
        second: f64,
    },
    /// A support along a direction that is zero or not finite.
    #[error(
        "the support of `{name}` has the direction ({}); give finite components, one of them not 0",
        listed(direction)
    )]
    SupportDirection { name: String, direction: [f64; 3] },
    /// A node on the axis of a radial support, at a distance \[length\].
    #[error(
        "node {node} of `{name}` is {distance:e} away from the axis of its radial support, so it has no radius to move \
         along; take it out of the set, and hold it with Support::clamped or Support::uniform"
    )]
    OnAxis { name: String, node: usize, distance: f64 },
    /// A list of prescribed displacements that does not fit its node set.
    #[error(
        "the support of node set `{name}` lists {given} displacements for {nodes} nodes; give one per node"
    )]
    SupportLength { name: String, given: usize, nodes: usize },
    /// A compliance of mixed elements that is negative or not finite.
    #[error("the compliance of the pressure field is {value}; give 1/κ, finite and at least 0")]
    Compliance { value: f64 },
    /// Nodal forces that do not fit the mesh.
    #[error("the load lists forces on {given} nodes, but the mesh has {nodes}; give one per node")]
    NodalForces { given: usize, nodes: usize },
    /// A material that does not fit the body.
    #[error(
        "the material has directions at {found} points and reads {needed} parameters, but the body has {points} quadrature points and \
         {given} parameters are given; let them agree"
    )]
    OtherMaterial { found: usize, points: usize, needed: usize, given: usize },
    /// A number of a load or a support that is not finite.
    #[error("{what} is {value}; give a finite number")]
    NotFinite { what: String, value: f64 },
    /// A constant of the law that is not positive and finite.
    #[error("the law's {name} is {value}; give a positive, finite number")]
    Constant { name: &'static str, value: f64 },
    /// A law of plane bodies in a solid.
    #[error(
        "{law} is a law of triangles, but the mesh is made of cells with {nodes} nodes; take the law of the solid"
    )]
    PlaneLaw { law: &'static str, nodes: usize },
    /// Mixed elements of linear cells.
    #[error(
        "mixed elements have quadratic tetrahedra or triangles, but the mesh is made of {cells}; make it quadratic (sinew_mesh::Mesh::quadratic)"
    )]
    LinearMixed { cells: &'static str },
    /// Triangles that are not in one plane.
    #[error(
        "node {node} lies {height:e} above node 0 along z, but triangles are a plane section in the x-y plane; flatten the mesh, \
         or give a mesh of solid cells"
    )]
    NotFlat { node: usize, height: f64 },
    /// A load across a plane body.
    #[error(
        "{what} is {value}, but a mesh of triangles is a plane section, whose nodes move in x and y only; give 0, or a mesh of solid cells"
    )]
    OutOfPlane { what: String, value: f64 },
    /// There are neither as many directions as cells, nor as quadrature points, nor as nodes.
    #[error(
        "the law reads {needed} directions, for each of the {cells} cells, {points} quadrature points or \
         {nodes} nodes, but {given} rows are given"
    )]
    DirectionCount { needed: usize, cells: usize, given: usize, points: usize, nodes: usize },
    /// A stiffness below zero.
    #[error("{what} is {value}; a foundation pushes back, so give a stiffness of at least 0")]
    NegativeStiffness { what: String, value: f64 },
    /// The thesis' pressure on an element that the thesis does not know.
    #[error(
        "the thesis' pressure is defined on linear tetrahedra (4 nodes), not on cells of {nodes} nodes; use \
         Load::Pressure, the true follower load"
    )]
    ThesisPressure { nodes: usize },
    /// A material direction that is not a unit vector.
    #[error(
        "direction {direction} of cell {cell} has length {length}, not 1; normalise it, and give a \
         direction to every cell that has none"
    )]
    NotUnit { cell: usize, direction: usize, length: f64 },
    /// Material directions that are not perpendicular.
    #[error(
        "directions {} and {} of cell {cell} have the inner product {product:e}, not 0; orthogonalise them",
        pair[0], pair[1]
    )]
    NotPerpendicular { cell: usize, pair: [usize; 2], product: f64 },
    /// θ has another number of entries than law and loads read.
    #[error(
        "the scene lists {given} parameters, but the law reads {} and the loads {loads} more; list \
         those of the law first",
        listed(names)
    )]
    ParameterCount { given: usize, names: Vec<&'static str>, loads: usize },
    /// The first parameters are not those of the law in its order.
    #[error(
        "the law reads {} in this order, but the scene lists {}; list the law's parameters first, in its order and by its names",
        listed(names),
        listed(given)
    )]
    ParameterNames { given: Vec<String>, names: Vec<&'static str> },
    /// Two parameters of one name.
    #[error(
        "the scene lists two parameters `{name}`; law and loads read entries of theta of their own: rename one"
    )]
    ParameterTwice { name: String },
    /// A load whose magnitude is an entry of θ that does not exist or belongs to the law, which reads those before
    /// `first`.
    #[error(
        "a load reads entry {index} of theta, but {}",
        entries_of_loads(*first, *count)
    )]
    LoadParameter { index: usize, first: usize, count: usize },
    /// A known value of a parameter that does not exist.
    #[error("there is no parameter `{name}`; law and loads read {}", listed(known))]
    UnknownParameter { name: String, known: Vec<String> },
    /// Two known values of one parameter.
    #[error("`{name}` is there twice among the known parameters; keep one value")]
    KnownTwice { name: String },
    /// A known value that makes no sense.
    #[error("the known value of `{name}` is {value}; it must be {}", requirement(&(*least..=*most), *value))]
    KnownValue { name: String, value: f64, least: f64, most: f64 },
    /// A range that is empty or not finite, or not positive for log sampling.
    #[error(
        "parameter `{name}` ranges from {} to {}; give finite ends in ascending order, positive for log sampling",
        range[0], range[1]
    )]
    Range { name: String, range: [f64; 2] },
    /// A follower pressure on a surface with a loose rim.
    #[error(
        "the pressure on `{name}` has no potential: the edge between nodes {} and {} of its rim is neither \
         held nor made to slide in one coordinate plane; hold the rim, close the \
         surface, or solve the force balance (Scene::loose_rims)",
        edge[0], edge[1]
    )]
    LooseRim { name: String, edge: [usize; 2] },
    /// A sliding rim that is not plane enough.
    #[error(
        "the rim of `{name}` slides across {axis} but is not even: it goes from {axis} = {least} to {axis} = {most}, so that {:.2} % \
         of the pressure's force would be lost, where 0.01 % is allowed; move its nodes into one plane, hold the rim, or solve \
         the force balance (Scene::loose_rims)",
        100.0 * part
    )]
    UnevenRim { name: String, axis: char, least: f64, most: f64, part: f64 },
    /// Rims that slide in different parallel planes, at positions \[length\] on an axis.
    #[error(
        "the rim of `{name}` slides in the planes {axis} = {first} and {axis} = {second}; its pressure has a \
         potential for one plane per axis only: hold one of the rims"
    )]
    RimPlanes { name: String, axis: char, first: f64, second: f64 },
}

/// Parameters that make no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ThetaError {
    /// θ has the wrong length.
    #[error(
        "theta has {given} entries, but {needed} are read: {}, then those of the loads",
        listed(names)
    )]
    Length { given: usize, needed: usize, names: Vec<&'static str> },
    /// A parameter outside the values that make sense.
    #[error("theta[{index}] ({name}) is {value}; it must be {}", requirement(&(*least..=*most), *value))]
    OutOfBounds { index: usize, name: &'static str, value: f64, least: f64, most: f64 },
}

/// Text of the bounds that a value violates, to follow "it must be": `positive`, `at least 0 and less than 0.5`.
pub fn requirement(bounds: &RangeInclusive<f64>, value: f64) -> String {
    let (least, most) = (*bounds.start(), *bounds.end());
    let (tiny, huge) = (*POSITIVE.start(), *POSITIVE.end());
    if (value > 0.0 && value < tiny) || value > huge {
        return format!("between {tiny:e} and {huge:e}, beyond which squares vanish or overflow");
    }
    let below = (most < huge).then(|| match rounded_up(most) {
        open if open > most => format!("less than {open}"),
        closed => format!("at most {closed}"),
    });
    match (least, below) {
        (least, None) if least == tiny => "positive".into(),
        (least, None) if least <= -huge => "finite".into(),
        (least, None) => format!("at least {least}"),
        (least, Some(below)) if least == tiny => format!("positive and {below}"),
        (least, Some(below)) if least <= -huge => below,
        (least, Some(below)) => format!("at least {least} and {below}"),
    }
}

/// A bound rounded to twelve digits: 0.5 − ε gives 0.5.
fn rounded_up(bound: f64) -> f64 {
    format!("{bound:.12}").parse().unwrap_or(bound)
}

/// Entries of θ that a load may read.
fn entries_of_loads(first: usize, count: usize) -> String {
    match count.saturating_sub(first) {
        0 => format!(
            "all {count} parameters belong to the law; list one for the load after them, which becomes entry {first}"
        ),
        1 => format!("only entry {first} is free for loads: the law reads those before it"),
        _ => format!(
            "only entries {first} to {} are free for loads: the law reads those before them",
            count - 1
        ),
    }
}

fn overlap_advice(twice: bool) -> &'static str {
    if twice {
        "they are one cell listed twice: remove one"
    } else {
        "one is folded over the other, the mesh is tangled there: move their nodes apart, or mesh the body anew"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requirements_are_words() {
        assert_eq!(requirement(&POSITIVE, -2.0), "positive");
        assert!(requirement(&POSITIVE, 1e120).starts_with("between 1e-100 and 1e100"));
        assert_eq!(requirement(&(0.0..=0.5 - f64::EPSILON), 0.5), "at least 0 and less than 0.5");
        assert_eq!(requirement(&(0.0..=1e100), -1.0), "at least 0");
        assert_eq!(requirement(&(-1.0..=2.0), 3.0), "at least -1 and at most 2");
        assert_eq!(requirement(&(f64::MIN..=f64::MAX), f64::NAN), "finite");
    }
}

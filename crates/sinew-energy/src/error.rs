//! What can be wrong with a scene or with θ, with numbers and advice.

use sinew_mesh::Defect;
use thiserror::Error;

/// Names or numbers for people: `mu, lambda`.
pub fn listed<T: ToString>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

/// A scene that cannot be lowered to a potential.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The mesh has no cell.
    #[error("the mesh has no cells; read or generate one that has")]
    EmptyMesh,
    /// The mesh breaks its own rules.
    #[error(transparent)]
    Mesh(#[from] Defect),
    /// A field of stiffness that is not one.
    #[error(
        "a field of stiffness has one finite, positive factor for each of {nodes} nodes; {found} were given, and that of node {node} \
         is missing or none"
    )]
    Factors {
        /// Nodes of the body.
        nodes: usize,
        /// Factors given.
        found: usize,
        /// First node without a fit one.
        node: usize,
    },
    /// A tetrahedron without positive volume.
    #[error(
        "cell {cell} has volume {volume:e}; turn inverted cells with sinew_mesh::repair_orientation \
         and remove flat ones"
    )]
    InvertedCell {
        /// Index of the cell.
        cell: usize,
        /// Its volume \[length³\].
        volume: f64,
    },
    /// Two cells on the same side of a facet: one cell listed twice, or folded over its neighbour.
    #[error(
        "cells {} and {} lie on the same side of the facet with nodes {}; {}",
        cells[0], cells[1], listed(facet), overlap_advice(*twice)
    )]
    OverlappingCells {
        /// Indices of the cells, ascending.
        cells: [usize; 2],
        /// Corners of the facet, ascending.
        facet: Vec<usize>,
        /// Whether both have the same nodes.
        twice: bool,
    },
    /// A quadrature rule that does not measure the reference element.
    #[error(
        "the weights of the {points} quadrature points add up to {sum}; give positive ones that add up to {needed}, the measure \
         of the reference element"
    )]
    Quadrature {
        /// Number of points.
        points: usize,
        /// Sum of their weights.
        sum: f64,
        /// Measure of the reference element.
        needed: f64,
    },
    /// A support names a node set that the mesh lacks.
    #[error("there is no node set `{name}`; the mesh has {}", listed(known))]
    UnknownNodeSet {
        /// The name.
        name: String,
        /// All node sets of the mesh.
        known: Vec<String>,
    },
    /// A load names a facet set that the mesh lacks.
    #[error("there is no facet set `{name}`; the mesh has {}", listed(known))]
    UnknownFacetSet {
        /// The name.
        name: String,
        /// All facet sets of the mesh.
        known: Vec<String>,
    },
    /// A load acts on a set without facets.
    #[error(
        "facet set `{name}` is empty, so its load acts on nothing; remove the load or name the facets"
    )]
    EmptyFacetSet {
        /// The name.
        name: String,
    },
    /// A facet that a set lists twice: its load would count twice.
    #[error(
        "facet set `{name}` lists the facet of cell {cell} opposite to its vertex {opposite} twice; list it once"
    )]
    RepeatedFacet {
        /// The facet set.
        name: String,
        /// Index of the cell.
        cell: usize,
        /// Local index of the vertex that the facet leaves out.
        opposite: usize,
    },
    /// A load on a facet between two cells.
    #[error(
        "facet set `{name}` names the facet of cell {cell} opposite to its vertex {opposite}, which lies inside the body; \
         loads act on its surface: leave inner facets out"
    )]
    InnerFacet {
        /// The facet set.
        name: String,
        /// Index of the cell.
        cell: usize,
        /// Local index of the vertex that the facet leaves out.
        opposite: usize,
    },
    /// Nothing holds the body along an axis.
    #[error(
        "no support holds the body along {axes}: it is free to move there and has no unique \
         equilibrium; add a support, such as Support::clamped"
    )]
    FreeToMove {
        /// The axes, such as `"x, z"`.
        axes: String,
    },
    /// A node that belongs to no cell and that no support holds.
    #[error(
        "{count} nodes belong to no cell (first: node {first}) and are not held; remove them from the mesh"
    )]
    LooseNodes {
        /// Number of such nodes.
        count: usize,
        /// The first of them.
        first: usize,
    },
    /// Two supports want different displacements.
    #[error(
        "supports prescribe both {first} and {second} for component {component} of node {node}; keep one"
    )]
    Contradiction {
        /// Index of the node.
        node: usize,
        /// Component 0, 1 or 2.
        component: usize,
        /// Displacement prescribed first.
        first: f64,
        /// Displacement prescribed later.
        second: f64,
    },
    /// Supports of a node that prescribe different displacements along one direction.
    #[error(
        "the support of `{name}` prescribes {second} along ({}) for node {node}, but it is held at {first} \
         there by those of {}; take the node out of one of the sets, or let the supports agree",
        listed(direction),
        listed(others)
    )]
    Conflict {
        /// Index of the node.
        node: usize,
        /// Node set of the support.
        name: String,
        /// Node sets of the other supports of the node.
        others: Vec<String>,
        /// The direction, a unit vector.
        direction: [f64; 3],
        /// Displacement along it that follows from the others.
        first: f64,
        /// Displacement along it that the support prescribes.
        second: f64,
    },
    /// A support along a direction that is zero or not finite.
    #[error(
        "the support of `{name}` has the direction ({}); give finite components, one of them not 0",
        listed(direction)
    )]
    SupportDirection {
        /// Node set of the support.
        name: String,
        /// The direction.
        direction: [f64; 3],
    },
    /// A node on the axis of a radial support.
    #[error(
        "node {node} of `{name}` is {distance:e} away from the axis of its radial support, so it has no radius to move \
         along; take it out of the set, and hold it with Support::clamped or Support::uniform"
    )]
    OnAxis {
        /// Node set of the support.
        name: String,
        /// Index of the node.
        node: usize,
        /// Its distance from the axis \[length\].
        distance: f64,
    },
    /// A list of prescribed displacements that does not fit its node set.
    #[error(
        "the support of node set `{name}` lists {given} displacements for {nodes} nodes; give one per node"
    )]
    SupportLength {
        /// The set.
        name: String,
        /// Rows given.
        given: usize,
        /// Nodes of the set.
        nodes: usize,
    },
    /// A number of a load or a support that is not finite.
    #[error("{what} is {value}; give a finite number")]
    NotFinite {
        /// What the number means.
        what: String,
        /// The number.
        value: f64,
    },
    /// A constant of the law that is not positive and finite.
    #[error("the law's {name} is {value}; give a positive, finite number")]
    Constant {
        /// Name of the constant.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// There are neither as many directions as cells, nor as quadrature points, nor as nodes.
    #[error(
        "the law reads {needed} directions, for each of the {cells} cells, {points} quadrature points or \
         {nodes} nodes, but {given} rows are given"
    )]
    DirectionCount {
        /// Directions per cell.
        needed: usize,
        /// Cells of the mesh.
        cells: usize,
        /// Rows given.
        given: usize,
        /// Quadrature points of the mesh.
        points: usize,
        /// Nodes of the mesh.
        nodes: usize,
    },
    /// A stiffness below zero.
    #[error("{what} is {value}; a foundation pushes back, so give a stiffness of at least 0")]
    NegativeStiffness {
        /// What the number means.
        what: String,
        /// The number.
        value: f64,
    },
    /// The thesis' pressure on an element that the thesis does not know.
    #[error(
        "the thesis' pressure is defined on linear tetrahedra (4 nodes), not on cells of {nodes} nodes; use \
         Load::Pressure, the true follower load"
    )]
    ThesisPressure {
        /// Nodes of a cell.
        nodes: usize,
    },
    /// A material direction that is not a unit vector.
    #[error(
        "direction {direction} of cell {cell} has length {length}, not 1; normalise it, and give a \
         direction to every cell that has none"
    )]
    NotUnit {
        /// Index of the cell.
        cell: usize,
        /// Index of the direction.
        direction: usize,
        /// Its length.
        length: f64,
    },
    /// Material directions that are not perpendicular.
    #[error(
        "directions {} and {} of cell {cell} have the inner product {product:e}, not 0; orthogonalise them",
        pair[0], pair[1]
    )]
    NotPerpendicular {
        /// Index of the cell.
        cell: usize,
        /// Indices of the directions.
        pair: [usize; 2],
        /// Their inner product.
        product: f64,
    },
    /// θ has another number of entries than law and loads read.
    #[error(
        "the scene lists {given} parameters, but the law reads {} and the loads {loads} more; list \
         those of the law first",
        listed(names)
    )]
    ParameterCount {
        /// Parameters listed.
        given: usize,
        /// Names of those of the law.
        names: &'static [&'static str],
        /// Number of those of the loads.
        loads: usize,
    },
    /// A load takes its size from an entry of θ that belongs to the law or does not exist.
    #[error(
        "a load reads entry {index} of theta, but {}",
        entries_of_loads(*first, *count)
    )]
    LoadParameter {
        /// The entry it reads.
        index: usize,
        /// First entry of the loads: the number of parameters of the law.
        first: usize,
        /// Number of parameters.
        count: usize,
    },
    /// A range that is not one, or that has no logarithm.
    #[error(
        "parameter `{name}` ranges from {} to {}; give finite ends in ascending order, positive for log sampling",
        range[0], range[1]
    )]
    Range {
        /// Name of the parameter.
        name: String,
        /// The range.
        range: [f64; 2],
    },
    /// A follower pressure on a surface with a loose rim.
    #[error(
        "the pressure on `{name}` has no potential: the edge between nodes {} and {} of its rim is neither \
         held nor made to slide in one coordinate plane; hold the rim, close the \
         surface, or lower the scene with lower_follower",
        edge[0], edge[1]
    )]
    LooseRim {
        /// The facet set.
        name: String,
        /// Nodes of an edge of the rim.
        edge: [usize; 2],
    },
    /// Rims that slide in different parallel planes.
    #[error(
        "the rim of `{name}` slides in the planes {axis} = {first} and {axis} = {second}; its pressure has a \
         potential for one plane per axis only: hold one of the rims"
    )]
    RimPlanes {
        /// The facet set.
        name: String,
        /// Axis across the planes.
        axis: char,
        /// Position of one plane \[length\].
        first: f64,
        /// Position of another plane \[length\].
        second: f64,
    },
}

/// Parameters that make no sense.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ThetaError {
    /// θ has the wrong length.
    #[error(
        "theta has {given} entries, but {needed} are read: {}, then those of the loads",
        listed(names)
    )]
    Length {
        /// Entries given.
        given: usize,
        /// Entries needed.
        needed: usize,
        /// Names of the law's parameters.
        names: &'static [&'static str],
    },
    /// A parameter outside the values that make sense.
    #[error("theta[{index}] ({name}) is {value}; it must lie in {least:e}..={most:e}")]
    OutOfBounds {
        /// Index into θ.
        index: usize,
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest sensible value.
        least: f64,
        /// Largest sensible value.
        most: f64,
    },
}

/// Which entries of θ a load may read.
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

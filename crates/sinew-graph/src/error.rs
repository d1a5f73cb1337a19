//! What can go wrong on the way from a mesh to the features of its augmented graph.

use crate::TopologyError;

/// Why a graph could not be built or described.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GraphError {
    /// A graph needs a pair of nodes to have an edge.
    #[error(
        "a graph needs at least 2 nodes, the mesh has {nodes}: was the file read completely, \
         and does it hold cells of the expected kind?"
    )]
    TooFewNodes {
        /// Nodes of the mesh.
        nodes: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "coordinate {axis} of node {node} is {value}: repair the mesh, or leave the node out \
         if no cell uses it"
    )]
    NonFinitePosition {
        /// The node.
        node: usize,
        /// Its offending axis: 0, 1 or 2.
        axis: usize,
        /// The coordinate.
        value: f64,
    },
    /// Two coordinates differ by more than a double can hold.
    #[error(
        "coordinate {axis} runs from {lowest:e} to {highest:e}, a distance beyond double \
         precision: choose a larger unit of length"
    )]
    ExtentOverflow {
        /// The axis: 0, 1 or 2.
        axis: usize,
        /// Smallest coordinate.
        lowest: f64,
        /// Largest coordinate.
        highest: f64,
    },
    /// A mesh edge names a node that does not exist.
    #[error(
        "mesh edge {edge} joins the nodes {a} and {b}, but there are {nodes} nodes, counted \
         from 0: do the edges and the positions belong to the same mesh?"
    )]
    EdgeOutOfRange {
        /// Index of the edge in the list given.
        edge: usize,
        /// One end.
        a: usize,
        /// The other end.
        b: usize,
        /// Nodes of the mesh.
        nodes: usize,
    },
    /// A mesh edge joins a node to itself.
    #[error("mesh edge {edge} joins node {node} to itself: remove cells that repeat a node")]
    SelfLoop {
        /// Index of the edge in the list given.
        edge: usize,
        /// The node.
        node: usize,
    },
    /// A layer of virtual nodes without nodes.
    #[error("layer {layer} asks for 0 roots: shorten `roots_per_layer` instead")]
    EmptyLayer {
        /// The layer, counted from 1.
        layer: usize,
    },
    /// A layer is at least as large as the one it clusters.
    #[error(
        "layer {layer} asks for {roots} roots of {leaves} leaves: each layer must be smaller \
         than the one before; for this mesh `AugmentationConfig::for_nodes` gives {suggestion:?}"
    )]
    LayerNotSmaller {
        /// The layer, counted from 1; the leaves of layer 1 are the mesh nodes.
        layer: usize,
        /// Roots asked for.
        roots: usize,
        /// Nodes of the layer before.
        leaves: usize,
        /// Layers that fit the mesh.
        suggestion: Vec<usize>,
    },
    /// k-means was asked for zero runs.
    #[error("k-means needs at least 1 run, `runs` is 0: 10 is a good number")]
    NoRuns,
    /// k-means failed on finite positions.
    #[error("k-means of {leaves} leaves into {roots} roots failed: {reason}")]
    Clustering {
        /// Nodes to cluster.
        leaves: usize,
        /// Clusters asked for.
        roots: usize,
        /// What linfa reported.
        reason: String,
    },
    /// The nearest-neighbour tree could not be built.
    #[error("no nearest-neighbour tree of {roots} roots: {reason}")]
    NeighbourTree {
        /// Points of the tree.
        roots: usize,
        /// What kiddo reported.
        reason: String,
    },
    /// A table has another number of rows than the graph needs.
    #[error("{what}: {expected} rows needed, {found} given: use the mesh the graph was built of")]
    RowCount {
        /// The table.
        what: &'static str,
        /// Rows the graph needs.
        expected: usize,
        /// Rows given.
        found: usize,
    },
    /// A table has another number of columns than expected.
    #[error(
        "{what}: {expected} columns needed, {found} given: all geometries and their \
         statistics must use the same features"
    )]
    ColumnCount {
        /// The table.
        what: &'static str,
        /// Columns expected.
        expected: usize,
        /// Columns given.
        found: usize,
    },
    /// The values do not fill rows times columns.
    #[error("a table of {rows} rows and {columns} columns cannot hold {values} values")]
    TableSize {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
        /// Values given.
        values: usize,
    },
    /// A feature is NaN or infinite.
    #[error("{what}: row {row}, column {column} is {value}: features must be finite")]
    NonFiniteFeature {
        /// The table.
        what: &'static str,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The value.
        value: f64,
    },
    /// An indicator names a node that does not exist.
    #[error("node {node} of the set does not exist, there are {nodes} nodes, counted from 0")]
    NodeOutOfRange {
        /// The node.
        node: usize,
        /// Nodes of the mesh.
        nodes: usize,
    },
    /// Space has one, two or three dimensions.
    #[error("{dimensions} space dimensions were asked for: use 1, 2 or 3")]
    Dimensions {
        /// Dimensions asked for.
        dimensions: usize,
    },
    /// A coordinate that the features would leave out is not constant.
    #[error(
        "coordinate {axis} runs from {lowest} to {highest}, but only {dimensions} dimensions \
         enter the edge features: use {suggestion}"
    )]
    LostCoordinate {
        /// The axis left out.
        axis: usize,
        /// Smallest coordinate.
        lowest: f64,
        /// Largest coordinate.
        highest: f64,
        /// Dimensions asked for.
        dimensions: usize,
        /// Dimensions that would include the axis.
        suggestion: usize,
    },
    /// Statistics or means over no geometry.
    #[error("no geometry was given: at least 1 is needed")]
    NoGeometry,
    /// The topology is not a valid augmented graph.
    #[error(transparent)]
    Topology(#[from] TopologyError),
}

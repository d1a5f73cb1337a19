//! Errors of an augmented graph and its features.

/// Why a graph could not be built or described.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum GraphError {
    /// A graph needs a pair of nodes to have an edge.
    #[error(
        "a graph needs at least 2 nodes, the mesh has {nodes}: was the file read completely, \
         and does it hold cells of the expected kind?"
    )]
    TooFewNodes { nodes: usize },
    /// A coordinate is NaN or infinite.
    #[error(
        "coordinate {axis} of node {node} is {value}: repair the mesh, or leave the node out \
         if no cell uses it"
    )]
    NonFinitePosition { node: usize, axis: usize, value: f64 },
    /// Two coordinates differ by more than a double can hold.
    #[error(
        "coordinate {axis} runs from {lowest:e} to {highest:e}, a distance beyond double \
         precision: choose a larger unit of length"
    )]
    ExtentOverflow { axis: usize, lowest: f64, highest: f64 },
    /// A mesh edge names a node that does not exist.
    #[error(
        "mesh edge {edge} joins the nodes {a} and {b}, but there are {nodes} nodes, counted \
         from 0: do the edges and the positions belong to the same mesh?"
    )]
    EdgeOutOfRange { edge: usize, a: usize, b: usize, nodes: usize },
    /// A mesh edge joins a node to itself.
    #[error("mesh edge {edge} joins node {node} to itself: remove cells that repeat a node")]
    SelfLoop { edge: usize, node: usize },
    /// A layer of virtual nodes without nodes.
    #[error("layer {layer} asks for 0 roots: shorten `roots_per_layer` instead")]
    EmptyLayer { layer: usize },
    /// A layer is at least as large as the one it clusters.
    #[error(
        "layer {layer} asks for {roots} roots of {leaves} leaves: each layer must be smaller \
         than the one before; for this mesh `AugmentationConfig::for_nodes` gives {suggestion:?}"
    )]
    LayerNotSmaller { layer: usize, roots: usize, leaves: usize, suggestion: Vec<usize> },
    /// k-means was asked for zero runs.
    #[error("k-means needs at least 1 run, `runs` is 0: 10 is a good number")]
    NoRuns,
    /// k-means failed on finite positions.
    #[error("k-means of {leaves} leaves into {roots} roots failed: {reason}")]
    Clustering { leaves: usize, roots: usize, reason: String },
    /// The nearest-neighbour tree could not be built.
    #[error("no nearest-neighbour tree of {roots} roots: {reason}")]
    NeighbourTree { roots: usize, reason: String },
    /// A table has another number of rows than the graph needs.
    #[error("{what}: {expected} rows needed, {found} given: use the mesh the graph was built of")]
    RowCount { what: &'static str, expected: usize, found: usize },
    /// A table has another number of columns than expected.
    #[error(
        "{what}: {expected} columns needed, {found} given: all geometries and their \
         statistics must use the same features"
    )]
    ColumnCount { what: &'static str, expected: usize, found: usize },
    /// The values do not fill rows times columns.
    #[error("a table of {rows} rows and {columns} columns cannot hold {values} values")]
    TableSize { rows: usize, columns: usize, values: usize },
    /// A feature is NaN or infinite.
    #[error("{what}: row {row}, column {column} is {value}: features must be finite")]
    NonFiniteFeature { what: &'static str, row: usize, column: usize, value: f64 },
    /// An indicator names a node that does not exist.
    #[error("node {node} of the set does not exist, there are {nodes} nodes, counted from 0")]
    NodeOutOfRange { node: usize, nodes: usize },
    /// Space has one, two or three dimensions.
    #[error("{dimensions} space dimensions were asked for: use 1, 2 or 3")]
    Dimensions { dimensions: usize },
    /// A coordinate that the features would leave out is not constant.
    #[error(
        "coordinate {axis} runs from {lowest} to {highest}, but only {dimensions} dimensions \
         enter the edge features: use {suggestion}"
    )]
    LostCoordinate { axis: usize, lowest: f64, highest: f64, dimensions: usize, suggestion: usize },
    /// Statistics or means over no geometry.
    #[error("no geometry was given: at least 1 is needed")]
    NoGeometry,
    /// The topology is not a valid augmented graph.
    #[error(transparent)]
    Topology(#[from] TopologyError),
}

/// Why a [`Topology`](crate::Topology) is not a valid augmented graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum TopologyError {
    /// Counts contradict each other.
    #[error("{what}: {expected} expected, {found} found; build the topology with `augment`")]
    Count { what: &'static str, expected: usize, found: usize },
    /// An edge whose sender is not the larger, existing index.
    #[error(
        "edge {edge} runs from {sender} to {receiver} in a graph of {nodes} nodes: senders must \
         exist and exceed their receivers, a pair is stored once"
    )]
    Edge { edge: usize, sender: usize, receiver: usize, nodes: usize },
    /// Fewer edges than connecting the nodes takes.
    #[error("{edges} edges cannot connect {nodes} nodes: is the file complete?")]
    TooFewEdges { nodes: usize, edges: usize },
    /// Edges repeat or are not ascending.
    #[error("edge {edge} does not follow its predecessor in order: sort the edges, drop repeats")]
    EdgeOrder { edge: usize },
    /// A leaf's root is not in the next layer.
    #[error("leaf {leaf} of layer {layer} names root {root}, the layer above has {roots}")]
    Root { layer: usize, leaf: usize, root: usize, roots: usize },
    /// A root without leaves.
    #[error("root {root} of layer {layer} has no leaves: its features would be undefined")]
    EmptyCluster { layer: usize, root: usize },
    /// A leaf is not joined to exactly its own root, or two layers are joined otherwise.
    #[error(
        "node {node} of layer {layer} is joined to {found} nodes of the layer above, of which \
         {own} is its root: it must be exactly its root"
    )]
    RootEdges { node: usize, layer: usize, found: usize, own: usize },
    /// An edge skips a layer.
    #[error("edge {edge} joins layer {from} to layer {to}, which do not follow each other")]
    LayerSkipped { edge: usize, from: usize, to: usize },
    /// The last layer is not fully connected.
    #[error("the {roots} roots of the last layer share {found} edges, all {expected} are needed")]
    LastLayer { roots: usize, expected: usize, found: usize },
    /// Messages cannot reach every node.
    #[error(
        "the graph falls into {components} parts of {largest} down to {smallest} nodes: merge \
         coincident nodes, drop nodes no cell uses, or add a layer of virtual nodes to join them"
    )]
    Disconnected { components: usize, largest: usize, smallest: usize },
}

//! The graph of a mesh on which an emulator passes messages: augmentation with layers of
//! virtual nodes, features and their statistics.
//!
//! Follows §2.2.1, §2.2.3 and Algorithm 1 of the thesis. Neighbouring mesh nodes are joined by
//! edges; virtual nodes, found by clustering, are shortcuts that carry messages across the body
//! in a few steps. Absolute positions enter no feature, so an emulator cannot tell where in
//! space the body lies.
//!
//! ```
//! use sinew_graph::{
//!     AugmentationConfig, FeatureMatrix, FeatureStatistics, augment, graph_features,
//! };
//!
//! let beam = sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
//! let config = AugmentationConfig::for_nodes(beam.points.len());
//! let topology = augment(&beam.points, &sinew_mesh::edges(&beam), &config)?;
//! assert_eq!(topology.nodes, 390 + 97 + 24);
//!
//! let clamped = FeatureMatrix::indicator(390, &beam.node_sets["x_min"])?;
//! let features = graph_features(&topology, &beam.points, &clamped, 3)?;
//! let statistics = FeatureStatistics::over(std::slice::from_ref(&features))?;
//! let input = statistics.standardise(&features)?;
//! assert_eq!((input.nodes.rows, input.nodes.columns), (511, 1));
//! assert_eq!((input.edges.rows, input.edges.columns), (topology.senders.len(), 4));
//! # Ok::<(), sinew_graph::GraphError>(())
//! ```

#[macro_use]
mod error;
mod augment;
mod features;
mod kmeans;
mod positions;
mod topology;

pub use augment::{AugmentationConfig, augment};
pub use error::GraphError;
pub use features::{
    ColumnStatistics, FeatureMatrix, FeatureStatistics, GraphFeatures, graph_features,
};
pub use positions::{pool_features, pool_positions};
pub use topology::Topology;

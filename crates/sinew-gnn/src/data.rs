//! Geometries, samples and data sets; graph and features of a body.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use sinew_emulate::Body;
use sinew_emulate::coordinates::{Coordinates, Dirichlet, Motions, require_count, require_finite};
use sinew_graph::{
    AugmentationConfig, FeatureMatrix, GraphFeatures, Topology, augment, graph_features,
};

/// One body as a network sees it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Graph of the body.
    pub topology: Topology,
    /// Raw features of nodes (virtual ones included) and stored edges.
    pub features: GraphFeatures,
    /// Embedding `z_global` of the global shape; empty where it is not used.
    pub global: Vec<f64>,
    /// Supports.
    pub dirichlet: Dirichlet,
    /// Coordinates of the network's outputs on this body.
    pub coordinates: Coordinates,
}

/// One parameter set on one geometry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Index of the geometry.
    pub geometry: usize,
    /// Parameters θ, in the units of their ranges.
    pub theta: Vec<f64>,
    /// Simulated displacement, node by node \[length\]; empty for physics-informed training.
    pub displacement: Vec<f64>,
}

/// Data set of an emulator: geometries, each with its own graph, and samples of parameters on them.
#[derive(Debug, Clone)]
pub struct DataSet {
    /// The bodies.
    pub geometries: Vec<Geometry>,
    /// Samples trained on.
    pub training: Vec<Sample>,
    /// Samples the best weights are chosen by; may be empty.
    pub validation: Vec<Sample>,
}

impl DataSet {
    /// Requires that geometries and samples fit each other, and are finite.
    ///
    /// # Errors
    /// The first misfit, by name and number.
    pub fn check(&self, dimensions: usize) -> Result<()> {
        if self.training.is_empty() {
            return Err(Error::NothingToTrain("the data set holds no training samples"));
        }
        for geometry in &self.geometries {
            geometry.check(dimensions)?;
        }
        for (index, sample) in self.training.iter().chain(&self.validation).enumerate() {
            let Some(body) = self.geometries.get(sample.geometry) else {
                let (geometry, geometries) = (sample.geometry, self.geometries.len());
                return Err(Error::UnknownGeometry { sample: index, geometry, geometries });
            };
            require_finite("parameters of a sample", &sample.theta)?;
            if !sample.displacement.is_empty() {
                let expected = body.topology.real_nodes * dimensions;
                require_count("displacement values", sample.displacement.len(), expected)?;
                require_finite("displacements of a sample", &sample.displacement)?;
            }
        }
        Ok(())
    }
}

impl Geometry {
    /// Requires that features and supports fit the graph.
    pub(crate) fn check(&self, dimensions: usize) -> Result<()> {
        let topology = &self.topology;
        require_count("rows of node features", self.features.nodes.rows, topology.nodes)?;
        require_count("rows of edge features", self.features.edges.rows, topology.senders.len())?;
        let degrees_of_freedom = topology.real_nodes * dimensions;
        require_count("prescribed entries", self.dirichlet.prescribed.len(), degrees_of_freedom)?;
        let values: Vec<f64> = self.dirichlet.prescribed.iter().flatten().copied().collect();
        require_finite("prescribed displacements", &values)?;
        if let Some(origin) = self.coordinates.origin() {
            require_count("entries of the output origin", origin.len(), degrees_of_freedom)?;
        }
        if let Coordinates::Motions(motions) = &self.coordinates {
            let clusters = motions.tree().cluster_parents.len();
            let virtual_nodes = topology.nodes - topology.real_nodes;
            require_count("clusters of the outputs", clusters, virtual_nodes)?;
        }
        require_finite("node features", &self.features.nodes.values)?;
        require_finite("edge features", &self.features.edges.values)?;
        Ok(require_finite("global features", &self.global)?)
    }
}

/// Clusters per cluster of the next layer, up to the whole body (docs/design.md, "Graph").
const SHRINKAGE: usize = 2;

/// Augmented graph and features of a body (thesis Algorithm 1): the indicator of the Dirichlet boundary
/// on the nodes, difference and distance of positions on the edges. `to_one_root` continues the clusters up to the whole body, by halves
/// where `virtual_nodes` does not say how many each level has.
///
/// # Errors
/// A mesh that has no valid graph.
pub(crate) fn geometry(
    body: &Body,
    virtual_nodes: Option<&[usize]>,
    to_one_root: bool,
    seed: u64,
) -> Result<Geometry> {
    let nodes = body.nodes;
    let config = match virtual_nodes {
        Some(levels) => {
            let mut levels = levels.to_vec();
            levels.extend((to_one_root && levels.last() != Some(&1)).then_some(1));
            AugmentationConfig::of_layers(nodes, levels)
        }
        None if to_one_root => AugmentationConfig::to_one_root(nodes, SHRINKAGE),
        None => AugmentationConfig::for_nodes(nodes),
    };
    let config = AugmentationConfig { seed, ..config };
    let topology = augment(&body.positions, &body.mesh.edges(), &config).map_err(Error::Mesh)?;
    let held = body.prescribed.chunks_exact(3).enumerate();
    let held: Vec<usize> =
        held.filter(|(_, row)| row.iter().all(Option::is_some)).map(|(node, _)| node).collect();
    let indicator = FeatureMatrix::indicator(nodes, &held)?;
    let features = graph_features(&topology, &body.positions, &indicator, 3)?;
    let (dirichlet, coordinates) = (Dirichlet::of_body(body), Coordinates::Components);
    Ok(Geometry { topology, features, global: Vec::new(), dirichlet, coordinates })
}

/// Appends the Taylor coefficients of the outputs to the features of the nodes.
pub(crate) fn add_features(geometry: &mut Geometry, motions: &Motions) -> Result<()> {
    let nodes = &mut geometry.features.nodes;
    let values = motions.features();
    let columns = values.len() / nodes.rows;
    *nodes = nodes.hstack(&FeatureMatrix { rows: nodes.rows, columns, values })?;
    Ok(())
}

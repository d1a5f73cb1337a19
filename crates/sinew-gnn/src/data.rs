//! Geometries, samples and data sets.

use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::{Coordinates, Dirichlet, require_count, require_finite};
use sinew_graph::{GraphFeatures, Topology};

use crate::error::{Error, Result};

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

//! A network with its units, supports and geometries, to be trained, stored and evaluated; predictions on one geometry.

use crate::fused::Input;
use crate::graph::kinds;
use crate::map::{GeometryTensors, OutputMap, matrix, numbers, parameter_tensor, rows};
use crate::{
    DataSet, Decoding, Embedding, Error, Geometry, Graph, GraphNetwork, GraphNetworkConfig, Result,
    Sample,
};
use burn::module::Module;
use burn::tensor::{Device, Tensor};
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::{
    Coordinates, OutputScale, ParameterScaling, all_terms, check_terms, require_count,
    require_finite,
};
use sinew_graph::{ColumnStatistics, FeatureMatrix, FeatureStatistics};
use std::sync::Arc;

/// Everything that turns physical inputs into network inputs and network outputs into displacements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Statistics of node and edge features over the training geometries.
    pub features: FeatureStatistics,
    /// Statistics of the shape embeddings over the training geometries.
    pub global: ColumnStatistics,
    /// Ranges of the parameters.
    pub parameters: ParameterScaling,
    /// Scale of the displacements.
    pub output: OutputScale,
}

impl Scales {
    /// Feature and shape statistics of `geometries`, with the given parameter and output scales.
    ///
    /// # Errors
    /// Geometries whose features disagree in number or are not finite.
    pub fn over(
        geometries: &[Geometry],
        parameters: ParameterScaling,
        output: OutputScale,
    ) -> Result<Self> {
        let features: Vec<_> =
            geometries.iter().map(|geometry| geometry.features.clone()).collect();
        let global: Vec<_> = geometries.iter().map(shape).collect();
        Ok(Self {
            features: FeatureStatistics::over(&features)?,
            global: ColumnStatistics::over("global features", global.iter())?,
            parameters,
            output,
        })
    }
}

/// An [`GraphNetwork`] that takes parameters in their units on named geometries and returns displacements.
#[derive(Debug, Clone)]
pub struct Surrogate {
    pub(crate) emulator: GraphNetwork,
    pub(crate) scales: Scales,
    pub(crate) geometries: Vec<Geometry>,
    pub(crate) prepared: Vec<GeometryTensors>,
}

impl Surrogate {
    /// An untrained surrogate for a data set.
    ///
    /// The configuration's feature counts must be those of the data; `device` is a plain one,
    /// training adds automatic differentiation itself.
    ///
    /// # Errors
    /// Counts that do not fit each other, a scale that is not positive, or data that are not finite.
    pub fn new(
        config: &GraphNetworkConfig,
        data: &DataSet,
        scales: Scales,
        seed: u64,
        device: &Device,
    ) -> Result<Self> {
        let emulator = GraphNetwork::new(config, seed, device)?;
        Self::assemble(emulator, scales, data.geometries.clone())
    }

    /// Network and scales on the geometries of other data, to be fine-tuned there. Embeddings that are
    /// weights go along if all these geometries are known.
    ///
    /// # Errors
    /// As [`Surrogate::new`].
    pub fn transferred_to(&self, data: &DataSet) -> Result<Self> {
        let embedding = |geometry| self.emulator.embedding(self.known(geometry)?);
        let embeddings: Option<Vec<_>> = data.geometries.iter().map(embedding).collect();
        let emulator = self.emulator.clone().with_embeddings(embeddings.unwrap_or_default());
        let scales = self.scales.clone();
        Self::assemble(emulator, scales, data.geometries.clone())
    }

    /// Puts the parts of a surrogate together, checking that they fit.
    pub(crate) fn assemble(
        emulator: GraphNetwork,
        scales: Scales,
        geometries: Vec<Geometry>,
    ) -> Result<Self> {
        let config = &emulator.config;
        let Scales { features, global, parameters, .. } = &scales;
        require_count("parameter ranges", parameters.count(), config.parameters)?;
        let (nodes, edges) = (features.nodes.mean.len(), features.edges.mean.len());
        require_count("columns of node features", nodes, config.node_features)?;
        require_count("columns of edge features", edges, config.edge_features)?;
        require_count("global features", global.mean.len(), config.global_features)?;
        if let Decoding::Motions { .. } = config.decoding {
            require_count("components of a motion's translation", config.dimensions, 3)?;
        }
        let emulator = emulator.valid();
        let mut surrogate = Self { emulator, scales, geometries, prepared: Vec::new() };
        let prepared = surrogate.geometries.iter().map(|geometry| surrogate.prepare(geometry));
        surrogate.prepared = prepared.collect::<Result<_>>()?;
        Ok(surrogate)
    }

    /// The network.
    pub fn emulator(&self) -> &GraphNetwork {
        &self.emulator
    }

    /// Input and output scales.
    pub fn scales(&self) -> &Scales {
        &self.scales
    }

    /// Geometries trained on.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// Prepares fast prediction on one geometry, which need not be one of those trained on, nor have a graph like theirs.
    ///
    /// # Errors
    /// A geometry that does not fit the configuration.
    pub fn fixed_geometry(&self, geometry: &Geometry) -> Result<FixedGeometry> {
        Ok(FixedGeometry::new(self, self.known(geometry), &self.prepare(geometry)?))
    }

    /// Index of a geometry whose graph and features are those of this one.
    fn known(&self, geometry: &Geometry) -> Option<usize> {
        let Geometry { topology, features, .. } = geometry;
        let same = |known: &Geometry| known.topology == *topology && known.features == *features;
        self.geometries.iter().position(same)
    }

    /// Displacement at each of some parameter sets on one geometry, node by node \[length\]: all steps of Algorithm 2, or the decoders alone where the
    /// geometry was trained on and its embeddings are weights.
    ///
    /// # Errors
    /// As [`Surrogate::fixed_geometry`] and [`FixedGeometry::predict`].
    pub fn predict(&self, geometry: &Geometry, thetas: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        self.fixed_geometry(geometry)?.predict(thetas)
    }

    /// [`Surrogate::predict`] as for an unseen geometry: all steps of Algorithm 2.
    ///
    /// # Errors
    /// As [`Surrogate::predict`].
    pub fn predict_unseen(
        &self,
        geometry: &Geometry,
        thetas: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        FixedGeometry::new(self, None, &self.prepare(geometry)?).predict(thetas)
    }

    /// Embeddings `z_local` of the nodes of the mesh by message passing, a row for each (thesis Algorithm 2).
    ///
    /// # Errors
    /// As [`Surrogate::fixed_geometry`].
    pub fn local_embedding(&self, geometry: &Geometry) -> Result<Vec<Vec<f64>>> {
        Ok(rows(&self.prepare(geometry)?.embedding(&self.emulator)[0]))
    }

    /// Standardised parameters `[batch, parameters]` of some samples.
    pub(crate) fn parameters_of(&self, samples: &[&Sample]) -> Result<Tensor<2>> {
        let thetas = samples.iter().map(|sample| &sample.theta[..]);
        parameter_tensor(&self.scales.parameters, thetas, &self.emulator.device())
    }

    /// Embeddings of the nodes of geometry `index`, through `emulator` (this surrogate's, or a copy of it).
    pub(crate) fn embedding(&self, emulator: &GraphNetwork, index: usize) -> Embedding {
        let passed = || self.prepared[index].embedding(emulator);
        emulator.embedding(index).unwrap_or_else(passed)
    }

    /// A geometry's tensors.
    pub(crate) fn prepare(&self, geometry: &Geometry) -> Result<GeometryTensors> {
        let dimensions = self.emulator.config.dimensions;
        geometry.check(dimensions)?;
        let nodes = geometry.topology.real_nodes;
        self.scales.output.check(dimensions, dimensions * nodes)?;
        let motions = matches!(geometry.coordinates, Coordinates::Motions(_));
        let decoded = matches!(self.emulator.config.decoding, Decoding::Motions { .. });
        require_count("outputs that are rigid motions", motions.into(), decoded.into())?;
        let parameters = self.scales.parameters.count();
        let (slopes, rates) = geometry.coordinates.taylor();
        check_terms(slopes.len() - usize::from(!rates.is_empty()), parameters)?;
        if let Some(anchors) = geometry.coordinates.anchors() {
            anchors.variance(&vec![0.0; parameters])?;
        }
        if !rates.is_empty() {
            require_count("terms of an amplitude", rates.len(), all_terms(parameters))?;
            require_finite("the rates of an amplitude", rates)?;
        }
        require_count("global features", geometry.global.len(), self.scales.global.mean.len())?;
        let features = self.scales.features.standardise(&geometry.features)?;
        let global = self.scales.global.standardise("global features", &shape(geometry))?.values;
        let device = self.emulator.device();
        let table = |table: &FeatureMatrix| {
            let bits: Vec<u32> = table.values.iter().map(|x| (*x as f32).to_bits()).collect();
            let kinds = kinds(bits.chunks_exact(table.columns));
            let examples: Vec<usize> = kinds.inverse.iter().map(|rows| rows[0]).collect();
            let values: Vec<f64> =
                examples.iter().flat_map(|row| table.row(*row)).copied().collect();
            (matrix(&values, examples.len(), &device), kinds)
        };
        let ((nodes, of_nodes), (edges, of_edges)) =
            (table(&features.nodes), table(&features.edges));
        let output = OutputMap::new(geometry, &self.scales.output, dimensions).into();
        Ok(GeometryTensors {
            graph: Graph::of_kinds(&geometry.topology, [of_nodes, of_edges]),
            nodes,
            edges,
            global: (!global.is_empty()).then(|| matrix(&global, 1, &device)),
            output,
        })
    }
}

/// The embedding of a geometry's global shape, as a table of one row.
fn shape(geometry: &Geometry) -> FeatureMatrix {
    let values = geometry.global.clone();
    FeatureMatrix { rows: 1, columns: values.len(), values }
}

/// Rows (parameter sets × nodes) decoded at once: their activations of 128 columns fill a few
/// megabytes, beyond that a batch only costs memory.
const ROWS_PER_CHUNK: usize = 8192;

/// A surrogate bound to one geometry (thesis §2.4.3): the embeddings `z_local`, and their part of
/// the decoders' first layers, are computed once; a prediction is the decoder only.
#[derive(Debug, Clone)]
pub struct FixedGeometry {
    emulator: GraphNetwork,
    parameters: ParameterScaling,
    node_parts: Vec<(usize, Tensor<2>)>,
    global: Option<Tensor<2>>,
    output: Arc<OutputMap>,
}

impl FixedGeometry {
    /// Binds a surrogate to a geometry of its training, at index `known`, or to another one.
    pub(crate) fn new(
        surrogate: &Surrogate,
        known: Option<usize>,
        geometry: &GeometryTensors,
    ) -> Self {
        let emulator = surrogate.emulator.clone();
        let local = known.and_then(|index| emulator.embedding(index));
        let local = local.unwrap_or_else(|| geometry.embedding(&emulator));
        Self {
            node_parts: emulator.decoder_node_part(geometry.output.decoded(local)),
            emulator,
            parameters: surrogate.scales.parameters.clone(),
            global: geometry.global.clone(),
            output: geometry.output.clone(),
        }
    }

    /// Displacement at each of some parameter sets, node by node \[length\], by the decoder alone.
    ///
    /// # Errors
    /// Parameters of a wrong number, not finite, or not positive on a log scale; a prediction that is not finite.
    pub fn predict(&self, thetas: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let [nodes, dimensions] = self.output.dims();
        let mut fields: Vec<Vec<f64>> = Vec::with_capacity(thetas.len());
        for chunk in thetas.chunks((ROWS_PER_CHUNK / nodes).max(1)) {
            let inputs = self.inputs(chunk)?;
            let parts = self.node_parts.iter().cloned();
            let parts = parts.map(|(decoder, values)| (decoder, Input { values, first_row: None }));
            let outputs = self.emulator.decode_from(parts, self.global.clone(), inputs.clone());
            let displacements = numbers(self.output.displacement(outputs, &inputs));
            fields.extend(displacements.chunks(nodes * dimensions).map(<[f64]>::to_vec));
        }
        match fields.iter().position(|field| field.iter().any(|u| !u.is_finite())) {
            Some(sample) => Err(Error::PredictionNotFinite { sample }),
            None => Ok(fields),
        }
    }

    /// `∂û/∂θ` at one parameter set, a field for each parameter [length per unit of the parameter], in forward mode through the decoder.
    ///
    /// # Errors
    /// As [`FixedGeometry::predict`].
    pub fn sensitivity(&self, theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        let inputs = self.inputs(&[theta.to_vec()])?;
        let (global, parts) = (self.global.clone(), &self.node_parts);
        let (outputs, changes) = self.emulator.decode_with_tangents(parts, global, inputs.clone());
        let mut tangents = self.output.tangents(outputs, &changes, inputs);
        if tangents.iter().flatten().any(|u| !u.is_finite()) {
            return Err(Error::PredictionNotFinite { sample: 0 });
        }
        for (tangent, slope) in tangents.iter_mut().zip(self.parameters.slopes(theta)) {
            tangent.iter_mut().for_each(|u| *u *= slope);
        }
        Ok(tangents)
    }

    fn inputs(&self, thetas: &[Vec<f64>]) -> Result<Tensor<2>> {
        let thetas = thetas.iter().map(Vec::as_slice);
        parameter_tensor(&self.parameters, thetas, &self.emulator.device())
    }
}

//! Training one network, with progress, curves and resumption.
//!
//! Coordinates of the displacement in which networks are trained are chosen here. In [rigid motions](Motions) of nested clusters, each scaled
//! by its own energy, the Hessian of the energy is well conditioned (docs/design.md): plain displacements learn bending last.

mod course;

use crate::map::standardised;
use crate::training::scale;
use crate::{
    Backend, DataSet, Decoding, Error, FixedGeometry, Geometry, GraphNetworkConfig, Objective,
    Result, Sample, Surrogate, TrainingConfig, data,
};
use course::Course;
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::{
    Coordinates as Meaning, Motions, OutputScale, PrincipalDirections,
};
use sinew_emulate::parts::{Session, admissible, not_finite, scaling, timed, work};
use sinew_emulate::{Body, Load, Predictor, Record, TestSet};
use sinew_fem::{NewtonStep, Options, SolveError, Solver};
use sinew_graph::Topology;
use std::path::Path;

/// Sizes of a network. The default has half of the thesis' width: where embeddings are weights of their own, more steps
/// of narrower perceptrons are worth more (docs/design.md).
#[doc(alias("MeshGraphNet", "GNN"))]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Network {
    /// Width of the embeddings of nodes, edges and parameters.
    pub latent: usize,
    /// Width of the hidden layers.
    pub width: usize,
    /// Width of the hidden layers that read the motions of clusters.
    pub cluster_width: usize,
    /// Message-passing steps.
    pub message_passing_steps: usize,
    /// Virtual nodes of each level, thesis' η (Algorithm 1, Tables A.3 and A.6), each fewer than before; none leaves the graph of the mesh.
    /// By default each level has a quarter of the nodes below, and in motions of clusters half of them, up to the whole body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub virtual_nodes: Option<Vec<usize>>,
}

impl Default for Network {
    fn default() -> Self {
        Self {
            latent: 40,
            width: 64,
            cluster_width: 32,
            message_passing_steps: 5,
            virtual_nodes: None,
        }
    }
}

impl Network {
    /// A network of these sizes for a geometry and so many parameters.
    pub(crate) fn on(&self, geometry: &Geometry, parameters: usize) -> GraphNetworkConfig {
        let Geometry { features, topology, coordinates, .. } = geometry;
        let Self { latent, width, cluster_width, message_passing_steps: steps, .. } = *self;
        let decoding = match coordinates {
            Meaning::Motions(_) => {
                Decoding::Motions { layers: topology.roots_per_layer.len(), width: cluster_width }
            }
            _ => Decoding::Components,
        };
        let (nodes, edges) = (features.nodes.columns, features.edges.columns);
        let sizes = GraphNetworkConfig::new(3, nodes, edges, parameters);
        GraphNetworkConfig { latent, width, steps, decoding, ..sizes }
    }
}

/// A trained network on its geometry.
#[derive(Debug)]
pub(crate) struct TrainedNetwork {
    surrogate: Surrogate,
    /// Message passing done once.
    pub fixed: FixedGeometry,
}

impl TrainedNetwork {
    /// Network on the geometry of its training.
    fn new(surrogate: Surrogate) -> Result<Self> {
        let fixed = surrogate.fixed_geometry(&surrogate.geometries()[0])?;
        Ok(Self { surrogate, fixed })
    }
}

/// Kind of the predictors that are networks.
const KIND: &str = "network";

/// Kinds of predictors that [`Emulator::load_with`](sinew_emulate::Emulator::load_with) reads beside those that it knows.
pub const KINDS: &[(&str, &Load)] = &[(KIND, &load)];

fn load(folder: &Path, _: &Body) -> sinew_emulate::Result<Box<dyn Predictor>> {
    let surrogate = Surrogate::load(folder, &Backend::default().device()?)?;
    Ok(Box::new(TrainedNetwork::new(surrogate)?))
}

/// Displacements of a prediction, one after the other.
fn displacement(
    body: &Body,
    thetas: &[Vec<f64>],
    predicted: Result<Vec<Vec<f64>>>,
) -> sinew_emulate::Result<Vec<f64>> {
    match predicted {
        Ok(fields) => Ok(fields.concat()),
        Err(Error::PredictionNotFinite { sample }) => Err(not_finite(body, &thetas[sample])),
        Err(other) => Err(other.into()),
    }
}

impl Predictor for TrainedNetwork {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn predict(&self, body: &Body, thetas: &[Vec<f64>]) -> sinew_emulate::Result<Vec<f64>> {
        displacement(body, thetas, self.fixed.predict(thetas))
    }

    fn predict_in_full(&self, body: &Body, thetas: &[Vec<f64>]) -> sinew_emulate::Result<Vec<f64>> {
        let geometry = &self.surrogate.geometries()[0];
        displacement(body, thetas, self.surrogate.predict_unseen(geometry, thetas))
    }

    /// Exact, in forward mode through the decoders.
    fn sensitivity(&self, _: &Body, theta: &[f64]) -> sinew_emulate::Result<Vec<Vec<f64>>> {
        Ok(self.fixed.sensitivity(theta)?)
    }

    fn save(&self, folder: &Path) -> sinew_emulate::Result<()> {
        Ok(self.surrogate.save(folder)?)
    }
}

/// Plan of a network's training, and its data.
pub(crate) struct Plan<'a> {
    /// Short name of the recipe.
    pub recipe: &'static str,
    pub network: &'a Network,
    pub coordinates: &'a OutputCoordinates,
    pub training: &'a TrainingConfig,
    /// The one place where recipes differ.
    pub objective: &'a dyn Fn() -> Result<Box<dyn Objective>>,
    pub thetas: &'a [Vec<f64>],
    /// Simulated displacements at the parameters; `None` for training without any.
    pub fields: Option<&'a [Vec<f64>]>,
    /// Sizes of displacements \[length\].
    pub scale: OutputScale,
    /// Energy of the linearised body at the centre of the ranges, where there are no simulations.
    pub energy: f64,
    /// Least work of loads that sizes are relative to, where they nearly vanish at the centre; else 0.
    pub least_work: f64,
    pub held_out: &'a TestSet<'a>,
}

/// Learning rate of fine-tuning [relative to training from scratch]: a high rate destroys the earlier training.
const RATE_OF_START: f64 = 0.5;

/// Trains by `plan`; an interrupted run goes on from its last checkpoint.
pub(crate) fn train(
    session: &mut Session<'_, '_>,
    plan: &Plan<'_>,
    record: &mut Record,
) -> Result<TrainedNetwork> {
    let body = session.body;
    let mut geometry = timed(&mut record.prepare_s, || {
        // Rigid motions read virtual nodes too, which then form clusters up to the whole body.
        let (levels, own) = (plan.network.virtual_nodes.as_deref(), plan.coordinates);
        let plain = matches!(own, OutputCoordinates::Components | OutputCoordinates::Simulations);
        data::geometry(body, levels, !plain, session.options.seed)
    })?;
    record.virtual_nodes.clone_from(&geometry.topology.roots_per_layer);
    let sample = |(index, theta): (usize, &Vec<f64>)| Sample {
        geometry: 0,
        theta: theta.clone(),
        displacement: plan.fields.map(|fields| fields[index].clone()).unwrap_or_default(),
    };
    let training = plan.thetas.iter().enumerate().map(sample).collect();
    let mut data = DataSet { geometries: Vec::new(), training, validation: Vec::new() };
    let (starts, anchors) = (session.options.start.is_some(), session.options.anchors);
    // Further anchors stand about a solved state.
    let solves = starts || anchors > 1;
    let (coordinates, training) = stages(session, plan, solves);
    let (mut course, mut earlier) = (Course::new(session, plan)?, None);
    let at_rest =
        |geometry: &Geometry| at_rest(body, &geometry.topology, plan.energy).map(Meaning::Motions);
    geometry.coordinates = match &coordinates {
        OutputCoordinates::Components => Meaning::Components,
        OutputCoordinates::Simulations => {
            let fields = plan.fields.unwrap_or_default();
            Meaning::Principal(timed(&mut record.prepare_s, || {
                of_simulations(body, plan.thetas, fields)
            })?)
        }
        OutputCoordinates::Motions => timed(&mut record.prepare_s, || at_rest(&geometry))?,
        // Fine-tuning has no first training that predicts a state of this body, and further anchors stand about a solved one: one solve gives it.
        OutputCoordinates::MotionsAfter(_) if solves => {
            let centre = body.centre();
            let solved = timed(&mut record.prepare_s, || {
                Solver::new(body)?.solve(&centre, &Options::default())
            })?;
            course.session.simulations += if anchors > 1 { anchors } else { 0 };
            timed(&mut record.prepare_s, || course.expanded(&mut geometry, &solved.displacement))?
        }
        OutputCoordinates::MotionsAfter(first) => {
            geometry.coordinates = timed(&mut record.prepare_s, || at_rest(&geometry))?;
            data.geometries = vec![geometry.clone()];
            let surrogate = course.stage("anchor", &data, first)?;
            let anchor = surrogate.predict(&geometry, &[body.centre()])?.concat();
            earlier = course.kept.map(|kept| (surrogate, kept));
            let step = newton_step(body, &anchor)?;
            let anchor = step.map_or(anchor, |step| step.displacement);
            timed(&mut record.prepare_s, || course.expanded(&mut geometry, &anchor))?
        }
    };
    data.geometries = vec![geometry.clone()];
    let last = course.stage("train", &data, &training)?;
    let surrogate = course.better(earlier, last);
    (record.steps, record.train_s) = course.before;
    (record.history, record.kept) = (course.curve, course.kept);
    TrainedNetwork::new(surrogate)
}

/// The coordinates, with the short training that they may need, and the training, within the session's budget.
fn stages(
    session: &Session<'_, '_>,
    plan: &Plan<'_>,
    solves: bool,
) -> (OutputCoordinates, TrainingConfig) {
    let (mut coordinates, mut training) = (plan.coordinates.clone(), plan.training.clone());
    if session.options.start.is_some() {
        training.learning_rate *= RATE_OF_START;
    }
    let mut stages = vec![&mut training];
    if let (OutputCoordinates::MotionsAfter(first), false) = (&mut coordinates, solves) {
        stages.push(first);
    }
    for stage in &mut stages {
        stage.seed = session.options.seed;
        stage.evaluations = stage.evaluations.min(session.options.evaluations).max(1);
    }
    scale(&mut stages, session.options.budget, session.simulate_s);
    (coordinates, training)
}

/// Coordinates of a network's outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputCoordinates {
    /// Displacements, one scale per component (thesis).
    Components,
    /// The directions in which the simulations differ.
    Simulations,
    /// Rigid motions of clusters and displacements of nodes within them, about rest.
    Motions,
    /// Rigid motions about the prediction of a first, short training in [`OutputCoordinates::Motions`] for the centre, so without
    /// simulations.
    MotionsAfter(TrainingConfig),
}

/// Energy of unit outputs about rest [relative to the energy of the linear response], found by trial.
pub(crate) const FIRST_SHARE: f64 = 9.0;

/// Energy of unit outputs about a solution [relative to the loads' work]. Over the parameter range the energy varies by
/// less than its size, and small first steps are safer.
pub(crate) const ENERGY_SHARE: f64 = 0.05;

/// Motions about rest; `energy` is that of the linear response.
pub(crate) fn at_rest(body: &Body, topology: &Topology, energy: f64) -> Result<Motions> {
    let motions =
        Motions::about(&vec![0.0; 3 * body.nodes], &topology.clusters, body, &body.centre())?;
    Ok(motions.of_energy(FIRST_SHARE * energy)?)
}

/// Motions about a displacement, such as one that a first training predicts for the centre of the parameter range; `least_work` is that of
/// the loads.
pub(crate) fn at_anchor(
    body: &Body,
    topology: &Topology,
    anchor: &[f64],
    least_work: f64,
) -> Result<Motions> {
    let anchor = admissible(body, anchor);
    let motions = Motions::about(&anchor, &topology.clusters, body, &body.centre())?;
    Ok(motions.of_energy(ENERGY_SHARE * work(body, &anchor).max(least_work))?)
}

/// Coordinates in which simulations at `thetas` differ beyond a polynomial in the parameters.
pub(crate) fn of_simulations(
    body: &Body,
    thetas: &[Vec<f64>],
    fields: &[Vec<f64>],
) -> Result<PrincipalDirections> {
    /// Power of the standard deviations, found by trial. With 1 the network does not resolve the small directions; with 0
    /// it spends its capacity on them.
    const POWER: f64 = 0.7;
    let parameters = standardised(&scaling(body)?, thetas.iter().map(Vec::as_slice))?;
    let fields = fields.iter().map(Vec::as_slice);
    Ok(PrincipalDirections::about_trend(fields, &parameters, POWER)?)
}

/// A Newton step at the centre of the parameter range; none from a displacement that inverts a cell.
pub(crate) fn newton_step(body: &Body, displacement: &[f64]) -> Result<Option<NewtonStep>> {
    match Solver::new(body)?.newton_steps(displacement, &body.centre(), 1) {
        Ok(mut steps) => Ok(steps.pop()),
        Err(SolveError::Inadmissible { .. }) => Ok(None),
        Err(other) => Err(other.into()),
    }
}

//! Training one emulator of a beam, with progress, curves and resumption.

use crate::evaluate::TestSet;
use crate::options::Method;
use crate::plan::{Coordinates, Plan};
use crate::report::{self, CurvePoint, EnergyPoint, PerMetric, TrainingHistory};
use crate::timing::timed;
use crate::{basis, progress, store};
use anyhow::{Context, Result};
use burn::tensor::Device;
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};
use sinew_gnn::{
    Concern, DataFit, DataFitWithGradient, DataSet, EmulatorConfig, EnergyNormFit, Geometry,
    GradientOperator, HistoryPoint, MinimumPotential, Objective, OutputScale, Progress, Sample,
    Scales, Surrogate, Trainer, TrainingConfig, TrainingReport,
};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What all emulators of a scene share.
#[derive(Debug)]
pub struct Body {
    /// Potential of the solver.
    pub exact: sinew_energy::Body,
    /// The same with barriers, for training.
    pub potential: sinew_energy::Body,
    /// Augmented graph.
    pub topology: sinew_graph::Topology,
    /// Features and supports.
    pub geometry: Geometry,
    /// Ranges of the parameters.
    pub parameters: sinew_gnn::ParameterScaling,
    /// Parameters to train with.
    pub thetas: Vec<Vec<f64>>,
    /// Linear response to the loads at the centre of the parameter range \[mm\]: the scale of
    /// displacement and energy that training without simulations starts from.
    pub linear_response: Vec<f64>,
    /// Its parameters.
    pub centre: Vec<f64>,
}

/// A trained emulator and how it got there.
#[derive(Debug)]
pub struct Trained {
    /// The emulator.
    pub surrogate: Surrogate,
    /// The geometry it predicts, with the coordinates it learned in.
    pub geometry: Geometry,
    /// Optimiser steps of all stages.
    pub steps: u64,
    /// Training time of all stages \[s\].
    pub seconds: f64,
    /// Time spent on coordinates of the displacement \[s\].
    pub prepare_s: f64,
    /// Validation errors and energies on the way.
    pub history: TrainingHistory,
    /// Reasons not to trust the emulator.
    pub concerns: Vec<String>,
}

/// Where and how an emulator is trained.
#[derive(Debug)]
pub struct Workshop<'a> {
    /// The body.
    pub body: &'a Body,
    /// How it is trained.
    pub method: Method,
    /// Simulated displacements at the body's parameters; `None` for training without any.
    pub fields: Option<&'a [Vec<f64>]>,
    /// Cases that the curves are drawn over.
    pub validation: &'a TestSet,
    /// Backend.
    pub device: &'a Device,
    /// Checkpoints and curves go here.
    pub folder: &'a Path,
    /// Whether to continue from the checkpoints in the folder.
    pub resume: bool,
}

impl Workshop<'_> {
    /// Trains by `plan`; an interrupted run goes on from its last checkpoint.
    ///
    /// # Errors
    /// Divergence, files that cannot be written or read.
    pub fn train(&self, plan: &Plan) -> Result<Trained> {
        let mut watch = Watch::new(self)?;
        let mut geometry = self.body.geometry.clone();
        let (mut before, mut prepare_s) = ((0, 0.0), 0.0);
        geometry.coordinates = match &plan.coordinates {
            Coordinates::Components => sinew_gnn::Coordinates::Components,
            Coordinates::Simulations => {
                let fields = self.simulations()?;
                sinew_gnn::Coordinates::Basis(timed(&mut prepare_s, || {
                    basis::of_simulations(fields)
                })?)
            }
            Coordinates::StiffnessOfSimulation => {
                let anchor = self.anchoring_simulation()?;
                let anchored = timed(&mut prepare_s, || basis::at_anchor(self.body, anchor))?;
                sinew_gnn::Coordinates::Basis(anchored.basis)
            }
            Coordinates::StiffnessAfter(first) => {
                let at_rest = timed(&mut prepare_s, || basis::at_rest(self.body))?;
                geometry.coordinates = sinew_gnn::Coordinates::Basis(at_rest);
                let (surrogate, report) = self.stage("anchor", &geometry, first, &mut watch)?;
                before = (report.steps as u64, report.seconds);
                watch.before = before;
                let centre = std::slice::from_ref(&self.body.centre);
                let anchor = surrogate.predict(&geometry, centre)?.displacement;
                let anchored = timed(&mut prepare_s, || basis::at_anchor(self.body, &anchor))?;
                sinew_gnn::Coordinates::Basis(anchored.basis)
            }
        };
        let (surrogate, report) = self.stage("train", &geometry, &plan.training, &mut watch)?;
        if self.method == Method::Pi {
            let centre = std::slice::from_ref(&self.body.centre);
            let predicted = surrogate.predict(&geometry, centre)?.displacement;
            watch.judge_equilibrium(basis::at_anchor(self.body, &predicted)?.excess);
        }
        progress::finish(
            &watch.bar,
            &format!("{} steps, {}", before.0 + report.steps as u64, watch.outcome()),
        );
        let curves = &watch.curves;
        Ok(Trained {
            surrogate,
            geometry,
            steps: before.0 + report.steps as u64,
            seconds: before.1 + report.seconds,
            prepare_s,
            history: TrainingHistory::new(self.method.into(), &curves.errors, &curves.energy),
            concerns: watch.concerns,
        })
    }

    fn stage(
        &self,
        name: &str,
        geometry: &Geometry,
        config: &TrainingConfig,
        watch: &mut Watch<'_>,
    ) -> Result<(Surrogate, TrainingReport)> {
        let output = self.output_scale()?;
        let data = self.data_set(geometry);
        let objective = self.objective(&output, &data)?;
        let checkpoint = self.folder.join(name);
        let mut trainer = if self.resume && checkpoint.exists() {
            Trainer::resume(&checkpoint, data, objective, self.device)?
        } else {
            let features = &geometry.features;
            let parameters = &self.body.parameters;
            let (nodes, edges) = (features.nodes.columns, features.edges.columns);
            let network = EmulatorConfig::new(3, nodes, edges, parameters.ranges().len());
            let scales = Scales::over(&data.geometries, parameters.clone(), output)?;
            let surrogate = Surrogate::new(&network, &data, scales, config.seed, self.device)?;
            Trainer::new(surrogate, data, objective, config.clone())?.with_checkpoints(&checkpoint)
        };
        watch.begin(name, geometry);
        let report = trainer.run(watch).with_context(|| {
            format!("training {} on {}", self.method.key(), self.folder.display())
        })?;
        watch.failure.take().map_or(Ok(()), Err)?;
        report
            .concerns
            .iter()
            .for_each(|concern| watch.raise(format!("training `{name}`: {concern}")));
        Ok((trainer.into_surrogate(), report))
    }

    /// Sizes of displacements, from simulations where there are any.
    fn output_scale(&self) -> Result<OutputScale> {
        Ok(match self.fields {
            Some(fields) => OutputScale::root_mean_square(3, fields.iter().map(Vec::as_slice))?,
            None => OutputScale::root_mean_square(3, [&self.body.linear_response[..]])?,
        })
    }

    fn simulations(&self) -> Result<&[Vec<f64>]> {
        self.fields.with_context(|| format!("{} needs simulations", self.method.key()))
    }

    fn anchoring_simulation(&self) -> Result<&[f64]> {
        let nearest = basis::nearest_to_centre(self.body, self.simulations()?);
        nearest.context("there is no simulation to begin from")
    }

    fn data_set(&self, geometry: &Geometry) -> DataSet {
        let sample = |(index, theta): (usize, &Vec<f64>)| Sample {
            geometry: 0,
            theta: theta.clone(),
            displacement: self.fields.map(|fields| fields[index].clone()).unwrap_or_default(),
        };
        DataSet {
            topology: self.body.topology.clone(),
            geometries: vec![geometry.clone()],
            training: self.body.thetas.iter().enumerate().map(sample).collect(),
            validation: Vec::new(),
        }
    }

    /// The one place where the methods differ.
    fn objective(&self, output: &OutputScale, data: &DataSet) -> Result<Box<dyn Objective>> {
        /// Weight of the deformation gradients in (B.1): both terms are then of one size at the start.
        const GRADIENT_WEIGHT: f64 = 1.0;
        let potential = &self.body.potential;
        Ok(match self.method {
            Method::Dd => Box::new(DataFit::new(output.length())?),
            Method::Hybrid => {
                let anchor = self.anchoring_simulation()?;
                let stiffness = self.body.exact.stiffness(anchor, &self.body.centre);
                let stiffness = stiffness.context("a simulation inverts a cell")?;
                Box::new(EnergyNormFit::new(vec![stiffness], data)?)
            }
            Method::Fdd => {
                let operator = GradientOperator {
                    nodes_per_cell: potential.nodes_per_cell,
                    cells: potential.cells.clone(),
                    shape_gradients: potential.shape_gradients.as_flattened().to_vec(),
                };
                Box::new(DataFitWithGradient::new(
                    output.length(),
                    GRADIENT_WEIGHT,
                    vec![operator],
                )?)
            }
            Method::Pi => {
                let energy = MinimumPotential::energy_of_linear_response(
                    potential,
                    &self.body.linear_response,
                    &self.body.centre,
                )?;
                Box::new(MinimumPotential::new(vec![Arc::new(potential.clone())], energy)?)
            }
        })
    }
}

/// Draws the bar and records errors on the validation cases.
struct Watch<'a> {
    bar: ProgressBar,
    validation: &'a TestSet,
    geometry: Geometry,
    file: PathBuf,
    curves: Curves,
    /// Steps and seconds of the stage before.
    before: (u64, f64),
    failure: Option<anyhow::Error>,
    concerns: Vec<String>,
    /// Whether a concern of this stage was said before its end.
    warned: bool,
}

#[derive(Default, Serialize, Deserialize)]
struct Curves {
    errors: Vec<CurvePoint>,
    energy: Vec<EnergyPoint>,
}

impl<'a> Watch<'a> {
    fn new(workshop: &Workshop<'a>) -> Result<Self> {
        let file = workshop.folder.join("curve.json");
        let stored = if workshop.resume { store::read_json(&file)? } else { None };
        Ok(Self {
            bar: progress::bar(&format!("train {}", workshop.method.key()), 1),
            validation: workshop.validation,
            geometry: workshop.body.geometry.clone(),
            file,
            curves: stored.unwrap_or_default(),
            before: (0, 0.0),
            failure: None,
            concerns: Vec::new(),
            warned: false,
        })
    }

    /// Prepares for a stage, which predicts on `geometry`.
    fn begin(&mut self, stage: &str, geometry: &Geometry) {
        (self.geometry, self.warned) = (geometry.clone(), false);
        self.bar.set_prefix(format!(
            "{} ({stage})",
            self.bar.prefix().split(" (").next().unwrap_or("")
        ));
    }

    fn record(&mut self, surrogate: &Surrogate, point: &HistoryPoint) -> Result<()> {
        let prediction = surrogate.predict(&self.geometry, &self.validation.thetas)?;
        let fields: Vec<_> =
            (0..self.validation.thetas.len()).map(|case| prediction.field(case).to_vec()).collect();
        let medians: PerMetric<f64> = self.validation.evaluate(&fields)?.medians()?;
        let (step, train_s) = (self.before.0 + point.step as u64, self.before.1 + point.seconds);
        // A run that was killed after its last checkpoint repeats some evaluations.
        self.curves.errors.retain(|earlier| earlier.step < step);
        self.curves.energy.retain(|earlier| earlier.step < step);
        self.curves.errors.push(CurvePoint::new(step, train_s, medians, point.loss));
        let excess = self.validation.mean_energy_excess(&fields);
        let excess_pct = excess.is_finite().then_some(excess);
        self.curves.energy.push(EnergyPoint { step, train_s, excess_pct });
        store::write_json(&self.file, &self.curves)
    }

    /// Keeps a reason not to trust the emulator, and says it at once.
    fn raise(&mut self, concern: String) {
        self.warn(&concern);
        self.concerns.push(concern);
    }

    fn warn(&self, text: &str) {
        self.bar.suspend(|| eprintln!("warning: {text}"));
    }

    /// Without simulations nothing but equilibrium tells whether a training went well; `excess` is that of
    /// [`basis::Anchored`].
    fn judge_equilibrium(&mut self, excess: f64) {
        /// The energy is then off by about as much.
        const FAR: f64 = 1e-2;
        if excess > FAR {
            self.raise(format!(
                "predictions are far from equilibrium: at the centre of the parameter range a Newton step would gain \
                 {:.1} % of the loads' work; train for longer",
                100.0 * excess
            ));
        }
    }

    fn outcome(&self) -> String {
        let last = self.curves.errors.last().and_then(|point| point.errors.err_u_mm);
        last.map_or_else(String::new, |error| format!("median error {error:.2e} mm"))
    }
}

impl sinew_gnn::Observer for Watch<'_> {
    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.bar.set_length(progress.steps as u64);
        self.bar.set_position(progress.step as u64);
        self.bar.set_message(format!("loss {:.3e}  {}", progress.loss, self.outcome()));
        if self.failure.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn evaluate(&mut self, surrogate: &Surrogate, point: &HistoryPoint) {
        if let Err(error) = self.record(surrogate, point) {
            self.failure = Some(error);
        }
    }

    fn concern(&mut self, concern: &Concern) {
        if !std::mem::replace(&mut self.warned, true) {
            self.warn(&format!("so far {concern}"));
        }
    }
}

impl From<Method> for report::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Dd => report::Method::Dd,
            Method::Pi => report::Method::Pi,
            Method::Hybrid => report::Method::Hybrid,
            Method::Fdd => report::Method::Fdd,
        }
    }
}

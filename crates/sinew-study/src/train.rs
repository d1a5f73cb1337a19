//! Training one emulator of a beam, with progress, curves and resumption.

use crate::evaluate::TestSet;
use crate::options::Method;
use crate::plan::Plan;
use crate::report::{self, CurvePoint, EnergyPoint, PerMetric, TrainingHistory};
use crate::{progress, store};
use anyhow::{Context, Result};
use burn::tensor::Device;
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Barriers, TotalPotential};
use sinew_gnn::{
    DataFit, DataFitWithGradient, DataSet, EmulatorConfig, Geometry, GradientOperator, HistoryPoint,
    MinimumPotential, Objective, OutputScale, Progress, Sample, Scales, Surrogate, Trainer,
    TrainingReport,
};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What all emulators of a scene share.
#[derive(Debug)]
pub struct Body {
    /// Potential for training, with barriers.
    pub potential: TotalPotential<NeoHookean, 0, Barriers>,
    /// Augmented graph.
    pub topology: sinew_graph::Topology,
    /// Features and supports.
    pub geometry: Geometry,
    /// Ranges of the parameters.
    pub parameters: sinew_gnn::ParameterScaling,
    /// Parameters to train with.
    pub thetas: Vec<Vec<f64>>,
    /// Linear response to the loads at the centre of the parameter range [mm]: the scale of
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
    /// Steps, seconds, why it ended.
    pub report: TrainingReport,
    /// Validation errors and energies on the way.
    pub history: TrainingHistory,
}

/// Trains one emulator; continues from the checkpoint in `folder` if there is one and `resume` is set.
///
/// `fields` are the simulated displacements at `body.thetas`; `None` for training without any.
///
/// # Errors
/// Divergence, files that cannot be written or read.
pub fn train(
    body: &Body,
    method: Method,
    fields: Option<&[Vec<f64>]>,
    plan: &Plan,
    validation: &TestSet,
    device: &Device,
    folder: &Path,
    resume: bool,
) -> Result<Trained> {
    let output = output_scale(body, fields)?;
    let data = data_set(body, fields);
    let objective = objective(body, method, &output)?;
    let checkpoint = folder.join("checkpoint");
    let mut trainer = if resume && checkpoint.exists() {
        Trainer::resume(&checkpoint, data, objective, device)?
    } else {
        let features = &body.geometry.features;
        let config = EmulatorConfig::new(
            3,
            features.nodes.columns,
            features.edges.columns,
            body.parameters.ranges().len(),
        );
        let scales = Scales::over(&data.geometries, body.parameters.clone(), output)?;
        let surrogate = Surrogate::new(&config, &data, scales, plan.training.seed, device)?;
        Trainer::new(surrogate, data, objective, plan.training.clone())?.with_checkpoints(&checkpoint)
    };
    let mut watch = Watch::new(method, validation, &body.geometry, folder.join("curve.json"), resume)?;
    let report = trainer.run(&mut watch).with_context(|| format!("training {}", method.key()))?;
    if let Some(error) = watch.failure.take() {
        return Err(error);
    }
    progress::finish(&watch.bar, &format!("{} steps, {}", report.steps, watch.outcome()));
    let curves = &watch.curves;
    let history = TrainingHistory::new(method.into(), &curves.errors, &curves.energy);
    Ok(Trained { surrogate: trainer.into_surrogate(), report, history })
}

fn output_scale(body: &Body, fields: Option<&[Vec<f64>]>) -> Result<OutputScale> {
    Ok(match fields {
        Some(fields) => OutputScale::root_mean_square(3, fields.iter().map(Vec::as_slice))?,
        None => OutputScale::root_mean_square(3, [&body.linear_response[..]])?,
    })
}

fn data_set(body: &Body, fields: Option<&[Vec<f64>]>) -> DataSet {
    let sample = |(index, theta): (usize, &Vec<f64>)| Sample {
        geometry: 0,
        theta: theta.clone(),
        displacement: fields.map(|fields| fields[index].clone()).unwrap_or_default(),
    };
    DataSet {
        topology: body.topology.clone(),
        geometries: vec![body.geometry.clone()],
        training: body.thetas.iter().enumerate().map(sample).collect(),
        validation: Vec::new(),
    }
}

/// The one place where the methods differ.
fn objective(body: &Body, method: Method, output: &OutputScale) -> Result<Box<dyn Objective>> {
    /// Weight of the deformation gradients in (B.1): both terms are then of one size at the start.
    const GRADIENT_WEIGHT: f64 = 1.0;
    Ok(match method {
        Method::Dd => Box::new(DataFit::new(output.length())?),
        Method::Fdd => {
            let operator = GradientOperator {
                nodes_per_cell: 4,
                cells: body.potential.cells.as_flattened().to_vec(),
                shape_gradients: body.potential.shape_gradients.as_flattened().as_flattened().to_vec(),
            };
            Box::new(DataFitWithGradient::new(output.length(), GRADIENT_WEIGHT, vec![operator])?)
        }
        Method::Pi => {
            let energy = MinimumPotential::energy_of_linear_response(
                &body.potential,
                &body.linear_response,
                &body.centre,
            )?;
            Box::new(MinimumPotential::new(vec![Arc::new(body.potential.clone())], energy)?)
        }
    })
}

/// Draws the bar and records errors on the validation cases.
struct Watch<'a> {
    bar: ProgressBar,
    validation: &'a TestSet,
    geometry: &'a Geometry,
    file: PathBuf,
    curves: Curves,
    failure: Option<anyhow::Error>,
}

#[derive(Default, Serialize, Deserialize)]
struct Curves {
    errors: Vec<CurvePoint>,
    energy: Vec<EnergyPoint>,
}

impl<'a> Watch<'a> {
    fn new(
        method: Method,
        validation: &'a TestSet,
        geometry: &'a Geometry,
        file: PathBuf,
        resume: bool,
    ) -> Result<Self> {
        let curves = if resume { store::read_json(&file)?.unwrap_or_default() } else { Curves::default() };
        let bar = progress::bar(&format!("train {}", method.key()), 1);
        Ok(Self { bar, validation, geometry, file, curves, failure: None })
    }

    fn record(&mut self, surrogate: &Surrogate, point: &HistoryPoint) -> Result<()> {
        let prediction = surrogate.predict(self.geometry, &self.validation.thetas)?;
        let fields: Vec<_> =
            (0..self.validation.thetas.len()).map(|case| prediction.field(case).to_vec()).collect();
        let medians: PerMetric<f64> = self.validation.evaluate(&fields)?.medians()?;
        let step = point.step as u64;
        // A run that was killed after its last checkpoint repeats some evaluations.
        self.curves.errors.retain(|earlier| earlier.step < step);
        self.curves.energy.retain(|earlier| earlier.step < step);
        self.curves.errors.push(CurvePoint::new(step, point.seconds, medians, point.loss));
        let excess = self.validation.mean_energy_excess(&fields);
        let excess_pct = excess.is_finite().then_some(excess);
        self.curves.energy.push(EnergyPoint { step, train_s: point.seconds, excess_pct });
        store::write_json(&self.file, &self.curves)
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
}

impl From<Method> for report::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Dd => report::Method::Dd,
            Method::Pi => report::Method::Pi,
            Method::Fdd => report::Method::Fdd,
        }
    }
}

//! Predictions and their corrections.

mod answer;
use super::{
    Batch, CaseArguments, MOST_WARNINGS, Neighbour, ThetaArguments, Written, chosen, refuse_if,
    runs, warn,
};
pub(crate) use answer::Plan;
use anyhow::{Result, ensure};
use clap::Args;
use sinew::output::{Quality, Row, displacement_in_words};
use sinew::{Body, Case, Emulator, EmulatorError, Estimate, Prediction, Warning, theta_in_words};
use sinew_emulate::{Correction, Counter, Terminal};
use sinew_num::in_parallel;
use std::path::Path;

/// Estimates between two signs of progress.
const AT_ONCE: usize = 64;

/// Arguments of both commands.
#[derive(Debug, Args)]
pub(crate) struct Asked {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    theta: ThetaArguments,
    /// Name of the emulator's folder within OUT, such as `regression` [default: the only one, or that of the case's recipe]
    #[arg(long, value_name = "NAME")]
    emulator: Option<String>,
    #[command(flatten)]
    written: Written,
}

/// Parameters and emulator.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/predict.txt"))]
pub(crate) struct Predict {
    #[command(flatten)]
    asked: Asked,
    /// Quasi-Newton steps with the frozen stiffness of the centre of the ranges, the same for all cases
    #[arg(long, value_name = "STEPS", default_value_t = 0)]
    refine: usize,
    /// Leave out error estimates
    #[arg(long)]
    quick: bool,
    /// Largest mean nodal error, relative to the mean nodal displacement, such as 1e-3: answers are refined until their error
    /// estimate is within it
    #[arg(long, value_name = "TOLERANCE", conflicts_with_all = ["refine", "quick"])]
    accuracy: Option<f64>,
    #[command(flatten)]
    neighbour: Neighbour,
}

/// Parameters and number of steps.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/correct.txt"))]
pub(crate) struct Correct {
    #[command(flatten)]
    asked: Asked,
    /// Newton steps, 1 or more
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
}

impl Asked {
    /// Reads θ and the emulator, and repeats the warnings of its training. Then computes and
    /// writes the rows in parts, into a folder of the command and the emulator.
    fn in_parts(
        &self,
        command: &str,
        (case, body, folder): (&Case, &Body, &Path),
        compute: impl Fn(Batch<'_>, &Emulator<'_>, &Path) -> Result<usize>,
    ) -> Result<()> {
        let (name, path) = chosen(self.emulator.as_deref(), case, folder)?;
        let folder = folder.join(command).join(&name);
        let batch = self.theta.read(body, None, Some(&folder))?;
        let emulator = sinew::load(&path, body)?;
        for warning in &emulator.record.warnings {
            eprintln!("warning: the training of `{name}` said: {warning}");
        }
        batch.in_parts(&self.written, |batch| compute(batch, &emulator, &folder))
    }
}

impl Predict {
    pub(crate) fn run(&self) -> Result<()> {
        let Asked { case, theta, written, .. } = &self.asked;
        let asked = [
            self.accuracy.is_some(),
            self.refine > 0,
            self.neighbour.from.is_some(),
            self.quick,
            self.asked.emulator.is_some(),
            written.fields,
        ];
        let options = "--accuracy, --refine, --from, --quick, --emulator, --fields";
        if let Some(emulator) = runs::trained(case, asked, options)? {
            return runs::predict(&emulator, case, theta, written.pictures);
        }
        let (case, body, folder) = case.open()?;
        if let Some(accuracy) = self.accuracy {
            return answer::to(&self.asked, accuracy, &self.neighbour, (&case, &body, &folder));
        }
        let reason = "--from answers to an accuracy: add --accuracy 1e-3";
        refuse_if(self.neighbour.body()?.is_some(), || reason)?;
        let part = |batch: Batch<'_>, by: &Emulator<'_>, to: &Path| self.part(batch, by, to);
        self.asked.in_parts("predict", (&case, &body, &folder), part)
    }

    /// Predicts and writes a part of the rows; returns how many failed.
    fn part(&self, mut batch: Batch<'_>, emulator: &Emulator<'_>, folder: &Path) -> Result<usize> {
        let body = emulator.body();
        let prediction = predicted(emulator, &mut batch, self.refine)?;
        let estimates = if self.quick { Vec::new() } else { estimated(emulator, &prediction) };
        let unit = &body.units.length;
        let fields = (0..prediction.thetas.len()).map(|place| prediction.field(place));
        batch.tell_states(&prediction.thetas, fields);
        batch.print(|place| {
            let moved = displacement_in_words(prediction.field(place), unit);
            let error = estimates.get(place).map_or(String::new(), |found| found.in_words(unit));
            let between = if error.is_empty() { "" } else { "; " };
            format!(": displacement {moved}{between}{error}")
        });
        let answer = |place: usize| Row {
            fields: vec![prediction.field(place)],
            quality: estimates.get(place).map(|found| quality(found, unit)),
            warnings: others(&prediction.warnings[place]),
            ..Row::default()
        };
        let answers = (0..prediction.thetas.len()).map(answer);
        batch.write(&["predicted"], answers, &self.asked.written, folder)
    }
}

/// Predictions for the open rows; those that have none are closed.
///
/// # Errors
/// No row has one.
fn predicted(emulator: &Emulator<'_>, batch: &mut Batch<'_>, steps: usize) -> Result<Prediction> {
    let refined = |thetas: &[Vec<f64>], wrong: &'static str| {
        let found = emulator.refine(thetas, steps)?;
        ensure!(found.displacement.iter().all(|u| u.is_finite()), wrong);
        Ok(found)
    };
    let thetas = batch.thetas();
    let refused = match refined(&thetas, "no prediction is finite") {
        Ok(prediction) => return Ok(prediction),
        Err(refused) => refused,
    };
    // Which of them, one by one.
    let alone = |theta: Vec<f64>| {
        let found = refined(&[theta], "the prediction is not finite");
        found.map(drop).map_err(|error| error.to_string())
    };
    match batch.answered(thetas.into_iter().map(alone)).is_empty() {
        true if batch.is_first() => Err(refused),
        true => Ok(emulator.predict(&[])?),
        false => Ok(emulator.refine(&batch.thetas(), steps)?),
    }
}

/// Error estimates on all threads, with progress on the terminal. One that fails says why, and the others are made.
fn estimated(emulator: &Emulator<'_>, prediction: &Prediction) -> Vec<Estimate> {
    let cases: Vec<usize> = (0..prediction.thetas.len()).collect();
    let mut terminal = Terminal::default();
    let mut counter = Counter::new(&mut terminal, "estimate errors", 0, cases.len());
    let mut estimates = Vec::with_capacity(cases.len());
    let estimate = |&case: &usize| {
        let failed = |error: EmulatorError| Estimate {
            distance: None,
            residual: None,
            newton_steps: 0,
            seconds: 0.0,
            warnings: vec![Warning::NotNearEquilibrium { reason: error.to_string() }],
        };
        emulator.estimate(prediction, case).unwrap_or_else(failed)
    };
    for cases in cases.chunks(AT_ONCE) {
        estimates.extend(in_parallel(cases, estimate));
        let _ = counter.step(cases.len(), "");
    }
    estimates
}

/// An estimate for the table.
fn quality(estimate: &Estimate, unit: &str) -> Quality {
    let Estimate { distance, residual, newton_steps, .. } = estimate;
    let kind = match (distance, newton_steps) {
        (Some(_), 1) => "1 Newton step".into(),
        (Some(_), steps) => format!("{steps} Newton steps"),
        (None, _) => estimate.in_words(unit),
    };
    Quality {
        mean: distance.map(|found| found.mean),
        largest: distance.map(|found| found.largest),
        energy_norm: distance.map(|found| 100.0 * found.relative),
        kind,
        residual: *residual,
    }
}

/// Warnings that no other column of the table holds.
fn others(warnings: &[Warning]) -> Vec<String> {
    let told = |warning: &&Warning| {
        !matches!(warning, Warning::OutsideRange { .. } | Warning::NotNearEquilibrium { .. })
    };
    warnings.iter().filter(told).map(ToString::to_string).collect()
}

impl Correct {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.asked.case.open()?;
        let part = |batch: Batch<'_>, by: &Emulator<'_>, to: &Path| self.part(batch, by, to);
        self.asked.in_parts("correct", (&case, &body, &folder), part)
    }

    /// Corrects and writes a part of the rows; returns how many failed.
    fn part(&self, mut batch: Batch<'_>, emulator: &Emulator<'_>, folder: &Path) -> Result<usize> {
        let body = emulator.body();
        let correct = |theta: Vec<f64>| {
            let found = emulator.correct(&theta, self.steps as usize);
            let found = found.map_err(|error| error.to_string())?;
            tell(body, &theta, &found);
            Ok(found)
        };
        let corrected = batch.answered(batch.thetas().into_iter().map(correct));
        let thetas = batch.thetas();
        batch.tell_states(&thetas, corrected.iter().map(|found| &found.displacement[..]));
        let predicted = emulator.predict(&thetas)?.fields();
        let unit = &body.units.length;
        let answers = corrected.iter().zip(&predicted).map(|(found, before)| Row {
            fields: vec![&found.displacement, before],
            quality: Some(quality(&found.estimate, unit)),
            warnings: others(&found.warnings),
            ..Row::default()
        });
        batch.write(&["corrected", "predicted"], answers, &self.asked.written, folder)
    }
}

fn tell(body: &Body, theta: &[f64], correction: &Correction) {
    println!("{}", theta_in_words(body, theta));
    for (index, step) in correction.steps.iter().enumerate() {
        // A body without forces is balanced.
        let scale = step.force_scale.max(f64::MIN_POSITIVE);
        println!(
            "  step {}: residual {:.1e} to {:.1e} of the forces, energy norm of the step {:.1e}, {:.1} ms",
            index + 1,
            step.residual_before / scale,
            step.residual_after / scale,
            step.energy_norm,
            1e3 * step.seconds
        );
    }
    println!("  {}", correction.estimate.in_words(&body.units.length));
    warn(others(&correction.warnings).iter().take(MOST_WARNINGS));
}

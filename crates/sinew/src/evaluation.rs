//! Errors and times of emulators beside the solver's.

use serde::{Deserialize, Serialize};
use sinew_emulate::{
    Emulator, Errors, Observer, Progress, Quantiles, TestSet, Warning, median_seconds,
};
use sinew_fem::{Options, SolveError, Solver};
use std::fmt;
use std::ops::ControlFlow;

/// Errors and times of some emulators of one body, on the same test cases.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Name of the scene.
    pub scene: String,
    /// Unit of lengths.
    pub length_unit: String,
    /// Nodes of its mesh.
    pub nodes: usize,
    /// Components that no support prescribes.
    pub unknowns: usize,
    /// Test cases.
    pub cases: usize,
    /// Nodal displacements of the test cases \[length\].
    pub displacement: Quantiles,
    /// Wall time of a solve from rest \[s\].
    pub solve_s: Option<f64>,
    /// The emulators.
    pub methods: Vec<Method>,
}

/// Errors and times of one emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Its name, such as that of its recipe.
    pub name: String,
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Optimiser steps.
    pub steps: u64,
    /// Wall times.
    pub times: Times,
    /// Errors as it predicts.
    pub raw: Errors,
    /// Errors after one, two, … Newton steps.
    pub corrected: Vec<Errors>,
    /// Test cases whose prediction inverts a cell, which no step can correct.
    pub inverted: usize,
    /// How well its estimates do.
    pub estimates: Coverage,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

/// Wall times \[s\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Simulations to learn from.
    pub simulate: f64,
    /// Preparation and training.
    pub train: f64,
    /// A prediction with message passing.
    pub full: f64,
    /// A prediction of a known geometry.
    pub one: f64,
    /// A prediction within all test cases at once.
    pub batch: f64,
    /// A Newton step.
    pub step: f64,
}

/// How many true errors lie where they are estimated to be, in the energy norm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Share within a factor of two of the estimate.
    pub within_two: f64,
    /// Share within the interval that is to hold 95 %.
    pub within_interval: f64,
}

/// Timed calls of a prediction, of which the median counts.
const REPEATS: usize = 15;

impl Evaluation {
    /// Of no emulator yet; a solve from rest at the centre of the ranges is timed.
    pub fn new(test: &TestSet<'_>) -> Self {
        let body = test.body;
        let lengths = test.fields.iter().flat_map(|field| {
            field.as_chunks::<3>().0.iter().map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt())
        });
        let centre = body.centre();
        let solve =
            || -> Result<_, SolveError> { Solver::new(body)?.solve(&centre, &Options::default()) };
        Self {
            scene: body.name.clone(),
            length_unit: body.units.length.clone(),
            nodes: body.nodes,
            unknowns: body.free_degrees_of_freedom().len(),
            cases: test.thetas.len(),
            displacement: Quantiles::of(lengths),
            solve_s: median_seconds(3, solve).ok(),
            methods: Vec::new(),
        }
    }

    /// Adds an emulator, raw and after one to `corrections` Newton steps.
    ///
    /// # Errors
    /// A test case that the emulator or the solver cannot be asked for, an observer that breaks.
    pub fn add(
        &mut self,
        name: &str,
        emulator: &Emulator<'_>,
        test: &TestSet<'_>,
        corrections: usize,
        observer: &mut dyn Observer,
    ) -> Result<(), sinew_emulate::Error> {
        let prediction = emulator.predict(&test.thetas)?;
        let raw = prediction.fields();
        let mut corrected = vec![raw.clone(); corrections];
        let (mut inverted, mut step_s, mut ratios) = (0, Vec::new(), Vec::new());
        let mut solver = Solver::new(test.body)?;
        let stage = format!("evaluate {name}");
        let start = std::time::Instant::now();
        for (case, theta) in test.thetas.iter().enumerate() {
            let steps = match emulator.correct(theta, corrections) {
                Ok(correction) => correction.steps,
                Err(sinew_emulate::Error::Solve(SolveError::Inadmissible { .. })) => {
                    inverted += 1;
                    ratios.push([f64::INFINITY; 2]);
                    continue;
                }
                Err(other) => return Err(other),
            };
            for (index, fields) in corrected.iter_mut().enumerate() {
                if let Some(step) = steps.get(index).or(steps.last()) {
                    fields[case].clone_from(&step.displacement);
                }
            }
            step_s.extend(steps.iter().map(|step| step.seconds));
            let estimate = emulator.estimate(&prediction, case)?;
            let error: Vec<f64> =
                raw[case].iter().zip(&test.fields[case]).map(|(a, b)| a - b).collect();
            let actual = solver.energy_norm(&test.fields[case], theta, &error)?;
            let factor = |a: f64, b: f64| if a == b { 1.0 } else { (a / b).max(b / a) };
            ratios.push([
                factor(actual, estimate.energy_norm),
                factor(estimate.between[1], estimate.energy_norm),
            ]);
            let done = (case + 1) as f64 / test.thetas.len() as f64;
            let seconds_left = start.elapsed().as_secs_f64() * (1.0 - done) / done;
            let progress = Progress { stage: &stage, fraction: done, seconds_left, message: "" };
            if let ControlFlow::Break(()) = observer.progress(&progress) {
                return Err(sinew_emulate::Error::Interrupted { stage });
            }
        }
        let share = |holds: fn(&[f64; 2]) -> bool| {
            ratios.iter().filter(|ratio| holds(ratio)).count() as f64 / ratios.len().max(1) as f64
        };
        let estimates = Coverage {
            within_two: share(|[ratio, _]| *ratio <= 2.0),
            within_interval: share(|[ratio, spread]| ratio.is_finite() && ratio <= spread),
        };
        let errors: Result<Vec<_>, _> =
            corrected.iter().map(|fields| test.errors(fields)).collect();
        let record = &emulator.record;
        self.methods.push(Method {
            name: name.into(),
            simulations: record.simulations,
            steps: record.steps,
            times: times(emulator, test, &step_s)?,
            raw: test.errors(&raw)?,
            corrected: errors?,
            inverted,
            estimates,
            warnings: record.warnings.clone(),
        });
        let best = &self.methods[self.methods.len() - 1].raw.err_u;
        let outcome = format!("median err_u {:.1e}, largest {:.1e}", best.q50, best.max);
        observer.finished(&stage, &outcome, start.elapsed().as_secs_f64());
        Ok(())
    }
}

fn times(
    emulator: &Emulator<'_>,
    test: &TestSet<'_>,
    steps: &[f64],
) -> Result<Times, sinew_emulate::Error> {
    let (record, one) = (&emulator.record, &test.thetas[..test.thetas.len().min(1)]);
    let batch = median_seconds(REPEATS, || emulator.predict(&test.thetas))?;
    Ok(Times {
        simulate: record.simulate_s,
        train: record.prepare_s + record.train_s,
        full: median_seconds(REPEATS, || emulator.predict_in_full(one))?,
        one: median_seconds(REPEATS, || emulator.predict(one))?,
        batch: batch / test.thetas.len().max(1) as f64,
        step: Quantiles::of(steps.iter().copied()).q50,
    })
}

/// A table: medians of the errors, the largest of err_u, and times.
impl fmt::Display for Evaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, nodes, unknowns, cases, displacement, length_unit: unit, .. } = self;
        writeln!(f, "{scene}: {nodes} nodes, {unknowns} unknowns, {cases} test cases")?;
        writeln!(
            f,
            "displacement: mean {:.3} {unit}, largest {:.3} {unit}",
            displacement.mean, displacement.max
        )?;
        if let Some(seconds) = self.solve_s {
            writeln!(f, "solver from rest: {}", duration(seconds))?;
        }
        writeln!(
            f,
            "{:<22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}  {:>9}",
            "medians",
            format!("err_u {unit}"),
            "largest",
            "err_F %",
            "err_I1 %",
            "err_Pi %",
            "err_V %",
            "time"
        )?;
        for method in &self.methods {
            let times = &method.times;
            row(f, &method.name, &method.raw, times.one)?;
            for (index, errors) in method.corrected.iter().enumerate() {
                let steps = index + 1;
                let name = format!("  {steps} Newton step{}", if steps == 1 { "" } else { "s" });
                row(f, &name, errors, times.one + steps as f64 * times.step)?;
            }
            writeln!(
                f,
                "  {} simulations {}, training {}; predicts in full {}, in a batch {}; estimates within a factor 2: {:.0} %, in their \
                 95 % interval: {:.0} %",
                method.simulations,
                duration(times.simulate),
                duration(times.train),
                duration(times.full),
                duration(times.batch),
                100.0 * method.estimates.within_two,
                100.0 * method.estimates.within_interval
            )?;
            if method.inverted > 0 {
                writeln!(
                    f,
                    "  {} of {cases} predictions invert a cell and were not corrected",
                    method.inverted
                )?;
            }
        }
        Ok(())
    }
}

fn row(f: &mut fmt::Formatter<'_>, name: &str, errors: &Errors, seconds: f64) -> fmt::Result {
    let volume = errors.err_volume.map_or("-".into(), |volume| format!("{:.1e}", volume.q50));
    writeln!(
        f,
        "{name:<22} {:>9.1e} {:>9.1e} {:>9.1e} {:>9.1e} {:>9.1e} {volume:>9}  {:>9}",
        errors.err_u.q50,
        errors.err_u.max,
        errors.err_f.q50,
        errors.err_i1.q50,
        errors.err_pi.q50,
        duration(seconds)
    )
}

/// "3.2 ms", "4.5 s", "3 min 05 s".
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.3} ms", 1e3 * s),
        s if s < 90.0 => format!("{s:.1} s"),
        s => format!("{} min {:02} s", (s / 60.0) as u64, s as u64 % 60),
    }
}

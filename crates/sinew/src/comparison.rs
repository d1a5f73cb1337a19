//! Emulators of one body beside each other.

use crate::locking_in_words;
use crate::theta::{range_in_words, theta_in_words};
use serde::{Deserialize, Serialize};
use sinew_emulate::{
    Calibration, CaseErrors, Emulator, Error, Errors, Evaluation, METRICS, Quantiles, Record,
    Result, TestSet, median_and_worst,
};
use sinew_energy::Body;
use sinew_energy::metrics::displacement_error;
use sinew_fem::locking;
use sinew_report::format::seconds as duration;
use sinew_report::{ReportError, Surfaces, density};
use std::fmt;

/// Errors and times of some emulators of one body, on the same test cases. Printed it is a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Name of the scene.
    pub scene: String,
    /// Unit of lengths.
    pub length_unit: String,
    /// Nodes of its mesh.
    pub nodes: usize,
    /// Cells of its mesh.
    pub cells: usize,
    /// Components that no support prescribes.
    pub unknowns: usize,
    /// Ranges of the parameters, in words.
    pub parameters: Vec<String>,
    /// Nodal displacements of the test cases \[length\].
    pub displacement: Quantiles,
    /// Text of the case file; may be empty.
    pub case: String,
    /// Seed of the test cases.
    pub seed: Option<u64>,
    /// Warnings about the solver's solutions, the reference of the errors.
    pub doubts: Vec<String>,
    /// The emulators.
    pub methods: Vec<Method>,
    /// The body's surface, coloured by its displacement, in the test cases that move it in the middle and the most.
    pub motion: Surfaces,
    /// The body's surface in the median and the worst case of each, coloured by the error.
    pub surfaces: Surfaces,
}

/// One emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Name, such as that of its recipe.
    pub name: String,
    /// Provenance.
    #[serde(flatten)]
    pub record: Record,
    /// Errors and times.
    pub evaluation: Evaluation,
    /// Densities of log₁₀ of the errors of [`sinew_emulate::METRICS`] and of the cavities' volumes: points (error, density per decade).
    pub densities: Vec<Vec<[f64; 2]>>,
    /// Recipe and options of its training, as they were stored beside it; may be empty.
    pub options: String,
}

impl Comparison {
    /// Comparison without emulators yet.
    ///
    /// # Errors
    /// A surface that cannot be drawn.
    pub fn new(test: &TestSet<'_>) -> Result<Self> {
        let body = test.body;
        let unit = &body.units.length;
        let mut surfaces =
            Surfaces::new(&body.mesh.boundary_triangles().0, &body.positions).map_err(refused)?;
        surfaces.quantity = "Where the errors are: ‖u − û‖ at the nodes".into();
        (surfaces.unit, surfaces.length) = (unit.clone(), unit.clone());
        let mut motion = surfaces.clone();
        (motion.quantity, motion.linear) = ("How the body moves: ‖u‖ at the nodes".into(), true);
        draw_motion(&mut motion, test)?;
        let solved = test.thetas.first().zip(test.fields.first());
        let locking = solved.and_then(|(theta, field)| locking(body, theta, field).ok().flatten());
        let norm = |u: &[f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
        let lengths =
            test.fields.iter().flat_map(|field| field.as_chunks::<3>().0.iter().map(norm));
        Ok(Self {
            scene: body.name.clone(),
            length_unit: body.units.length.clone(),
            nodes: body.nodes,
            cells: body.cell_count(),
            unknowns: body.free_degrees_of_freedom().len(),
            parameters: body.parameters.iter().map(range_in_words).collect(),
            displacement: Quantiles::of(lengths),
            case: String::new(),
            seed: None,
            doubts: locking.iter().map(locking_in_words).collect(),
            methods: Vec::new(),
            motion,
            surfaces,
        })
    }

    /// Adds an emulator, raw and after one to `corrections` Newton steps; its errors, case by case.
    ///
    /// # Errors
    /// As [`Emulator::evaluate`].
    pub fn add(
        &mut self,
        name: &str,
        emulator: &Emulator<'_>,
        test: &TestSet<'_>,
        corrections: usize,
    ) -> Result<Vec<CaseErrors>> {
        let fields = emulator.predict(&test.thetas)?.fields();
        let cases = test.cases(&fields)?;
        let pooled = METRICS.map(|metric| metric.pooled(&cases).collect());
        let volumes = cases.iter().flat_map(|case| case.err_volume.iter().copied()).collect();
        let densities = pooled.iter().chain([&volumes]).map(|errors: &Vec<_>| density(errors));
        let densities = densities.collect();
        for (kind, case) in ["median", "worst"].into_iter().zip(median_and_worst(&cases)) {
            let deformed = deformed(test.body, &fields[case]);
            let error = displacement_error(&test.fields[case], &fields[case]);
            let title = format!("{kind} case, {}", theta_in_words(test.body, &test.thetas[case]));
            self.surfaces.push(name, title, &deformed, &error).map_err(refused)?;
        }
        self.methods.push(Method {
            name: name.into(),
            record: emulator.record.clone(),
            evaluation: emulator.evaluate(test, corrections)?,
            densities,
            options: String::new(),
        });
        Ok(cases)
    }

    /// Wall time on one thread of each emulator, and of the solver last, for each of [`Evaluation::SETS`] to each of [`Evaluation::ACCURACIES`] \[s\], as
    /// [`Evaluation::seconds_to`] derives it.
    pub fn seconds(&self) -> Vec<(&str, usize, [f64; Evaluation::ACCURACIES.len()])> {
        let of = |sets: usize| {
            let method = move |method: &'_ Method| {
                Evaluation::ACCURACIES.map(|accuracy| method.evaluation.seconds_to(accuracy, sets))
            };
            let solver = self.methods.first().map(|method| method.evaluation.times.solver_s(sets));
            let methods = self.methods.iter().map(move |m| (m.name.as_str(), sets, method(m)));
            let solver = solver.map(|s| (SOLVER, sets, [s; Evaluation::ACCURACIES.len()]));
            methods.chain(solver)
        };
        Evaluation::SETS.into_iter().flat_map(of).collect()
    }
}

/// An error of a surface that cannot be drawn.
fn refused(error: ReportError) -> Error {
    Error::Refused(error.to_string())
}

/// Draws the solver's solutions of the test cases with the median and the largest mean displacement.
fn draw_motion(surfaces: &mut Surfaces, test: &TestSet<'_>) -> Result<()> {
    let mean = |case: &usize| crate::output::mean_and_largest(&test.fields[*case])[0];
    let mut order: Vec<usize> = (0..test.fields.len()).collect();
    order.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
    let Some(&most) = order.last() else { return Ok(()) };
    let rest = vec![0.0; test.fields[most].len()];
    for (kind, case) in [("median", order[(order.len() - 1) / 2]), ("largest", most)] {
        let field = &test.fields[case];
        let length = displacement_error(field, &rest);
        let title = format!("{kind} motion, {}", theta_in_words(test.body, &test.thetas[case]));
        surfaces.push(SOLVER, title, &deformed(test.body, field), &length).map_err(refused)?;
    }
    Ok(())
}

/// Positions of the nodes at a displacement \[length\].
fn deformed(body: &Body, field: &[f64]) -> Vec<[f64; 3]> {
    let moved = field.as_chunks::<3>().0.iter().zip(&body.positions);
    moved.map(|(u, x)| std::array::from_fn(|i| u[i] + x[i])).collect()
}

/// Name of the row that times are compared with.
pub(crate) const SOLVER: &str = "Newton solver";

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, nodes, unknowns, displacement, length_unit: unit, .. } = self;
        writeln!(
            f,
            "{scene}: {nodes} nodes, {unknowns} unknowns; displacement {:.3} {unit} in the mean, {:.3} {unit} at most",
            displacement.mean, displacement.max
        )?;
        self.doubts.iter().try_for_each(|doubt| writeln!(f, "warning: {doubt}"))?;
        let err_u = format!("err_u {unit}");
        let head = [&*err_u, "largest", "err_F %", "err_I1 %", "err_Pi %", "err_V %"];
        let head = head.map(|name| format!("{name:>9}")).join(" ");
        writeln!(f, "{:<22} {head} {:>12}", "medians", "time")?;
        self.methods.iter().try_for_each(|method| write!(f, "{method}"))?;
        let head =
            Evaluation::ACCURACIES.map(|accuracy| format!("{:>10}", format!("to {accuracy:e}")));
        writeln!(f, "{:<22} {:>6} {}", "seconds, derived", "sets", head.join(" "))?;
        for (name, sets, seconds) in self.seconds() {
            let seconds = seconds.map(|seconds| format!("{:>10}", duration(seconds)));
            writeln!(f, "{name:<22} {sets:>6} {}", seconds.join(" "))?;
        }
        Ok(())
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Evaluation { raw, corrected, calibration, times, .. } = &self.evaluation;
        let Calibration { cases, within_two, refused, inverted } = calibration;
        row(f, &self.name, raw, times.predict_decoder_s)?;
        for after in corrected {
            let name =
                format!("  {} Newton step{}", after.steps, if after.steps == 1 { "" } else { "s" });
            let seconds = times.predict_decoder_s + after.steps as f64 * times.correction_s;
            row(f, &name, &after.errors, seconds)?;
        }
        let Record { simulations, steps, .. } = &self.record;
        let [simulate, prepare, train] =
            [times.simulate_s, times.prepare_s, times.train_s].map(duration);
        writeln!(
            f,
            "  {simulations} simulations {simulate}, preparation {prepare}, training {train} ({steps} steps)"
        )?;
        writeln!(
            f,
            "  predicts in full {}, in a batch {}; solver {} from rest, {} from a neighbour",
            duration(times.predict_full_s),
            duration(times.predict_batch_per_theta_s),
            duration(times.solver_cold_s),
            duration(times.solver_warm_s)
        )?;
        let slopes = self.evaluation.sensitivity_errors.iter().map(|error| format!("{error:.1e}"));
        let slopes = slopes.collect::<Vec<_>>().join(", ");
        writeln!(f, "  derivatives in the parameters off by {slopes} %")?;
        let hurt: usize = corrected.iter().map(|after| after.hurt).sum();
        writeln!(
            f,
            "  of {cases} cases: without an estimate {refused}, the others within a factor 2 of it {:.0} %, predictions that invert a cell {inverted}, corrections that hurt {hurt}",
            100.0 * within_two
        )
    }
}

fn row(f: &mut fmt::Formatter<'_>, name: &str, errors: &Errors, seconds: f64) -> fmt::Result {
    let volume = errors.err_volume.map_or("-".into(), |volume| format!("{:.1e}", volume.q50));
    let Errors { err_u, err_f, err_i1, err_pi, .. } = errors;
    let medians = [err_u.q50, err_u.max, err_f.q50, err_i1.q50, err_pi.q50];
    let medians = medians.map(|value| format!("{value:>9.1e}")).join(" ");
    writeln!(f, "{name:<22} {medians} {volume:>9} {:>12}", duration(seconds))
}

//! Emulators of one body beside each other.

use crate::theta::{range_in_words, theta_in_words};
use serde::{Deserialize, Serialize};
use sinew_emulate::{
    CaseErrors, CurvePoint, Emulator, Errors, Evaluation, METRICS, Quantiles, Recipe, Record,
    TestSet, Warning, median_and_worst,
};
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
    /// The emulators.
    pub methods: Vec<Method>,
    /// The body's surface in the median and the worst case of each, coloured by the error.
    pub surfaces: Surfaces,
}

/// One emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Its name, such as that of its recipe.
    pub name: String,
    /// What it is, in a line.
    #[serde(default)]
    pub about: String,
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Optimiser steps.
    pub steps: u64,
    /// Errors and times.
    pub evaluation: Evaluation,
    /// Densities of log₁₀ of the errors of [`sinew_emulate::METRICS`] and of the cavities' volumes: points (error, density per decade).
    pub densities: Vec<Vec<[f64; 2]>>,
    /// Errors on held-out cases while it was trained; empty for a regression.
    pub history: Vec<CurvePoint>,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// The emulator cannot be evaluated.
    #[error(transparent)]
    Evaluation(#[from] sinew_emulate::Error),
    /// The surface cannot be drawn.
    #[error(transparent)]
    Report(#[from] ReportError),
}

impl Comparison {
    /// Of no emulator yet.
    ///
    /// # Errors
    /// A surface that cannot be drawn.
    pub fn new(test: &TestSet<'_>) -> Result<Self, ComparisonError> {
        let body = test.body;
        let mut surfaces = Surfaces::new(&triangles(&body.mesh), &body.positions)?;
        surfaces.quantity = "Where the errors are: ‖u − û‖ at the nodes".into();
        (surfaces.unit, surfaces.length) = (body.units.length.clone(), body.units.length.clone());
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
            methods: Vec::new(),
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
    ) -> Result<Vec<CaseErrors>, ComparisonError> {
        let record = &emulator.record;
        let fields = emulator.predict(&test.thetas)?.fields();
        let cases = test.cases(&fields)?;
        let pooled = METRICS.map(|metric| metric.pooled(&cases).collect());
        let volumes = cases.iter().flat_map(|case| case.err_volume.iter().copied()).collect();
        let densities = pooled.iter().chain([&volumes]).map(|errors: &Vec<_>| density(errors));
        let densities = densities.collect();
        for (kind, case) in ["median", "worst"].into_iter().zip(median_and_worst(&cases)) {
            let moved = fields[case].as_chunks::<3>().0.iter().zip(&test.body.positions);
            let deformed: Vec<[f64; 3]> =
                moved.map(|(u, x)| std::array::from_fn(|i| u[i] + x[i])).collect();
            let error =
                sinew_energy::metrics::displacement_error(&test.fields[case], &fields[case]);
            let title = format!("{kind} case, {}", theta_in_words(test.body, &test.thetas[case]));
            self.surfaces.push(name, title, &deformed, &error)?;
        }
        self.methods.push(Method {
            name: name.into(),
            about: about(record),
            simulations: record.simulations,
            steps: record.steps,
            evaluation: emulator.evaluate(test, corrections)?,
            densities,
            history: record.history.clone(),
            warnings: record.warnings.clone(),
        });
        Ok(cases)
    }
}

/// What an emulator is, in one line.
fn about(record: &Record) -> String {
    match &record.recipe {
        Recipe::DataDriven(recipe) => {
            let and = if recipe.gradient_weight > 0.0 { " and their gradients" } else { "" };
            format!("network on {} simulations{and}", record.simulations)
        }
        Recipe::Hybrid(_) => format!(
            "network on {} simulations, errors weighed by the stiffness about one of them",
            record.simulations
        ),
        Recipe::PhysicsInformed(_) => {
            "network by minimum potential energy, without simulations; a few linear solves set its scale and what it follows by \
             itself"
                .into()
        }
        Recipe::Series => "one solution, followed to second order in the parameters".into(),
        Recipe::Regression(_) | Recipe::Auto(_) => {
            let choice = record.choice.as_ref();
            let taken = choice.and_then(|choice| choice.candidates.get(choice.taken));
            taken.map_or_else(String::new, |taken| {
                format!("{} on {} simulations, {}", taken.recipe, taken.simulations, taken.detail)
            })
        }
    }
}

/// Triangles of a mesh's boundary, by the corners of its facets.
fn triangles(mesh: &sinew_mesh::AnyMesh) -> Vec<[usize; 3]> {
    let facets = mesh.boundary_facets().into_iter();
    facets
        .flat_map(|facet| match mesh.nodes_of_facet(facet)[..] {
            [a, b, c, d] => vec![[a, b, c], [a, c, d]],
            [a, b, c, ..] => vec![[a, b, c]],
            _ => Vec::new(),
        })
        .collect()
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, nodes, unknowns, displacement, length_unit: unit, .. } = self;
        writeln!(
            f,
            "{scene}: {nodes} nodes, {unknowns} unknowns; displacement {:.3} {unit} in the mean, {:.3} {unit} at most",
            displacement.mean, displacement.max
        )?;
        let head = ["err_F %", "err_I1 %", "err_Pi %", "err_V %"].map(|name| format!("{name:>9}"));
        writeln!(
            f,
            "{:<22} {:>9} {:>9} {} {:>12}",
            "medians",
            format!("err_u {unit}"),
            "largest",
            head.join(" "),
            "time"
        )?;
        self.methods.iter().try_for_each(|method| write!(f, "{method}"))
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Evaluation { cases, raw, corrected, within_two, inverted, times, .. } =
            &self.evaluation;
        row(f, &self.name, raw, times.predict_decoder_s)?;
        for after in corrected {
            let name =
                format!("  {} Newton step{}", after.steps, if after.steps == 1 { "" } else { "s" });
            let seconds = times.predict_decoder_s + after.steps as f64 * times.correction_s;
            row(f, &name, &after.errors, seconds)?;
        }
        writeln!(
            f,
            "  {} simulations {}, preparation {}, training {} ({} steps)",
            self.simulations,
            duration(times.simulate_s),
            duration(times.prepare_s),
            duration(times.train_s),
            self.steps
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
        writeln!(
            f,
            "  derivatives in the parameters off by {} %",
            slopes.collect::<Vec<_>>().join(", ")
        )?;
        let hurt: usize = corrected.iter().map(|after| after.hurt).sum();
        writeln!(
            f,
            "  of {cases} cases: estimates within a factor 2 {:.0} %, predictions that invert a cell {inverted}, corrections that hurt {hurt}",
            100.0 * within_two
        )
    }
}

fn row(f: &mut fmt::Formatter<'_>, name: &str, errors: &Errors, seconds: f64) -> fmt::Result {
    let volume = errors.err_volume.map_or("-".into(), |volume| format!("{:.1e}", volume.q50));
    let medians = [
        errors.err_u.q50,
        errors.err_u.max,
        errors.err_f.q50,
        errors.err_i1.q50,
        errors.err_pi.q50,
    ];
    let medians = medians.map(|value| format!("{value:>9.1e}")).join(" ");
    writeln!(f, "{name:<22} {medians} {volume:>9} {:>12}", duration(seconds))
}

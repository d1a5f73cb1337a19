//! Emulators of one body beside each other.

use serde::{Deserialize, Serialize};
use sinew_emulate::{Emulator, Errors, Evaluation, Quantiles, TestSet, Warning};
use sinew_report::format::seconds as duration;
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
    /// Components that no support prescribes.
    pub unknowns: usize,
    /// Nodal displacements of the test cases \[length\].
    pub displacement: Quantiles,
    /// The emulators.
    pub methods: Vec<Method>,
}

/// One emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Method {
    /// Its name, such as that of its recipe.
    pub name: String,
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Optimiser steps.
    pub steps: u64,
    /// Errors and times.
    pub evaluation: Evaluation,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl Comparison {
    /// Of no emulator yet.
    pub fn new(test: &TestSet<'_>) -> Self {
        let body = test.body;
        let norm = |u: &[f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
        let lengths =
            test.fields.iter().flat_map(|field| field.as_chunks::<3>().0.iter().map(norm));
        Self {
            scene: body.name.clone(),
            length_unit: body.units.length.clone(),
            nodes: body.nodes,
            unknowns: body.free_degrees_of_freedom().len(),
            displacement: Quantiles::of(lengths),
            methods: Vec::new(),
        }
    }

    /// Adds an emulator, raw and after one to `corrections` Newton steps.
    ///
    /// # Errors
    /// As [`Emulator::evaluate`].
    pub fn add(
        &mut self,
        name: &str,
        emulator: &Emulator<'_>,
        test: &TestSet<'_>,
        corrections: usize,
    ) -> Result<(), sinew_emulate::Error> {
        let record = &emulator.record;
        self.methods.push(Method {
            name: name.into(),
            simulations: record.simulations,
            steps: record.steps,
            evaluation: emulator.evaluate(test, corrections)?,
            warnings: record.warnings.clone(),
        });
        Ok(())
    }
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

//! Our solver against an independent program on the same mesh: what the truth of all other rows rests on.

use crate::beams::scenes;
use crate::beams::scenes::Beam;
use crate::program;
use anyhow::{Context, Result};
use sinew_emulate::{METRICS, TestSet};
use sinew_energy::{Body, metrics};
use sinew_fem::{Options, Solver, sweep};
use sinew_report::{Column, Distribution, ReportError, Row, Table};

/// Result of the comparison.
pub(crate) struct Found {
    /// Rows `fem_cold` and `fem_warm`.
    pub table: Table,
    /// Their lines of `samples.csv`.
    pub samples: String,
    /// Median nodal distance of our linear tetrahedra from quadratic ones on the same mesh, at one of
    /// the parameters \[mm\]: what the mesh costs, beside which an emulator's error is to be seen.
    pub discretisation_mm: f64,
}

/// Solves at the parameters of the independent program, from rest and in a sweep; `times` are those of a solve from rest, of one
/// in a sweep on its thread, and of one in a sweep on all threads \[s\].
pub(crate) fn compare(beam: &Beam, body: &Body, times: [f64; 3]) -> Result<Found> {
    let array = |what: &str| program::fixture(&format!("beam/{}/{what}.npy", beam.name));
    let rows = |values: Vec<f64>, columns: usize| -> Vec<Vec<f64>> {
        values.chunks(columns).map(<[f64]>::to_vec).collect()
    };
    let thetas = rows(array("theta")?, body.parameters.len());
    let fields = rows(array("displacement")?, 3 * body.nodes);
    let mut solver = Solver::new(body)?;
    let mut cold = Vec::with_capacity(thetas.len());
    for theta in &thetas {
        cold.push(solver.solve(theta, &Options::default())?.displacement);
    }
    let swept = sweep(body, &thetas, &Options::default(), || ())?;
    let warm =
        swept.into_iter().map(|solution| Ok(solution?.displacement)).collect::<Result<_>>()?;
    let quadratic = array("p2_displacement")?;
    let centre = thetas.iter().position(|theta| theta == &[75.0, 75.0]);
    let centre = centre.context("fixtures/beam holds no solution at mu = lambda = 75 kPa")?;
    let distances = metrics::displacement_error(&quadratic, &cold[centre]);
    let discretisation_mm = program::median(distances).context("a beam without nodes")?;

    let independent = TestSet { body, thetas, fields, median_solve_s: f64::NAN };
    let errors = METRICS.map(|m| Column::new(m.name, m.unit("mm")).about(m.about));
    let mut table =
        Table::new(errors, [Column::new("solve", "s"), Column::new("in a batch", "s")], []);
    let mut lines = String::new();
    let [cold_s, warm_s, batch_s] = times;
    let about =
        ["from rest, one thread", "in a sweep, each solve starting from a neighbour's solution"];
    for (method, about, fields, times) in
        [("fem_cold", about[0], cold, [cold_s; 2]), ("fem_warm", about[1], warm, [warm_s, batch_s])]
    {
        let cases = independent.cases(&fields)?;
        let errors = METRICS.iter().map(|metric| {
            let name = format!("{} of {method}", metric.name);
            Ok(Distribution::with_density(&name, metric.pooled(&cases).collect())?.into())
        });
        let errors = errors.collect::<Result<_, ReportError>>()?;
        let row = Row::new(method, 0.0, times[0])?.time(times[1]);
        let reference = "FEniCS on the same mesh (fixtures/beam)".into();
        table.push(Row { errors, about: about.into(), reference, ..row })?;
        lines += &scenes::lines(beam.name, method, &independent.thetas, &cases)?;
    }
    Ok(Found { table, samples: lines, discretisation_mm })
}

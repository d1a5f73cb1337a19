//! The thesis' two gravity beams (§3.3.1), what the thesis reached on them, lines of `samples.csv`, and our solver against an independent
//! program on the same mesh: what the truth of all other rows rests on.

use crate::program;
use crate::published::Published;
use anyhow::{Context, Result};
use sinew_emulate::{CaseErrors, METRICS, TestSet};
use sinew_energy::{Body, Parameter, metrics};
use sinew_fem::{Options, Solver, sweep};
use sinew_report::{Column, Distribution, ReportError, Row, Table};

/// A beam.
#[derive(Debug)]
pub struct Beam {
    /// Short name for files, those of `fixtures/beam` too, and the command line.
    pub name: &'static str,
    /// Name of the built-in scene.
    pub scene: &'static str,
    pub(crate) thesis: Published,
}

/// Both.
pub static BEAMS: [Beam; 2] = [
    Beam {
        name: "once",
        scene: "OnceClampedBeam",
        thesis: Published { section: "once", method: None, displacement: [15.7, 50.1] },
    },
    Beam {
        name: "twice",
        scene: "TwiceClampedBeam",
        thesis: Published { section: "twice", method: None, displacement: [2.3, 6.0] },
    },
];

/// The head of the table, with a column for each of the parameters that all scenes have, such as `mu_kPa`.
pub fn head(parameters: &[Parameter]) -> String {
    let theta = parameters.iter().map(|p| format!("{}_{},", p.name, p.unit)).collect::<String>();
    let spread = |error| ["mean", "median", "max"].map(|of| format!("{error}_{of},")).concat();
    let errors = ["err_u_mm", "err_F_pct", "err_I1_pct"].map(spread).concat();
    format!("scene,sample,method,{theta}{errors}err_Pi_pct\n")
}

/// The lines of one method on one scene.
pub fn lines(
    scene: &str,
    method: &str,
    thetas: &[Vec<f64>],
    cases: &[CaseErrors],
) -> Result<String> {
    let mut text = String::new();
    for (sample, (theta, case)) in thetas.iter().zip(cases).enumerate() {
        text += &format!("{scene},{sample},{method}");
        theta.iter().for_each(|value| text += &format!(",{value}"));
        for metric in &METRICS[..3] {
            let found = Distribution::of(metric.of(case).to_vec());
            let found = found.context("an error of a test case is not a number")?;
            text += &format!(",{:e},{:e},{:e}", found.mean, found.q50, found.q100);
        }
        text += &format!(",{:e}\n", case.err_pi);
    }
    Ok(text)
}

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
    let mut samples = String::new();
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
        samples += &lines(beam.name, method, &independent.thetas, &cases)?;
    }
    Ok(Found { table, samples, discretisation_mm })
}

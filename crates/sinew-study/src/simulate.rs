//! Finite-element solutions that emulators are judged by, and what they cost.

use crate::program::test_set;
use crate::recipes::Samples;
use crate::scenes::Beam;
use anyhow::{Context, Result};
use sinew_emulate::{Body, TestSet, store};
use sinew_energy::metrics;
use sinew_fem::{Options, Solver, sweep};
use std::path::Path;

/// Our solutions at the parameters of an independent program's.
#[derive(Clone, Debug)]
pub(crate) struct FixtureRuns<'b> {
    /// Its parameters and displacements.
    pub independent: TestSet<'b>,
    /// Ours, each from rest \[mm\].
    pub cold: Vec<Vec<f64>>,
    /// Ours, in a sweep \[mm\].
    pub warm: Vec<Vec<f64>>,
    /// Median nodal distance of our linear tetrahedra from quadratic ones on the same mesh, at one of
    /// the parameters \[mm\]: what the mesh costs, beside which an emulator's error is to be seen.
    pub discretisation_mm: f64,
}

/// What a scene's emulators are judged by.
#[derive(Clone, Debug)]
pub(crate) struct Simulations<'b> {
    /// For errors: uniform.
    pub test: TestSet<'b>,
    /// Wall time of all its solves on all threads \[s\].
    pub test_s: f64,
    /// Comparison with an independent program.
    pub fixture: FixtureRuns<'b>,
    /// Median wall time of preparing the solver and solving from rest, one thread \[s\].
    pub cold_s: f64,
}

/// Solves what emulators are judged by, or reads what an interrupted run has solved (in `folder`).
pub(crate) fn run<'b>(
    beam: &Beam,
    body: &'b Body,
    counts: Samples,
    seed: u64,
    folder: &Path,
) -> Result<Simulations<'b>> {
    let (test, test_s) = test_set(body, counts.test, seed, folder)?;
    let cold_s = cold_seconds(body, &test.thetas)?;
    Ok(Simulations { test, test_s, fixture: fixture_runs(beam, body)?, cold_s })
}

fn cold_seconds(body: &Body, thetas: &[Vec<f64>]) -> Result<f64> {
    const SOLVES: usize = 11;
    let mut thetas = thetas.iter().cycle();
    Ok(sinew_emulate::median_seconds(SOLVES, || {
        let theta = thetas.next().map_or(&[][..], Vec::as_slice);
        Solver::new(body)?.solve(theta, &Options::default())
    })?)
}

fn fixture_runs<'b>(beam: &Beam, body: &'b Body) -> Result<FixtureRuns<'b>> {
    let table = |what: &str, bytes| {
        let file = format!("fixtures/beam/{}/{what}.npy", beam.name);
        store::parse_table(Path::new(&file), bytes)
    };
    let thetas = table("theta", beam.fixture.theta)?;
    let fields = table("displacement", beam.fixture.displacement)?;
    let mut solver = Solver::new(body)?;
    let mut cold = Vec::with_capacity(thetas.len());
    for theta in &thetas {
        cold.push(solver.solve(theta, &Options::default())?.displacement);
    }
    let swept = sweep(body, &thetas, &Options::default(), || ())?;
    let warm = swept.solutions()?.iter().map(|solution| solution.displacement.clone()).collect();
    let quadratic = table("p2_displacement", beam.fixture.quadratic)?.concat();
    let centre = thetas.iter().position(|theta| theta == &[75.0, 75.0]);
    let centre = centre.context("fixtures/beam holds no solution at mu = lambda = 75 kPa")?;
    let mut distances = metrics::displacement_error(&quadratic, &cold[centre]);
    distances.sort_by(f64::total_cmp);
    let discretisation_mm = distances[distances.len() / 2];
    let independent = TestSet { body, thetas, fields, median_solve_s: f64::NAN };
    Ok(FixtureRuns { independent, cold, warm, discretisation_mm })
}

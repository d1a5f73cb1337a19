//! Finite-element solutions that emulators learn from and are judged by, and what they cost.

use crate::plan::Samples;
use crate::scenes::Beam;
use crate::{progress, sampling, store};
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use sinew_fem::{Options, Solver, sweep};
use std::path::Path;
use std::time::Instant;

type Potential = sinew_energy::Body;

/// Parameters with their equilibria.
#[derive(Clone, Debug)]
pub struct Set {
    /// Parameters, sample by sample.
    pub thetas: Vec<Vec<f64>>,
    /// Displacements, sample by sample \[mm\].
    pub fields: Vec<Vec<f64>>,
    /// Wall time of all solves on all threads \[s\].
    pub seconds: f64,
}

/// Our solutions at the parameters of an independent program's.
#[derive(Clone, Debug)]
pub struct FixtureRuns {
    /// Parameters.
    pub thetas: Vec<Vec<f64>>,
    /// Displacements by the independent program \[mm\].
    pub independent: Vec<Vec<f64>>,
    /// Ours, each from rest \[mm\].
    pub cold: Vec<Vec<f64>>,
    /// Ours, in a sweep \[mm\].
    pub warm: Vec<Vec<f64>>,
    /// Median nodal distance of our linear tetrahedra from quadratic ones on the same mesh, at one of
    /// the parameters \[mm\]: what the mesh costs, beside which an emulator's error is to be seen.
    pub discretisation_mm: f64,
}

/// All simulations of a scene.
#[derive(Clone, Debug)]
pub struct Simulations {
    /// For training: a log-uniform Latin hypercube.
    pub training: Set,
    /// For curves: uniform.
    pub validation: Set,
    /// For errors: uniform.
    pub test: Set,
    /// For the regression rival: a small Latin hypercube.
    pub pod: Set,
    /// Comparison with an independent program.
    pub fixture: FixtureRuns,
    /// Centre of the parameter range (geometric).
    pub centre: Vec<f64>,
    /// Displacement of the linearised body at the centre \[mm\].
    pub linear_response: Vec<f64>,
    /// Wall time of that solve \[s\].
    pub linear_s: f64,
    /// Median wall time of preparing the solver and solving from rest, one thread \[s\].
    pub cold_s: f64,
    /// Median wall time of one solve in a sweep, one thread \[s\].
    pub warm_s: f64,
}

/// Independent seeds of the sets, derived from the run's seed.
#[derive(Clone, Copy)]
enum Stream {
    Training,
    Validation,
    Test,
    Pod,
}

/// Wall times of a set's solves, kept with its fields.
#[derive(Serialize, Deserialize)]
struct SetTimes {
    seconds: f64,
    median_solve_s: f64,
}

/// Solves everything, or reads what an interrupted run has solved (in `folder`).
///
/// # Errors
/// A solve that fails, with its parameters and advice; files that cannot be written or read.
pub fn run(
    beam: &Beam,
    potential: &Potential,
    counts: Samples,
    seed: u64,
    folder: &Path,
) -> Result<Simulations> {
    let ranges: Vec<[f64; 2]> = beam.scene.parameters.iter().map(|p| p.range).collect();
    let stream = |stream: Stream| seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ stream as u64;
    let solve = |name: &str, thetas: Vec<Vec<f64>>| {
        solve_set(
            potential,
            thetas,
            &format!("simulate {name}"),
            &folder.join("simulations").join(name),
        )
    };
    let hypercube = |count, which| sampling::log_latin_hypercube(count, &ranges, stream(which));
    let uniform = |count, which| sampling::uniform(count, &ranges, stream(which));
    let (training, _) = solve("training", hypercube(counts.training, Stream::Training))?;
    let (validation, _) = solve("validation", uniform(counts.validation, Stream::Validation))?;
    let (test, warm_s) = solve("test", uniform(counts.test, Stream::Test))?;
    let (pod, _) = solve("pod", hypercube(counts.pod, Stream::Pod))?;

    let centre: Vec<f64> = ranges.iter().map(|[low, high]| (low * high).sqrt()).collect();
    let start = Instant::now();
    let linear_response = linear_response(potential, &centre)?;
    let linear_s = start.elapsed().as_secs_f64();
    let cold_s = cold_seconds(potential, &test.thetas)?;
    let fixture = fixture_runs(beam, potential)?;
    Ok(Simulations {
        training,
        validation,
        test,
        pod,
        fixture,
        centre,
        linear_response,
        linear_s,
        cold_s,
        warm_s,
    })
}

/// A set and the median time of one solve.
fn solve_set(
    potential: &Potential,
    thetas: Vec<Vec<f64>>,
    title: &str,
    folder: &Path,
) -> Result<(Set, f64)> {
    let (times_file, fields_file) = (folder.join("times.json"), folder.join("displacement.npy"));
    if let Some(times) = store::read_json::<SetTimes>(&times_file)? {
        let fields = store::read_table(&fields_file)?;
        return Ok((Set { thetas, fields, seconds: times.seconds }, times.median_solve_s));
    }
    let bar = progress::bar(title, thetas.len() as u64);
    let start = Instant::now();
    let swept = sweep(potential, &thetas, &Options::default(), || bar.inc(1))?;
    let seconds = start.elapsed().as_secs_f64();
    let solutions = swept.solutions().with_context(|| title.to_string())?;
    let mut solve_seconds: Vec<f64> = solutions.iter().map(|solution| solution.seconds).collect();
    solve_seconds.sort_by(f64::total_cmp);
    let median_solve_s = solve_seconds[solve_seconds.len() / 2];
    let fields: Vec<_> = solutions.iter().map(|solution| solution.displacement.clone()).collect();
    progress::finish(&bar, &format!("{} solves", thetas.len()));
    store::write_table(&folder.join("theta.npy"), &thetas)?;
    store::write_table(&fields_file, &fields)?;
    store::write_json(&times_file, &SetTimes { seconds, median_solve_s })?;
    Ok((Set { thetas, fields, seconds }, median_solve_s))
}

/// Displacement of the linearised body under the full dead loads: that under a millionth of them, scaled up.
fn linear_response(potential: &Potential, theta: &[f64]) -> Result<Vec<f64>> {
    /// Small enough for linearity, large beside rounding.
    const LOAD: f64 = 1e-6;
    let mut nearly_unloaded = potential.clone();
    nearly_unloaded.nodal_force.iter_mut().for_each(|force| *force *= LOAD);
    let solution = Solver::new(&nearly_unloaded)?.solve(theta, &Options::default())?;
    Ok(solution.displacement.iter().map(|u| u / LOAD).collect())
}

fn cold_seconds(potential: &Potential, thetas: &[Vec<f64>]) -> Result<f64> {
    const SOLVES: usize = 11;
    let mut seconds = Vec::with_capacity(SOLVES);
    for theta in thetas.iter().cycle().take(SOLVES) {
        let start = Instant::now();
        Solver::new(potential)?.solve(theta, &Options::default())?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    Ok(seconds[SOLVES / 2])
}

fn fixture_runs(beam: &Beam, potential: &Potential) -> Result<FixtureRuns> {
    let table = |what: &str, bytes| {
        store::parse_table(&format!("fixtures/beam/{}/{what}.npy", beam.name), bytes)
    };
    let thetas = table("theta", beam.fixture.theta)?;
    let independent = table("displacement", beam.fixture.displacement)?;
    let mut solver = Solver::new(potential)?;
    let mut cold = Vec::with_capacity(thetas.len());
    for theta in &thetas {
        cold.push(solver.solve(theta, &Options::default())?.displacement);
    }
    let swept = sweep(potential, &thetas, &Options::default(), || ())?;
    let warm = swept.solutions()?.iter().map(|solution| solution.displacement.clone()).collect();
    let quadratic = table("p2_displacement", beam.fixture.quadratic)?.concat();
    let centre = thetas.iter().position(|theta| theta == &[75.0, 75.0]);
    let centre = centre.context("fixtures/beam holds no solution at mu = lambda = 75 kPa")?;
    let mut distances = sinew_energy::metrics::displacement_error(&quadratic, &cold[centre]);
    distances.sort_by(f64::total_cmp);
    let discretisation_mm = distances[distances.len() / 2];
    Ok(FixtureRuns { thetas, independent, cold, warm, discretisation_mm })
}

//! Two problems by this crate, by plain NumPy and SciPy, and by a Gaussian process in JAX: the same data, in one run.
//!
//! `SINEW_JAX_PYTHON=venv/bin/python cargo run -p sinew-gp --example peers -- 5`
//!
//! The slab: diffusivity from 25 values with errors of 2.5 %, f = 0. The beam: stiffness of a clamped beam on a bed under a load.
//! Error is the mean of |u − û| over 50 places, the interval is one of 95 %, seconds are those of one answer after imports
//! (with what JAX compiles for new shapes, once, apart), lines are those of code for both problems. Python programs answer lines
//! on their standard input; without them, or without their packages, their rows are missing.

mod ours;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_gp::{Domain, GpError};
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Data that all are given.
pub struct Given<const D: usize> {
    /// Places where u is measured.
    pub places: Vec<[f64; D]>,
    /// Measured values.
    pub values: Vec<f64>,
    /// Collocation points.
    pub points: Vec<[f64; D]>,
    /// Right-hand side of the equation at these points.
    pub loads: Vec<f64>,
    /// Places where u is predicted.
    pub grid: Vec<[f64; D]>,
}

/// Answer of each program.
pub struct Answer {
    /// Estimate of the parameter.
    pub estimate: f64,
    /// 95 % interval of the parameter.
    pub interval: [f64; 2],
    /// u on the grid.
    pub mean: Vec<f64>,
}

type Failure = Box<dyn std::error::Error>;

fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (2.0 * std::f64::consts::PI * random.random::<f64>()).cos()
}

fn given<const D: usize>(
    domain: &Domain<D>,
    exact: fn([f64; D]) -> f64,
    load: fn([f64; D]) -> f64,
    seed: u64,
) -> Result<Given<D>, GpError> {
    let of = |places: &[[f64; D]]| places.iter().map(|x| exact(*x)).collect::<Vec<f64>>();
    let spread = of(&domain.grid(21));
    let mean = spread.iter().sum::<f64>() / spread.len() as f64;
    let square = spread.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / spread.len() as f64;
    let mut random = ChaCha8Rng::seed_from_u64(seed + 500);
    let places = domain.sample(25, seed)?;
    let values =
        of(&places).iter().map(|u| u + 0.025 * square.sqrt() * normal(&mut random)).collect();
    let points = domain.sample(25, seed + 100)?;
    let loads = points.iter().map(|x| load(*x)).collect();
    Ok(Given { places, values, points, loads, grid: domain.sample(50, 99)? })
}

impl<const D: usize> Given<D> {
    fn json(&self, problem: &str) -> String {
        format!(
            r#"{{"problem": "{problem}", "places": {:?}, "values": {:?}, "points": {:?}, "loads": {:?}, "grid": {:?}}}"#,
            self.places, self.values, self.points, self.loads, self.grid
        )
    }
}

/// One row of the table.
struct Row {
    errors: Vec<f64>,
    held: usize,
    widths: Vec<f64>,
    seconds: Vec<f64>,
}

impl Row {
    fn add(&mut self, answer: &Answer, exact: &[f64], truth: f64, seconds: f64) {
        let off = answer.mean.iter().zip(exact).map(|(m, u)| (m - u).abs());
        self.errors.push(off.sum::<f64>() / exact.len() as f64);
        let [lower, upper] = answer.interval;
        self.held += usize::from(lower <= truth && truth <= upper);
        self.widths.push((upper - lower) / truth);
        self.seconds.push(seconds);
    }
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A Python program that answers problems line by line.
fn peer(script: &str, problems: &[String]) -> Result<Vec<(Answer, f64)>, Failure> {
    let python = std::env::var("SINEW_JAX_PYTHON").unwrap_or_else(|_| "python3".into());
    let path = format!("{}/peers/{script}", env!("CARGO_MANIFEST_DIR"));
    let mut process =
        Command::new(python).arg(path).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
    let mut input = process.stdin.take().ok_or("no input")?;
    let mut output = BufReader::new(process.stdout.take().ok_or("no output")?);
    let mut answers = Vec::new();
    for problem in problems {
        writeln!(input, "{problem}")?;
        let mut line = String::new();
        output.read_line(&mut line)?;
        let numbers = line.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let [estimate, lower, upper, seconds, mean @ ..] = &numbers[..] else {
            return Err(format!("{script} gave no answer").into());
        };
        let answer =
            Answer { estimate: *estimate, interval: [*lower, *upper], mean: mean.to_vec() };
        answers.push((answer, *seconds));
    }
    drop(input);
    process.wait()?;
    Ok(answers)
}

fn lines(code: &str, comment: &str) -> usize {
    code.lines().filter(|l| !l.trim().is_empty() && !l.trim_start().starts_with(comment)).count()
}

fn study<const D: usize>(
    (name, truth): (&str, f64),
    domain: &Domain<D>,
    [exact, load]: [fn([f64; D]) -> f64; 2],
    solve: fn(&Given<D>) -> Result<Answer, GpError>,
    sets: u64,
) -> Result<(), Failure> {
    let all: Vec<Given<D>> =
        (0..sets).map(|seed| given(domain, exact, load, seed)).collect::<Result<_, _>>()?;
    let at: Vec<f64> = all[0].grid.iter().map(|x| exact(*x)).collect();
    let print = |what: &str, answers: Vec<(Answer, f64)>, lines: usize| {
        let mut row = Row { errors: Vec::new(), held: 0, widths: Vec::new(), seconds: Vec::new() };
        answers.iter().for_each(|(answer, seconds)| row.add(answer, &at, truth, *seconds));
        let estimates: Vec<f64> =
            answers.iter().map(|(a, _)| (a.estimate / truth - 1.0).abs()).collect();
        println!(
            "| {name} | {what} | {:.1e} | {:.1} % | {} of {sets}, {:.1} % wide | {:.2} ({:.2}) | {lines} |",
            median(&row.errors),
            100.0 * median(&estimates),
            row.held,
            100.0 * median(&row.widths),
            median(&row.seconds),
            row.seconds[0]
        );
    };
    let timed = |given: &Given<D>| {
        let start = Instant::now();
        Ok((solve(given)?, start.elapsed().as_secs_f64()))
    };
    let own: Vec<(Answer, f64)> = all.iter().map(timed).collect::<Result<_, GpError>>()?;
    print("this crate", own, lines(include_str!("ours.rs"), "//"));
    let problems: Vec<String> = all.iter().map(|given| given.json(name)).collect();
    let scripts = [
        ("NumPy, SciPy", "plain.py", include_str!("../../peers/plain.py")),
        ("JAX", "hard_jax.py", include_str!("../../peers/hard_jax.py")),
    ];
    for (what, script, code) in scripts {
        match peer(script, &problems) {
            Ok(answers) => print(what, answers, lines(code, "#")),
            Err(error) => println!("| {name} | {what} | {error} |"),
        }
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let sets = std::env::args().nth(1).map_or(Ok(5), |word| word.parse())?;
    println!(
        "| problem | by | error of u | of θ | 95 % interval holds | seconds (first) | lines |"
    );
    println!("|---|---|---|---|---|---|---|");
    let slab = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let cooling = |[x, t]: [f64; 2]| {
        let half = std::f64::consts::PI / 2.0;
        (x * half).cos() * (-0.3 * half * half * t).exp()
    };
    study(("slab", 0.3), &slab, [cooling, |_| 0.0], ours::slab, sets)?;
    let span = Domain::interval("x", [0.0, 1.0])?;
    // 100 x² (1 − x)² (1 + x), with u⁗ = 100 (120 x − 24).
    let bent = |[x]: [f64; 1]| 100.0 * (x * (1.0 - x)).powi(2) * (1.0 + x);
    let load = |[x]: [f64; 1]| {
        100.0 * (120.0 * x - 24.0) + 300.0 * 100.0 * (x * (1.0 - x)).powi(2) * (1.0 + x)
    };
    study(("beam", 1.0), &span, [bent, load], ours::beam, sets)
}

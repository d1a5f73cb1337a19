//! Evidence and gradient of Heat-BVP-1 beside the JAX baseline `../shared/bench/jax_hcgp.py`, in turns.
//!
//! The baseline is not part of this repository: without it, or without a Python that has JAX and SciPy
//! (`SINEW_JAX_PYTHON`), nothing is measured. Both sides get one thread on the same core:
//!
//! ```text
//! SINEW_JAX_PYTHON=venv/bin/python CORE=0 taskset -c 0 \
//!     cargo bench --profile dev -p sinew-gp --bench against_jax -- 50 300
//! ```
//!
//! Both get the same points, values and parameters and maximise the joint evidence with a relative
//! jitter of 1e-10; ours through the public interface. They take turns of a tenth of a second; figures
//! are the shortest evaluations over all turns, which a busy machine disturbs least. Beside the times stands by how
//! much the two evidences and gradients differ.

use sinew_gp::{
    Condition, Data, Domain, Evidence, GpError, Model, Noise, Parameter, Prior, Problem, Series,
    Side, field, squared_exponential,
};
use std::f64::consts::PI;
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

/// Turns of each side, and the time that one takes at least [s].
const TURNS: usize = 7;
const TURN: f64 = 0.1;

/// Amplitude of u, lengthscales, diffusivity and noise at which both evaluate.
const AT: [f64; 5] = [1.0, 2.0, 0.7, 0.9, 0.02];

/// Imports the baseline as a module; then, for each line on its input, times evaluations for that many seconds.
const SERVER: &str = r#"
import sys, time, json, tempfile, importlib.util
import numpy as np
script, points = sys.argv[1], json.loads(sys.stdin.readline())
spec = importlib.util.spec_from_file_location("jax_hcgp", script)
sys.argv = sys.argv[:1]
module = importlib.util.module_from_spec(spec)
module.__file__ = tempfile.mkdtemp() + "/jax_hcgp.py"  # it makes a folder beside itself
spec.loader.exec_module(module)
problem = module.prob("heat1")
# Any mean that meets the conditions will do; this one is ours, without the factor 1 - t of theirs.
pi, jnp = module.pi, module.jnp
problem.mean = lambda x: 2 * x[0] / pi * jnp.exp(-x[1]) + jnp.sin(x[0]) - 2 * x[0] / pi
model, _ = module.build(problem, "hcgp")
X = module.J(points["places"], points["collocation"])
y = module.J(points["values"], [0.0] * len(points["collocation"]))
p = jnp.log(module.J(points["at"])[0])
def evaluate():
    value, gradient = model.vg(p, X, y)
    return float(value), np.asarray(gradient)
value, gradient = evaluate()
print(json.dumps([value] + gradient.tolist()), flush=True)
for line in sys.stdin:
    best, end = float("inf"), time.perf_counter() + float(line)
    while best == float("inf") or time.perf_counter() < end:
        start = time.perf_counter()
        evaluate()
        best = min(best, time.perf_counter() - start)
    print(1e3 * best, flush=True)
"#;

fn main() -> Result<(), GpError> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/bench/jax_hcgp.py");
    if !script.exists() {
        eprintln!("skipped: no JAX baseline at {}", script.display());
        return Ok(());
    }
    if let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(1).build_global() {
        eprintln!("more than one thread: {error}");
    }
    let python: PathBuf =
        std::env::var_os("SINEW_JAX_PYTHON").unwrap_or_else(|| "python3".into()).into();
    let sizes: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let sizes = if sizes.is_empty() { vec![50, 100, 300, 600, 1200] } else { sizes };
    for size in sizes {
        let heat = Heat::new(size)?;
        let Some((mut jax, theirs)) = Jax::start(&python, &script, &heat) else {
            eprintln!("skipped: {} does not run the baseline", python.display());
            return Ok(());
        };
        let (model, at) = heat.model()?;
        let evaluation = model.evaluate(&at)?;
        // Theirs is the negative evidence; parameters come in the same order on both sides.
        let ours = std::iter::once(evaluation.value).chain(evaluation.gradient);
        let difference = ours
            .zip(&theirs)
            .map(|(ours, theirs)| (ours + theirs).abs() / theirs.abs().max(1.0))
            .fold(0.0, f64::max);
        let mut best = [f64::INFINITY; 2];
        for _ in 0..TURNS {
            let Some(turn) = jax.turn() else {
                eprintln!("skipped: the baseline ended early");
                return Ok(());
            };
            best = [best[0].min(turn), best[1].min(our_turn(&model, &at)?)];
        }
        let [jax, ours] = best;
        println!(
            "N = {size}: JAX {jax:.3} ms, ours {ours:.3} ms, ratio {:.2}; \
             evidence and gradient differ by {difference:.1e}",
            ours / jax
        );
    }
    Ok(())
}

/// Shortest evaluation in a turn [ms].
fn our_turn(model: &Model<2>, at: &[f64]) -> Result<f64, GpError> {
    let turn = Instant::now();
    let mut best = f64::INFINITY;
    while best.is_infinite() || turn.elapsed().as_secs_f64() < TURN {
        let start = Instant::now();
        black_box(model.evaluate(black_box(at))?);
        best = best.min(1e3 * start.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// Half of the observations of u, half of the equation.
struct Heat {
    domain: Domain<2>,
    places: Vec<[f64; 2]>,
    values: Vec<f64>,
    collocation: Vec<[f64; 2]>,
}

impl Heat {
    fn new(size: usize) -> Result<Self, GpError> {
        let domain = Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])])?;
        let places = domain.sample(size / 2, 1)?;
        let error = |k: usize| 0.015 * (2.7 * k as f64).sin();
        let values = (places.iter().enumerate())
            .map(|(k, [x, t])| x.sin() * (-t).exp() + error(k))
            .collect();
        Ok(Self { collocation: domain.sample(size / 2, 2)?, domain, places, values })
    }

    /// The model, with the parameters that are the baseline's [`AT`].
    fn model(&self) -> Result<(Model<2>, Vec<f64>), GpError> {
        let [dx, dt] = self.domain.derivatives();
        let theta = Parameter::new("theta", [0.02, 50.0])?;
        let end =
            |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
        let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin()));
        let problem = Problem::new(self.domain.clone(), dt - &theta * dx * dx)?
            .condition("x", Side::Lower, end(-1.0))?
            .condition("x", Side::Upper, end(1.0))?
            .condition("t", Side::Lower, start)?;
        let zeros = vec![0.0; self.collocation.len()];
        let data = Data::new().values(&self.places, &self.values, Noise::Learned).equation(
            &self.collocation,
            &zeros,
            Noise::Exact,
        );
        let prior = Prior::constrained(&problem, &squared_exponential())?;
        let model = Model::new(prior, data, Evidence::Joint)?;
        // Our feature has the size one, theirs that of (x + π/2)(π/2 − x) t, at most π²/4.
        let size = [PI * PI / 4.0, 1.0, 1.0, 1.0, 1.0];
        let at = AT.iter().zip(size).map(|(at, size)| (at * size).ln()).collect();
        Ok((model, at))
    }
}

/// The baseline, waiting for its turn; it ends when its input does.
struct Jax {
    process: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Jax {
    /// Starts it; also returns its negative evidence followed by the gradient.
    fn start(python: &Path, script: &Path, heat: &Heat) -> Option<(Self, Vec<f64>)> {
        let mut process = Command::new(python)
            .args(["-c", SERVER])
            .arg(script)
            .env("NT", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .ok()?;
        let (input, output) = (process.stdin.take()?, BufReader::new(process.stdout.take()?));
        let mut jax = Self { process, input, output };
        // Arrays of numbers look alike in Rust and in JSON.
        let text = format!(
            r#"{{"places": {:?}, "values": {:?}, "collocation": {:?}, "at": {AT:?}}}"#,
            heat.places, heat.values, heat.collocation
        );
        let line = jax.ask(&text)?;
        let numbers = line.trim().strip_prefix('[')?.strip_suffix(']')?;
        let numbers = numbers.split(',').map(|number| number.trim().parse().ok());
        let numbers = numbers.collect::<Option<Vec<f64>>>()?;
        Some((jax, numbers))
    }

    /// Shortest evaluation in a turn [ms].
    fn turn(&mut self) -> Option<f64> {
        self.ask(&TURN.to_string())?.trim().parse().ok()
    }

    fn ask(&mut self, line: &str) -> Option<String> {
        writeln!(self.input, "{line}").ok()?;
        let mut answer = String::new();
        self.output.read_line(&mut answer).ok()?;
        (!answer.is_empty()).then_some(answer)
    }
}

impl Drop for Jax {
    fn drop(&mut self) {
        // Already ended, or about to be measured no more: either way there is nothing to report.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

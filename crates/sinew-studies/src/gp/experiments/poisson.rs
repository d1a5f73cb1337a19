//! Poisson equations of the thesis (§4.8.1): an interval, and a domain that is not a box.
//!
//! The introduction's PINN (§1.7.3): −u″ = x² with u(0) = u(1) = 0, by the strong form or by the energy.
//!
//! Misprints corrected: u = (x − x⁴)/12, and the energy has ½⟨u′, u′⟩.

use crate::gp::deep::{Jet, WEIGHTS, adam, backward, forward, random_weights};
use crate::gp::draw;
use crate::gp::experiment::{Case, Experiment, Purpose, Scale, Task, derived};
use crate::gp::hcnn::Network;
use crate::gp::inference::{Approach, Inference, Observed};
use crate::gp::pentagon::{Pentagon, corners};
use crate::gp::problems::{self, Setting};
use crate::gp::row::{Method, Run};
use anyhow::Result;
use sinew_gp::{
    Conditional, Data, Domain, Evidence, Functional, GpError, Model, Noise, Operator, Prior,
    Problem, constant, squared_exponential,
};
use sinew_report::{Chart, Figure, Series, Style};
use std::sync::Arc;
use std::time::Instant;

/// Places at which both random starts of a network are shown (Fig. 4.3 c, d).
const SHOWN: usize = 8;
/// Functions drawn from the prior (Fig. 4.3 a).
const SAMPLES: usize = 10;

/// HCGP and HCNN from 4, 8 and 50 collocation points.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let setting = problems::poisson_1()?;
    let mut cases = Vec::new();
    for count in [4, 8, 50] {
        let name = format!("N_f = {count}");
        cases.push(process_case(&setting, count, scale).at(&name));
        cases.push(network_case(&setting, count, scale).at(&name));
    }
    Ok(Experiment {
        title: "Poisson-BVP-1 (§4.8.1, Fig. 4.3)",
        about: "u(0) = u′(0) = 0 and u′(2) = u(2), f = −2 (the thesis prints 2), at equidistant points. The network \
                has one hidden layer of 16 tanh units; of four restarts the one with the least loss is taken.",
        cases,
    })
}

fn observed(setting: &Setting<1>, count: usize) -> Observed<1> {
    let collocation: Vec<[f64; 1]> = (1..=count).map(|k| [2.0 * k as f64 / count as f64]).collect();
    let load = collocation.iter().map(|x| (setting.load)(*x)).collect();
    Observed::collocated(collocation, load)
}

fn process_case(setting: &Setting<1>, count: usize, scale: Scale) -> Case {
    let observe = move |setting: &Setting<1>, _: &Task| Ok(observed(setting, count));
    let inference = Inference::new(setting, Approach::Constrained, scale, observe);
    Case::new(setting.named(), Method::Hcgp, move |task| {
        let mut run = inference.run(task)?;
        if task.draw && count == 4 {
            run.figures.insert(0, prior_samples(&inference.setting, task)?);
        }
        Ok(run)
    })
}

/// Functions drawn from the constrained prior, each of which satisfies the conditions.
fn prior_samples(setting: &Setting<1>, task: &Task) -> Result<Figure, GpError> {
    let points = setting.problem.domain().grid(81);
    // One value known to be anything leaves the prior as it is.
    let data = Data::new().values(&points[..1], &[0.0], Noise::Known(1e6));
    let prior = Prior::constrained(&setting.problem, &squared_exponential())?;
    let model = Arc::new(Model::new(prior, data, Evidence::Joint)?);
    let middle = |parameter: &sinew_gp::FreeParameter| {
        let [low, high] = parameter.start.map(|end| parameter.to_scale(end));
        0.5 * (low + high)
    };
    let parameters: Vec<f64> = model.parameters().iter().map(middle).collect();
    let conditional = Conditional::new(model, &parameters)?;
    let samples = conditional.sample(&points, SAMPLES, task.seed_for(Purpose::Draws))?;
    let lines = samples.iter().map(|values| draw::curve("", &points, values));
    Ok(Figure {
        title: "Prior of the HCGP (Fig. 4.3 a)".into(),
        caption: "Every function satisfies u(0) = u′(0) = 0 and u′(2) = u(2).".into(),
        panels: vec![Chart {
            series: lines.collect(),
            ..Chart::new("functions drawn from the prior", ["x", "u"], [false; 2])
        }],
    })
}

fn network_case(setting: &Setting<1>, count: usize, scale: Scale) -> Case {
    let own = setting.clone();
    Case::new(setting.named(), Method::Hcnn, move |task| {
        let (start, seed) = (Instant::now(), task.seed_for(Purpose::Starts));
        let network = train(&own, count, scale.pick(4, 1), scale, seed)?;
        let seconds = start.elapsed().as_secs_f64();
        let grid = own.grid(scale);
        let err_u = own.error(&grid, &network.values(&grid));
        let figures = match task.draw && count == SHOWN {
            true => vec![two_starts(&own, scale, seed)?],
            false => Vec::new(),
        };
        let evaluations = Some(network.evaluations);
        Ok(Run { err_u, seconds, evaluations, figures, ..Run::default() })
    })
}

fn train(
    setting: &Setting<1>,
    count: usize,
    restarts: usize,
    scale: Scale,
    seed: u64,
) -> Result<Network> {
    let Observed { collocation, load, .. } = observed(setting, count);
    let effort = (restarts, scale.pick(300, 20));
    Network::train(&setting.problem, (&collocation, &load), effort, seed)
}

/// Solution and right-hand side of two networks from two random starts.
fn two_starts(setting: &Setting<1>, scale: Scale, seed: u64) -> Result<Figure> {
    let points = setting.problem.domain().grid(101);
    let networks = [1, 2].map(|start| train(setting, SHOWN, 1, scale, derived(seed, start)));
    let [first, second] = networks;
    let networks = [first?, second?];
    let panel = |title: &str, symbol: &str, exact: Vec<f64>, values: [Vec<f64>; 2]| {
        let mut chart = Chart::new(title, ["x", symbol], [false; 2]);
        chart.series.push(draw::curve("exact", &points, &exact));
        for (values, name) in values.iter().zip(["HCNN 1", "HCNN 2"]) {
            chart.series.push(draw::curve(name, &points, values));
        }
        if symbol == "f" {
            let places = observed(setting, SHOWN).collocation;
            let marks = places.iter().map(|[x]| [*x, -2.0]);
            chart.series.push(Series::new("equation imposed", Style::Points, marks));
        }
        chart
    };
    let exact = |of: &dyn Fn([f64; 1]) -> f64| points.iter().map(|x| of(*x)).collect();
    let [first, second] = &networks;
    let loads = [first.loads(&points), second.loads(&points)];
    let solutions = [first.values(&points), second.values(&points)];
    let losses = networks.map(|network| format!("{:.1e}", network.loss));
    Ok(Figure {
        title: "Two random starts of the HCNN (Fig. 4.3 c, d)".into(),
        caption: format!("From {SHOWN} points; the losses are {} and {}.", losses[0], losses[1]),
        panels: vec![
            panel("right-hand side", "f", exact(&*setting.load), loads),
            panel("solution", "u", exact(&*setting.solution), solutions),
        ],
    })
}

const LOAD: f64 = 4.0;
const COLLOCATION: usize = 100;

/// −Δu = 4 on a pentagon from a hundred collocation points.
pub(super) fn pentagon(scale: Scale) -> Result<Experiment> {
    let domain = Domain::polygon(["x", "y"], &corners())?;
    let [dx, dy] = domain.derivatives();
    let reference = Pentagon::solve();
    let problem = Problem::new(domain, -(dx * dx) - dy * dy)?.boundary(constant(0.0))?;
    let setting = Setting::new("Poisson-BVP-2", problem, &[], move |place| reference.value(place));
    let setting = Setting { load: Arc::new(|_| LOAD), ..setting };
    let count = scale.pick(COLLOCATION, COLLOCATION / 4);
    let inference =
        Inference::new(&setting, Approach::Constrained, scale, move |setting, task: &Task| {
            let domain = setting.problem.domain();
            let collocation = domain.sample(count, task.seed_for(Purpose::Collocation))?;
            Ok(Observed::collocated(collocation, vec![LOAD; count]))
        });
    Ok(Experiment {
        title: "Poisson-BVP-2 (§4.8.1, Fig. 4.4)",
        about: "−Δu = 4 on a regular pentagon with corners on the unit circle, u = 0 on its edges. The reference is a \
                sum of harmonic functions whose error is below 1e-8 everywhere; the thesis' is a finite-element \
                solution.",
        cases: vec![inference.case().at(format!("N_f = {count}"))],
    })
}

const STRONG_POINTS: usize = 50;
const QUADRATURE: usize = 16;
/// Learning rate at the first and at the last step.
const RATES: [f64; 2] = [1e-2, 1e-5];
/// Points of the grid that errors are over.
const GRID: usize = 201;

fn solution(x: f64) -> f64 {
    (x - x.powi(4)) / 12.0
}

fn load(x: f64) -> f64 {
    x * x
}

/// û = x(1 − x) NN(x) (1.20) with two derivatives.
fn constrained(x: f64, [value, slope, bend]: Jet) -> Jet {
    let (q, dq, ddq) = (x * (1.0 - x), 1.0 - 2.0 * x, -2.0);
    [q * value, dq * value + q * slope, ddq * value + 2.0 * dq * slope + q * bend]
}

/// Adjoint of [`constrained`].
fn constrained_back(x: f64, [u, slope, bend]: Jet) -> Jet {
    let (q, dq, ddq) = (x * (1.0 - x), 1.0 - 2.0 * x, -2.0);
    [q * u + dq * slope + ddq * bend, q * slope + 2.0 * dq * bend, q * bend]
}

/// Points with weights, and the derivatives of the loss at one point in û, û′ and û″.
struct Loss {
    points: Vec<(f64, f64)>,
    slope: fn(f64, Jet) -> Jet,
}

impl Loss {
    /// Mean (g + û″)² (1.21).
    fn strong() -> Self {
        let points = (0..STRONG_POINTS).map(|k| (k as f64 + 0.5) / STRONG_POINTS as f64);
        Self {
            points: points.map(|x| (x, 1.0 / STRONG_POINTS as f64)).collect(),
            slope: |x, [_, _, bend]| [0.0, 0.0, 2.0 * (load(x) + bend)],
        }
    }

    /// ∫ ½ û′² − g û (1.19, 1.22) by Gauss and Legendre.
    fn energy() -> Result<Self> {
        let interval = Domain::interval("x", [0.0, 1.0])?;
        let rule = Functional::integral(&interval, Operator::identity(), QUADRATURE)?;
        Ok(Self {
            points: rule.points.iter().map(|[x]| *x).zip(rule.weights).collect(),
            slope: |x, [_, slope, _]| [-load(x), slope, 0.0],
        })
    }

    fn gradient(&self, weights: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; WEIGHTS];
        for &(x, share) in &self.points {
            let trace = forward(weights, x);
            let slope = (self.slope)(x, constrained(x, trace.output)).map(|s| share * s);
            backward(weights, &trace, constrained_back(x, slope), &mut gradient);
        }
        gradient
    }
}

pub(super) fn pinn(scale: Scale) -> Experiment {
    let cases = [
        (Method::StrongForm, format!("{STRONG_POINTS} collocation points")),
        (Method::EnergyForm, format!("{QUADRATURE} quadrature points")),
    ];
    let case = |(method, setting)| {
        let run = move |task: &Task| run_pinn(method, scale, task);
        Case::new(("Poisson in 1-D", &[]), method, run).at(setting)
    };
    Experiment {
        title: "A first PINN (§1.7.3, Fig. 1.4)",
        about: "Two hidden layers of 16 tanh units times x(1 − x), Adam. The energy has the factor ½ that the thesis \
                leaves out of (1.19), without which its minimum is 2u.",
        cases: cases.map(case).into(),
    }
}

fn run_pinn(method: Method, scale: Scale, task: &Task) -> Result<Run> {
    let steps = scale.pick(20_000, 300);
    let start = Instant::now();
    let loss = if method == Method::EnergyForm { Loss::energy()? } else { Loss::strong() };
    let mut weights = random_weights(task.seed_for(Purpose::Starts));
    adam(&mut weights, steps, RATES, |weights| loss.gradient(weights));
    let seconds = start.elapsed().as_secs_f64();
    let grid: Vec<[f64; 1]> = (0..GRID).map(|k| [k as f64 / (GRID - 1) as f64]).collect();
    let jets: Vec<Jet> =
        grid.iter().map(|[x]| constrained(*x, forward(&weights, *x).output)).collect();
    let mean = |error: &dyn Fn(f64, &Jet) -> f64| {
        grid.iter().zip(&jets).map(|([x], jet)| error(*x, jet).abs()).sum::<f64>() / GRID as f64
    };
    let err_u = mean(&|x, jet| jet[0] - solution(x));
    let err_f = mean(&|x, jet| jet[2] + load(x));
    let panel = |title: &str, symbol: &str, exact: fn(f64) -> f64, values: Vec<f64>| {
        let exact: Vec<f64> = grid.iter().map(|[x]| exact(*x)).collect();
        let chart = Chart::new(format!("{}: {title}", method.label()), ["x", symbol], [false; 2]);
        let exact = draw::curve("exact", &grid, &exact);
        chart.with(exact).with(draw::curve(method.label(), &grid, &values))
    };
    let figure = || Figure {
        title: format!("{} (Fig. 1.4)", method.label()),
        caption: String::new(),
        panels: vec![
            panel("solution", "u", solution, jets.iter().map(|jet| jet[0]).collect()),
            panel("right-hand side", "g", load, jets.iter().map(|jet| -jet[2]).collect()),
        ],
    };
    Ok(Run {
        err_u,
        seconds,
        err_f: Some(err_f),
        evaluations: Some(steps),
        figures: task.draw.then(figure).into_iter().collect(),
        ..Run::default()
    })
}

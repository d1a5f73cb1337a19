//! The introduction's PINN (§1.7.3): −u″ = x² with u(0) = u(1) = 0, by the strong form or by the energy.
//!
//! Misprints corrected: u = (x − x⁴)/12, and the energy has ½⟨u′, u′⟩.

use crate::gp::deep::{Jet, WEIGHTS, adam, backward, forward, random_weights};
use crate::gp::draw;
use crate::gp::experiment::{Case, Experiment, Purpose, Scale, Task};
use crate::gp::row::{Method, Run};
use anyhow::Result;
use sinew_gp::{Domain, Functional, Operator};
use sinew_report::{Chart, Figure, Panel};
use std::time::Instant;

const COLLOCATION: usize = 50;
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
        let points = (0..COLLOCATION).map(|k| (k as f64 + 0.5) / COLLOCATION as f64);
        Self {
            points: points.map(|x| (x, 1.0 / COLLOCATION as f64)).collect(),
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

/// Both forms.
pub(super) fn experiment(scale: Scale) -> Experiment {
    let cases = [
        (Method::StrongForm, format!("{COLLOCATION} collocation points")),
        (Method::EnergyForm, format!("{QUADRATURE} quadrature points")),
    ];
    let case = |(method, setting)| {
        let run = move |task: &Task| run(method, scale, task);
        Case::new(("Poisson in 1-D", &[]), method, run).at(setting)
    };
    Experiment {
        title: "A first PINN (§1.7.3, Fig. 1.4)",
        about: "Two hidden layers of 16 tanh units times x(1 − x), Adam. The energy has the factor ½ that the thesis \
                leaves out of (1.19), without which its minimum is 2u.",
        cases: cases.map(case).into(),
    }
}

fn run(method: Method, scale: Scale, task: &Task) -> Result<Run> {
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
        Panel::Chart(chart.with(exact).with(draw::curve(method.label(), &grid, &values)))
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

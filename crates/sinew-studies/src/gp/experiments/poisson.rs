//! Poisson equations of the thesis (§4.8.1): an interval, and a domain that is not a box.

use crate::gp::draw;
use crate::gp::experiment::{Case, Experiment, Purpose, Scale, Task, derived};
use crate::gp::hcnn::Network;
use crate::gp::inference::{Approach, Inference, Observed};
use crate::gp::pentagon::{Pentagon, corners};
use crate::gp::problems::{self, Setting};
use crate::gp::row::{Method, Run};
use anyhow::Result;
use sinew_gp::{
    Conditional, Data, Domain, Evidence, GpError, Model, Noise, Prior, Problem, constant,
    squared_exponential,
};
use sinew_report::{Chart, Figure, Panel, Series, Style};
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
        panels: vec![Panel::Chart(Chart {
            series: lines.collect(),
            ..Chart::new("functions drawn from the prior", ["x", "u"], [false; 2])
        })],
    })
}

fn network_case(setting: &Setting<1>, count: usize, scale: Scale) -> Case {
    let own = setting.clone();
    let run = move |task: &Task| run_network(&own, count, scale, task);
    Case::new(setting.named(), Method::Hcnn, run)
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

fn run_network(setting: &Setting<1>, count: usize, scale: Scale, task: &Task) -> Result<Run> {
    let start = Instant::now();
    let seed = task.seed_for(Purpose::Starts);
    let network = train(setting, count, scale.pick(4, 1), scale, seed)?;
    let seconds = start.elapsed().as_secs_f64();
    let grid = setting.grid(scale);
    let err_u = setting.error(&grid, &network.values(&grid));
    let figures = match task.draw && count == SHOWN {
        true => vec![two_starts(setting, scale, seed)?],
        false => Vec::new(),
    };
    let evaluations = Some(network.evaluations);
    Ok(Run { err_u, seconds, evaluations, figures, ..Run::default() })
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
        Panel::Chart(chart)
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

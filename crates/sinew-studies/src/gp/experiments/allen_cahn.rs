//! A thin travelling front: a nonlinear equation, forward and inverse, beyond the thesis' linear ones.

use crate::gp::experiment::{Case, Experiment, Purpose, Scale, Task};
use crate::gp::inference::{Approach, Drawings, Inference, Observed};
use crate::gp::problems::{Setting, allen_cahn};
use crate::gp::row::{Covered, Run};
use crate::program::standard_normal;
use anyhow::Result;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_gp::{Derivative, Domain, FitOptions, Noise, SemiLinear, Solution, squared_exponential};
use std::time::Instant;

/// Steps of linearisation at most.
const STEPS: usize = 15;
/// Collocation points and values of the inverse problem.
const COLLOCATION: usize = 50;
const VALUES: usize = 40;
/// Errors of the values in standard deviations of u, which is one half.
const NOISE: f64 = 0.025 * 0.5;
/// Places of measurement: the front passes late, and u depends on ε.
const WINDOW: [[f64; 2]; 2] = [[-0.2, 0.4], [0.5, 1.0]];
/// κ of an axis that is even to a millionth, and of one stretched about the front at t = 0.
const EVEN: f64 = 1e-3;
const STRETCHED: f64 = 2.5;
/// Points along the axes of the grid that bands are compared on.
const PLACES: usize = 12;

/// Fronts from collocation alone, and ε from values.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let mut cases = Vec::new();
    for (kappa, name) in [(EVEN, "even axis"), (STRETCHED, "stretched axis")] {
        for &count in scale.pick(&[25, 50, 100][..], &[10]) {
            cases.push(forward(scale, kappa, count)?.case(format!("{name}, N_f = {count}")));
        }
    }
    let equation =
        [(Noise::Exact, "exact equation"), (Noise::Learned, "equation with learned noise")];
    for (noise, name) in equation {
        cases.push(inverse(scale, noise)?.case(format!("{VALUES} values, {name}")));
    }
    Ok(Experiment {
        title: "A nonlinear equation: Allen and Cahn's front",
        about: "u_t = ε² u_xx + u − u³ on [−1, 1] × [0, 1] with ε = 0.05, values of the travelling front at both ends and \
                at the start as hard conditions; not in the thesis. First with ε known from collocation alone, then ε \
                from 40 values with errors of 2.5 % where the front passes late and 50 collocation points on the \
                stretched axis. Intervals and bands are those the fit answers with.",
        cases,
    })
}

/// One way to one of the problems.
struct Front {
    equation: SemiLinear<2, 1>,
    inference: Inference<2>,
    kappa: f64,
    /// Label that distinguishes it from the others.
    name: String,
}

fn front(scale: Scale, kappa: f64, unknown: bool) -> Result<Front> {
    let setting = allen_cahn(kappa, unknown)?;
    let term = |[u]: [sinew_gp::Series; 1]| u.powi(3) - u;
    let equation = SemiLinear::new(setting.problem.clone(), [Derivative::identity()], term);
    let nothing = |_: &Setting<2>, _: &Task| Ok(Observed::collocated(Vec::new(), Vec::new()));
    let inference = Inference::new(&setting, Approach::Constrained, scale, nothing);
    let inference = Inference { restarts: scale.pick(2, 1), ..inference };
    Ok(Front { equation, inference, kappa, name: String::new() })
}

fn forward(scale: Scale, kappa: f64, count: usize) -> Result<Front> {
    let front = front(scale, kappa, false)?;
    let observe = move |_: &Setting<2>, task: &Task| {
        Ok(Observed::collocated(lattice(count, task), vec![0.0; count]))
    };
    // One of a kind is enough to be seen.
    let drawings = if count == COLLOCATION { Drawings::Posterior } else { Drawings::None };
    let inference = Inference { observe: Box::new(observe), drawings, ..front.inference };
    Ok(Front { inference, ..front })
}

fn inverse(scale: Scale, noise: Noise) -> Result<Front> {
    let front = front(scale, STRETCHED, true)?;
    let observe = move |setting: &Setting<2>, task: &Task| {
        let window = Domain::cuboid([("x", WINDOW[0]), ("t", WINDOW[1])])?;
        let places = window.sample(VALUES, task.seed_for(Purpose::Places))?;
        let places: Vec<[f64; 2]> =
            places.into_iter().map(|[x, t]| [stretched(x, STRETCHED), t]).collect();
        let mut random = ChaCha8Rng::seed_from_u64(task.seed_for(Purpose::Noise));
        let mut noisy = |value: f64| value + NOISE * standard_normal(&mut random);
        Ok(Observed {
            values: places.iter().map(|place| noisy((setting.solution)(*place))).collect(),
            places,
            collocation: lattice(scale.pick(COLLOCATION, 12), task),
            load: vec![0.0; scale.pick(COLLOCATION, 12)],
            noise: [Noise::Learned, noise],
        })
    };
    let inference = Inference { observe: Box::new(observe), ..front.inference };
    Ok(Front { inference, ..front })
}

impl Front {
    fn case(self, name: String) -> Case {
        let (setting, method) = (self.inference.setting.clone(), self.inference.approach.method());
        let front = Self { name: name.clone(), ..self };
        Case::new(setting.named(), method, move |task| front.run(task)).at(name)
    }

    fn run(&self, task: &Task) -> Result<Run> {
        let setting = &self.inference.setting;
        let observed = (self.inference.observe)(setting, task)?;
        let (data, kernel) = (observed.data(), squared_exponential());
        let options = FitOptions {
            restarts: self.inference.restarts,
            seed: task.seed_for(Purpose::Starts),
            ..FitOptions::default()
        };
        let start = Instant::now();
        let solution = self.equation.solve(&kernel, &data, &options, STEPS)?;
        let seconds = start.elapsed().as_secs_f64();
        let grid = self.grid(self.inference.scale.pick(60, 12))?;
        let mut run = self.inference.measured(&solution.fit, &observed, &grid, task)?;
        run.figures.iter_mut().for_each(|figure| figure.title += &format!(", {}", self.name));
        Ok(Run { seconds, covered: self.covered(&solution)?, ..run })
    }

    /// Points that are even in x and t.
    fn grid(&self, count: usize) -> Result<Vec<[f64; 2]>> {
        let even = Domain::cuboid([("x", [-1.0, 1.0]), ("t", [0.0, 1.0])])?.grid(count);
        Ok(even.into_iter().map(|[x, t]| [stretched(x, self.kappa), t]).collect())
    }

    /// Whether the interval of ε holds it, and where the band holds u; none where ε is known.
    fn covered(&self, solution: &Solution<2>) -> Result<Option<Covered>> {
        if self.inference.setting.truth.is_empty() {
            return Ok(None);
        }
        // On the boundary bands have no width.
        let inside = |[s, t]: &[f64; 2]| s.abs() < 1.0 && *t > 0.0;
        let places: Vec<[f64; 2]> = self.grid(PLACES)?.into_iter().filter(inside).collect();
        Ok(Some(self.inference.setting.judged(&solution.fit, &places)?))
    }
}

/// s of x = sinh(κ s)/sinh κ.
fn stretched(x: f64, kappa: f64) -> f64 {
    (x * kappa.sinh()).asinh() / kappa
}

/// Points of Fibonacci's kind, evenly spread and no two at one place or one time, from a random one on.
fn lattice(count: usize, task: &Task) -> Vec<[f64; 2]> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let first: f64 =
        ChaCha8Rng::seed_from_u64(task.seed_for(Purpose::Collocation)).random_range(0.0..1.0);
    (0..count)
        .map(|k| {
            let s = 2.0 * (k as f64 + 0.5) / count as f64 - 1.0;
            [s, (first + k as f64 * golden).fract()]
        })
        .collect()
}

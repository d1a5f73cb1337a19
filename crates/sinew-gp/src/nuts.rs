//! The No-U-Turn sampler over all parameters of a model.
//!
//! Hoffman & Gelman 2014, with multinomial choice along the trajectory (Betancourt 2017). The
//! space is stretched by the curvature at the fit, and each parameter's interval is opened up by
//! a logistic map, so that one step size serves all directions.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::ensemble::Ensemble;
use crate::error::GpError;
use crate::fit::Fit;
use crate::laplace::Normal;
use crate::model::Model;
use crate::posterior::standard_normal;

/// How parameters are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NutsOptions {
    /// Steps to find a step size, not kept.
    pub warmup: usize,
    /// Draws kept.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for NutsOptions {
    fn default() -> Self {
        Self { warmup: 150, draws: 300, seed: 0 }
    }
}

/// Mean acceptance that the step size is adapted to.
const ACCEPTANCE: f64 = 0.8;
/// Error of the energy beyond which a trajectory has left the region where it can be followed.
const DIVERGENCE: f64 = 1000.0;
const MOST_DOUBLINGS: usize = 8;

/// Draws parameters from their posterior, starting at the fit, for the evidence of
/// [`Model::ensemble_evidence`].
///
/// # Errors
/// If the evidence cannot be evaluated at the fit.
pub fn nuts<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>, GpError> {
    let model = fit.model();
    let space = Space::new(model, &fit.ensemble_mode())?;
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let mut state = space.state(vec![0.0; model.parameters().len()]);
    let mut adaptation = StepSize::new(0.2);
    let mut draws = Vec::with_capacity(options.draws);
    for iteration in 0..options.warmup + options.draws {
        let warming = iteration < options.warmup;
        let step = if warming { adaptation.current } else { adaptation.settled() };
        let acceptance;
        (state, acceptance) = transition(&space, state, step, &mut random);
        if warming {
            adaptation.learn(acceptance);
        } else {
            draws.push(space.parameters(&state.position));
        }
    }
    Ok(Ensemble::new(model.clone(), draws))
}

/// Whitened coordinates z: q = q̂ + S z, each parameter a logistic function of its q.
struct Space<'a, const D: usize> {
    model: &'a Model<D>,
    normal: Normal,
    /// Ends of each parameter's interval, on its scale.
    bounds: Vec<[f64; 2]>,
}

/// A point of a trajectory.
#[derive(Clone, Debug)]
struct State {
    position: Vec<f64>,
    momentum: Vec<f64>,
    gradient: Vec<f64>,
    log_density: f64,
}

impl State {
    fn log_joint(&self) -> f64 {
        self.log_density - 0.5 * self.momentum.iter().map(|p| p * p).sum::<f64>()
    }
}

/// Share of an interval that a fit at its end is moved inwards by.
const INWARDS: f64 = 1e-3;

impl<'a, const D: usize> Space<'a, D> {
    fn new(model: &'a Model<D>, fitted: &[f64]) -> Result<Self, GpError> {
        let bounds = model.scaled_bounds();
        let inside: Vec<f64> = fitted
            .iter()
            .zip(&bounds)
            .map(|(x, [lower, upper])| {
                let margin = INWARDS * (upper - lower);
                x.clamp(lower + margin, upper - margin)
            })
            .collect();
        let mut normal = Normal::at(model, &inside)?;
        for (row, (x, [lower, upper])) in inside.iter().zip(&bounds).enumerate() {
            let share = (x - lower) / (upper - lower);
            normal.mean[row] = (share / (1.0 - share)).ln();
            // dq/dx of the logistic map, which takes the factor from x to q.
            let slope = 1.0 / ((upper - lower) * share * (1.0 - share));
            for mode in 0..inside.len() {
                normal.factor[(row, mode)] *= slope;
            }
        }
        Ok(Self { model, normal, bounds })
    }

    fn parameters(&self, position: &[f64]) -> Vec<f64> {
        self.normal
            .map(position)
            .iter()
            .zip(&self.bounds)
            .map(|(q, [lower, upper])| lower + (upper - lower) / (1.0 + (-q).exp()))
            .collect()
    }

    /// Density and gradient; −∞ where the evidence has no value.
    fn state(&self, position: Vec<f64>) -> State {
        let momentum = vec![0.0; position.len()];
        let q = self.normal.map(&position);
        let parameters = self.parameters(&position);
        let evidence = self.model.ensemble_evidence();
        let Ok(evaluation) = self.model.evaluate_posterior(evidence, &parameters) else {
            let gradient = momentum.clone();
            return State { position, momentum, gradient, log_density: f64::NEG_INFINITY };
        };
        let mut log_density = evaluation.value;
        // With s the logistic function, ln |dx/dq| = ln s + ln (1 − s) up to a constant.
        let by_q: Vec<f64> = q
            .iter()
            .zip(&self.bounds)
            .zip(&evaluation.gradient)
            .map(|((q, [lower, upper]), slope)| {
                let s = 1.0 / (1.0 + (-q).exp());
                log_density += s.ln() + (1.0 - s).ln();
                slope * (upper - lower) * s * (1.0 - s) + 1.0 - 2.0 * s
            })
            .collect();
        let gradient = (0..by_q.len())
            .map(|mode| self.normal.factor.col(mode).iter().zip(&by_q).map(|(s, g)| s * g).sum())
            .collect();
        if !log_density.is_finite() {
            log_density = f64::NEG_INFINITY;
        }
        State { position, momentum, gradient, log_density }
    }

    fn leapfrog(&self, from: &State, step: f64) -> State {
        let half: Vec<f64> =
            from.momentum.iter().zip(&from.gradient).map(|(p, g)| p + 0.5 * step * g).collect();
        let position = from.position.iter().zip(&half).map(|(x, p)| x + step * p).collect();
        let mut next = self.state(position);
        next.momentum = half.iter().zip(&next.gradient).map(|(p, g)| p + 0.5 * step * g).collect();
        next
    }
}

/// A stretch of a trajectory.
struct Tree {
    first: State,
    last: State,
    chosen: State,
    /// Logarithm of the sum of exp(energy error) of its states.
    log_weight: f64,
    /// Whether it turned back on itself, or its energy went astray.
    ended: bool,
    acceptance: f64,
    states: usize,
}

fn turned(first: &State, last: &State) -> bool {
    let along = |momentum: &[f64]| -> f64 {
        let ends = last.position.iter().zip(&first.position);
        ends.zip(momentum).map(|((b, a), p)| (b - a) * p).sum()
    };
    along(&first.momentum) < 0.0 || along(&last.momentum) < 0.0
}

fn log_sum(a: f64, b: f64) -> f64 {
    let most = a.max(b);
    if most == f64::NEG_INFINITY { most } else { most + ((a - most).exp() + (b - most).exp()).ln() }
}

/// 2^depth steps on from `from`.
fn build<const D: usize>(
    space: &Space<'_, D>,
    from: &State,
    step: f64,
    depth: usize,
    start: f64,
    random: &mut ChaCha8Rng,
) -> Tree {
    if depth == 0 {
        let next = space.leapfrog(from, step);
        let log_weight = next.log_joint() - start;
        let log_weight = if log_weight.is_nan() { f64::NEG_INFINITY } else { log_weight };
        return Tree {
            first: next.clone(),
            last: next.clone(),
            chosen: next,
            log_weight,
            ended: log_weight < -DIVERGENCE,
            acceptance: log_weight.exp().min(1.0),
            states: 1,
        };
    }
    let mut tree = build(space, from, step, depth - 1, start, random);
    if tree.ended {
        return tree;
    }
    let edge = if step > 0.0 { &tree.last } else { &tree.first };
    let further = build(space, edge, step, depth - 1, start, random);
    tree.join(further, step > 0.0, false, random);
    tree
}

impl Tree {
    /// Appends a stretch; the new one's state is preferred where `biased` (Betancourt 2017, A.3.2).
    fn join(&mut self, further: Self, forward: bool, biased: bool, random: &mut ChaCha8Rng) {
        let total = log_sum(self.log_weight, further.log_weight);
        let against = if biased { self.log_weight } else { total };
        self.acceptance += further.acceptance;
        self.states += further.states;
        if !further.ended && random.random::<f64>().ln() < further.log_weight - against {
            self.chosen = further.chosen;
        }
        self.log_weight = total;
        if forward {
            self.last = further.last;
        } else {
            self.first = further.first;
        }
        self.ended = further.ended || turned(&self.first, &self.last);
    }
}

fn transition<const D: usize>(
    space: &Space<'_, D>,
    mut state: State,
    step: f64,
    random: &mut ChaCha8Rng,
) -> (State, f64) {
    state.momentum.iter_mut().for_each(|p| *p = standard_normal(random));
    let start = state.log_joint();
    let mut tree = Tree {
        first: state.clone(),
        last: state.clone(),
        chosen: state,
        log_weight: 0.0,
        ended: false,
        acceptance: 0.0,
        states: 0,
    };
    for depth in 0..MOST_DOUBLINGS {
        let forward = random.random::<bool>();
        let (edge, signed) = if forward { (&tree.last, step) } else { (&tree.first, -step) };
        let further = build(space, edge, signed, depth, start, random);
        tree.join(further, forward, true, random);
        if tree.ended {
            break;
        }
    }
    (tree.chosen, tree.acceptance / tree.states.max(1) as f64)
}

/// Dual averaging of the logarithm of the step size (Hoffman & Gelman 2014, §3.2).
struct StepSize {
    current: f64,
    centre: f64,
    averaged: f64,
    error: f64,
    count: f64,
}

impl StepSize {
    fn new(start: f64) -> Self {
        Self {
            current: start,
            centre: (10.0 * start).ln(),
            averaged: start.ln(),
            error: 0.0,
            count: 0.0,
        }
    }

    fn settled(&self) -> f64 {
        self.averaged.exp()
    }

    fn learn(&mut self, acceptance: f64) {
        // Their γ, t₀ and κ.
        const GAMMA: f64 = 0.05;
        const DELAY: f64 = 10.0;
        const DECAY: f64 = 0.75;
        self.count += 1.0;
        let share = 1.0 / (self.count + DELAY);
        self.error += share * (ACCEPTANCE - acceptance - self.error);
        let logarithm = self.centre - self.count.sqrt() / GAMMA * self.error;
        let weight = self.count.powf(-DECAY);
        self.averaged += weight * (logarithm - self.averaged);
        self.current = logarithm.exp();
    }
}

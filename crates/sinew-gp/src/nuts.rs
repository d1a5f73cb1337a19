//! The No-U-Turn sampler over all parameters of a model.
//!
//! Hoffman & Gelman 2014, with multinomial choice along the trajectory (Betancourt 2017). The
//! space is stretched by the curvature at the maximum, and each parameter's interval is opened up by
//! a logistic map, so that one step size serves all directions.

use crate::ensemble::Ensemble;
use crate::error::GpError;
use crate::fit::Fit;
use crate::posterior::standard_normal;
use crate::space::Space;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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

/// Draws parameters from their posterior, starting at its maximum.
///
/// # Errors
/// If the evidence cannot be evaluated at the fit.
pub fn nuts<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>, GpError> {
    let model = fit.model();
    let space = Space::new(model, &fit.outcome().parameters)?;
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let mut state = space.state(vec![0.0; space.dimension()]);
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

impl<const D: usize> Space<'_, D> {
    fn state(&self, position: Vec<f64>) -> State {
        let (log_density, gradient) = self.log_density_and_slope(&position);
        State { momentum: vec![0.0; position.len()], position, gradient, log_density }
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

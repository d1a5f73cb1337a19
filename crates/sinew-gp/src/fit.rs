//! The fit of a model: the most probable parameters, searched for from several starts, with as many points as the equation needs.

pub(crate) mod optimise;
pub(crate) mod resolve;
pub(crate) mod warning;
pub(crate) mod warnings;

use crate::fit::optimise::{Maximum, maximise};
use crate::{Conditional, Ensemble, FreeParameter, GpError, Measure, Model, Result, Term, Warning};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_num::in_parallel;
use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

/// Options of the search for a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Number of random starts; one at least is tried.
    pub restarts: usize,
    /// Iterations of each at most.
    pub iterations: usize,
    /// Seed of the starts.
    pub seed: u64,
    /// Collocation points that the fit adds up to, where it knows the right-hand side between those given (see [`Model::fit`]). With 0,
    /// points and equation stay as they are given, and what they leave open is not in the intervals.
    pub most_points: usize,
    /// Memory \[bytes\] that matrices of all observations may take.
    pub most_memory: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { restarts: 4, iterations: 300, seed: 0, most_points: 200, most_memory: 8e9 }
    }
}

/// Rounds of further points at most.
pub(crate) const ROUNDS: u64 = 8;
/// Share of the error before that a round must stay below, at least every other time.
const BETTER: f64 = 0.8;
/// Starts that are looked at before climbing, and their seed.
const SCANNED: usize = 48;
const SCAN_SEED: u64 = 0x5ca7;

/// One start and where it led.
#[derive(Clone, Debug)]
pub struct Restart {
    /// Parameters it began at, on their scales.
    pub start: Vec<f64>,
    /// Outcome.
    pub outcome: Result<Outcome>,
}

/// A local maximum.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Parameters, on their scales.
    pub parameters: Vec<f64>,
    /// Logarithm of the evidence, which [`crate::Model::evidence`] names.
    pub log_evidence: f64,
    /// Logarithm of evidence times prior density of the parameters: what was maximised.
    pub log_posterior: f64,
    /// Evaluations of evidence and gradient.
    pub evaluations: usize,
    /// Relative jitter at the end.
    pub jitter: f64,
    /// Whether the posterior explains less than a tenth of the variance of measured values with errors: the
    /// "trivial solution" that takes all of it for noise.
    pub collapsed: bool,
    /// The equation's parameters in their own unit after each iteration.
    pub trace: Vec<Vec<f64>>,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit<const D: usize> {
    pub(crate) model: Arc<Model<D>>,
    /// All restarts, in the order of their starts.
    pub restarts: Vec<Restart>,
    pub(crate) best: usize,
    /// Why its points or steps did not suffice.
    pub(crate) unsettled: Option<Warning>,
    /// Error of the equation where it was left out, before it was put into the model.
    pub(crate) hold_out: Option<HoldOut>,
    /// Parameters that the data do not tell, once sought.
    pub(crate) silent: OnceLock<Result<Vec<usize>>>,
    /// Ensemble of its own, once made.
    pub(crate) ensemble: OnceLock<Result<Ensemble<D>>>,
}

/// Error of the equation at places that the fit did not know of.
#[derive(Clone, Debug)]
pub(crate) struct HoldOut {
    /// The worst of them.
    pub at: Vec<f64>,
    /// Root mean square.
    pub residual: f64,
    /// Size of the equation's largest term.
    pub term: f64,
}

impl<const D: usize> Model<D> {
    /// Maximises evidence times [`crate::Hyperprior`]s from several starts, in parallel: half of them drawn at random, half the
    /// most probable of many.
    ///
    /// The best restart that did not collapse is taken, or the best if all did. Where the equation holds everywhere
    /// ([`crate::Data::equation_everywhere`]), or has the same right-hand side at all of its points (ten or more, in the box that they fill), further points are
    /// imposed where it is off, up to [`FitOptions::most_points`], as long as they help. The error that is left, at points left out or in between, is
    /// taken for noise of the equation, so that intervals and bands are as wide as it leaves them.
    ///
    /// # Errors
    /// If no restart has a finite evidence, or matrices of all observations would take more than [`FitOptions::most_memory`].
    pub fn fit(self, options: &FitOptions) -> Result<Fit<D>> {
        instance!(D, Model::resolved, fn(Model<D>, &FitOptions) -> Result<Fit<D>>)(self, options)
    }

    fn resolved(self, options: &FitOptions) -> Result<Fit<D>> {
        self.check_memory(options)?;
        let starts = self.chosen_starts(options);
        let mut fit = self.fit_from(starts, options.iterations)?;
        if options.most_points == 0 {
            return Ok(fit);
        }
        let aim = fit.model().aim();
        let (mut error, mut idle, mut best) = (f64::INFINITY, 0, None);
        for round in 0.. {
            let Some(mut found) = fit.left_out()? else { return Ok(fit) };
            if round == 0 && found.residual > aim * found.term {
                (fit, found) = fit.stretched(found, options)?;
            }
            let now = found.residual / found.term;
            idle = if now <= BETTER * error { 0 } else { idle + 1 };
            if best.is_none() || now < error {
                best = Some((fit.clone(), found));
            }
            error = error.min(now);
            let more = match now <= aim || round == ROUNDS || idle == 3 {
                true => None,
                false => fit.with_more_points(options.most_points, round)?,
            };
            let Some(model) = more else {
                let open = fit.model().source.is_some() && error > aim;
                let points = fit.model().places().len();
                let (mut fit, found) = best.expect("a first fit");
                fit.unsettled = open.then(|| Warning::of_points(points, options.most_points));
                return fit.with_equation_error(found, options.iterations);
            };
            let mut starts = model.random_starts(options);
            starts.truncate(1);
            starts.push(fit.outcome().parameters.clone());
            fit = model.fit_from(starts, options.iterations)?;
        }
        unreachable!("the last round returns")
    }

    /// The starts of [`Model::fit`].
    pub(crate) fn random_starts(&self, options: &FitOptions) -> Vec<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(options.seed);
        (0..options.restarts.max(1)).map(|_| self.random_start(&mut random)).collect()
    }

    /// Starts of [`Model::fit`]: half of them as drawn, half the most probable of some dozens, in which parameters of the equation are
    /// spread evenly over their ranges, with lengthscales as drawn or as the equation suggests. Evidences with a maximum for each
    /// number of waves are climbed from near the right one.
    pub(crate) fn chosen_starts(&self, options: &FitOptions) -> Vec<Vec<f64>> {
        let mut starts = self.random_starts(options);
        let chosen = starts.len() / 2;
        if self.theta.is_empty() || chosen == 0 {
            return starts;
        }
        let mut random = ChaCha8Rng::seed_from_u64(options.seed ^ SCAN_SEED);
        let mut scanned: Vec<_> = (0..SCANNED).map(|_| self.random_start(&mut random)).collect();
        for position in self.theta_range() {
            let [lower, upper] = self.scaled_bounds()[position];
            let mut order: Vec<(u64, usize)> = (0..SCANNED).map(|k| (random.random(), k)).collect();
            order.sort_unstable();
            for (stratum, (_, k)) in order.into_iter().enumerate() {
                let share = (stratum as f64 + random.random::<f64>()) / SCANNED as f64;
                scanned[k][position] = lower + share * (upper - lower);
            }
        }
        // Lengthscales of every other one are those of its equation.
        scanned.iter_mut().skip(1).step_by(2).for_each(|start| self.scale_lengths(start));
        let value = |x: Vec<f64>| (self.log_posterior(&x), x);
        let mut scanned = in_parallel(scanned, value);
        scanned.sort_by(|a, b| b.0.total_cmp(&a.0));
        starts.truncate(starts.len() - chosen);
        starts.extend(scanned.into_iter().take(chosen).map(|(_, start)| start));
        starts
    }

    /// Moves the lengthscales of a start, drawn for functions that vary over the whole domain, to the half waves that solve the
    /// equation at its parameters, where these are shorter: of sin kx for u″ + k² u = 0.
    fn scale_lengths(&self, start: &mut [f64]) {
        let theta = self.theta_values(start);
        let waves: [f64; D] = std::array::from_fn(|axis| self.half_wave(axis, &theta));
        for (part, offset) in self.prior.parts.iter().zip(&self.part_offsets) {
            for (k, hyperparameter) in part.kernel.hyperparameters().iter().enumerate() {
                if let Measure::Length { axis } = hyperparameter.measure {
                    start[offset + 1 + k] += waves[axis].min(1.0).ln();
                }
            }
        }
    }

    /// Shortest half wave along an axis in units of its extent for which a term of the highest order along it cancels one of a lower
    /// order; infinite where none does.
    fn half_wave(&self, axis: usize, theta: &[f64]) -> f64 {
        let of = |term: &Term<D>| (term.derivative.orders[axis], self.symbol(term, theta));
        let terms: Vec<(usize, f64)> = self.prior.equation.terms().iter().map(of).collect();
        let most = terms.iter().map(|(order, _)| *order).max().unwrap_or(0);
        let lower = terms.iter().filter(|(order, _)| *order < most);
        let highest = || terms.iter().filter(|(order, _)| *order == most);
        let pairs = lower.flat_map(|low| highest().map(move |high| (low, high)));
        let length = |((order, low), (_, high)): (&(usize, f64), &(usize, f64))| {
            (-high / low).powf(((most - order) as f64).recip())
        };
        PI * pairs.map(length).filter(|length| *length > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Fourier symbol of a term at a wavenumber of one over the extent along each axis, in the middle of the domain; 0 where it is
    /// imaginary.
    fn symbol(&self, term: &Term<D>, theta: &[f64]) -> f64 {
        let (domain, orders) = (&self.prior.domain, term.derivative.orders);
        let powers = term.parameters.iter().map(|(own, power)| {
            let known = self.theta.iter().position(|other| other == own);
            known.map_or(1.0, |k| theta[k].powi(*power))
        });
        let middle = domain.ends.map(|[lower, upper]| 0.5 * (lower + upper));
        let function = term.function.as_ref().map_or(1.0, |function| function.value(middle));
        let shrink = domain.extents().into_iter().zip(orders).map(|(l, n)| l.powi(-(n as i32)));
        let turned = [1.0, 0.0, -1.0, 0.0][orders.iter().sum::<usize>() % 4];
        turned * term.scale * function * powers.chain(shrink).product::<f64>()
    }

    /// [`Model::fit`] from given starts, on the parameters' scales; they are moved into the bounds. An equation that holds
    /// everywhere stays at the points that it begins with, of which [`Fit::warnings`] tells.
    ///
    /// # Errors
    /// As [`Model::fit`]; and if there are no starts, or one has another number of parameters.
    pub fn fit_from(self, starts: Vec<Vec<f64>>, iterations: usize) -> Result<Fit<D>> {
        instance!(D, Model::climbed_from, fn(Model<D>, Vec<Vec<f64>>, usize) -> Result<Fit<D>>)(
            self, starts, iterations,
        )
    }

    fn climbed_from(self, starts: Vec<Vec<f64>>, iterations: usize) -> Result<Fit<D>> {
        ensure!(
            !starts.is_empty(),
            "no starts are given; give one at least, or let `Model::fit` draw some"
        );
        starts.iter().try_for_each(|start| self.check_count(start))?;
        let model = Arc::new(self);
        let climb = |start: Vec<f64>| Restart { outcome: model.climb(&start, iterations), start };
        let restarts = in_parallel(starts, climb);
        let rank = |restart: &Restart| match &restart.outcome {
            Ok(outcome) => (!outcome.collapsed, outcome.log_posterior),
            Err(_) => (false, f64::NEG_INFINITY),
        };
        let best = (0..restarts.len())
            .max_by(|a, b| rank(&restarts[*a]).partial_cmp(&rank(&restarts[*b])).expect("numbers"))
            .expect("a start");
        // Until more points of an equation everywhere have left the answer as it is.
        let points = model.source.as_ref().map(|_| model.places().len());
        let unsettled = points.map(|points| Warning::Unsettled { points });
        if let Err(last) = &restarts[best].outcome {
            return Err(GpError::Invalid(format!(
                "none of {} restarts reached a finite evidence; narrow the bounds of the parameters or add noise; the last one: {last}",
                restarts.len()
            )));
        }
        let (hold_out, silent, ensemble) = (None, OnceLock::new(), OnceLock::new());
        Ok(Fit { model, restarts, best, unsettled, hold_out, silent, ensemble })
    }

    fn random_start(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let draw = |parameter: &FreeParameter| {
            let [lower, upper] = parameter.start.map(|end| parameter.to_scale(end));
            random.random_range(lower..=upper)
        };
        self.parameters.iter().map(draw).collect()
    }

    /// Ends of all parameters' intervals, on their scales.
    pub(crate) fn scaled_bounds(&self) -> Vec<[f64; 2]> {
        self.parameters.iter().map(|p| p.bounds.map(|bound| p.to_scale(bound))).collect()
    }

    fn climb(self: &Arc<Self>, start: &[f64], iterations: usize) -> Result<Outcome> {
        let mut last = GpError::NotPositiveDefinite { size: self.size, jitter: f64::NAN };
        let evaluate = |x: &[f64]| self.evaluate_posterior(x).map_err(|error| last = error).ok();
        let found = maximise(evaluate, start, &self.scaled_bounds(), iterations);
        let Some(Maximum { point, path, value, evaluations }) = found else { return Err(last) };
        let conditional = Conditional::new(self.clone(), &point)?;
        Ok(Outcome {
            log_evidence: value - self.log_hyperprior(&point),
            log_posterior: value,
            evaluations,
            jitter: conditional.jitter,
            collapsed: conditional.is_collapsed(),
            parameters: point,
            trace: path.iter().map(|x| self.theta_values(x)).collect(),
        })
    }
}

impl<const D: usize> Fit<D> {
    /// Outcome of the best restart.
    pub fn outcome(&self) -> &Outcome {
        self.restarts[self.best].outcome.as_ref().expect("the best restart succeeded")
    }

    /// The model that was fitted.
    pub fn model(&self) -> &Arc<Model<D>> {
        &self.model
    }

    /// Value of a parameter by name, in its own unit.
    ///
    /// # Errors
    /// If no parameter has that name.
    pub fn parameter(&self, name: &str) -> Result<f64> {
        let position = self.model.position(name)?;
        Ok(self.model.parameters()[position].from_scale(self.outcome().parameters[position]))
    }

    /// The process at the most probable parameters alone. Its standard deviations are too narrow, as lengthscales, noise and θ
    /// count as known; [`Fit::predict`] is the full posterior.
    ///
    /// # Errors
    /// If the covariance cannot be factorised, which fitting has done before.
    pub fn conditional(&self) -> Result<Conditional<D>> {
        Conditional::new(self.model.clone(), &self.outcome().parameters)
    }
}

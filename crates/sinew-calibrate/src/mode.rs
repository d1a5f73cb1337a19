//! Modes of the posterior by Levenberg's and Marquardt's method with exact derivatives (Nocedal and Wright, 10.3), from several
//! starts at once.

use crate::fault::Result;
use crate::likelihood::Noise;
use crate::problem::FACTOR_DEVIATION;
use crate::{Answer, CalibrateError, Observed, Problem, Solves};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Steps of a search at most.
const MOST_STEPS: usize = 25;
/// Step length that ends a search \[posterior standard deviations\], far below the error of a Laplace approximation.
const CONVERGED: f64 = 0.02;
/// Longest step \[prior standard deviations\].
const LONGEST_STEP: f64 = 1.5;
/// Moves of a start towards the middle of the prior until the solver has an answer.
const HALVINGS: usize = 4;
/// Distance above which two modes are distinct \[posterior standard deviations\].
const APART: f64 = 3.0;
/// Twice the difference of the log posterior to the best mode, above which a mode is dropped: it has less than 1e-4 of the
/// mass.
const NEGLIGIBLE: f64 = 20.0;
/// Steps of Newton's method for a factor of noise: a convex function of one number.
const FACTOR_STEPS: usize = 30;

/// A maximum of the posterior.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Coordinates, those of factors of noise included.
    pub y: Vec<f64>,
    /// Parameters.
    pub theta: Vec<f64>,
    /// Observables there.
    pub observed: Observed,
    /// Logarithm of the posterior, up to a constant.
    pub log_posterior: f64,
    /// Gauss and Newton's information of the data in the coordinates of the parameters: Jᵀ Σ⁻¹ J.
    pub information: DMatrix<f64>,
    /// Misfit over the standard deviation, datum by datum.
    pub misfits: Vec<f64>,
    /// Precision of all coordinates.
    pub(crate) precision: DMatrix<f64>,
}

/// Modes from starts, the best first.
pub(crate) fn modes(
    problem: &Problem,
    solves: &mut Solves,
    starts: Vec<Vec<f64>>,
) -> Result<Vec<Mode>> {
    let count = starts.len();
    let mut searches: Vec<Search> = starts.into_iter().map(|y| Search::new(problem, y)).collect();
    loop {
        let open: Vec<usize> = (0..count).filter(|&i| !searches[i].done).collect();
        if open.is_empty() {
            break;
        }
        let thetas: Vec<_> = open.iter().map(|&i| problem.theta(&searches[i].candidate)).collect();
        let answers = solves.at("search for the mode", &thetas, true)?;
        for ((&at, answer), theta) in open.iter().zip(answers).zip(thetas) {
            searches[at].tell(problem, answer, theta);
        }
    }
    let reason = searches.iter().filter_map(|s| s.reason.clone()).next_back().unwrap_or_default();
    let found = searches.into_iter().filter_map(|s| s.mode(problem));
    // Data of 1e160 deviations overflow.
    let mut found: Vec<Mode> = found.filter(|mode| mode.log_posterior.is_finite()).collect();
    found.sort_by(|a, b| b.log_posterior.total_cmp(&a.log_posterior));
    if found.is_empty() {
        return Err(CalibrateError::NoStart { starts: count, reason });
    }
    let best = found[0].log_posterior;
    found.retain(|mode| 2.0 * (best - mode.log_posterior) < NEGLIGIBLE);
    let mut apart: Vec<Mode> = Vec::new();
    for mode in found {
        if apart.iter().all(|other| distance(&mode.y, &other.y, &other.precision) > APART) {
            apart.push(mode);
        }
    }
    Ok(apart)
}

/// Distance of coordinates in standard deviations of a posterior about the second, by its precision.
pub(crate) fn distance(y: &[f64], about: &[f64], precision: &DMatrix<f64>) -> f64 {
    let step = DVector::from_fn(y.len(), |at, _| y[at] - about[at]);
    step.dot(&(precision * &step)).sqrt()
}

/// One search.
#[derive(Default)]
struct Search {
    candidate: Vec<f64>,
    best: Option<State>,
    damping: f64,
    steps: usize,
    halvings: usize,
    done: bool,
    reason: Option<String>,
}

/// A point with its misfit.
struct State {
    y: Vec<f64>,
    theta: Vec<f64>,
    observed: Observed,
    jacobian: DMatrix<f64>,
    residual: DVector<f64>,
    cost: f64,
}

impl Search {
    fn new(problem: &Problem, mut y: Vec<f64>) -> Self {
        y.resize(problem.dimension(), 0.0);
        Self { candidate: y, damping: 1e-2, ..Self::default() }
    }

    /// Takes the answer at the candidate, and sets the next candidate.
    fn tell(&mut self, problem: &Problem, answer: Answer, theta: Vec<f64>) {
        self.steps += 1;
        let next = answer.map_err(|error| error.reason).and_then(|observed| {
            State::new(problem, self.candidate.clone(), theta, observed)
                .ok_or_else(|| "the solver gives no derivatives".into())
        });
        match (next, &self.best) {
            (Err(reason), None) => {
                self.reason = Some(reason);
                self.halvings += 1;
                self.done = self.halvings > HALVINGS;
                self.candidate.iter_mut().for_each(|y| *y *= 0.5);
                return;
            }
            (Err(reason), Some(_)) => {
                self.reason = Some(reason);
                self.damping *= 10.0;
            }
            (Ok(state), Some(best)) if state.cost.is_nan() || state.cost >= best.cost => {
                self.damping *= 10.0;
            }
            (Ok(state), _) => {
                self.best = Some(state.with_factors(problem));
                self.damping = (self.damping * 0.1).max(1e-9);
            }
        }
        self.propose(problem);
    }

    fn propose(&mut self, problem: &Problem) {
        let Some(best) = &self.best else { return };
        let (information, noise) = best.information(problem);
        let count = problem.unknowns.len();
        let y = DVector::from_column_slice(&best.y[..count]);
        let force = best.jacobian.tr_mul(&noise.factor.solve(&best.residual)) - y;
        let precision = information + DMatrix::identity(count, count);
        let mut damped = precision.clone();
        (0..count).for_each(|at| damped[(at, at)] *= 1.0 + self.damping);
        let Some(factor) = Cholesky::new(damped) else {
            self.done = true;
            return;
        };
        let mut step = factor.solve(&force);
        let length = step.norm();
        if length > LONGEST_STEP {
            step *= LONGEST_STEP / length;
        }
        let size = step.dot(&(&precision * &step)).sqrt();
        self.done = size < CONVERGED || self.steps >= MOST_STEPS || !size.is_finite();
        self.candidate = best.y.clone();
        (0..count).for_each(|at| self.candidate[at] += step[at]);
    }

    fn mode(self, problem: &Problem) -> Option<Mode> {
        let best = self.best?;
        let (information, _) = best.information(problem);
        let (count, all) = (problem.unknowns.len(), problem.dimension());
        let mut precision = DMatrix::identity(all, all);
        let mut own = precision.view_mut((0, 0), (count, count));
        own += &information;
        let factors = problem.log_factors(&best.y);
        let of = |at: usize| best.residual[at] * (-problem.log_factor(at, &factors)).exp();
        let misfits: Vec<f64> = (0..problem.data.len()).map(of).collect();
        for (at, misfit) in misfits.iter().enumerate() {
            if let Some(place) = problem.factor_of(at) {
                precision[(count + place, count + place)] +=
                    2.0 * (FACTOR_DEVIATION * misfit).powi(2);
            }
        }
        Some(Mode {
            log_posterior: -best.cost,
            y: best.y,
            theta: best.theta,
            observed: best.observed,
            information,
            misfits,
            precision,
        })
    }
}

impl State {
    fn new(problem: &Problem, y: Vec<f64>, theta: Vec<f64>, observed: Observed) -> Option<Self> {
        let jacobian = problem.jacobian(&theta, &y, &observed)?;
        let residual = problem.residual(&observed.values);
        let cost = -problem.log_posterior(&y, &observed);
        Some(Self { y, theta, observed, jacobian, residual, cost })
    }

    fn information(&self, problem: &Problem) -> (DMatrix<f64>, Noise) {
        let noise = problem.noise(&self.y);
        (self.jacobian.tr_mul(&noise.factor.solve(&self.jacobian)), noise)
    }

    /// Replaces the factors of noise by their posterior mode, without shared bias.
    fn with_factors(mut self, problem: &Problem) -> Self {
        let first = problem.unknowns.len();
        for place in 0..problem.inferred() {
            let of_kind =
                (0..problem.data.len()).filter(|&at| problem.factor_of(at) == Some(place));
            let [count, squares] =
                of_kind.fold([0.0, 0.0], |[n, s], at| [n + 1.0, s + self.residual[at].powi(2)]);
            self.y[first + place] = likeliest_factor(count, squares);
        }
        self.cost = -problem.log_posterior(&self.y, &self.observed);
        self
    }
}

/// Minimiser of n f y + S exp(−2 f y)/2 + y²/2, for the standard deviation f of a factor's logarithm.
fn likeliest_factor(count: f64, squares: f64) -> f64 {
    let f = FACTOR_DEVIATION;
    let mut y: f64 = 0.0;
    for _ in 0..FACTOR_STEPS {
        let decay = squares * (-2.0 * f * y).exp();
        let step = (count * f - f * decay + y) / (2.0 * f * f * decay + 1.0);
        y -= step.clamp(-1.0, 1.0);
    }
    y
}

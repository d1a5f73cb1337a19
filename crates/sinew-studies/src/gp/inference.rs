//! Inference with a Gaussian process: data, prior, fit, and what came of it.

use crate::gp::draw;
use crate::gp::experiment::{Case, Purpose, Scale, Task};
use crate::gp::problems::Setting;
use crate::gp::row::{Method, RestartEnd, Run};
use crate::program::standard_normal;
use anyhow::Result;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_gp::{
    Data, Evidence, Fit, FitOptions, GpError, Model, Noise, Prior, squared_exponential,
};
use std::time::Instant;

/// Observations of u and of the right-hand side.
pub(crate) struct Observed<const D: usize> {
    /// Places where u is observed.
    pub places: Vec<[f64; D]>,
    pub values: Vec<f64>,
    /// Collocation points.
    pub collocation: Vec<[f64; D]>,
    /// Right-hand side of the equation at these points.
    pub load: Vec<f64>,
    /// Noise model of values and of loads.
    pub noise: [Noise; 2],
}

impl<const D: usize> Observed<D> {
    /// An equation that holds exactly at some points, and nothing else.
    pub(crate) fn collocated(collocation: Vec<[f64; D]>, load: Vec<f64>) -> Self {
        let noise = [Noise::Exact, Noise::Exact];
        Self { places: Vec::new(), values: Vec::new(), collocation, load, noise }
    }

    /// Form that the library takes.
    pub(crate) fn data(&self) -> Data<D> {
        let data = match self.places.is_empty() {
            true => Data::new(),
            false => Data::new().values(&self.places, &self.values, self.noise[0]),
        };
        data.equation(&self.collocation, &self.load, self.noise[1])
    }
}

/// Sampling of an inverse problem's data: numbers of values and points, and their errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampling {
    /// Observations of u at random places.
    pub values: usize,
    /// Collocation points at random places.
    pub collocation: usize,
    /// Errors of observations.
    pub error: Error,
}

/// Standard deviation of observation errors.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Error {
    /// A share of the standard deviation of u over the domain, on u only; its level is inferred.
    Relative(f64),
    /// Equal for u and f, and known.
    Known(f64),
}

/// The thesis' 2.5 %.
pub(crate) const NOISE: Error = Error::Relative(0.025);

impl<const D: usize> Setting<D> {
    /// Points per axis of the grids that errors are over.
    fn resolution(scale: Scale) -> usize {
        scale.pick([200, 40, 14], [50, 15, 7])[D.clamp(1, 3) - 1]
    }

    /// The grid that errors are over.
    pub(crate) fn grid(&self, scale: Scale) -> Vec<[f64; D]> {
        self.problem.domain().grid(Self::resolution(scale))
    }

    /// Mean |u − û| (4.50).
    pub(crate) fn error(&self, grid: &[[f64; D]], mean: &[f64]) -> f64 {
        let sum: f64 = mean.iter().zip(grid).map(|(m, x)| (m - (self.solution)(*x)).abs()).sum();
        sum / grid.len() as f64
    }

    /// Standard deviation of u over the domain.
    fn deviation(&self) -> f64 {
        let grid = self.problem.domain().grid(Self::resolution(Scale { quick: false }));
        let values: Vec<f64> = grid.into_iter().map(|x| (self.solution)(x)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    }

    /// Noisy observations at random places.
    pub(crate) fn observe(&self, sampling: Sampling, task: &Task) -> Result<Observed<D>, GpError> {
        let domain = self.problem.domain();
        let places = domain.sample(sampling.values, task.seed_for(Purpose::Places))?;
        let collocation =
            domain.sample(sampling.collocation, task.seed_for(Purpose::Collocation))?;
        let mut random = ChaCha8Rng::seed_from_u64(task.seed_for(Purpose::Noise));
        let (of_u, of_f, noise) = match sampling.error {
            Error::Relative(share) => {
                (share * self.deviation(), 0.0, [Noise::Learned, Noise::Exact])
            }
            Error::Known(sigma) => (sigma, sigma, [Noise::Known(sigma), Noise::Known(sigma)]),
        };
        let mut noisy = |exact: f64, sigma: f64| exact + sigma * standard_normal(&mut random);
        let values = places.iter().map(|x| noisy((self.solution)(*x), of_u)).collect();
        let load = collocation.iter().map(|x| noisy((self.load)(*x), of_f)).collect();
        Ok(Observed { places, values, collocation, load, noise })
    }
}

/// Treatment of the boundary conditions by a prior.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Approach {
    /// HCGP
    Constrained,
    /// PCGP with this many pseudo-observations
    Penalised(usize),
    /// UCGP
    Unconstrained,
}

impl Approach {
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Constrained => Method::Hcgp,
            Self::Penalised(_) => Method::Pcgp,
            Self::Unconstrained => Method::Ucgp,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drawings {
    None,
    Posterior,
    /// Moves of each restart.
    PosteriorAndTraces,
}

/// Function that makes a case's observations.
type Observe<const D: usize> =
    Box<dyn Fn(&Setting<D>, &Task) -> Result<Observed<D>, GpError> + Send + Sync>;

/// One approach to one problem.
pub(crate) struct Inference<const D: usize> {
    pub setting: Setting<D>,
    pub approach: Approach,
    pub observe: Observe<D>,
    /// Random starts of a fit.
    pub restarts: usize,
    /// Result for the first data set.
    pub drawings: Drawings,
    pub evidence: Evidence,
    pub scale: Scale,
}

impl<const D: usize> Inference<D> {
    /// Inference with data at random places.
    pub(crate) fn sampled(
        setting: &Setting<D>,
        approach: Approach,
        sampling: Sampling,
        scale: Scale,
    ) -> Self {
        Self::new(setting, approach, scale, move |setting, task| setting.observe(sampling, task))
    }

    /// Inference with data of any kind.
    pub(crate) fn new(
        setting: &Setting<D>,
        approach: Approach,
        scale: Scale,
        observe: impl Fn(&Setting<D>, &Task) -> Result<Observed<D>, GpError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            setting: setting.clone(),
            approach,
            observe: Box::new(observe),
            restarts: scale.pick(4, 1),
            drawings: Drawings::Posterior,
            evidence: Evidence::Auto,
            scale,
        }
    }

    /// Inference from ten starts, with a drawing of how each moves (Fig. 4.9).
    pub(crate) fn traced(self) -> Self {
        Self { restarts: self.scale.pick(10, 2), drawings: Drawings::PosteriorAndTraces, ..self }
    }

    pub(crate) fn undrawn(self) -> Self {
        Self { drawings: Drawings::None, ..self }
    }

    pub(crate) fn case(self) -> Case {
        let setting = self.setting.clone();
        Case::new(setting.named(), self.approach.method(), move |task| self.run(task))
    }

    fn prior(&self, task: &Task) -> Result<Prior<D>, GpError> {
        let (problem, kernel) = (&self.setting.problem, squared_exponential());
        match self.approach {
            Approach::Constrained => Prior::constrained(problem, &kernel),
            Approach::Penalised(points) => {
                Prior::penalised(problem, &kernel, points, task.seed_for(Purpose::Boundary))
            }
            Approach::Unconstrained => Prior::unconstrained(problem, &kernel),
        }
    }

    /// Makes data, fits, and measures.
    pub(crate) fn run(&self, task: &Task) -> Result<Run> {
        let observed = (self.observe)(&self.setting, task)?;
        let start = Instant::now();
        let fit =
            Model::new(self.prior(task)?, observed.data(), self.evidence)?.fit(&FitOptions {
                restarts: self.restarts,
                iterations: self.scale.pick(FitOptions::default().iterations, 40),
                seed: task.seed_for(Purpose::Starts),
                // Rows are named by their number of points.
                most_points: 0,
                ..FitOptions::default()
            })?;
        let seconds = start.elapsed().as_secs_f64();
        let (conditional, grid) = (fit.conditional()?, self.setting.grid(self.scale));
        let mut figures = Vec::new();
        if task.draw && self.drawings != Drawings::None {
            figures.push(draw::posterior(self, &conditional, &observed, &fit)?);
        }
        if task.draw && self.drawings == Drawings::PosteriorAndTraces {
            figures.push(draw::traces(self, &fit));
        }
        let restarts = self.ends(&fit)?;
        Ok(Run {
            err_u: self.setting.error(&grid, &conditional.mean(&grid)?),
            seconds,
            theta: self.theta(&fit, &fit.outcome().parameters)?,
            evaluations: Some(restarts.iter().map(|end| end.evaluations).sum()),
            jitter: Some(fit.outcome().jitter),
            collapsed: fit.outcome().collapsed,
            restarts,
            figures,
            ..Run::default()
        })
    }

    /// The equation's parameters in a vector of all, in their own units.
    fn theta(&self, fit: &Fit<D>, scaled: &[f64]) -> Result<Vec<f64>, GpError> {
        let model = fit.model();
        let value = |name: &str| {
            let position = model.position(name)?;
            Ok(model.parameters()[position].from_scale(scaled[position]))
        };
        self.setting.truth.iter().map(|truth| value(&truth.name)).collect()
    }

    fn ends(&self, fit: &Fit<D>) -> Result<Vec<RestartEnd>, GpError> {
        fit.restarts
            .iter()
            .filter_map(|restart| restart.outcome.as_ref().ok())
            .map(|outcome| {
                Ok(RestartEnd {
                    evaluations: outcome.evaluations,
                    log_evidence: outcome.log_evidence,
                    theta: self.theta(fit, &outcome.parameters)?,
                    collapsed: outcome.collapsed,
                })
            })
            .collect()
    }
}

/// All three approaches on the same data, the PCGP with `boundary` pseudo-observations.
pub(crate) fn approaches<const D: usize>(
    setting: &Setting<D>,
    sampling: Sampling,
    boundary: usize,
    scale: Scale,
) -> Vec<Case> {
    let case = |approach| Inference::sampled(setting, approach, sampling, scale).case();
    vec![
        case(Approach::Constrained),
        case(Approach::Penalised(boundary)).at(format!("N_b = {boundary}")),
        case(Approach::Unconstrained),
    ]
}

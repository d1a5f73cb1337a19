//! The variational bound of one problem at given parameters and sites, with its gradient.

use super::expectation::{Expected, Residual, standard_rule};
use super::sites::{Approximation, Normal, Pull, Site};
use super::{SemiLinear, Solution, collocation, is_exact, singular_term};
use crate::data::{Data, Group, Noise, Role};
use crate::error::GpError;
use crate::evidence::{Evaluation, Evidence};
use crate::kernel::Kernel;
use crate::model::{Compiled, Model, Variance};
use crate::posterior::{Posterior, Whitening};
use crate::prior::Prior;
use crate::state::State;
use faer::Mat;
use std::f64::consts::PI;
use std::sync::Arc;

/// Gain of a step of the sites below which they have settled for the parameters at hand.
const SITE_GAIN: f64 = 1e-6;
/// Steps of the sites for given parameters at most, and halvings of each.
const SITE_STEPS: usize = 30;
const HALVINGS: usize = 8;
/// Noise of exact values in units of their spread: a jitter of 1e-10.
const EXACT: f64 = 1e-5;

/// Where the latent values of a collocation point are.
struct Point {
    /// d₀, d₁, …, d_M
    rows: Vec<usize>,
    load: f64,
    /// Group of the equation, which has the noise.
    group: usize,
}

/// A measured value.
struct Observed {
    row: usize,
    value: f64,
    group: usize,
}

/// The bound of one problem with its data.
pub(crate) struct Inference<'a, const D: usize, const M: usize> {
    semilinear: &'a SemiLinear<D, M>,
    pub model: Arc<Model<D>>,
    /// The collocation points.
    at: Vec<[f64; D]>,
    points: Vec<Point>,
    observed: Vec<Observed>,
    /// For groups of exact values, the noise that stands for none.
    exact: Vec<f64>,
    rule: Vec<([f64; M], f64)>,
}

/// The model at certain parameters.
struct Stage<'a, const D: usize> {
    state: State<'a, D>,
    prior: Normal,
}

/// The bound at certain parameters and sites.
struct Bound {
    value: f64,
    approximation: Approximation,
    /// At each collocation point.
    expected: Vec<Expected>,
}

impl<'a, const D: usize, const M: usize> Inference<'a, D, M> {
    pub fn new(
        semilinear: &'a SemiLinear<D, M>,
        start: &Solution<D>,
        kernel: &dyn Kernel<D>,
        data: &Data<D>,
    ) -> Result<Self, GpError> {
        let at = collocation(data, semilinear.problem.domain())?;
        if is_exact(data) {
            return Err(GpError::Data(
                "the equation holds exactly in these data, where no normal distribution has a finite variational bound; give its values `Noise::Learned`, or a known noise"
                    .into(),
            ));
        }
        let mean = start.fit.posterior()?;
        let mut groups = data.groups.clone();
        for argument in semilinear.arguments {
            groups.push(Group {
                operator: Some(argument.into()),
                points: at.clone(),
                further: Vec::new(),
                values: mean.mean_of(&argument.into(), &at)?,
                // Latent values are never compared with anything.
                noise: Noise::Known(1.0),
                role: Role::Latent,
            });
        }
        let prior = Prior::constrained(&semilinear.problem, kernel)?;
        let model = Model::new(prior, Data { groups, everywhere: None }, Evidence::Joint)?;
        let offsets = |role: Role| {
            model.groups.iter().enumerate().filter(move |(_, group)| group.role == role)
        };
        let latent: Vec<usize> = offsets(Role::Latent).map(|(_, group)| group.offset).collect();
        let points = offsets(Role::Imposed)
            .flat_map(|(number, group)| group.rows().zip(&group.values).map(move |v| (number, v)))
            .enumerate()
            .map(|(index, (group, (row, load)))| Point {
                rows: std::iter::once(row)
                    .chain(latent.iter().map(|first| first + index))
                    .collect(),
                load: *load,
                group,
            })
            .collect();
        let observed = offsets(Role::Observed)
            .flat_map(|(group, data)| {
                data.rows().zip(&data.values).map(move |(row, value)| Observed {
                    row,
                    value: *value,
                    group,
                })
            })
            .collect();
        let model = Arc::new(model);
        let (exact, rule) = (Vec::new(), standard_rule());
        let mut inference = Self { semilinear, model, at, points, observed, exact, rule };
        inference.exact = inference.noises_for_none(&inference.start(start))?;
        Ok(inference)
    }

    /// For each group the noise that stands for none, in units of the values' spread; where all are
    /// zero, in units of what the prior takes them for.
    fn noises_for_none(&self, parameters: &[f64]) -> Result<Vec<f64>, GpError> {
        let state = State::new(&self.model, parameters)?;
        let covariance = state.covariance();
        let diagonal = |row: usize| covariance[row * (self.model.size() + 1)];
        let believed = |group: &Compiled<D>| {
            let variance = group.rows().map(diagonal).fold(0.0, f64::max);
            if variance > 0.0 { variance.sqrt() } else { 1.0 }
        };
        let size = |group: &Compiled<D>| size(&group.values).unwrap_or_else(|| believed(group));
        Ok(self.model.groups.iter().map(|group| EXACT * size(group)).collect())
    }

    /// Parameters of the solution by name; others in the middle of where fits start.
    pub fn start(&self, solution: &Solution<D>) -> Vec<f64> {
        let known = |name: &str| {
            let position = solution.fit.model().position(name).ok()?;
            Some(solution.fit.outcome().parameters[position])
        };
        let middle = |ends: [f64; 2]| 0.5 * (ends[0] + ends[1]);
        self.model
            .parameters()
            .iter()
            .map(|p| known(&p.name).unwrap_or_else(|| middle(p.start.map(|end| p.to_scale(end)))))
            .collect()
    }

    fn stage(&self, parameters: &[f64]) -> Result<Stage<'_, D>, GpError> {
        let state = State::new(&self.model, parameters)?;
        let size = self.model.size();
        let lower = state.covariance();
        let entry = |row: usize, column: usize| lower[row.min(column) * size + row.max(column)];
        let covariance = Mat::from_fn(size, size, entry);
        let values = self.model.groups.iter().flat_map(|group| &group.values);
        let mean = values.zip(state.residual()).map(|(y, r)| y - r).collect();
        Ok(Stage { state, prior: Normal { mean, covariance } })
    }

    fn sigma(&self, stage: &Stage<'_, D>, group: usize) -> f64 {
        match stage.state.noise[group] {
            0.0 => self.exact[group],
            sigma => sigma,
        }
    }

    /// The sites of linearisation about the start.
    pub fn first_sites(
        &self,
        start: &Solution<D>,
        parameters: &[f64],
    ) -> Result<Vec<Site>, GpError> {
        let stage = self.stage(parameters)?;
        let equation = self.semilinear.problem.equation();
        let linear = start.fit.posterior()?.mean_of(equation, &self.at)?;
        // Latent groups hold the arguments at the start.
        let values: Vec<f64> =
            self.model.groups.iter().flat_map(|group| group.values.iter().copied()).collect();
        let still = Mat::zeros(M + 1, M + 1);
        let sites = self.points.iter().zip(linear).enumerate().map(|(index, (point, linear))| {
            let arguments = point.rows[1..].iter().map(|row| values[*row]);
            let own: Vec<f64> = std::iter::once(linear).chain(arguments).collect();
            let expected = self.expected(point, &own, &still);
            expected
                .and_then(|e| site(point, &e, &own, self.sigma(&stage, point.group)))
                .ok_or_else(|| singular_term(index, &own[1..]))
        });
        sites.collect()
    }

    fn expected(&self, point: &Point, mean: &[f64], covariance: &Mat<f64>) -> Option<Expected> {
        Residual { term: &*self.semilinear.term, load: point.load }
            .expected(&self.rule, mean, covariance)
    }

    /// All sites: those of the points, with the noise of the stage, and those of measured values.
    fn all_sites(&self, stage: &Stage<'_, D>, sites: &[Site]) -> Vec<Site> {
        let points = sites
            .iter()
            .zip(&self.points)
            .map(|(site, point)| site.with_noise(self.sigma(stage, point.group)));
        let observed = self
            .observed
            .iter()
            .map(|o| Site::observed(o.row, o.value, self.sigma(stage, o.group)));
        points.chain(observed).collect()
    }

    fn bound(&self, stage: &Stage<'_, D>, all: &[Site]) -> Option<Bound> {
        let approximation = Approximation::new(&stage.prior, all)?;
        let mut value = -approximation.divergence;
        let mut add = |sigma: f64, square: f64| {
            value -= 0.5 * (square / (sigma * sigma) + (2.0 * PI * sigma * sigma).ln());
        };
        let mut expected = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let own: Vec<f64> = point.rows.iter().map(|row| approximation.mean[*row]).collect();
            let covariance = approximation.covariance(&stage.prior, &point.rows);
            let found = self.expected(point, &own, &covariance)?;
            add(self.sigma(stage, point.group), found.square);
            expected.push(found);
        }
        for o in &self.observed {
            add(self.sigma(stage, o.group), self.misfit(stage, &approximation, o));
        }
        value.is_finite().then_some(Bound { value, approximation, expected })
    }

    /// E (y − d)² of a measured value.
    fn misfit(&self, stage: &Stage<'_, D>, q: &Approximation, o: &Observed) -> f64 {
        (o.value - q.mean[o.row]).powi(2) + q.variance(&stage.prior, o.row)
    }

    /// Sites for the parameters at hand, by damped steps of the natural gradient.
    pub fn settle(&self, parameters: &[f64], mut sites: Vec<Site>) -> Result<Vec<Site>, GpError> {
        let stage = self.stage(parameters)?;
        let evaluate = |sites: &[Site]| self.bound(&stage, &self.all_sites(&stage, sites));
        let mut best = evaluate(&sites).ok_or_else(|| self.failure(parameters, &sites))?;
        for _ in 0..SITE_STEPS {
            let Some(proposed) = self.proposed(&stage, &best) else { break };
            let step = (0..HALVINGS).find_map(|halving| {
                let share = 0.5_f64.powi(halving as i32);
                let blended = sites.iter().zip(&proposed).map(|(a, b)| a.towards(b, share));
                let blended = blended.collect::<Option<Vec<Site>>>()?;
                let bound = evaluate(&blended)?;
                (bound.value > best.value).then_some((blended, bound))
            });
            let Some((blended, bound)) = step else { break };
            let gain = bound.value - best.value;
            (sites, best) = (blended, bound);
            if gain < SITE_GAIN {
                break;
            }
        }
        Ok(sites)
    }

    /// The sites that would be right if q were: Λ = −E ∇²ℓ and λ = E ∇ℓ + Λ a.
    fn proposed(&self, stage: &Stage<'_, D>, bound: &Bound) -> Option<Vec<Site>> {
        let sites = self.points.iter().zip(&bound.expected).map(|(point, expected)| {
            let mean: Vec<f64> =
                point.rows.iter().map(|row| bound.approximation.mean[*row]).collect();
            site(point, expected, &mean, self.sigma(stage, point.group))
        });
        sites.collect()
    }

    /// Bound plus hyperpriors at fixed sites, with its gradient.
    pub fn evaluate(&self, parameters: &[f64], sites: &[Site]) -> Option<Evaluation> {
        let stage = self.stage(parameters).ok()?;
        let all = self.all_sites(&stage, sites);
        let bound = self.bound(&stage, &all)?;
        let q = &bound.approximation;
        let pulls: Vec<Option<Pull>> = (self.points.iter().zip(&bound.expected).zip(&all))
            .map(|((point, expected), site)| Some(pull(point, expected, site, q)))
            .chain(self.observed.iter().map(|_| None))
            .collect();
        let slopes = q.pull_back(&stage.prior, &all, &pulls);
        let size = self.model.size();
        let mut cotangent = vec![0.0; size * size];
        for column in 0..size {
            cotangent[column * (size + 1)] = slopes.covariance[(column, column)];
            for row in column + 1..size {
                cotangent[column * size + row] =
                    slopes.covariance[(row, column)] + slopes.covariance[(column, row)];
            }
        }
        // The residual falls as the mean rises.
        let of_residual: Vec<f64> = slopes.mean.iter().map(|m| -m).collect();
        let mut gradient = stage.state.propagated(&cotangent, &of_residual);
        let squares = bound.expected.iter().map(|e| e.square);
        let squares = squares.chain(self.observed.iter().map(|o| self.misfit(&stage, q, o)));
        let groups = self.points.iter().map(|p| p.group);
        let groups = groups.chain(self.observed.iter().map(|o| o.group));
        for ((square, group), (site, slope)) in
            squares.zip(groups).zip(all.iter().zip(&slopes.sigma))
        {
            if let Variance::Learned(position) = self.model.groups[group].variance {
                gradient[position] += square / site.sigma.powi(2) - 1.0 + slope;
            }
        }
        let mut value = bound.value;
        for ((slope, parameter), x) in
            gradient.iter_mut().zip(self.model.parameters()).zip(parameters)
        {
            let (density, own) = parameter.hyperprior.log_density(*x);
            value += density;
            *slope += own;
        }
        Some(Evaluation { value, gradient, jitter: 0.0 })
    }

    /// Why there is no bound: the first point where the term has no value, or the covariance.
    pub fn failure(&self, parameters: &[f64], sites: &[Site]) -> GpError {
        let none = GpError::NotPositiveDefinite { size: self.model.size(), jitter: 0.0 };
        let Ok(stage) = self.stage(parameters) else { return none };
        let all = self.all_sites(&stage, sites);
        let Some(q) = Approximation::new(&stage.prior, &all) else { return none };
        let failing = self.points.iter().enumerate().find_map(|(index, point)| {
            let own: Vec<f64> = point.rows.iter().map(|row| q.mean[*row]).collect();
            let covariance = q.covariance(&stage.prior, &point.rows);
            let found = self.expected(point, &own, &covariance);
            found.is_none().then(|| singular_term(index, &own[1..]))
        });
        failing.unwrap_or(none)
    }

    /// The bound, and what q says of u.
    pub fn posterior(
        &self,
        parameters: &[f64],
        sites: &[Site],
    ) -> Result<(f64, Posterior<D>), GpError> {
        let stage = self.stage(parameters)?;
        let bound = self
            .bound(&stage, &self.all_sites(&stage, sites))
            .ok_or_else(|| self.failure(parameters, sites))?;
        let Approximation { weights, whitening, .. } = bound.approximation;
        let (model, parameters) = (self.model.clone(), parameters.to_vec());
        let whitening = Whitening::Matrix(whitening);
        Ok((bound.value, Posterior { model, parameters, weights, whitening, jitter: 0.0 }))
    }
}

/// The factor of a point that means of the squared residual ask for.
fn site(point: &Point, expected: &Expected, mean: &[f64], sigma: f64) -> Option<Site> {
    let pull = |precision: &Mat<f64>| {
        (0..mean.len())
            .map(|i| {
                let held: f64 = (0..mean.len()).map(|j| precision[(i, j)] * mean[j]).sum();
                held - expected.slope[i]
            })
            .collect()
    };
    Site::new(&point.rows, &expected.curvature, pull, sigma)
}

/// Derivatives of the bound in q's mean and covariance at a point; none are left once sites are settled.
fn pull(point: &Point, expected: &Expected, site: &Site, q: &Approximation) -> Pull {
    let scale = site.sigma.powi(-2);
    let precision = site.precision();
    let mean = point
        .rows
        .iter()
        .zip(&expected.slope)
        .map(|(row, slope)| -scale * slope - q.weights[*row])
        .collect();
    let covariance = Mat::from_fn(point.rows.len(), point.rows.len(), |i, j| {
        0.5 * scale * (precision[(i, j)] - expected.curvature[(i, j)])
    });
    Pull { mean, covariance }
}

/// Standard deviation of the values, or their size where that is zero; `None` where all are zero.
fn size(values: &[f64]) -> Option<f64> {
    let most = values.iter().fold(f64::NEG_INFINITY, |most, v| most.max(*v));
    let least = values.iter().fold(f64::INFINITY, |least, v| least.min(*v));
    [most - least, most.abs()].into_iter().find(|size| *size > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Condition, Derivative, Domain, FitOptions, Parameter, Problem, Side, SquaredExponential,
        constant,
    };

    #[test]
    fn the_gradient_is_that_of_the_bound_for_any_sites() {
        let domain = Domain::interval("x", [0.0, 1.0]).unwrap();
        let [dx] = domain.derivatives();
        let stiffness = Parameter::new("stiffness", [0.05, 5.0]).unwrap();
        let held = || Condition::Dirichlet(constant(0.0));
        let problem = Problem::new(domain, -(&stiffness * dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held()))
            .unwrap();
        let arguments = [Derivative::identity(), dx];
        let term = SemiLinear::new(problem, arguments, |[u, slope]| u.powi(3) + u * slope * 0.5);
        let at: Vec<[f64; 1]> = (1..6).map(|k| [f64::from(k) / 6.0]).collect();
        let load: Vec<f64> = at.iter().map(|[x]| 3.0 * (4.0 * x).sin()).collect();
        let data = Data::new().equation(&at, &load, Noise::Learned).values(
            &at[1..4],
            &[0.3, 0.2, 0.25],
            Noise::Learned,
        );
        let kernel = SquaredExponential::new();
        let options = FitOptions { restarts: 1, ..FitOptions::default() };
        let start = term.solve(&kernel, &data, &options, 3).unwrap();
        let inference = Inference::new(&term, &start, &kernel, &data).unwrap();
        // Amplitude, lengthscale, stiffness, two noises: none of it settled.
        let parameters = [-0.5, -0.9, -0.2, -2.0, -1.5];
        let sites = inference.first_sites(&start, &parameters).unwrap();
        let found = inference.evaluate(&parameters, &sites).unwrap();
        for (number, slope) in found.gradient.iter().enumerate() {
            const STEP: f64 = 1e-5;
            let at = |step: f64| {
                let mut moved = parameters;
                moved[number] += step;
                inference.evaluate(&moved, &sites).unwrap().value
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            let name = &inference.model.parameters()[number].name;
            assert!(
                (slope - difference).abs() < 1e-6 * slope.abs().max(1.0),
                "{name}: {slope} {difference}"
            );
        }
    }
}

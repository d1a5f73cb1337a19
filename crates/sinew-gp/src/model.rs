//! A prior with data: parameters, and everything that does not change with them.

mod averages;
pub(crate) mod compile;
pub(crate) mod data;
pub(crate) mod parameter;

use crate::evidence::gram::PairPlan;
use crate::model::compile::{Compiled, compile};
use crate::model::data::{Group, NO_DATA, Role, check, largest, noise_name};
use crate::prior::Part;
use crate::prior::coefficients::monomials;
use crate::{
    Data, Evaluation, Evidence, Field, FreeParameter, GpError, Hyperparameter, Hyperprior, Measure,
    Noise, Parameter, Prior, Result,
};
use sinew_sample::quantile;
use std::sync::Arc;

/// Derivatives that each part takes for each pair of legs.
type Plans<const D: usize> = Arc<Vec<Vec<PairPlan<D>>>>;

/// A prior and observations, ready to be fitted.
#[derive(Clone, Debug)]
pub struct Model<const D: usize> {
    pub(crate) prior: Prior<D>,
    pub(crate) parameters: Vec<FreeParameter>,
    /// First parameter (the amplitude) of each part; kernel parameters follow.
    pub(crate) part_offsets: Vec<usize>,
    /// Parameters of the operators, in the order of their numbers in monomials.
    pub(crate) theta: Vec<Parameter>,
    pub(crate) theta_offset: usize,
    /// Imposed groups first.
    pub(crate) groups: Vec<Compiled<D>>,
    /// Observations that are imposed rather than measured: the first ones.
    pub(crate) imposed: usize,
    pub(crate) size: usize,
    pub(crate) evidence: Evidence,
    /// Right-hand side of an equation that holds everywhere.
    pub(crate) source: Option<Field<D>>,
    /// Right-hand side that is the same at all points of the equation, and the box that these fill.
    pub(crate) even: Option<(f64, [[f64; 2]; D])>,
    /// All data, for models with more points.
    pub(crate) given: Vec<Group<D>>,
    /// Plans of each part between legs at `[first · legs + second]`.
    pub(crate) plans: Plans<D>,
}

impl<const D: usize> Model<D> {
    /// Puts a prior and data together.
    ///
    /// Noise-free observations at points where the prior leaves no freedom (of u on a Dirichlet
    /// boundary) carry no information and are left out.
    ///
    /// # Errors
    /// If there are no data, or some are not finite, lie outside the domain, contradict the boundary conditions, lie where
    /// a feature has no derivative; if an equation's parameter has the name of another one; if an operator's order is too high.
    pub fn new(prior: Prior<D>, data: Data<D>, evidence: Evidence) -> Result<Self> {
        instance!(D, Model::put_together, fn(Prior<D>, Data<D>, Evidence) -> Result<Model<D>>)(
            prior, data, evidence,
        )
    }

    fn put_together(prior: Prior<D>, data: Data<D>, evidence: Evidence) -> Result<Self> {
        if let Some(source) = &data.everywhere {
            let at = prior.domain.sample(FIRST_POINTS * D, POINTS_SEED)?;
            let model = Self::new(prior, data.placed(source, &at), evidence)?;
            return Ok(Self { source: data.everywhere, ..model });
        }
        let given = data.groups;
        let groups = [&given[..], &prior.boundary].concat();
        check(&groups, &prior.domain)?;
        // A stable sort keeps the order given within each role.
        let mut order: Vec<usize> = (0..groups.len()).collect();
        order.sort_by_key(|number| groups[*number].role);
        let mut theta = Vec::new();
        monomials(&prior.equation, &mut theta)?;
        let mut compiled = Vec::new();
        for number in order {
            let whose = format!("observation group {}", number + 1);
            let own = compile(&prior, &groups[number], (number, &whose), &mut theta)?;
            append(&mut compiled, own);
        }
        let end = |role: Role| {
            let last = compiled.iter().rfind(|group| group.given.role <= role);
            last.map_or(0, |group| group.rows().end)
        };
        let [imposed, size] = [Role::Imposed, Role::Observed].map(end);
        ensure!(size > 0, "{NO_DATA}");
        let evidence = evidence.resolve(&compiled, theta.len());
        let mut model = Self {
            source: None,
            even: None,
            given,
            plans: plans(&prior, &compiled, 0),
            prior,
            parameters: Vec::new(),
            part_offsets: Vec::new(),
            theta,
            theta_offset: 0,
            groups: compiled,
            imposed,
            size,
            evidence,
        };
        model.lay_out_parameters();
        model.check_parameters()?;
        Ok(Self { even: model.even_source(), ..model })
    }

    /// The model with one more group of values, which come after its data and are none of them.
    pub(crate) fn with_group(&self, group: Compiled<D>) -> Self {
        let mut groups = self.groups.clone();
        let from = append(&mut groups, group);
        // Predictions ask for its covariances alone.
        Self { plans: plans(&self.prior, &groups, from), groups, ..self.clone() }
    }

    /// The parameters, in the order of the vectors that describe them.
    pub fn parameters(&self) -> &[FreeParameter] {
        &self.parameters
    }

    /// The density that fits maximise and ensembles draw from, with `Auto` resolved.
    pub fn evidence(&self) -> Evidence {
        self.evidence
    }

    /// Logarithm of the prior density of all parameters, up to a constant.
    pub(crate) fn log_hyperprior(&self, scaled: &[f64]) -> f64 {
        self.parameters.iter().zip(scaled).map(|(p, x)| p.hyperprior.log_density(*x).0).sum()
    }

    /// Logarithm of evidence times prior density; −∞ where the evidence has no value.
    pub(crate) fn log_posterior(&self, scaled: &[f64]) -> f64 {
        let value = self.log_evidence(scaled).map(|value| value + self.log_hyperprior(scaled));
        value.ok().filter(|value| value.is_finite()).unwrap_or(f64::NEG_INFINITY)
    }

    /// [`Model::log_posterior`] with its gradient: what fits maximise, and what NUTS and Laplace explore.
    pub(crate) fn evaluate_posterior(&self, scaled: &[f64]) -> Result<Evaluation> {
        let mut evaluation = self.evaluate(scaled)?;
        let priors = self.parameters.iter().map(|p| p.hyperprior).zip(scaled);
        for (slope, (hyperprior, x)) in evaluation.gradient.iter_mut().zip(priors) {
            let (density, own) = hyperprior.log_density(*x);
            evaluation.value += density;
            *slope += own;
        }
        Ok(evaluation)
    }

    /// Position of a parameter by name.
    ///
    /// # Errors
    /// If no parameter has that name.
    pub fn position(&self, name: &str) -> Result<usize> {
        self.parameters.iter().position(|p| p.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.parameters.iter().map(|p| p.name.as_str()).collect();
            let known = known.join(", ");
            GpError::Invalid(format!("there is no parameter {name}; the model has {known}"))
        })
    }

    /// Number of parameters but for the weights of values, which are last.
    pub(crate) fn without_weights(&self) -> usize {
        self.groups.iter().find_map(|group| group.weighted).unwrap_or(self.parameters.len())
    }

    /// Refuses a parameter vector of wrong length.
    pub(crate) fn check_count(&self, scaled: &[f64]) -> Result<()> {
        let (found, expected) = (scaled.len(), self.parameters.len());
        ensure!(
            found == expected,
            "{found} parameters given, the model has {expected}; give one value for each"
        );
        Ok(())
    }

    /// Requires that no parameter of the equation is called like one of the prior or the noise, and that the variances that
    /// covariances are made of are numbers.
    fn check_parameters(&self) -> Result<()> {
        for by in self.groups.iter().flat_map(Compiled::shrinkages) {
            ensure!(
                (by * by).is_normal(),
                "derivatives over the whole domain shrink functions by {by:e}, whose square is no number of double precision; give coordinates in a unit in which the domain is of order one"
            );
        }
        for (k, FreeParameter { name, bounds, .. }) in self.parameters.iter().enumerate() {
            if self.theta_range().contains(&k) {
                ensure!(
                    self.parameters.iter().filter(|p| p.name == *name).count() == 1,
                    "parameter {name} has the name of an amplitude, lengthscale or noise; call it otherwise"
                );
                continue;
            }
            let [lower, upper] = bounds;
            ensure!(
                // With room for rounding errors of the variances.
                bounds.iter().all(|end| (end * end * f64::EPSILON).is_normal()),
                "by the size of the data {name} is between {lower:e} and {upper:e}, whose squares are not numbers of double precision; give values, conditions and coordinates in a unit in which they are between 1e-140 and 1e140"
            );
        }
        Ok(())
    }

    fn lay_out_parameters(&mut self) {
        let middle: Vec<f64> = self.theta.iter().map(Parameter::middle).collect();
        let scales = self.amplitude_scales(&middle);
        let mut parameters = Vec::new();
        for (number, (part, scale)) in (1..).zip(self.prior.parts.iter().zip(&scales)) {
            self.part_offsets.push(parameters.len());
            let hyperprior = Hyperprior::about(*scale, DEVIATION);
            parameters.push(positive(format!("amplitude {number}"), *scale, AMPLITUDE, hyperprior));
            for hyperparameter in part.kernel.hyperparameters() {
                let free = self.of_kernel(&hyperparameter, number);
                parameters.push(FreeParameter { name: distinct(free.name, &parameters), ..free });
            }
        }
        self.theta_offset = parameters.len();
        for parameter in &self.theta {
            let bounds = parameter.bounds;
            parameters.push(FreeParameter {
                name: parameter.name().to_string(),
                logarithmic: bounds[0] > 0.0,
                bounds,
                start: bounds,
                hyperprior: Hyperprior::Flat,
            });
        }
        let scale = largest(&scales);
        for group in &mut self.groups {
            if let Noise::Learned | Noise::StudentT(_) = group.given.noise {
                group.learned = Some(parameters.len());
                // Of conditions that are all zero, what functions of the data's size would break them by.
                let broken = || scale * largest(&group.operator_sizes(&middle));
                let (values, heavy) = (&group.given.values, group.given.noise != Noise::Learned);
                let bulk = Some(bulk(values)[1]).filter(|deviation| heavy && *deviation > 0.0);
                let scale = bulk.or_else(|| spread(values)).unwrap_or_else(broken);
                let hyperprior = match group.given.role {
                    Role::Observed => Hyperprior::about(NOISE_MEDIAN * scale, NOISE_DEVIATION),
                    Role::Imposed => Hyperprior::Flat,
                };
                let name = noise_name(group.number);
                parameters.push(positive(name, scale, NOISE, hyperprior));
            }
        }
        // Weights last: they are nobody's result.
        for group in &mut self.groups {
            let (Noise::StudentT(freedom), Some(learned)) = (group.given.noise, group.learned)
            else {
                continue;
            };
            group.weighted = Some(parameters.len());
            let hyperprior = Hyperprior::Gamma { shape: 0.5 * freedom };
            let (median, [_, error]) = (bulk(&group.given.values)[0], parameters[learned].start);
            for (value, y) in group.given.values.iter().enumerate() {
                let name = format!("weight {value} of {}", noise_name(group.number));
                // As small as where u tells nothing of the values, so that no start has an outlier in u.
                let least = (freedom + 1.0) / (freedom + ((y - median) / error).powi(2));
                let ends = [WEIGHT, [least.clamp(WEIGHT[0], 1.0), 1.0]];
                parameters.push(positive(name, 1.0, ends, hyperprior));
            }
        }
        self.parameters = parameters;
    }

    /// Hyperparameter of the kernel of the part of this number.
    fn of_kernel(&self, own: &Hyperparameter, number: usize) -> FreeParameter {
        match own.measure {
            Measure::Length { axis } => {
                let (domain, extent) = (&self.prior.domain, self.prior.domain.extents()[axis]);
                let name = format!("{} {} {number}", own.name, domain.names()[axis]);
                positive(name, extent, LENGTH, Hyperprior::about(extent, DEVIATION))
            }
            Measure::Number { lower, upper } | Measure::Width { lower, upper, .. } => {
                let middle = (lower * upper).sqrt();
                let start = [lower, upper].map(|end| (end * middle).sqrt());
                let name = format!("{} {number}", own.name);
                positive(name, 1.0, [[lower, upper], start], Hyperprior::Flat)
            }
        }
    }

    /// Sizes of the parts of u as the data suggest them: what these differ from the prior mean by, over the size of their
    /// operator on functions that vary over the whole domain. Measured values tell the size of u, a load that of each part
    /// by what the equation makes of it: features that vanish at many derivatives are steep, and a load tells little of them.
    fn amplitude_scales(&self, middle: &[f64]) -> Vec<f64> {
        let of = |role: Role| {
            let mut scales = vec![0.0_f64; self.prior.parts.len()];
            for group in self.groups.iter().filter(|group| group.given.role == role) {
                let (size, sizes) = (group.residual_size(middle), group.operator_sizes(middle));
                let most = largest(&sizes);
                for (scale, own) in scales.iter_mut().zip(&sizes) {
                    let own = if role == Role::Observed { most } else { *own };
                    if own > NOTHING * most {
                        *scale = scale.max(size / own);
                    }
                }
            }
            // Where the operators make nothing of a part, it is of the size of the others.
            let most = largest(&scales);
            scales.iter_mut().filter(|scale| **scale == 0.0).for_each(|scale| *scale = most);
            scales
        };
        let told = |scales: &Vec<f64>| scales.iter().any(|scale| *scale > 0.0);
        let roles = [Role::Observed, Role::Imposed];
        let nothing = || vec![1.0; self.prior.parts.len()];
        roles.into_iter().map(of).find(told).unwrap_or_else(nothing)
    }

    /// Positions of the operators' parameters.
    pub(crate) fn theta_range(&self) -> std::ops::Range<usize> {
        self.theta_offset..self.theta_offset + self.theta.len()
    }

    /// Values of the operators' parameters, from a vector of all parameters on their scales.
    pub(crate) fn theta_values(&self, scaled: &[f64]) -> Vec<f64> {
        let own = self.theta_range();
        let each = self.parameters[own.clone()].iter().zip(&scaled[own]);
        each.map(|(parameter, x)| parameter.from_scale(*x)).collect()
    }
}

/// Bounds and starts of amplitudes and lengths in units of the data's size and the axes' extents: wide enough
/// for functions close to polynomials, narrow enough to keep covariances representable.
const AMPLITUDE: [[f64; 2]; 2] = [[1e-2, 1e3], [0.3, 3.0]];
const LENGTH: [[f64; 2]; 2] = [[0.03, 30.0], [0.3, 1.5]];
/// Share of an operator's size on the part that it makes most of, below which it says nothing of another part's size.
const NOTHING: f64 = 1e-3;
/// Hyperprior of logarithms of amplitudes and lengths about the size of data and domain.
const DEVIATION: f64 = 1.0;
/// Bounds and starts in units of the spread of the values: from far below any instrument to nothing but noise.
const NOISE: [[f64; 2]; 2] = [[1e-5, 2.0], [0.01, 0.1]];
/// Hyperprior of measurement errors: 95 % between 0.3 % and all of the spread. A few values tell their errors hardly at
/// all; without a belief these would be taken for next to nothing.
const NOISE_MEDIAN: f64 = 0.05;
const NOISE_DEVIATION: f64 = 1.5;
/// Median of the size of a standard normal variate.
pub(crate) const MEDIAN: f64 = 0.6745;

/// Weights of values: of one a million standard deviations off, to one closer than any.
const WEIGHT: [f64; 2] = [1e-12, 10.0];

/// Points that an equation everywhere begins with, for each dimension, and the seed of their places.
pub(crate) const FIRST_POINTS: usize = 15;
pub(crate) const POINTS_SEED: u64 = 0x5eed;

/// A positive number, with bounds and starts in units of `unit`.
fn positive(name: String, unit: f64, ends: [[f64; 2]; 2], hyperprior: Hyperprior) -> FreeParameter {
    let [bounds, start] = ends.map(|ends| ends.map(|end| end * unit));
    FreeParameter { name, logarithmic: true, bounds, start, hyperprior }
}

/// A name that no other parameter has: in a sum of like kernels hyperparameters are numbered.
fn distinct(name: String, taken: &[FreeParameter]) -> String {
    let is_free = |name: &String| taken.iter().all(|parameter| parameter.name != *name);
    let numbered = (2..).map(|number| format!("{name} ({number})"));
    let mut names = std::iter::once(name.clone()).chain(numbered);
    names.find(is_free).expect("some number is not taken")
}

/// Standard deviation of values, or their size where all are equal; none where all are zero.
pub(crate) fn spread(values: &[f64]) -> Option<f64> {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
    [deviation, mean.abs()].into_iter().find(|s| *s > 0.0)
}

/// Median of values, and the standard deviation of normal ones with the same median distance from it: without those far off.
fn bulk(values: &[f64]) -> [f64; 2] {
    let centre = quantile(values, 0.5);
    let distances: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
    [centre, quantile(&distances, 0.5) / MEDIAN]
}

/// Adds a group whose rows and legs follow those of all others; its first leg.
fn append<const D: usize>(groups: &mut Vec<Compiled<D>>, group: Compiled<D>) -> usize {
    let ends = |last: &Compiled<D>| (last.rows().end, last.first_leg + last.legs.len());
    let (offset, first_leg) = groups.last().map_or((0, 0), ends);
    groups.push(Compiled { offset, first_leg, ..group });
    first_leg
}

/// Plans of the pairs whose first leg is not before `from`; those of the others are empty.
fn plans<const D: usize>(prior: &Prior<D>, groups: &[Compiled<D>], from: usize) -> Plans<D> {
    let legs = || groups.iter().flat_map(|group| &group.legs);
    let of = |(number, part): (usize, &Part<D>)| {
        let orders = || legs().map(|leg| &leg.parts[number].orders[..]);
        let pairs = orders().enumerate().flat_map(|first| orders().map(move |b| (first, b)));
        let plan = |((leg, first), second)| match leg < from {
            true => PairPlan::default(),
            false => PairPlan::new(part, first, second),
        };
        pairs.map(plan).collect()
    };
    Arc::new(prior.parts.iter().enumerate().map(of).collect())
}

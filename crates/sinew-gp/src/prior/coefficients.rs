//! Per point, what an operator makes of a prior's mean and features: O(N) work, done once.
//!
//! By Leibniz' rule L(φ z) = Σ_α c_α ∂^α (φ z) = Σ_β a_β ∂^β z with
//! a_β = Σ_α c_α C(α, β) ∂^{α−β} φ. The parameters θ of the operator enter only through monomials,
//! so that a_β = Σ_t μ_t(θ) A_{t,β} with constant arrays A.

use crate::error::{Result, place};
use crate::model::data::largest;
use crate::problem::domain::grid;
use crate::{Operator, Parameter, Prior, Series, Term};

/// Relative size of a residual that counts as agreement of an exact value with the boundary.
pub(crate) const AGREEMENT: f64 = 1e-8;

/// A product of powers of parameters; empty for 1.
pub(crate) type Monomial = Vec<(usize, i32)>;

/// Π θ^power.
fn monomial_value(monomial: &Monomial, theta: &[f64]) -> f64 {
    monomial.iter().map(|(position, power)| theta[*position].powi(*power)).product()
}

/// ∂/∂θ of a monomial, for the parameter at `position`.
pub(crate) fn monomial_slope(monomial: &Monomial, theta: &[f64], position: usize) -> f64 {
    let factor = |(other, power): &(usize, i32)| match *other == position {
        true => f64::from(*power) * theta[*other].powi(power - 1),
        false => theta[*other].powi(*power),
    };
    monomial.iter().map(factor).product()
}

/// The constant arrays A of one part of the prior.
#[derive(Clone, Debug)]
pub(crate) struct PartCoefficients<const D: usize> {
    /// The derivatives β of the latent function that occur.
    pub orders: Vec<[usize; D]>,
    /// A of each monomial, at `[order · points + point]`.
    pub arrays: Vec<Vec<f64>>,
}

/// An operator on a prior at points.
#[derive(Clone, Debug)]
pub(crate) struct PointCoefficients<const D: usize> {
    pub count: usize,
    /// Coordinates of the points axis by axis, as latent functions take them.
    pub axes: [Vec<f64>; D],
    /// Lengths of the domain's axes, in which derivatives are of size one.
    pub extents: [f64; D],
    pub monomials: Vec<Monomial>,
    /// Share of each monomial in the mean at each point.
    pub mean: Vec<Vec<f64>>,
    pub parts: Vec<PartCoefficients<D>>,
}

/// Position of each parameter by name, added where it is new.
fn register(known: &mut Vec<Parameter>, parameter: &Parameter) -> Result<usize> {
    let name = parameter.name();
    ensure!(
        known.iter().all(|other| other.name() != name || other == parameter),
        "parameter {name} is declared twice with different bounds; clone one `Parameter`"
    );
    Ok(position(known, parameter.clone()))
}

impl<const D: usize> PointCoefficients<D> {
    /// Coefficients of `operator` on `prior` at `points`, in errors those of `whose`; `parameters` are all that
    /// occur in the model.
    pub(crate) fn new(
        prior: &Prior<D>,
        operator: &Operator<D>,
        (points, whose): (&[[f64; D]], &str),
        parameters: &mut Vec<Parameter>,
    ) -> Result<Self> {
        operator.check_orders(&prior.domain)?;
        let (monomials, of_term) = monomials(operator, parameters)?;
        let (of_term, of_source) = of_term.split_at(operator.terms().len());
        let (count, degrees) = (points.len(), operator.orders());
        let mut mean = vec![vec![0.0; count]; monomials.len()];
        let axes = std::array::from_fn(|d| points.iter().map(|x| prior.seen(*x)[d]).collect());
        let arrays = vec![Vec::new(); monomials.len()];
        let mut parts = vec![PartCoefficients { orders: Vec::new(), arrays }; prior.parts.len()];
        for (index, point) in points.iter().enumerate() {
            let finite = |number: f64, what: &str| {
                ensure!(
                    number.is_finite(),
                    "the {what} has no finite value or derivative at point {index} of {whose} {}; move the point off the corner, or make the formula finite there",
                    place(point)
                );
                Ok(number)
            };
            let factor = |term: &Term<D>, what: &str| {
                let function = term.function.as_ref().map_or(1.0, |own| own.value(*point));
                finite(term.scale * function, what)
            };
            // Known functions are there whatever u is, as a mean of the operator.
            for (source, monomial) in operator.sources().iter().zip(of_source) {
                mean[*monomial][index] += factor(source, "known function of the operator")?;
            }
            let x = Series::variables(*point, degrees);
            let value = prior.mean.at(x.clone());
            let features = prior.parts.iter().map(|part| part.feature.factor.at(x.clone()));
            let features: Vec<Series> = features.collect();
            for (term, monomial) in operator.terms().iter().zip(of_term) {
                let alpha = term.derivative.orders;
                let factor = factor(term, "coefficient of the operator")?;
                mean[*monomial][index] += finite(factor * value.derivative(&alpha), "prior mean")?;
                for ((part, series), built) in prior.parts.iter().zip(&features).zip(&mut parts) {
                    for beta in below(alpha, &part.kernel.axes) {
                        let rest: [usize; D] = std::array::from_fn(|d| alpha[d] - beta[d]);
                        let binomial: f64 = (0..D).map(|d| choose(alpha[d], beta[d])).product();
                        for (beta, turned) in prior.turned(beta, point) {
                            let value = factor * binomial * turned * series.derivative(&rest);
                            built.add(*monomial, beta, [index, count], finite(value, "feature")?);
                        }
                    }
                }
            }
        }
        Ok(Self { count, axes, extents: prior.domain.extents(), monomials, mean, parts })
    }

    /// Values of the monomials.
    pub(crate) fn factors(&self, theta: &[f64]) -> Vec<f64> {
        self.monomials.iter().map(|monomial| monomial_value(monomial, theta)).collect()
    }

    /// a_β = amplitude · Σ_t μ_t A_{t,β} of each part, for the amplitudes of `kernels` and the parameters.
    pub(crate) fn combined(&self, kernels: &[(f64, Vec<f64>)], theta: &[f64]) -> Vec<Vec<f64>> {
        let monomials = self.factors(theta);
        let of = |(part, (amplitude, _)): (&PartCoefficients<D>, &(f64, Vec<f64>))| {
            let mut sum = vec![0.0; part.orders.len() * self.count];
            for (monomial, array) in monomials.iter().zip(&part.arrays) {
                let factor = amplitude * monomial;
                sum.iter_mut().zip(array).for_each(|(s, a)| *s += factor * a);
            }
            sum
        };
        self.parts.iter().zip(kernels).map(of).collect()
    }

    /// Subtracts the operator's mean at each point.
    pub(crate) fn subtract_mean(&self, theta: &[f64], values: &mut [f64]) {
        for (factor, mean) in self.factors(theta).iter().zip(&self.mean) {
            values.iter_mut().zip(mean).for_each(|(value, m)| *value -= factor * m);
        }
    }

    /// Positions of the observations on which the prior has any freedom; the others must agree.
    pub(crate) fn informative(&self, values: &[f64], whose: &str) -> Result<Vec<usize>> {
        let mut kept = Vec::new();
        for (index, value) in values.iter().enumerate() {
            let mut arrays = self.parts.iter().flat_map(|part| &part.arrays);
            if arrays.any(|a| a.iter().skip(index).step_by(self.count).any(|a| *a != 0.0)) {
                kept.push(index);
                continue;
            }
            // With unknown parameters in front, nothing can be said of the value.
            let [mean] = &self.mean[..] else { continue };
            let residual = value - mean[index];
            ensure!(
                residual.abs() <= AGREEMENT * largest(values).max(largest(mean)),
                "value {index} of {whose} is noise-free and off by {residual} where the boundary conditions fix it; correct it or give it noise"
            );
        }
        Ok(kept)
    }

    /// Coefficients of a multiple of the operator.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        let arrays = self.parts.iter_mut().flat_map(|part| &mut part.arrays);
        let numbers = arrays.chain(&mut self.mean).flatten();
        numbers.for_each(|number| *number *= factor);
        self
    }
}

/// Binomial coefficient.
fn choose(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>().round()
}

/// The distinct monomials of an operator, and that of each of its terms and sources.
pub(crate) fn monomials<const D: usize>(
    operator: &Operator<D>,
    parameters: &mut Vec<Parameter>,
) -> Result<(Vec<Monomial>, Vec<usize>)> {
    let (mut monomials, mut of_term): (Vec<Monomial>, _) = (Vec::new(), Vec::new());
    for term in operator.terms().iter().chain(operator.sources()) {
        let mut of = |(own, power): &(Parameter, i32)| Ok((register(parameters, own)?, *power));
        let mut monomial: Monomial = term.parameters.iter().map(&mut of).collect::<Result<_>>()?;
        monomial.sort_unstable();
        of_term.push(position(&mut monomials, monomial));
    }
    Ok((monomials, of_term))
}

/// Position of an entry, added at the end where it is new.
pub(crate) fn position<T: PartialEq>(known: &mut Vec<T>, entry: T) -> usize {
    known.iter().position(|other| *other == entry).unwrap_or_else(|| {
        known.push(entry);
        known.len() - 1
    })
}

/// All β ≤ α whose derivatives act on `axes` only: the latent function depends on no others.
fn below<const D: usize>(alpha: [usize; D], axes: &[usize]) -> Vec<[usize; D]> {
    let last = |d: usize| if axes.contains(&d) { alpha[d] } else { 0 };
    grid(&std::array::from_fn(|d| (0..=last(d)).collect()))
}

impl<const D: usize> PartCoefficients<D> {
    /// Adds to the factor of a derivative at a point of `count`, with room for a derivative that occurs for the first time.
    fn add(&mut self, monomial: usize, orders: [usize; D], [at, count]: [usize; 2], value: f64) {
        if value != 0.0 {
            let row = position(&mut self.orders, orders);
            let size = self.orders.len() * count;
            self.arrays.iter_mut().for_each(|array| array.resize(size, 0.0));
            self.arrays[monomial][row * count + at] += value;
        }
    }
}

//! Per point, what an operator makes of a prior's mean and features: O(N) work, done once.
//!
//! By Leibniz' rule L(φ z) = Σ_α c_α ∂^α (φ z) = Σ_β a_β ∂^β z with
//! a_β = Σ_α c_α C(α, β) ∂^{α−β} φ. The parameters θ of the operator enter only through monomials,
//! so that a_β = Σ_t μ_t(θ) A_{t,β} with constant arrays A.

use crate::error::{GpError, place};
use crate::field::Field;
use crate::operator::{Operator, Parameter, Term};
use crate::prior::{Part, Prior};
use crate::problem::check_orders;
use crate::series::Series;
use std::rc::Rc;

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
    /// For each monomial, A at `[order · points + point]`.
    pub arrays: Vec<Vec<f64>>,
    /// Coordinates of the points axis by axis, as the latent function takes them.
    pub axes: [Vec<f64>; D],
}

/// An operator on a prior at points.
#[derive(Clone, Debug)]
pub(crate) struct PointCoefficients<const D: usize> {
    pub count: usize,
    /// Lengths of the domain's axes, in which derivatives are of size one.
    pub extents: [f64; D],
    pub monomials: Vec<Monomial>,
    /// For each monomial, its share of the mean at each point.
    pub mean: Vec<Vec<f64>>,
    pub parts: Vec<PartCoefficients<D>>,
}

/// Position of each parameter by name, added where it is new.
pub(crate) fn register(
    known: &mut Vec<Parameter>,
    parameter: &Parameter,
) -> Result<usize, GpError> {
    match known.iter().position(|other| other.name() == parameter.name()) {
        Some(position) if known[position] == *parameter => Ok(position),
        Some(_) => Err(GpError::Problem(format!(
            "parameter {} is declared twice with different bounds; clone one `Parameter`",
            parameter.name()
        ))),
        None => {
            known.push(parameter.clone());
            Ok(known.len() - 1)
        }
    }
}

impl<const D: usize> PointCoefficients<D> {
    /// Coefficients of `operator` on `prior` at `points`, in errors those of `whose`; `parameters` are all that
    /// occur in the model.
    pub(crate) fn new(
        prior: &Prior<D>,
        operator: &Operator<D>,
        (points, whose): (&[[f64; D]], &str),
        parameters: &mut Vec<Parameter>,
    ) -> Result<Self, GpError> {
        check_orders(&prior.domain, operator)?;
        let mut monomials: Vec<Monomial> = Vec::new();
        let mut of_term = Vec::new();
        for term in operator.terms().iter().chain(operator.sources()) {
            let mut monomial = Vec::new();
            for (parameter, power) in &term.parameters {
                monomial.push((register(parameters, parameter)?, *power));
            }
            monomial.sort_unstable();
            let position = monomials.iter().position(|m| *m == monomial).unwrap_or_else(|| {
                monomials.push(monomial);
                monomials.len() - 1
            });
            of_term.push(position);
        }
        let of_term = &of_term;
        let builder = Builder { operator, points, whose, of_term, monomials: monomials.len() };
        let (mean, parts) = builder.build(prior)?;
        Ok(Self { count: points.len(), extents: prior.domain.extents(), monomials, mean, parts })
    }

    /// Values of the monomials.
    pub(crate) fn factors(&self, theta: &[f64]) -> Vec<f64> {
        self.monomials.iter().map(|monomial| monomial_value(monomial, theta)).collect()
    }

    /// Adds the operator's mean at each point times `sign`, for the monomials' values `factors`.
    pub(crate) fn add_mean(&self, factors: &[f64], sign: f64, sum: &mut [f64]) {
        for (factor, mean) in factors.iter().zip(&self.mean) {
            sum.iter_mut().zip(mean).for_each(|(s, m)| *s += sign * factor * m);
        }
    }

    /// At some of the points.
    pub(crate) fn of_points(&self, points: &[usize]) -> Self {
        let pick = |row: &[f64]| points.iter().map(|k| row[*k]).collect::<Vec<f64>>();
        let picked = |array: &Vec<f64>| array.chunks(self.count.max(1)).flat_map(pick).collect();
        let part = |part: &PartCoefficients<D>| PartCoefficients {
            orders: part.orders.clone(),
            arrays: part.arrays.iter().map(picked).collect(),
            axes: part.axes.each_ref().map(|axis| pick(axis)),
        };
        Self {
            count: points.len(),
            extents: self.extents,
            monomials: self.monomials.clone(),
            mean: self.mean.iter().map(|mean| pick(mean)).collect(),
            parts: self.parts.iter().map(part).collect(),
        }
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

struct Builder<'a, const D: usize> {
    operator: &'a Operator<D>,
    points: &'a [[f64; D]],
    whose: &'a str,
    of_term: &'a [usize],
    monomials: usize,
}

type Built<const D: usize> = (Vec<Vec<f64>>, Vec<PartCoefficients<D>>);

impl<const D: usize> Builder<'_, D> {
    fn singular(&self, what: &str, index: usize) -> GpError {
        let (whose, at) = (self.whose, place(&self.points[index]));
        GpError::Singular(format!(
            "the {what} has no finite value or derivative at point {index} of {whose} {at}; move the point off the corner, or make the formula finite there"
        ))
    }

    fn build(&self, prior: &Prior<D>) -> Result<Built<D>, GpError> {
        let mut mean = vec![vec![0.0; self.points.len()]; self.monomials];
        if !prior.mean.is_zero() {
            for (index, term, coefficient, value) in self.expansions(&prior.mean) {
                let derivative = coefficient? * value.derivative(&term.1.derivative.orders);
                if !derivative.is_finite() {
                    return Err(self.singular("prior mean", index));
                }
                mean[self.of_term[term.0]][index] += derivative;
            }
        }
        // Known functions are there whatever u is, as a mean of the operator.
        let own = self.of_term.iter().skip(self.operator.terms().len());
        for (source, monomial) in self.operator.sources().iter().zip(own) {
            for (index, (sum, point)) in mean[*monomial].iter_mut().zip(self.points).enumerate() {
                let value = source.function.as_ref().map_or(1.0, |function| function.value(*point));
                if !value.is_finite() {
                    return Err(self.singular("known function of the operator", index));
                }
                *sum += source.scale * value;
            }
        }
        let parts = prior.parts.iter().map(|part| self.part(part)).collect::<Result<_, _>>()?;
        Ok((mean, parts))
    }

    /// For each point and term: its coefficient there, and `field` as a series.
    fn expansions(
        &self,
        field: &Field<D>,
    ) -> impl Iterator<Item = (usize, (usize, &Term<D>), Result<f64, GpError>, Rc<Series>)> {
        let degrees = self.operator.orders();
        self.points.iter().enumerate().flat_map(move |(index, point)| {
            let x = Series::variables(*point, degrees);
            let value = Rc::new(field.at(x));
            self.operator.terms().iter().enumerate().map(move |(number, term)| {
                let factor = term.function.as_ref().map_or(1.0, |function| function.value(*point));
                let coefficient = term.scale * factor;
                let coefficient = match coefficient.is_finite() {
                    true => Ok(coefficient),
                    false => Err(self.singular("coefficient of the operator", index)),
                };
                (index, (number, term), coefficient, value.clone())
            })
        })
    }

    fn part(&self, part: &Part<D>) -> Result<PartCoefficients<D>, GpError> {
        let count = self.points.len();
        let mut orders: Vec<[usize; D]> = Vec::new();
        let mut arrays: Vec<Vec<f64>> = vec![Vec::new(); self.monomials];
        for (index, (number, term), coefficient, series) in self.expansions(&part.feature.factor) {
            let coefficient = coefficient?;
            let alpha = term.derivative.orders;
            for beta in below(alpha, &part.feature.axes) {
                let rest: [usize; D] = std::array::from_fn(|d| alpha[d] - beta[d]);
                let binomial: f64 = (0..D).map(|d| choose(alpha[d], beta[d])).product();
                let (beta, turned) = part.turned(beta);
                let value = coefficient * binomial * turned * series.derivative(&rest);
                if !value.is_finite() {
                    return Err(self.singular("feature", index));
                }
                let position = orders.iter().position(|o| *o == beta).unwrap_or_else(|| {
                    orders.push(beta);
                    arrays.iter_mut().for_each(|array| array.resize(orders.len() * count, 0.0));
                    orders.len() - 1
                });
                arrays[self.of_term[number]][position * count + index] += value;
            }
        }
        let at: Vec<[f64; D]> = self.points.iter().map(|point| part.seen(*point)).collect();
        let axes = std::array::from_fn(|d| at.iter().map(|point| point[d]).collect());
        Ok(without_zeros(PartCoefficients { orders, arrays, axes }, count))
    }
}

/// All β ≤ α whose derivatives act on `axes` only: the latent function depends on no others.
fn below<const D: usize>(alpha: [usize; D], axes: &[usize]) -> Vec<[usize; D]> {
    let mut all = vec![[0; D]];
    for d in axes {
        all = all
            .iter()
            .flat_map(|beta| {
                (0..=alpha[*d]).map(move |n| {
                    let mut raised = *beta;
                    raised[*d] = n;
                    raised
                })
            })
            .collect();
    }
    all
}

/// Drops derivatives that nowhere occur.
fn without_zeros<const D: usize>(
    PartCoefficients { orders, arrays, axes }: PartCoefficients<D>,
    count: usize,
) -> PartCoefficients<D> {
    let row = |position: usize| position * count..(position + 1) * count;
    let kept: Vec<usize> = (0..orders.len())
        .filter(|position| {
            arrays.iter().any(|array| array[row(*position)].iter().any(|a| *a != 0.0))
        })
        .collect();
    PartCoefficients {
        orders: kept.iter().map(|position| orders[*position]).collect(),
        arrays: arrays
            .iter()
            .map(|array| kept.iter().flat_map(|position| array[row(*position)].to_vec()).collect())
            .collect(),
        axes,
    }
}

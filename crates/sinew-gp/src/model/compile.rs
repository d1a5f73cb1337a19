//! Observations in numbers: what does not change with the parameters.

use crate::model::data::{Averages, Group, Role, largest, root_mean_square};
use crate::prior::coefficients::{AGREEMENT, PartCoefficients, PointCoefficients};
use crate::{Noise, Parameter, Prior, Result};

/// Observations compiled for one operator.
#[derive(Clone, Debug)]
pub(crate) struct Compiled<const D: usize> {
    /// Position among the groups as they were given.
    pub number: usize,
    /// The observations, but for those of which the prior leaves nothing to tell.
    pub given: Group<D>,
    /// Legs of an observation, which is the sum of the operator's values over these: one set of points, or the
    /// two ends of a jump, the second with the opposite sign.
    pub legs: Vec<PointCoefficients<D>>,
    /// Number of the first among the legs of all groups.
    pub first_leg: usize,
    /// Position of the logarithm of a learned standard deviation, or of the scale of Student's t distribution, among the parameters.
    pub learned: Option<usize>,
    /// Position of the logarithm of the first value's weight in that distribution; the others follow.
    pub weighted: Option<usize>,
    /// Position of the first observation in the covariance matrix.
    pub offset: usize,
}

impl<const D: usize> Compiled<D> {
    /// Rows of the covariance matrix.
    pub(crate) fn rows(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.given.values.len()
    }

    /// Whether imposed values without a known noise are met by the prior mean alone, once the
    /// terms with parameters in front are left out.
    pub(crate) fn is_trivially_satisfied(&self) -> bool {
        let Group { role, values, noise, .. } = &self.given;
        if *role != Role::Imposed || values.is_empty() || matches!(noise, Noise::Known(_)) {
            return false;
        }
        let mut residual = values.clone();
        let mut size = largest(&residual);
        let means = self.legs.iter().flat_map(|leg| leg.monomials.iter().zip(&leg.mean));
        for (monomial, mean) in means {
            size = size.max(largest(mean));
            if monomial.is_empty() {
                residual.iter_mut().zip(mean).for_each(|(r, m)| *r -= m);
            }
        }
        largest(&residual) <= AGREEMENT * size
    }

    /// Divisors of the noise variance of each observation, at parameters on their scales.
    pub(crate) fn weights(&self, scaled: &[f64]) -> Vec<f64> {
        let count = self.given.values.len();
        match (self.weighted, &self.given.averages) {
            (Some(first), _) => scaled[first..first + count].iter().map(|w| w.exp()).collect(),
            (_, Some(averages)) => averages.counts.clone(),
            _ => vec![1.0; count],
        }
    }

    /// Logarithm of the likelihood of what values differ by from their averages, and its derivative in ln σ.
    pub(crate) fn scatter(&self, sigma: f64) -> (f64, f64) {
        let averages = self.given.averages.as_ref();
        let Some(Averages { squares, freedom, .. }) = averages else { return (0.0, 0.0) };
        let ratio = squares / (sigma * sigma);
        (-0.5 * ratio - freedom * sigma.ln(), ratio - freedom)
    }

    /// Root mean square of what values differ from the prior mean by.
    pub(crate) fn residual_size(&self, theta: &[f64]) -> f64 {
        let mut residual = self.given.values.clone();
        self.legs.iter().for_each(|leg| leg.subtract_mean(theta, &mut residual));
        root_mean_square(&residual)
    }

    /// [`shrinkage`] of each derivative.
    pub(crate) fn shrinkages(&self) -> impl Iterator<Item = f64> {
        let each = |leg: &PointCoefficients<D>| {
            let orders = leg.parts.iter().flat_map(|part| &part.orders);
            orders.map(|orders| shrinkage(&leg.extents, orders)).collect::<Vec<_>>()
        };
        self.legs.iter().flat_map(each)
    }

    /// Size of the operator on functions of size one of each part that vary over the whole domain: a derivative is
    /// of the size of one over the extent, whatever the unit of length.
    pub(crate) fn operator_sizes(&self, theta: &[f64]) -> Vec<f64> {
        let count = self.given.values.len().max(1);
        let size = |leg: &PointCoefficients<D>, part: usize| {
            let PartCoefficients { orders, arrays } = &leg.parts[part];
            let mut sum = 0.0;
            for (monomial, array) in leg.factors(theta).into_iter().zip(arrays) {
                for (row, orders) in array.chunks(count).zip(orders) {
                    let factor = monomial * shrinkage(&leg.extents, orders);
                    row.iter().for_each(|a| sum += (factor * a).powi(2));
                }
            }
            (sum / count as f64).sqrt()
        };
        let largest = |part| self.legs.iter().map(|leg| size(leg, part)).fold(0.0, f64::max);
        (0..self.legs[0].parts.len()).map(largest).collect()
    }
}

/// Size of a derivative of functions of size one that vary over the whole domain.
fn shrinkage<const D: usize>(extents: &[f64; D], orders: &[usize; D]) -> f64 {
    extents.iter().zip(orders).map(|(l, n)| l.powi(-(*n as i32))).product()
}

/// Puts a group of observations into numbers; messages call it `whose`.
pub(crate) fn compile<const D: usize>(
    prior: &Prior<D>,
    group: &Group<D>,
    (number, whose): (usize, &str),
    theta: &mut Vec<Parameter>,
) -> Result<Compiled<D>> {
    let operator = group.operator.as_ref().unwrap_or(&prior.equation);
    prior.parts.iter().try_for_each(|part| part.kernel.check_smoothness(operator))?;
    let mut coefficients = |(factor, points): &(f64, Vec<[f64; D]>)| {
        let plain = PointCoefficients::new(prior, operator, (points, whose), theta)?;
        Ok(plain.scaled(*factor))
    };
    let mut given = group.clone();
    let mut legs = group.legs.iter().map(&mut coefficients).collect::<Result<Vec<_>>>()?;
    if let ([(factor, points)], Noise::Exact) = (&group.legs[..], group.noise) {
        let kept = legs[0].informative(&group.values, whose)?;
        if kept.len() < group.values.len() {
            given.legs = vec![(*factor, kept.iter().map(|index| points[*index]).collect())];
            given.values = kept.iter().map(|index| group.values[*index]).collect();
            legs = vec![coefficients(&given.legs[0])?];
        }
    }
    let (learned, weighted) = (None, None);
    Ok(Compiled { number, given, legs, learned, weighted, offset: 0, first_leg: 0 })
}

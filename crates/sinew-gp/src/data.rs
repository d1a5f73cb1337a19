//! What is observed.

use std::collections::HashMap;

use crate::domain::Domain;
use crate::error::GpError;
use crate::operator::Operator;

/// Standard deviation of the error of observations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// None: the values are exact.
    Exact,
    /// Known, in the unit of the values.
    Known(f64),
    /// Inferred along with the other parameters.
    Learned,
}

/// Part that a group of observations has in the evidence.
///
/// Their order is that of the rows of the covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    /// Part of the model: what the conditional evidence conditions on.
    Imposed,
    /// Measured: the evidence says how well it is predicted.
    Observed,
    /// Not observed at all: an argument of a nonlinear term, near its value.
    Latent,
}

/// Values of one linear functional of u at several points.
#[derive(Clone, Debug)]
pub(crate) struct Group<const D: usize> {
    /// Nothing for the operator of the problem's equation.
    pub operator: Option<Operator<D>>,
    pub points: Vec<[f64; D]>,
    /// For jumps, the points whose values are subtracted.
    pub opposite: Option<Vec<[f64; D]>>,
    pub values: Vec<f64>,
    pub noise: Noise,
    pub role: Role,
}

/// Observations of u, of the equation's right-hand side, and of other linear functionals of u.
///
/// ```
/// use sinew_gp::{Data, Noise};
///
/// let data = Data::new()
///     .values(&[[0.1, 0.2], [0.5, 0.9]], &[1.2, 0.3], Noise::Learned)
///     .equation(&[[0.5, 0.5]], &[0.0], Noise::Exact);
/// assert_eq!(data.count(), 3);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Data<const D: usize> {
    pub(crate) groups: Vec<Group<D>>,
}

impl<const D: usize> Data<D> {
    /// None yet.
    pub fn new() -> Self {
        Self { groups: Vec::new() }
    }

    /// Number of observations.
    pub fn count(&self) -> usize {
        self.groups.iter().map(|group| group.points.len()).sum()
    }

    /// Adds values of u, one for each point.
    pub fn values(self, points: &[[f64; D]], values: &[f64], noise: Noise) -> Self {
        self.functional(Operator::identity(), points, values, noise)
    }

    /// Adds values of the right-hand side f of the problem's equation at collocation points.
    pub fn equation(mut self, points: &[[f64; D]], values: &[f64], noise: Noise) -> Self {
        self.groups.push(Group {
            operator: None,
            points: points.to_vec(),
            opposite: None,
            values: values.to_vec(),
            noise,
            role: Role::Imposed,
        });
        self
    }

    /// Adds measured values of any linear functional of u, as a flux on a boundary.
    pub fn functional(
        mut self,
        operator: impl Into<Operator<D>>,
        points: &[[f64; D]],
        values: &[f64],
        noise: Noise,
    ) -> Self {
        self.groups.push(Group {
            operator: Some(operator.into()),
            points: points.to_vec(),
            opposite: None,
            values: values.to_vec(),
            noise,
            role: Role::Observed,
        });
        self
    }
}

/// Refuses data that are not numbers or not of the domain, before anything is computed with them.
pub(crate) fn check<const D: usize>(
    groups: &[Group<D>],
    domain: &Domain<D>,
) -> Result<(), GpError> {
    for (number, group) in groups.iter().enumerate() {
        if group.points.len() != group.values.len() {
            return Err(GpError::Lengths {
                points: group.points.len(),
                values: group.values.len(),
            });
        }
        let not_finite =
            |what, index, value| GpError::NotFinite { what, index, group: number, value };
        for (index, (point, value)) in group.points.iter().zip(&group.values).enumerate() {
            if let Some(coordinate) = point.iter().find(|c| !c.is_finite()) {
                return Err(not_finite("point", index, *coordinate));
            }
            if !value.is_finite() {
                return Err(not_finite("value", index, *value));
            }
            if !domain.nearly_contains(*point) {
                let point = point.to_vec();
                return Err(GpError::OutsideDomain { index, group: number, point });
            }
        }
        match group.noise {
            Noise::Known(sigma) if !(sigma.is_finite() && sigma > 0.0) => {
                return Err(GpError::Noise(sigma));
            }
            Noise::Exact => check_duplicates(group, number)?,
            Noise::Known(_) | Noise::Learned => {}
        }
    }
    let empty = |group: &Group<D>| group.points.is_empty();
    if groups.iter().all(empty) {
        return Err(GpError::NoData);
    }
    match groups.iter().position(|group| empty(group) && group.noise == Noise::Learned) {
        Some(group) => Err(GpError::EmptyGroup { group }),
        None => Ok(()),
    }
}

/// Refuses places of a prediction that are not numbers.
pub(crate) fn check_places<const D: usize>(points: &[[f64; D]]) -> Result<(), GpError> {
    for (index, point) in points.iter().enumerate() {
        if let Some(value) = point.iter().find(|c| !c.is_finite()) {
            return Err(GpError::NotFinitePrediction { what: "point", index, value: *value });
        }
    }
    Ok(())
}

/// Relative difference up to which noise-free values of one point are the same.
const SAME: f64 = 1e-8;

/// Refuses noise-free values of one point that differ: jitter would let them pass for their mean.
fn check_duplicates<const D: usize>(group: &Group<D>, number: usize) -> Result<(), GpError> {
    if group.opposite.is_some() {
        return Ok(());
    }
    let mut seen: HashMap<[u64; D], usize> = HashMap::new();
    for (second, (point, value)) in group.points.iter().zip(&group.values).enumerate() {
        // Zero of either sign is one place.
        let first = *seen.entry(point.map(|c| (c + 0.0).to_bits())).or_insert(second);
        let difference = value - group.values[first];
        if difference.abs() > SAME * value.abs().max(group.values[first].abs()) {
            return Err(GpError::Duplicates { first, second, group: number, difference });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_determine_nothing_are_named() {
        let domain = Domain::interval("x", [0.0, 1.0]).unwrap();
        let check = |data: Data<1>| check(&data.groups, &domain);
        let refused = |data: Data<1>| check(data).unwrap_err();
        let some = || Data::new().equation(&[[0.5]], &[1.0], Noise::Exact);
        assert_eq!(refused(Data::new()), GpError::NoData);
        let off = some().values(&[[1.0 + 1e-12], [3.5]], &[0.1, 0.2], Noise::Learned);
        let outside = GpError::OutsideDomain { index: 1, group: 1, point: vec![3.5] };
        assert_eq!(refused(off), outside);
        let empty = some().values(&[], &[], Noise::Learned);
        assert_eq!(refused(empty), GpError::EmptyGroup { group: 1 });
        assert_eq!(check(some().values(&[], &[], Noise::Known(0.1))), Ok(()));
        let at = [[0.0], [0.3], [-0.0]];
        let twice = |noise| some().values(&at, &[1.0, 1.0, 1.5], noise);
        let differ = GpError::Duplicates { first: 0, second: 2, group: 1, difference: 0.5 };
        assert_eq!(refused(twice(Noise::Exact)), differ);
        assert_eq!(check(twice(Noise::Known(0.1))), Ok(()));
        assert_eq!(check(some().values(&at, &[1.0; 3], Noise::Exact)), Ok(()));
    }
}

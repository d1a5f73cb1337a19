//! An equation that holds everywhere, at as many points as are asked for.

use crate::data::{Data, Noise};
use crate::domain::Domain;
use crate::error::GpError;
use crate::field::Field;

/// An equation that holds everywhere, and what else there is.
#[derive(Clone, Debug)]
pub(crate) struct Everywhere<const D: usize> {
    pub source: Field<D>,
    pub rest: Data<D>,
}

/// Points that an equation begins with, for each dimension.
const FIRST: usize = 15;
/// Seed of their places.
const SEED: u64 = 0x5eed;

impl<const D: usize> Everywhere<D> {
    /// All data, with the equation at `count` points: the first of a sequence that does not depend on their number.
    pub(crate) fn at(&self, domain: &Domain<D>, count: usize) -> Result<Data<D>, GpError> {
        let at = domain.sample(count, SEED)?;
        let f: Vec<f64> = at.iter().map(|x| self.source.value(*x)).collect();
        Ok(self.rest.clone().equation(&at, &f, Noise::Exact))
    }

    pub(crate) fn first() -> usize {
        FIRST * D
    }
}

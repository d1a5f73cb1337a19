//! The error of collocation, from places that the fit does not know of.

use crate::fit::HoldOut;
use crate::model::compile::Compiled;
use crate::model::data::root_mean_square;
use crate::{Fit, GpError, Model, Noise, Operator, Result};

/// Points that are left out at most, for time.
const MOST_LEFT_OUT: usize = 200;
/// Places where the equation is looked at, and their seed.
pub(crate) const PLACES: usize = 300;
const SEED: u64 = 0x0a11;
/// Share of the left-hand side's standard deviation before the data below which terms count as zero: a residual is not held
/// against what is next to nothing.
const NOTHING: f64 = 1e-3;
/// Points at which a right-hand side is the same, from which on it is taken to be the same everywhere.
pub(crate) const EVEN: usize = 10;

/// A place where the equation may be imposed.
pub(crate) struct Candidate<const D: usize> {
    pub at: [f64; D],
    /// The right-hand side.
    pub value: f64,
    /// Error of the left-hand side of the posterior mean.
    pub residual: f64,
}

/// Error of the equation in units of its largest term from which on intervals are withheld.
const WITHHELD: f64 = 2.0;

impl<const D: usize> Fit<D> {
    /// Error in place of intervals of an equation that next to nothing was seen of.
    pub(crate) fn withheld(&self) -> Option<GpError> {
        let HoldOut { at, residual, term } = self.hold_out.clone()?;
        (residual > WITHHELD * term).then_some(GpError::Unresolved { at, residual, term })
    }

    /// The equation left out at each of its points in turn, by the inverse of the covariance; and at other places where its
    /// right-hand side is known, because it holds everywhere or is the same at all points. None without an equation.
    pub(crate) fn left_out(&self) -> Result<Option<HoldOut>> {
        let (model, conditional) = (self.model(), self.conditional()?);
        let (mut own, mut term) = (Vec::new(), 0.0_f64);
        for group in model.equations() {
            let at = group.given.points();
            term = term.max(NOTHING * conditional.prior_spread(&model.prior.equation, at)?);
            for (row, at) in group.rows().zip(at).step_by(1 + at.len() / MOST_LEFT_OUT) {
                own.push((conditional.left_out(row)[0], *at));
            }
            for summand in model.prior.equation.terms() {
                let values = conditional.mean_of(&Operator::of(summand), at)?;
                term = term.max(root_mean_square(&values));
            }
        }
        let elsewhere = self.candidates(SEED)?.into_iter();
        let elsewhere: Vec<_> = elsewhere.map(|place| (place.residual, place.at)).collect();
        let size = |found: &[(f64, [f64; D])]| {
            root_mean_square(&found.iter().map(|(residual, _)| *residual).collect::<Vec<_>>())
        };
        let worse = if size(&elsewhere) > size(&own) { elsewhere } else { own };
        let worst = worse.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let residual = size(&worse);
        Ok(worst.map(|(_, at)| HoldOut { at: at.to_vec(), residual, term }))
    }

    /// Places with the residual of the equation there, where its right-hand side is known; else none.
    pub(crate) fn candidates(&self, seed: u64) -> Result<Vec<Candidate<D>>> {
        let model = self.model();
        let mut exact = model.equations();
        let Some(group) = exact.next() else { return Ok(Vec::new()) };
        let (f, count) = (group.given.values[0], group.given.values.len());
        let even = count >= EVEN && group.given.values.iter().all(|value| *value == f);
        let even = even && group.given.noise == Noise::Exact && exact.next().is_none();
        let source = |x: &[f64; D]| model.source.as_ref().map(|source| source.value(*x));
        let known = |x: &[f64; D]| source(x).or(even.then_some(f));
        let places = model.prior.domain.sample(PLACES, seed)?;
        let values: Vec<f64> = places.iter().filter_map(known).collect();
        if values.len() < places.len() {
            return Ok(Vec::new());
        }
        let found = self.conditional()?.mean_of(&model.prior.equation, &places)?;
        let each = places.into_iter().zip(values).zip(found);
        Ok(each.map(|((at, value), u)| Candidate { at, value, residual: u - value }).collect())
    }
}

impl<const D: usize> Model<D> {
    /// Groups of values of the right-hand side.
    fn equations(&self) -> impl Iterator<Item = &Compiled<D>> {
        self.groups
            .iter()
            .filter(|group| group.given.operator.is_none() && !group.given.points().is_empty())
    }

    /// All collocation points.
    pub(crate) fn places(&self) -> Vec<[f64; D]> {
        self.equations().flat_map(|group| group.given.points().iter().copied()).collect()
    }
}

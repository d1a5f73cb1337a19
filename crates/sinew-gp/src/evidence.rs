//! The evidence of a model: which one, and its value.

use sinew_num::on_ready_threads;

use crate::error::GpError;
use crate::model::{Compiled, Model};
use crate::state::State;

/// What a fit maximises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evidence {
    /// ln p(y_u, y_f) (4.18). Unbounded where noise-free collocation is met by the prior mean
    /// itself, be it as θ → 0: a covariance K_ff → 0 then makes the collocation values as likely
    /// as one likes, and u is lost.
    Joint,
    /// ln p(y_u | y_f): how well what is imposed (the equation, and pseudo-observations of the
    /// boundary) predicts what is measured.
    Conditional,
    /// Joint where it is bounded. Elsewhere restarts maximise the conditional evidence, and from the best of
    /// them a last climb the joint one ([`crate::Fit::sharpened`]): next to a sound fit that has a local
    /// maximum, mostly, which tells the size of errors and θ more sharply, because it also counts how well θ lets the
    /// solution be a typical draw of the prior. It is taken unless it collapsed, or left the region that
    /// holds 95 % of what the conditional evidence finds probable, of all parameters or of θ alone.
    ///
    /// Ensembles ([`crate::nuts`], [`crate::laplace`]) of models with parameters in the equation and noise-free
    /// collocation always take the conditional one: see [`Model::ensemble_evidence`].
    #[default]
    Auto,
}

impl Evidence {
    pub(crate) fn resolve<const D: usize>(
        self,
        groups: &[Compiled<D>],
        imposed: usize,
        size: usize,
    ) -> Result<Self, GpError> {
        let unbounded = groups.iter().any(Compiled::is_trivially_satisfied);
        match self {
            Self::Conditional if imposed == size => Err(GpError::Data(
                "conditional evidence needs observations of u beside those of the equation; use joint evidence"
                    .into(),
            )),
            Self::Auto if unbounded && imposed < size => Ok(Self::Conditional),
            Self::Auto => Ok(Self::Joint),
            chosen => Ok(chosen),
        }
    }
}

/// An evidence with its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Logarithm of the evidence.
    pub value: f64,
    /// Its derivatives in the parameters, each on the scale that it is adjusted on.
    pub gradient: Vec<f64>,
    /// Relative jitter that the factorisation needed.
    pub jitter: f64,
}

impl<const D: usize> Model<D> {
    /// The evidence that ensembles explore.
    ///
    /// It is the model's own, but for [`Evidence::Auto`] with free parameters in the equation and
    /// noise-free collocation, where it is the conditional one. There p(y_f | θ) has no noise in it: what it says of
    /// θ depends on how far the true solution is from typical draws of the prior, not on how
    /// accurate the measurements are. That makes a good estimate, but no interval that covers.
    pub fn ensemble_evidence(&self) -> Evidence {
        self.ensemble_evidence
    }

    /// The prior covariance of all observed functionals, without noise, row by row: imposed
    /// groups (equation, pseudo-observations) first, then the measured ones in their order.
    ///
    /// # Errors
    /// If the number of parameters is wrong.
    pub fn prior_covariance(&self, parameters: &[f64]) -> Result<Vec<Vec<f64>>, GpError> {
        let lower = State::new(self, parameters)?.covariance();
        let entry =
            |row: usize, column: usize| lower[row.min(column) * self.size + row.max(column)];
        Ok((0..self.size).map(|row| (0..self.size).map(|c| entry(row, c)).collect()).collect())
    }

    /// Logarithm of the evidence at parameters on their scales (see [`crate::FreeParameter`]).
    ///
    /// # Errors
    /// If their number is wrong, or the covariance is not positive definite with any jitter.
    pub fn log_evidence(&self, parameters: &[f64]) -> Result<f64, GpError> {
        let state = State::new(self, parameters)?;
        Ok(state.value(&state.factored()?))
    }

    /// [`Model::log_evidence`] with its gradient.
    ///
    /// # Errors
    /// As [`Model::log_evidence`].
    pub fn evaluate(&self, parameters: &[f64]) -> Result<Evaluation, GpError> {
        self.evaluate_as(self.evidence, parameters)
    }

    /// [`Model::evaluate`] for another evidence than the model's own.
    pub(crate) fn evaluate_as(
        &self,
        evidence: Evidence,
        parameters: &[f64],
    ) -> Result<Evaluation, GpError> {
        let state = State::with_evidence(self, parameters, evidence)?;
        let evaluate = || {
            let factored = state.factored()?;
            Ok(Evaluation {
                value: state.value(&factored),
                gradient: state.gradient(&factored),
                jitter: factored.jitter,
            })
        };
        if state.parallel() { on_ready_threads(evaluate) } else { evaluate() }
    }
}

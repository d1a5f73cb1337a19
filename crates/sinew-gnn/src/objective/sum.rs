//! Several objectives at once.

use burn::tensor::Tensor;

use super::{Batch, Objective};
use crate::data::DataSet;
use crate::error::{Error, Result, require_positive};

/// `Σ wᵢ lossᵢ`, for instance of a potential energy and of simulated displacements.
pub struct WeightedSum {
    terms: Vec<(f64, Box<dyn Objective>)>,
}

impl WeightedSum {
    /// Of objectives and their weights.
    ///
    /// # Errors
    /// No objective at all, or a weight that is not positive.
    pub fn new(terms: Vec<(f64, Box<dyn Objective>)>) -> Result<Self> {
        if terms.is_empty() {
            return Err(Error::NothingToTrain("a sum of no objectives"));
        }
        for (weight, _) in &terms {
            require_positive("the weight of an objective", *weight)?;
        }
        Ok(Self { terms })
    }
}

impl Objective for WeightedSum {
    fn check(&self, data: &DataSet) -> Result<()> {
        self.terms.iter().try_for_each(|(_, objective)| objective.check(data))
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        let mut sum: Option<Tensor<1>> = None;
        for (weight, objective) in &self.terms {
            let term = objective.loss(batch, displacement.clone())? * *weight;
            sum = Some(sum.map_or(term.clone(), |sum| sum + term));
        }
        sum.ok_or(Error::NothingToTrain("a sum of no objectives"))
    }

    fn inadmissible(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> usize {
        let counts =
            self.terms.iter().map(|(_, term)| term.inadmissible(batch, displacement.clone()));
        counts.max().unwrap_or(0)
    }
}

//! A regression as a folder: `modes.npy`, the mean and the modes row by row, and `regression.json`, the rest.

use super::PodRegression;
use super::interpolation::Fitted;
use crate::store::{content, read_json, read_table, write_json, write_table};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sinew_energy::Parameter;
use std::path::Path;

#[derive(Serialize, Deserialize)]
struct Description {
    /// One for all modes.
    fitted: [Fitted; 1],
    leave_one_out: f64,
}

impl PodRegression {
    /// Writes a folder with all that prediction needs.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let column = |column: &[f64]| column.to_vec();
        let mean = std::iter::once(column(self.mean.as_slice()));
        let modes = self.modes.column_iter().map(|mode| column(mode.as_slice()));
        write_table(&folder.join("modes.npy"), &mean.chain(modes).collect::<Vec<_>>())?;
        let (fitted, leave_one_out) = ([self.fitted.clone()], self.leave_one_out);
        write_json(&folder.join("regression.json"), &Description { fitted, leave_one_out })
    }

    /// Reads what [`PodRegression::save`] wrote, for the parameters that it was fitted with.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub fn load(folder: &Path, parameters: &[Parameter]) -> Result<Self> {
        let (file, table) = (folder.join("regression.json"), folder.join("modes.npy"));
        let Description { fitted: [fitted], leave_one_out } =
            read_json(&file)?.ok_or_else(|| Error::NoEmulator { folder: folder.into() })?;
        let rows = read_table(&table)?;
        let length = rows.first().map_or(0, Vec::len);
        let modes = rows.len().saturating_sub(1);
        if length == 0 || fitted.weights.ncols() != modes {
            return Err(content(&table, &"it does not hold one mode per column of weights"));
        }
        Ok(Self {
            mean: DVector::from_column_slice(&rows[0]),
            modes: DMatrix::from_fn(length, modes, |i, j| rows[1 + j][i]),
            parameters: parameters.to_vec(),
            fitted,
            leave_one_out,
        })
    }
}

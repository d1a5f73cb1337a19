//! Proper orthogonal decomposition of snapshots.

use nalgebra::{DMatrix, DVector};

use super::RegressionError;

/// Fields about their mean: `field = mean + modes · coefficientsᵀ`.
pub(super) struct Decomposition {
    pub(super) mean: DVector<f64>,
    /// One orthonormal mode per column.
    pub(super) modes: DMatrix<f64>,
    /// One row per sample.
    pub(super) coefficients: DMatrix<f64>,
}

pub(super) fn decompose(
    snapshots: &DMatrix<f64>,
    dropped_energy: f64,
) -> Result<Decomposition, RegressionError> {
    let mean = snapshots.column_mean();
    let mut centred = snapshots.clone();
    centred.column_iter_mut().for_each(|mut column| column -= &mean);
    let failed = || RegressionError::Decomposition {
        samples: snapshots.ncols(),
        length: snapshots.nrows(),
        largest: snapshots.amax(),
    };
    if !centred.norm_squared().is_finite() {
        return Err(failed());
    }
    // nalgebra's own accuracy, and more sweeps than any matrix needs instead of no bound.
    let svd =
        centred.clone().try_svd(true, false, 5.0 * f64::EPSILON, 10_000).ok_or_else(failed)?;
    let energies: Vec<f64> = svd.singular_values.iter().map(|s| s * s).collect();
    let allowed = dropped_energy * energies.iter().sum::<f64>();
    let mut dropped = 0.0;
    let mut kept = energies.len();
    // The rounding error of a zero singular value is not a mode, whatever the tolerance.
    let rounding = (f64::EPSILON * snapshots.norm()).powi(2);
    while kept > 0 && (dropped + energies[kept - 1] <= allowed || energies[kept - 1] <= rounding) {
        kept -= 1;
        dropped += energies[kept];
    }
    let modes = svd.u.ok_or_else(failed)?.columns(0, kept).into_owned();
    let coefficients = centred.tr_mul(&modes);
    Ok(Decomposition { mean, modes, coefficients })
}

//! Random states of deformation.

use crate::lower::geometry::orthonormalise;
use sinew_num::{Mat3, SplitMix64};

/// A stream of random states, the same on every machine.
pub(super) struct States(SplitMix64);

impl States {
    pub(super) fn new(seed: u64) -> Self {
        Self(SplitMix64(seed))
    }

    /// Entries up to `size`, so that J may be anything.
    pub(super) fn any(&mut self, size: f64) -> Mat3<f64> {
        Mat3::from_fn(|_, _| size * self.0.number())
    }

    /// A state that a soft tissue may be in: entries up to 0.15, J between 0.6 and 1.6.
    pub(super) fn admissible(&mut self) -> Mat3<f64> {
        loop {
            let h = self.any(0.15);
            if (-0.4..0.6).contains(&h.volume_change()) {
                return h;
            }
        }
    }

    /// A rotation of random axes.
    pub(super) fn rotation(&mut self) -> Mat3<f64> {
        let mut axes = self.any(1.0).0;
        // Once more, for the rounding errors of axes that were nearly parallel.
        (0..2).for_each(|_| _ = orthonormalise(&mut axes));
        let sign = Mat3(axes).determinant().signum();
        Mat3(axes.map(|axis| axis.map(|x| sign * x)))
    }
}

/// `R(I + H) − I`.
pub(super) fn moved(rotation: &Mat3<f64>, h: &Mat3<f64>) -> Mat3<f64> {
    let f = h.plus_identity();
    Mat3::from_fn(|i, j| {
        (0..3).map(|k| rotation[i][k] * f[k][j]).sum::<f64>() - Mat3::IDENTITY[i][j]
    })
}

/// `h` with `step` added to one entry.
pub(super) fn shifted(h: &Mat3<f64>, entry: usize, step: f64) -> Mat3<f64> {
    let mut h = *h;
    h.0[entry / 3][entry % 3] += step;
    h
}

/// Largest entry; NaN if one is.
pub(super) fn norm(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |m: f64, x| if m.is_nan() || x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Largest difference of entries; NaN if one is.
pub(super) fn difference(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<_> = a.iter().zip(b).map(|(x, y)| x - y).collect();
    norm(&differences)
}

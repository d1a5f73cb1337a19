//! Random states of deformation.

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

    /// A rotation from a random unit quaternion: any axis, any angle.
    pub(super) fn rotation(&mut self) -> Mat3<f64> {
        let q = loop {
            let q = [self.0.number(), self.0.number(), self.0.number(), self.0.number()];
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            // Away from zero, where normalising loses digits, and inside the ball, for uniformity.
            if (0.1..1.0).contains(&length) {
                break q.map(|x| x / length);
            }
        };
        let [w, x, y, z] = q;
        Mat3([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ])
    }
}

/// `R(I + H) − I`.
pub(super) fn moved(rotation: &Mat3<f64>, h: &Mat3<f64>) -> Mat3<f64> {
    let delta = |i, j| if i == j { 1.0 } else { 0.0 };
    Mat3::from_fn(|i, j| {
        (0..3).map(|k| rotation[i][k] * (h[k][j] + delta(k, j))).sum::<f64>() - delta(i, j)
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

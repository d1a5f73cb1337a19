//! A regression with the digits that a page needs.

use sinew_emulate::{PodRegression, RegressionError};
use sinew_report::{Model, Packed};

/// Error of a mode in 16 bits up to which it is stored in them [relative to the root of the mean square of the values]: dozens of
/// modes together stay below 1e-6, the distance that a page may have from the program.
const COARSE: f64 = 4e-8;

/// A regression as a page evaluates it, with its rounding.
pub(super) struct Compact {
    regression: PodRegression,
    mean: Vec<f32>,
    fine: Vec<Vec<f32>>,
    /// Modes in 16 bits, each with its step.
    coarse: Vec<(f64, Vec<i16>)>,
}

impl Compact {
    /// Keeps some of the values, or all. How many digits a mode needs is measured at `thetas`.
    pub(super) fn of(
        regression: PodRegression,
        rows: Option<&[usize]>,
        thetas: &[Vec<f64>],
    ) -> Result<Self, RegressionError> {
        let parts = regression.parts();
        let kept = |values: &[f64]| -> Vec<f64> {
            rows.map_or_else(|| values.to_vec(), |rows| rows.iter().map(|&r| values[r]).collect())
        };
        let mut largest = vec![0.0f64; parts.modes.len()];
        let mut square = 0.0;
        for theta in thetas {
            let coefficients = regression.coefficients(theta)?;
            let pairs = largest.iter_mut().zip(&coefficients);
            pairs.for_each(|(largest, c)| *largest = largest.max(c.abs()));
            square += coefficients.iter().map(|c| c * c).sum::<f64>();
        }
        square =
            square / thetas.len().max(1) as f64 + parts.mean.iter().map(|m| m * m).sum::<f64>();
        let size = (square / parts.mean.len() as f64).sqrt();
        let step =
            |mode: &[f64]| mode.iter().fold(0.0, |m: f64, x| m.max(x.abs())) / f64::from(i16::MAX);
        let modes: Vec<Vec<f64>> = parts.modes.iter().map(|mode| kept(mode)).collect();
        // Modes come in the order of their size, so that the first small one begins the coarse ones.
        let small = |(mode, largest): (&Vec<f64>, &f64)| largest * step(mode) <= COARSE * size;
        let count = modes.iter().zip(&largest).rposition(|pair| !small(pair)).map_or(0, |k| k + 1);
        let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        let coarse = |mode: &Vec<f64>| {
            let step = step(mode).max(f64::MIN_POSITIVE);
            (step, mode.iter().map(|x| (x / step).round() as i16).collect())
        };
        Ok(Self {
            mean: single(&kept(parts.mean)),
            fine: modes[..count].iter().map(|mode| single(mode)).collect(),
            coarse: modes[count..].iter().map(coarse).collect(),
            regression,
        })
    }

    /// Values at θ, as the page has them.
    pub(super) fn at(&self, theta: &[f64]) -> Result<Vec<f64>, RegressionError> {
        let coefficients = self.regression.coefficients(theta)?;
        let mut values: Vec<f64> = self.mean.iter().map(|&m| f64::from(m)).collect();
        let (first, others) = coefficients.split_at(self.fine.len());
        for (c, mode) in first.iter().zip(&self.fine) {
            values.iter_mut().zip(mode).for_each(|(value, &m)| *value += c * f64::from(m));
        }
        for (c, (step, mode)) in others.iter().zip(&self.coarse) {
            values.iter_mut().zip(mode).for_each(|(value, &m)| *value += c * step * f64::from(m));
        }
        Ok(values)
    }

    pub(super) fn packed(&self) -> Model {
        let parts = self.regression.parts();
        Model {
            mean: Packed::f32(self.mean.iter().copied()),
            fine: Packed::f32(self.fine.iter().flatten().copied()),
            coarse: Packed::i16(self.coarse.iter().flat_map(|(_, mode)| mode.iter().copied())),
            steps: Packed::f64(self.coarse.iter().map(|(step, _)| *step)),
            lengths: parts.lengths.to_vec(),
            points: Packed::f64(parts.points.concat()),
            exponents: parts.exponents.to_vec(),
            weights: Packed::f64(parts.weights.concat()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_energy::Parameter;

    #[test]
    fn sixteen_bits_are_taken_where_nobody_sees_them() {
        let parameters = [Parameter::log("k", "kPa", 1.0..=3.0)];
        let thetas: Vec<Vec<f64>> = (0..40).map(|i| vec![1.0 + 0.05 * i as f64]).collect();
        let field = |t: &Vec<f64>| -> Vec<f64> {
            (0..300).map(|i| (0.02 * i as f64 * t[0]).sin() / t[0]).collect()
        };
        let fields: Vec<_> = thetas.iter().map(field).collect();
        let regression = PodRegression::fit_polynomial(&parameters, &thetas, &fields, 8).unwrap();
        let compact = Compact::of(regression.clone(), None, &thetas).unwrap();
        assert!(!compact.fine.is_empty() && !compact.coarse.is_empty());
        let norm = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
        for theta in &thetas {
            let (own, exact) = (compact.at(theta).unwrap(), regression.predict(theta).unwrap());
            let apart: Vec<f64> = own.iter().zip(&exact).map(|(a, b)| a - b).collect();
            assert!(norm(&apart) < 1e-6 * norm(&exact), "{}", norm(&apart) / norm(&exact));
        }
    }
}

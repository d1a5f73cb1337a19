//! How the error fell while an emulator was trained.

use serde::{Deserialize, Serialize};

use super::{Method, PerMetric};

/// Points kept of one curve: more than a plot can show, and a bound for the file.
const MAX_POINTS: usize = 400;

/// Errors at one moment of training.
///
/// Numbers that are not finite are `None` (`null` in the file): an inverted element
/// early in training has infinite energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Optimiser steps done.
    pub step: u64,
    /// Training time so far, without evaluation \[s\].
    pub train_s: f64,
    /// Median errors over the validation cases.
    #[serde(flatten)]
    pub errors: PerMetric<Option<f64>>,
    /// The objective; its unit depends on the method.
    pub loss: Option<f64>,
}

impl CurvePoint {
    /// A point from plain numbers.
    pub fn new(step: u64, train_s: f64, errors: PerMetric<f64>, loss: f64) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            step,
            train_s,
            errors: PerMetric {
                err_u_mm: finite(errors.err_u_mm),
                err_f_pct: finite(errors.err_f_pct),
                err_i1_pct: finite(errors.err_i1_pct),
                err_pi_pct: finite(errors.err_pi_pct),
            },
            loss: finite(loss),
        }
    }
}

/// Potential energy at one moment of training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergyPoint {
    /// Optimiser steps done.
    pub step: u64,
    /// Training time so far, without evaluation \[s\].
    pub train_s: f64,
    /// Mean of (Π(û) − Π(u)) / |Π(u)| over the validation cases \[%\], u from FEM.
    /// `None` if not finite.
    pub excess_pct: Option<f64>,
}

/// Curves of one trained emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainingHistory {
    /// The emulator.
    pub method: Method,
    /// Validation errors, in the order of steps.
    pub curve: Vec<CurvePoint>,
    /// Energy above the finite-element minimum, in the order of steps.
    pub energy: Vec<EnergyPoint>,
}

impl TrainingHistory {
    /// Curves thinned to at most 400 points each, evenly on a logarithmic axis; the
    /// first and the last point stay.
    pub fn new(method: Method, curve: &[CurvePoint], energy: &[EnergyPoint]) -> Self {
        Self { method, curve: thin(curve), energy: thin(energy) }
    }
}

fn thin<T: Copy>(points: &[T]) -> Vec<T> {
    if points.len() <= MAX_POINTS {
        return points.to_vec();
    }
    let ratio = (points.len() as f64).ln() / (MAX_POINTS - 1) as f64;
    let mut indices: Vec<usize> = (0..MAX_POINTS)
        .map(|k| (ratio * k as f64).exp().round() as usize - 1)
        .map(|index| index.min(points.len() - 1))
        .collect();
    indices.dedup();
    indices.into_iter().map(|index| points[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_ends_and_the_order() {
        let points: Vec<usize> = (0..10_000).collect();
        let kept = thin(&points);
        assert!(kept.len() <= MAX_POINTS && kept.len() > MAX_POINTS / 2);
        assert_eq!((kept[0], kept[kept.len() - 1]), (0, 9_999));
        assert!(kept.is_sorted());
        assert_eq!(thin(&points[..MAX_POINTS]), points[..MAX_POINTS]);
    }

    #[test]
    fn infinite_energy_becomes_null_and_stays_readable() {
        let errors = PerMetric { err_pi_pct: f64::INFINITY, ..PerMetric::default() };
        let point = CurvePoint::new(3, 0.5, errors, f64::NAN);
        let text = serde_json::to_string(&point).unwrap();
        assert!(text.contains(r#""err_Pi_pct":null"#), "{text}");
        assert_eq!(serde_json::from_str::<CurvePoint>(&text).unwrap(), point);
    }
}

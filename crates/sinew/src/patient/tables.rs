//! The tables of a patient file.

use crate::case::Exactly;
use serde::Deserialize;
use sinew_calibrate::{CalibrateOptions, Direction};
use sinew_energy::Fibres;
use std::collections::BTreeMap;

/// Tables of a patient file beside its case, whose keys are read elsewhere.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Tables {
    /// Values of loads and tensions by phase; `image` is the state of the mesh.
    pub phases: BTreeMap<String, BTreeMap<String, Quantity>>,
    /// Measurements.
    pub data: Vec<Entry>,
    /// Settings.
    pub calibration: Settings,
}

/// A number, or one with its unit.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum Quantity {
    Number(f64),
    Text(String),
}

/// One measurement, or one of each segment.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Entry {
    /// Facet set of the cavity whose volume it is.
    pub volume: Option<String>,
    /// Direction of the strain that it is.
    pub strain: Option<Direction>,
    /// Direction of the displacement that it is.
    pub displacement: Option<Exactly<f64, 3>>,
    /// Place of the displacement in the image \[mm\].
    pub point: Option<Exactly<f64, 3>>,
    /// Segment of the strain: its name, or the number of a label.
    pub segment: Option<toml::Value>,
    /// Phase.
    pub phase: Option<String>,
    /// Phase that strains and displacements are counted from; the image unless told.
    pub from: Option<String>,
    /// Value.
    pub value: Option<f64>,
    /// Values of all segments in their order.
    pub values: Option<Vec<f64>>,
    /// Standard deviation, in the unit of the value or a share of it.
    pub sd: Option<Quantity>,
    /// Unit of the value.
    pub unit: Option<String>,
}

/// Settings of a calibration.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Settings {
    /// Whether the image is taken as unloaded.
    pub image_at_rest: bool,
    /// Whether fibres move with the tissue (`carried`) or are the same vectors at rest (`kept`).
    pub fibres: Fibres,
    /// Log-normal priors by name of the parameter; the others are log-uniform over their ranges.
    pub priors: BTreeMap<String, LogNormal>,
    /// Relative standard deviation of all pressures together.
    pub pressure_common: Option<f64>,
    /// Relative standard deviation of the pressure of each phase.
    pub pressure_each: Option<f64>,
    /// Kinds of data whose noise is inferred.
    pub infer_noise: Vec<String>,
    /// Standard deviation of an error that all data of a kind share.
    pub bias: BTreeMap<String, Quantity>,
    /// Surfaces of the wall, for directions and segments.
    pub wall: Option<Wall>,
    /// Division in segments: `aha17`, `4x6` (levels and sectors) or `field:NAME`.
    pub segments: Option<String>,
    /// Seed.
    pub seed: Option<u64>,
    /// Draws of the result.
    pub draws: Option<usize>,
    /// Design points of the emulator.
    pub design: Option<usize>,
    /// Draws that the solver checks in each round.
    pub checks: Option<usize>,
    /// Rounds at most.
    pub rounds: Option<usize>,
    /// Highest degree of the emulator's polynomials.
    pub degree: Option<usize>,
}

/// A log-normal prior.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LogNormal {
    /// Median, in the unit of the parameter.
    pub median: f64,
    /// Relative standard deviation, as that of the logarithm.
    pub sd: f64,
}

/// Surfaces of a wall, and the direction of the septum.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wall {
    pub endocardium: String,
    pub epicardium: String,
    pub base: String,
    pub septum: Option<Exactly<f64, 3>>,
}

/// Least number of draws whose Pareto k̂ is estimated: five in the tail, a fifth of all.
const FEWEST_DRAWS: usize = 25;
/// Most of them, and of rounds: years of solves.
const MOST_SOLVES: usize = 1_000_000;
/// Highest degree of the emulator's polynomials.
const MOST_DEGREE: usize = 4;

impl Settings {
    /// Requires numbers that the method has a meaning for; else the key, and what is wrong there.
    pub(super) fn check(&self) -> Result<(), (&'static str, String)> {
        let bounds = [
            ("draws", self.draws, FEWEST_DRAWS..=MOST_SOLVES),
            ("design", self.design, 1..=MOST_SOLVES),
            ("checks", self.checks, FEWEST_DRAWS..=MOST_SOLVES),
            ("rounds", self.rounds, 1..=MOST_SOLVES),
            ("degree", self.degree, 1..=MOST_DEGREE),
        ];
        for (key, value, bounds) in bounds {
            if let Some(value) = value.filter(|value| !bounds.contains(value)) {
                let (least, most) = (bounds.start(), bounds.end());
                return Err((
                    key,
                    format!("it is {value}; give at least {least} and at most {most}"),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn options(&self) -> CalibrateOptions {
        let plain = CalibrateOptions::default();
        CalibrateOptions {
            seed: self.seed.unwrap_or(plain.seed),
            draws: self.draws.unwrap_or(plain.draws),
            design: self.design.unwrap_or(plain.design),
            checks: self.checks.unwrap_or(plain.checks),
            rounds: self.rounds.unwrap_or(plain.rounds),
            degree: self.degree.unwrap_or(plain.degree),
            ..plain
        }
    }
}

//! Pressure–volume curve of a posterior, with bands.

use crate::case::stress_in_kpa;
use crate::patient::Prepared;
use rayon::prelude::*;
use sinew_calibrate::{Forward, Klotz, Posterior};
use sinew_sample::quantile;
use std::fmt::Write;

/// Pressures of the curve \[mmHg\].
const PRESSURES: [f64; 10] = [2.0, 5.0, 8.0, 11.0, 14.0, 17.0, 20.0, 23.0, 26.0, 30.0];
/// Draws that the curve is solved for, which give its band.
const CURVE_DRAWS: usize = 48;
/// One millilitre in mm³.
const MILLILITRE: f64 = 1e3;

/// Volumes of a cavity over pressures, with bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Facet set of the cavity.
    pub cavity: String,
    /// Pressures \[mmHg\], from 0.
    pub pressures: Vec<f64>,
    /// 2.5 %, 50 % and 97.5 % quantile of the volume at each \[mL\].
    pub volumes: Vec<[f64; 3]>,
    /// Curve of other hearts through the data, where it makes sense.
    pub klotz: Option<Klotz>,
    /// Draws that were solved.
    pub draws: usize,
}

impl Curve {
    /// Solves for the volumes of a cavity at some draws of the posterior.
    ///
    /// # Errors
    /// A cavity whose pressure is not a parameter, and draws that cannot be solved.
    pub fn new(prepared: &Prepared, posterior: &Posterior, cavity: &str) -> Result<Self, String> {
        let kpa = stress_in_kpa("mmHg").unwrap_or(1.0);
        let patient = prepared.curve(cavity, &PRESSURES.map(|p| p * kpa))?;
        let chains = posterior.draws.draws.len().max(1);
        let thin = posterior.draws.thinned(CURVE_DRAWS.div_ceil(chains));
        let places = prepared.curve_parameters();
        let thetas: Vec<Vec<f64>> =
            thin.pooled().map(|draw| places.iter().map(|&at| draw[at]).collect()).collect();
        if let Some(middle) = thetas.get(thetas.len() / 2) {
            patient.expect_among(std::slice::from_ref(middle));
        }
        let solve = |theta: &Vec<f64>| patient.observe(theta, false).ok().map(|seen| seen.values);
        let found: Vec<Vec<f64>> = thetas.par_iter().filter_map(solve).collect();
        if found.is_empty() {
            return Err(format!("the curve of {cavity} has no equilibrium at any draw"));
        }
        let quantiles = |volumes: Vec<f64>| {
            [0.025, 0.5, 0.975].map(|share| quantile(&volumes, share) / MILLILITRE)
        };
        let name = format!("volume of {cavity} at rest");
        let rest = prepared.reported.iter().find(|seen| seen.name == name);
        let rest =
            rest.map(|seen| quantiles(posterior.observed.parameter(seen.observable).concat()));
        let at = |p: usize| quantiles(found.iter().map(|volumes| volumes[p]).collect());
        let (mut pressures, mut volumes) = (Vec::new(), Vec::new());
        if let Some(rest) = rest {
            pressures.push(0.0);
            volumes.push(rest);
        }
        pressures.extend(PRESSURES);
        volumes.extend((0..PRESSURES.len()).map(at));
        let data = measured(prepared, posterior, cavity);
        let klotz = data.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
        let klotz = klotz.and_then(|[volume, pressure]| Klotz::through(*pressure, *volume));
        Ok(Self { cavity: cavity.into(), pressures, volumes, klotz, draws: found.len() })
    }

    /// The table as CSV.
    pub fn to_csv(&self) -> String {
        let mut text = String::from(
            "pressure [mmHg],volume 2.5 % [mL],volume 50 % [mL],volume 97.5 % [mL],Klotz [mL]\n",
        );
        for (pressure, [low, middle, high]) in self.pressures.iter().zip(&self.volumes) {
            let klotz = self.klotz.map_or(String::new(), |k| inverse(&k, *pressure).to_string());
            let _ = writeln!(text, "{pressure},{low},{middle},{high},{klotz}");
        }
        text
    }
}

/// Volume of Klotz's curve at a pressure; the unloaded one at 0.
pub(super) fn inverse(klotz: &Klotz, pressure: f64) -> f64 {
    match pressure > 0.0 {
        true => (pressure / klotz.alpha).powf(1.0 / klotz.beta),
        false => klotz.unloaded,
    }
}

/// Measured volumes of a cavity with their pressures \[mL, mmHg\].
pub(super) fn measured(prepared: &Prepared, posterior: &Posterior, cavity: &str) -> Vec<[f64; 2]> {
    let kpa = stress_in_kpa("mmHg").unwrap_or(1.0);
    let parameter = prepared.pressures.iter().find(|(facets, _)| facets == cavity);
    let pair = |datum: &sinew_calibrate::Datum| {
        let state = datum.name.strip_prefix(&format!("volume of {cavity} at "))?;
        let pressure = prepared.phases.get(state)?.get(&parameter?.1)?;
        Some([datum.value / MILLILITRE, pressure / kpa])
    };
    posterior.problem.data.iter().filter_map(pair).collect()
}

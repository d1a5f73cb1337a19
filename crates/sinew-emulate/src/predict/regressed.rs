//! Regressions of simulations, of what a Taylor expansion leaves of them, and the expansion alone; a frozen stiffness.

use crate::coordinates::Motions;
use crate::predict::{Predictor, taylor};
use crate::store::record::Record;
use crate::store::{read_json, write_json};
use crate::{Body, Emulator, Error, PodRegression, Result};
use sinew_fem::FrozenStiffness;
use sinew_num::{difference, try_in_parallel};
use std::path::Path;

const FILE: &str = "taylor.json";
/// Kind of these predictors, by which a stored one is known.
pub(crate) const KIND: &str = "regression";

/// Predictor by a Taylor expansion, by a regression of simulations, or by a regression of the remainder of the expansion.
#[derive(Clone, Debug)]
pub(crate) struct Regressed {
    /// Expansion whose remainder the regression predicts; `None` if it predicts the displacement.
    pub taylor: Option<Motions>,
    /// `None` where only the Taylor expansion was asked for.
    pub regression: Option<PodRegression>,
}

impl Regressed {
    /// Displacement at θ, node by node \[length\].
    pub(crate) fn at(&self, body: &Body, theta: &[f64]) -> Result<Vec<f64>> {
        let mut field = match &self.regression {
            Some(regression) => regression.predict(theta)?,
            None => vec![0.0; 3 * body.nodes],
        };
        if let Some(taylor) = &self.taylor {
            let expanded = taylor::at(taylor, body, theta)?;
            field.iter_mut().zip(expanded).for_each(|(u, expanded)| *u += expanded);
        }
        Ok(field)
    }

    /// Regression of the fields, or of the remainder of a Taylor expansion if that halves the leave-one-out error. Also
    /// returns that error: root mean square norm, relative to that of the fields.
    pub(crate) fn fit(
        body: &Body,
        taylor: Option<&Motions>,
        thetas: &[Vec<f64>],
        fields: &[Vec<f64>],
    ) -> Result<(Self, f64)> {
        let plain = PodRegression::fit(&body.parameters, thetas, fields)?;
        let error = plain.leave_one_out();
        let plain = (Self { taylor: None, regression: Some(plain) }, error);
        let Some(taylor) = taylor else { return Ok(plain) };
        let left = |(theta, field): (&Vec<f64>, &Vec<f64>)| {
            Ok(difference(field, &taylor::at(taylor, body, theta)?))
        };
        let left: Vec<Vec<f64>> = thetas.iter().zip(fields).map(left).collect::<Result<_>>()?;
        let regression = PodRegression::fit(&body.parameters, thetas, &left)?;
        let error = regression.leave_one_out() * norm(&left) / norm(fields).max(f64::MIN_POSITIVE);
        // A Taylor expansion takes longer to predict.
        if 2.0 * error >= plain.1 {
            return Ok(plain);
        }
        Ok((Self { taylor: Some(taylor.clone()), regression: Some(regression) }, error))
    }

    /// Description of the regression in words.
    pub(crate) fn detail(&self) -> String {
        let Some(regression) = &self.regression else { return String::new() };
        let of = ", of what second order about one solution leaves";
        let of = if self.taylor.is_some() { of } else { "" };
        format!("{} modes, {}{of}", regression.modes(), regression.interpolation())
    }

    /// Reads a folder that [`Predictor::save`] wrote.
    pub(crate) fn load(folder: &Path, body: &Body) -> Result<Self> {
        let taylor = read_json::<Motions>(&folder.join(FILE))?;
        let regression = match PodRegression::load(folder, &body.parameters) {
            Err(Error::NoEmulator { .. }) if taylor.is_some() => None,
            found => Some(found?),
        };
        Ok(Self { taylor, regression })
    }
}

impl Predictor for Regressed {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn predict(&self, body: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>> {
        Ok(try_in_parallel(thetas, |theta| self.at(body, theta))?.concat())
    }

    fn regression(&self) -> Option<&PodRegression> {
        self.regression.as_ref().filter(|_| self.taylor.is_none())
    }

    fn save(&self, folder: &Path) -> Result<()> {
        if let Some(taylor) = &self.taylor {
            write_json(&folder.join(FILE), taylor)?;
        }
        self.regression.as_ref().map_or(Ok(()), |regression| regression.save(folder))
    }
}

fn norm(fields: &[Vec<f64>]) -> f64 {
    fields.iter().flatten().map(|u| u * u).sum::<f64>().sqrt()
}

/// Short name of predictions by it.
const KEY: &str = "frozen-stiffness";

/// Quasi-Newton steps of a prediction: from there one or two Newton steps contract.
const STEPS: usize = 16;

/// Cost of a quasi-Newton step [Newton steps]. A Newton step has a factorisation (measured on a left ventricle of 1570
/// nodes: 1.9 ms against 13 ms).
const STEP: f64 = 0.15;

impl<'b> Emulator<'b> {
    /// Emulator of an unseen body, by quasi-Newton steps from the solution of another body with its stiffness
    /// ([`FrozenStiffness::descend`]). Nothing is trained and nothing prepared for it.
    ///
    /// ```
    /// use sinew_emulate::Emulator;
    /// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::FrozenStiffness;
    /// use sinew_mesh::box_tetrahedra;
    ///
    /// let [block, other] = [0.0, 0.2].map(|waist: f64| {
    ///     let mut mesh = box_tetrahedra([20.0, 10.0, 10.0], [6, 4, 4]);
    ///     mesh.map_points(|[x, y, z]| [x, y * (1.0 - waist * (x / 20.0)), z]);
    ///     let stiffness = |name: &str| Parameter::log(name, "kPa", 2.0..=20.0);
    ///     let scene = Scene::new(mesh, NeoHookean)
    ///         .parameter(stiffness("mu"))
    ///         .parameter(stiffness("lambda"))
    ///         .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
    ///         .support(Support::clamped("x_min"));
    ///     scene.lower().expect("a block")
    /// });
    /// let known = FrozenStiffness::new(&block)?;
    /// let answer = Emulator::frozen_stiffness(&other, &known)?.answer(&[4.0, 12.0], 1e-3)?;
    /// assert!(answer.is_within(1e-3) && answer.steps == 1); // Newton steps of its own
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A body of other cells or supports.
    pub fn frozen_stiffness(body: &'b Body, known: &FrozenStiffness<'b>) -> Result<Self> {
        known.suits(body)?;
        let mut record = Record::new(KEY);
        record.about = format!("from solution and stiffness of {}", known.body().name);
        Ok(Self::new(body, Box::new(known.clone()), record))
    }
}

impl Predictor for FrozenStiffness<'_> {
    fn kind(&self) -> &'static str {
        KEY
    }

    fn predict(&self, body: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>> {
        let found = try_in_parallel(thetas, |theta| self.descend(body, theta, STEPS))?;
        Ok(found.into_iter().flat_map(|refined| refined.displacement).collect())
    }

    fn newton_steps(&self) -> f64 {
        STEPS as f64 * STEP
    }

    fn save(&self, _: &Path) -> Result<()> {
        let what = format!(
            "an emulator of the kind `{KEY}` is not stored: it needs another body's stiffness; keep that body and make it again"
        );
        Err(Error::Refused(what))
    }
}

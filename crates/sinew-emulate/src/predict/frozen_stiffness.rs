//! Solution and factorised stiffness of one body as a predictor of others.

use crate::predict::Predictor;
use crate::store::record::Record;
use crate::{Body, Emulator, Error, Result};
use rayon::prelude::*;
use sinew_fem::FrozenStiffness;
use std::path::Path;

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
        let found = thetas.par_iter().map(|theta| self.descend(body, theta, STEPS));
        let found: Vec<_> = found.collect::<std::result::Result<_, _>>()?;
        Ok(found.into_iter().flat_map(|refined| refined.displacement).collect())
    }

    fn newton_steps(&self) -> f64 {
        STEPS as f64 * STEP
    }

    fn save(&self, _: &Path) -> Result<()> {
        Err(Error::NotStored { kind: KEY })
    }
}

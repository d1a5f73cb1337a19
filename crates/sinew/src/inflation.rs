//! Volumes of cavities over the pressure in them.

use serde::{Deserialize, Serialize};
use sinew_emulate::{Emulator, Error, simulate};
use sinew_energy::{Body, Magnitude, Parameter};

/// Pressures of a curve: a parabola between neighbours is straight to the eye.
const PRESSURES: usize = 9;

/// Volumes of a body's cavities over a pressure of θ, the other parameters in the middle of their ranges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inflation {
    /// Names of the cavities.
    pub cavities: Vec<String>,
    /// The pressure's name with its unit, such as `p [mmHg]`.
    pub pressure: String,
    /// Values of the pressure in that unit, θ by θ.
    pub pressures: Vec<f64>,
    /// θ, rising pressures over their range; those without an equilibrium are left out.
    pub thetas: Vec<Vec<f64>>,
    /// Volumes by the solver \[length³\]: of every cavity, θ by θ.
    pub volumes: Vec<Vec<f64>>,
}

impl Inflation {
    /// Solves for the volumes of a body; `None` without a cavity whose pressure is in θ.
    ///
    /// # Errors
    /// A body that the solver refuses.
    pub fn of(body: &Body) -> Result<Option<Self>, Error> {
        let magnitudes = body.pressures.iter().map(|pressure| pressure.magnitude);
        let mut of_theta = magnitudes.filter_map(|magnitude| match magnitude {
            Magnitude::Theta(index) => Some(index),
            Magnitude::Fixed(_) => None,
        });
        let found = of_theta.next().and_then(|index| Some((index, body.parameters.get(index)?)));
        let Some((parameter, Parameter { name, unit, range: [low, high], .. })) = found else {
            return Ok(None);
        };
        let at = |step: usize| {
            let mut theta = body.centre();
            theta[parameter] = low + (high - low) * step as f64 / (PRESSURES - 1) as f64;
            theta
        };
        let thetas: Vec<_> = (0..PRESSURES).map(at).collect();
        let solved = simulate(body, &thetas, "pressure and volume", None, &mut ())?;
        let inflation = Self {
            cavities: body.cavities.iter().map(|cavity| cavity.name.clone()).collect(),
            pressure: format!("{name} [{}]", unit.name()),
            pressures: solved.thetas.iter().map(|theta| unit.shown(theta[parameter])).collect(),
            volumes: volumes(body, &solved.fields),
            thetas: solved.thetas,
        };
        Ok((!inflation.cavities.is_empty() && !inflation.thetas.is_empty()).then_some(inflation))
    }

    /// The volumes as an emulator predicts them, ordered as [`Inflation::volumes`].
    ///
    /// # Errors
    /// θ that it does not take.
    pub fn predicted(&self, emulator: &Emulator<'_>) -> Result<Vec<Vec<f64>>, Error> {
        let fields = emulator.predict(&self.thetas)?.fields();
        Ok(volumes(emulator.body(), &fields))
    }
}

/// Volumes of every cavity, field by field \[length³\].
fn volumes(body: &Body, fields: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let by_field: Vec<_> = fields.iter().map(|field| body.cavity_volumes(field)).collect();
    (0..body.cavities.len())
        .map(|cavity| by_field.iter().map(|volumes| volumes[cavity]).collect())
        .collect()
}

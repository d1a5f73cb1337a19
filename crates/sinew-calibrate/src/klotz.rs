//! The curve that end-diastolic pressures and volumes of many hearts share.

/// Pressure–volume relation through one pressure and volume: S. Klotz et al., "Single-beat estimation of end-diastolic
/// pressure–volume relationship" (American Journal of Physiology, 2006).
///
/// ```
/// let curve = sinew_calibrate::Klotz::through(12.0, 140.0).expect("a pressure and a volume");
/// assert!((curve.volume(12.0) - 140.0).abs() < 0.5);
/// assert!((curve.volume(30.0) - curve.at_30).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Klotz {
    /// Volume without pressure, in the unit of the volume given.
    pub unloaded: f64,
    /// Volume at 30 mmHg.
    pub at_30: f64,
    /// Factor α of p = α V^β \[mmHg\].
    pub alpha: f64,
    /// Exponent β.
    pub beta: f64,
}

/// Pressure that volumes are normalised at \[mmHg\].
const PRESSURE: f64 = 30.0;
/// Coefficient and exponent of the normalised curve p = A ((V − V₀)/(V₃₀ − V₀))^B \[mmHg\].
const A: f64 = 27.78;
const B: f64 = 2.76;

impl Klotz {
    /// The curve through a pressure \[mmHg\] and a volume; none where they do not make one, as for a pressure of 30 mmHg.
    pub fn through(pressure: f64, volume: f64) -> Option<Self> {
        let unloaded = volume * (0.6 - 0.006 * pressure);
        let at_30 = unloaded + (volume - unloaded) / (pressure / A).powf(1.0 / B);
        let beta = (pressure / PRESSURE).log10() / (volume / at_30).log10();
        let alpha = PRESSURE / at_30.powf(beta);
        let usable = pressure > 0.0 && unloaded > 0.0 && beta > 0.0 && alpha.is_finite();
        usable.then_some(Self { unloaded, at_30, alpha, beta })
    }

    /// Volume at a pressure \[mmHg\]; the unloaded one at 0.
    pub fn volume(&self, pressure: f64) -> f64 {
        if pressure > 0.0 { (pressure / self.alpha).powf(self.beta.recip()) } else { self.unloaded }
    }
}

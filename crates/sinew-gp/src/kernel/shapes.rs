//! The kernels of this crate, by their formulas.

use super::{Formula, Hyperparameter, Measure};
use crate::{Result, Series};
use std::f64::consts::PI;

/// One length for each axis.
fn lengths<const D: usize>(name: &'static str) -> Vec<Hyperparameter> {
    (0..D).map(|axis| Hyperparameter { name, measure: Measure::Length { axis } }).collect()
}

/// ½ Σ (xᵢ − yᵢ)² / λᵢ².
fn half_square<const D: usize>(scales: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
    (0..D).fold(x[0].constant(0.0), |sum, d| sum + ((&x[d] - &y[d]) / &scales[d]).squared() * 0.5)
}

/// exp(−½ Σ (xᵢ − xᵢ′)² / λᵢ²) with a lengthscale per axis (4.46); infinitely smooth.
#[doc(alias("RBF", "Gaussian kernel"))]
pub fn squared_exponential<const D: usize>() -> Formula<D> {
    let formula = |h: &[Series], x: &[Series; D], y: &[Series; D]| (-half_square(h, x, y)).exp();
    let kernel = Formula::new("squared-exponential", lengths::<D>("lengthscale"), formula);
    Formula { closed: true, ..kernel.stationary() }
}

/// Number of derivatives that the functions of a [`matern`] kernel have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothness {
    /// ν = 3/2: one derivative.
    Once = 1,
    /// ν = 5/2: two derivatives.
    Twice = 2,
    /// ν = 7/2: three derivatives.
    Thrice = 3,
}

/// The Matérn kernel of ν = 3/2, 5/2 or 7/2 with a lengthscale per axis (Rasmussen & Williams
/// 2006, eq. 4.16). Its functions have ν − ½ derivatives; operators of higher order are refused.
pub fn matern<const D: usize>(smoothness: Smoothness) -> Formula<D> {
    let p = smoothness as usize;
    let formula =
        move |h: &[Series], x: &[Series; D], y: &[Series; D]| bessel(p, &half_square(h, x, y));
    let name = format!("Matérn {}/2", 2 * p + 1);
    Formula::new(name, lengths::<D>("lengthscale"), formula).smooth(p).stationary()
}

/// The Matérn kernel as a function of s = ½ r²/λ², by its derivatives in s, so that nothing cancels next to x = x′, where the
/// root has no Taylor series. With h_μ(z) = z^μ K_μ(z), of which h_ν is the kernel up to scale at z = √(4 ν s), it holds that
/// (1/z d/dz) h_μ = −h_{μ−1}, hence d/ds h_μ = −2ν h_{μ−1}.
fn bessel(p: usize, s: &Series) -> Series {
    let twice_nu = (2 * p + 1) as f64;
    let z = (2.0 * twice_nu * s.value()).sqrt();
    let mut factor = (-z).exp() / reverse_bessel(p, 0.0);
    s.compose(|m| {
        let polynomial = if m <= p {
            reverse_bessel(p - m, z)
        } else {
            // K_{−μ} = K_μ: h_{−μ} = z^(−2μ) h_μ, with μ = m − p − ½.
            reverse_bessel(m - p - 1, z) / z.powi((2 * (m - p) - 1) as i32)
        };
        factor *= if m > 0 { -twice_nu / m as f64 } else { 1.0 };
        // Where no such derivative exists it meets powers of the difference that vanish faster.
        if polynomial.is_finite() { factor * polynomial } else { 0.0 }
    })
}

/// √(2/π) h_{p+½}(z) e^z for p ≥ 0: the reverse Bessel polynomial of degree p.
fn reverse_bessel(p: usize, z: f64) -> f64 {
    let (mut before, mut at) = (1.0, 1.0);
    for n in 1..=p {
        // θₙ = (2n − 1) θₙ₋₁ + z² θₙ₋₂ with θ₀ = 1, θ₁ = z + 1
        let next = if n == 1 { z + 1.0 } else { (2 * n - 1) as f64 * at + z * z * before };
        (before, at) = (at, next);
    }
    at
}

/// (1 + s/α)^(−α) with s = ½ Σ (xᵢ − xᵢ′)² / λᵢ²: squared exponentials of many lengthscales at
/// once; infinitely smooth (Rasmussen & Williams 2006, eq. 4.19).
pub fn rational_quadratic<const D: usize>() -> Formula<D> {
    let measure = Measure::Number { lower: 0.1, upper: 100.0 };
    let shape = Hyperparameter { name: "shape", measure };
    let known = [lengths::<D>("lengthscale"), vec![shape]].concat();
    let formula = |h: &[Series], x: &[Series; D], y: &[Series; D]| {
        ((half_square(h, x, y) / &h[D] + 1.0).ln() * &h[D] * -1.0).exp()
    };
    Formula::new("rational-quadratic", known, formula).stationary()
}

/// 1 + Σ xᵢ xᵢ′ / λᵢ²: affine functions (1.26).
pub fn linear<const D: usize>() -> Formula<D> {
    let formula = |h: &[Series], x: &[Series; D], y: &[Series; D]| {
        (0..D).fold(x[0].constant(1.0), |sum, d| sum + (&x[d] / &h[d]) * (&y[d] / &h[d]))
    };
    Formula::new("linear", lengths::<D>("length"), formula)
}

/// exp(−2 sin²(π (x − x′) / period) / w²) along an axis: the squared exponential of a point's position on a
/// circle (MacKay 1998; the thesis warps inputs likewise). The width w is in units of the circle's radius.
///
/// # Errors
/// If the period is not finite and above 0.
pub fn periodic<const D: usize>(axis: usize, period: f64) -> Result<Formula<D>> {
    ensure!(
        period.is_finite() && period > 0.0,
        "a periodic kernel of period {period}; give a finite one above 0"
    );
    let measure = Measure::Width { axis, lower: 0.1, upper: 30.0 };
    let width = Hyperparameter { name: "width", measure };
    let formula = move |h: &[Series], x: &[Series; D], y: &[Series; D]| {
        let angle = (&x[axis] - &y[axis]) * (PI / period);
        ((angle.sin() / &h[0]).squared() * -2.0).exp()
    };
    Ok(Formula::new("periodic", vec![width], formula).stationary())
}

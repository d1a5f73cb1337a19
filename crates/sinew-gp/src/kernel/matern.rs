//! Matérn kernels of half-integer order.

use super::Hyperparameter;
use super::axes::Axes;
use super::radial::{Profile, Radial};
use crate::series::Series;

/// How many derivatives the functions of a [`Matern`] kernel have.
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
pub type Matern = Radial<Bessel>;

impl Matern {
    /// On all axes.
    pub fn new(smoothness: Smoothness) -> Self {
        Self { axes: Axes::default(), profile: Bessel { p: smoothness as usize } }
    }

    /// On the axes with these numbers only.
    pub fn along(axes: &[usize], smoothness: Smoothness) -> Self {
        Self { axes: Axes::only(axes), ..Self::new(smoothness) }
    }
}

/// Recurrence of the derivatives. With h_μ(z) = z^μ K_μ(z), of which h_ν is the kernel up to scale at z = √(4 ν s), it holds that
/// (1/z d/dz) h_μ = −h_{μ−1}, hence d/ds h_μ = −2ν h_{μ−1}.
#[derive(Clone, Debug)]
pub struct Bessel {
    /// ν − ½.
    p: usize,
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

impl Profile for Bessel {
    fn name(&self) -> String {
        format!("Matérn {}/2", 2 * self.p + 1)
    }

    fn smoothness(&self) -> Option<usize> {
        Some(self.p)
    }

    fn own(&self) -> Vec<Hyperparameter> {
        Vec::new()
    }

    /// At x = x′, where the root has no Taylor series, by those derivatives that there are.
    fn formula(&self, s: Series, _: &[Series]) -> Series {
        if s.value() == 0.0 {
            let mut slopes = [0.0; 4];
            self.slopes(0.0, &[], &mut slopes[..=self.p]);
            let known = slopes[..=self.p].iter().enumerate().rev();
            return known
                .fold(s.constant(0.0), |sum, (m, slope)| sum * &s / (m as f64 + 1.0) + *slope);
        }
        let z = (s * (2.0 * (2 * self.p + 1) as f64)).sqrt();
        let polynomial = match self.p {
            1 => &z + 1.0,
            2 => &z * &z / 3.0 + &z + 1.0,
            _ => z.powi(3) / 15.0 + z.powi(2) * 0.4 + &z + 1.0,
        };
        polynomial * (-z).exp()
    }

    fn slopes(&self, s: f64, _: &[f64], slopes: &mut [f64]) {
        let twice_nu = (2 * self.p + 1) as f64;
        let z = (2.0 * twice_nu * s).sqrt();
        let scale = (-z).exp() / reverse_bessel(self.p, 0.0);
        let mut factor = scale;
        for (m, slope) in slopes.iter_mut().enumerate() {
            let polynomial = if m <= self.p {
                reverse_bessel(self.p - m, z)
            } else {
                // K_{−μ} = K_μ: h_{−μ} = z^(−2μ) h_μ, with μ = m − p − ½.
                let mu = m - self.p - 1;
                reverse_bessel(mu, z) / z.powi((2 * mu + 1) as i32)
            };
            // Where no such derivative exists it meets powers of the difference that vanish faster.
            *slope = if polynomial.is_finite() { factor * polynomial } else { 0.0 };
            factor *= -twice_nu;
        }
    }
}

//! Matérn kernels of half-integer order.

use sinew_num::Series;

use super::axes::Axes;
use super::radial::{self, Profile};
use super::squared_exponential::{half_square, lengthscales};
use super::{Hyperparameter, Kernel, Orders, Pairs};

/// How many derivatives the functions of a [`Matern`] kernel have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothness {
    /// ν = 3/2: one derivative.
    Once,
    /// ν = 5/2: two derivatives.
    Twice,
    /// ν = 7/2: three derivatives.
    Thrice,
}

/// The Matérn kernel of ν = 3/2, 5/2 or 7/2 with a lengthscale per axis (Rasmussen & Williams
/// 2006, eq. 4.16). Its functions have ν − ½ derivatives; operators of higher order are refused.
#[derive(Clone, Debug)]
pub struct Matern {
    axes: Axes,
    smoothness: Smoothness,
}

impl Matern {
    /// On all axes.
    pub fn new(smoothness: Smoothness) -> Self {
        Self { axes: Axes::default(), smoothness }
    }

    /// On the axes with these numbers only.
    pub fn along(axes: &[usize], smoothness: Smoothness) -> Self {
        Self { axes: Axes::only(axes), smoothness }
    }

    /// ν − ½.
    fn derivatives_of_functions(&self) -> usize {
        match self.smoothness {
            Smoothness::Once => 1,
            Smoothness::Twice => 2,
            Smoothness::Thrice => 3,
        }
    }
}

/// With h_μ(z) = z^μ K_μ(z), of which h_ν is the kernel up to scale at z = √(4 ν s), it holds that
/// (1/z d/dz) h_μ = −h_{μ−1}, hence d/ds h_μ = −2ν h_{μ−1}.
struct Bessel {
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
    fn slopes(&self, s: f64, slopes: &mut [f64]) {
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

impl<const D: usize> Kernel<D> for Matern {
    fn name(&self) -> String {
        format!("Matérn {}/2", 2 * self.derivatives_of_functions() + 1)
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        lengthscales(self.axes.of::<D>())
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { axes: self.axes.among::<D>(axes), ..self.clone() })
    }

    /// At x = x′ a Taylor series of it does not exist; derivatives come in closed form.
    fn formula(&self, lengthscales: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let p = self.derivatives_of_functions();
        let s = half_square(self.axes.of::<D>(), lengthscales, x, y);
        if s.value() == 0.0 {
            return x[0].constant(1.0);
        }
        let z = (s * (2.0 * (2 * p + 1) as f64)).sqrt();
        let polynomial = match self.smoothness {
            Smoothness::Once => &z + 1.0,
            Smoothness::Twice => &z * &z / 3.0 + &z + 1.0,
            Smoothness::Thrice => z.powi(3) / 15.0 + z.powi(2) * 0.4 + &z + 1.0,
        };
        polynomial * (-z).exp()
    }

    fn smoothness(&self) -> Option<usize> {
        Some(self.derivatives_of_functions())
    }

    fn is_stationary(&self) -> bool {
        true
    }

    fn derivatives(
        &self,
        lengthscales: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        table: &mut [f64],
    ) {
        let profile = Bessel { p: self.derivatives_of_functions() };
        radial::derivatives(&profile, self.axes.of::<D>(), lengthscales, pairs, orders, table);
    }

    fn pull_back(
        &self,
        lengthscales: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        let profile = Bessel { p: self.derivatives_of_functions() };
        radial::pull_back(
            &profile,
            self.axes.of::<D>(),
            lengthscales,
            pairs,
            orders,
            weights,
            gradient,
        );
    }
}

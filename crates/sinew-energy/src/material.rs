//! A law at the quadrature points of a body, whatever the law is.

use crate::lower::geometry::orthonormal;
use crate::{Barriers, Exact, Law, Response};
use sinew_num::Mat3;
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// A strain-energy law with its material directions at every quadrature point of a body: what a [`crate::Body`]
/// is made of, without the law's type.
///
/// Every [`Law`] is one by [`at_points`]. Parameters are those of the law, in the order of
/// [`Material::parameters`]; H = ∂u/∂X is the displacement gradient at the point.
pub trait Material: Debug + Send + Sync {
    /// Name of the law, with its source.
    fn name(&self) -> &'static str;
    /// Names of the law's parameters, which come first in θ.
    fn parameters(&self) -> &[&'static str];
    /// Values of a parameter that make sense.
    fn bounds(&self, index: usize) -> RangeInclusive<f64>;
    /// Number of points; `None` for an isotropic law, which is the same everywhere.
    fn points(&self) -> Option<usize>;
    /// Unit material directions at a point; none for an isotropic law.
    fn directions(&self, point: usize) -> &[[f64; 3]];
    /// Energy density \[stress\]; +∞ outside the law's domain, unless barriers keep it finite.
    fn energy(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> f64;
    /// Energy density and first Piola–Kirchhoff stress ∂Ψ/∂H \[stress\].
    fn stress(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> (f64, Mat3<f64>);
    /// Energy density, stress and tangent \[stress\], without barriers.
    fn response(&self, point: usize, parameters: &[f64], h: &Mat3<f64>) -> Response;
    /// The material of [`Law::with_softer_volume`], where there is one.
    fn with_softer_volume(&self, factor: f64) -> Option<Arc<dyn Material>>;
    /// The material with its energy multiplied by a factor at each point.
    fn stiffened(&self, factors: Vec<f64>) -> Arc<dyn Material>;
    /// The material whose directions go with maps f of their points: d becomes f d / |f d|, those after the first orthonormal to the
    /// ones before. `None` where there are no directions.
    fn carried(&self, maps: &[Mat3<f64>]) -> Option<Arc<dyn Material>>;
    /// Change of the stress with the parameters along `rates`, one per parameter: `∂²Ψ/∂H∂θ · rates`.
    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64>;
}

/// A law with one row of directions per quadrature point.
#[derive(Debug)]
struct AtPoints<L, const D: usize> {
    law: L,
    /// Takes no storage for isotropic laws.
    directions: Vec<[[f64; 3]; D]>,
    /// Factor of the energy at each point; empty if it is one everywhere.
    factors: Vec<f64>,
}

/// The material of a law with its directions, one row per quadrature point; an isotropic law reads none.
///
/// A point beyond the rows is outside the law's domain, where the energy is +∞; the solver tells it as an error.
///
/// ```
/// use sinew_energy::{at_points, laws::NeoHookean};
/// use sinew_num::Mat3;
///
/// let material = at_points(NeoHookean, vec![]);
/// assert_eq!(material.parameters(), ["mu", "lambda"]);
/// assert_eq!(material.energy(0, &[1.0, 2.0], &Mat3::ZERO, None), 0.0);
/// ```
pub fn at_points<L: Law<D>, const D: usize>(
    law: L,
    directions: Vec<[[f64; 3]; D]>,
) -> Arc<dyn Material> {
    Arc::new(AtPoints { law, directions, factors: Vec::new() })
}

impl<L: Law<D>, const D: usize> AtPoints<L, D> {
    /// Directions at a point, if there are any for it.
    #[inline]
    fn at(&self, point: usize) -> Option<&[[f64; 3]; D]> {
        if D == 0 { Some(&[[0.0; 3]; D]) } else { self.directions.get(point) }
    }

    /// Factor of the energy at a point.
    #[inline]
    fn factor(&self, point: usize) -> f64 {
        if self.factors.is_empty() { 1.0 } else { self.factors[point] }
    }
}

impl<L: Law<D>, const D: usize> Material for AtPoints<L, D> {
    fn name(&self) -> &'static str {
        L::NAME
    }

    fn parameters(&self) -> &[&'static str] {
        L::PARAMETERS
    }

    fn bounds(&self, index: usize) -> RangeInclusive<f64> {
        L::bounds(index)
    }

    fn points(&self) -> Option<usize> {
        match self.factors.len() {
            0 => (D > 0).then_some(self.directions.len()),
            points => Some(points),
        }
    }

    fn directions(&self, point: usize) -> &[[f64; 3]] {
        self.at(point).map_or(&[], <[_; D]>::as_slice)
    }

    fn energy(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> f64 {
        let Some(directions) = self.at(point) else { return f64::INFINITY };
        let energy = match barriers {
            None => self.law.energy(parameters, h, directions, &Exact),
            Some(barriers) => self.law.energy(parameters, h, directions, barriers),
        };
        self.factor(point) * energy
    }

    fn stress(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> (f64, Mat3<f64>) {
        let Some(directions) = self.at(point) else { return (f64::INFINITY, Mat3::ZERO) };
        let (energy, stress) = match barriers {
            None => self.law.stress(parameters, h, directions, &Exact),
            Some(barriers) => self.law.stress(parameters, h, directions, barriers),
        };
        let factor = self.factor(point);
        (factor * energy, times(factor, &stress))
    }

    fn response(&self, point: usize, parameters: &[f64], h: &Mat3<f64>) -> Response {
        let Some(directions) = self.at(point) else { return Response::INADMISSIBLE };
        let found = self.law.response(parameters, h, directions);
        if self.factors.is_empty() {
            return found;
        }
        let factor = self.factor(point);
        let tangent = found.tangent.map(|row| row.map(|entry| factor * entry));
        Response { energy: factor * found.energy, stress: times(factor, &found.stress), tangent }
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Arc<dyn Material>> {
        let law = self.law.with_softer_volume(factor)?;
        let (directions, factors) = (self.directions.clone(), self.factors.clone());
        Some(Arc::new(Self { law, directions, factors }))
    }

    fn stiffened(&self, mut factors: Vec<f64>) -> Arc<dyn Material> {
        factors.iter_mut().enumerate().for_each(|(point, factor)| *factor *= self.factor(point));
        let (law, directions) = (self.law.clone(), self.directions.clone());
        Arc::new(Self { law, directions, factors })
    }

    fn carried(&self, maps: &[Mat3<f64>]) -> Option<Arc<dyn Material>> {
        if D == 0 {
            return None;
        }
        let rows = self.directions.iter().zip(maps);
        let directions = rows.map(|(row, map)| orthonormal(row.map(|d| map.apply(&d))).0).collect();
        let (law, factors) = (self.law.clone(), self.factors.clone());
        Some(Arc::new(Self { law, directions, factors }))
    }

    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64> {
        let Some(directions) = self.at(point) else { return Mat3([[f64::NAN; 3]; 3]) };
        times(self.factor(point), &self.law.stress_rate(parameters, rates, h, directions))
    }
}

#[inline]
fn times(factor: f64, stress: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| factor * stress.at(i, j))
}

//! A law at the quadrature points of a body, whatever the law is.

use crate::mapped::{ParameterMap, Parameters};
use crate::{Barriers, Exact, Law, Response};
use sinew_num::Mat3;
use std::fmt::Debug;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// A strain-energy law with its material directions at every quadrature point of a body: what a [`crate::Body`]
/// is made of, without the law's type.
///
/// Every [`Law`] is one by [`Law::along`]. Parameters are those of the law, in the order of
/// [`Material::parameters`]; H = ∂u/∂X is the displacement gradient at the point. In a [`crate::Scene`] the rows of directions may
/// be those of cells or nodes instead, which [`crate::Scene::lower`] brings to the points.
pub trait Material: Debug + Send + Sync {
    /// Facts about the law.
    fn law(&self) -> LawFacts;
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
    /// The material with known values of some of the parameters that it lists.
    fn with_known(&self, held: &[Option<f64>]) -> Arc<dyn Material>;
    /// The material with one of the parameters that it lists times a factor at each point.
    fn with_factors(&self, parameter: usize, factors: Vec<f64>) -> Arc<dyn Material>;
    /// The material with other unit directions, those of a point one after the other, point by point.
    fn with_directions(&self, directions: Vec<[f64; 3]>) -> Arc<dyn Material>;
    /// Change of the stress with the parameters along `rates`, one per parameter: `∂²Ψ/∂H∂θ · rates`.
    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64>;
}

/// Facts about the law of a [`Material`].
#[derive(Clone, Debug, PartialEq)]
pub struct LawFacts {
    /// Name of the law, with its source.
    pub name: &'static str,
    /// Number of material directions that it reads; none for an isotropic law.
    pub directions: usize,
    /// Names and values of the constants that the law holds itself.
    pub constants: Vec<(&'static str, f64)>,
}

/// Material of a [`crate::Scene`]: an isotropic law as it is, or any law with its directions ([`Law::along`]).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an isotropic law",
    note = "a law with fibres becomes a material by `law.along(directions)`"
)]
pub trait IntoMaterial {
    /// The material.
    fn into_material(self) -> Arc<dyn Material>;
}

impl<L: Law<0>> IntoMaterial for L {
    fn into_material(self) -> Arc<dyn Material> {
        self.along(Vec::new())
    }
}

impl IntoMaterial for Arc<dyn Material> {
    fn into_material(self) -> Arc<dyn Material> {
        self
    }
}

/// A law with one row of directions per quadrature point.
#[derive(Clone, Debug)]
pub(crate) struct AtPoints<L, const D: usize> {
    law: L,
    /// Takes no storage for isotropic laws.
    directions: Vec<[[f64; 3]; D]>,
    /// Factor of the energy at each point; empty if it is one everywhere.
    factors: Vec<f64>,
    /// Map from θ to the law's parameters, unless they are the same.
    map: Option<ParameterMap>,
}

impl<L: Law<D>, const D: usize> AtPoints<L, D> {
    pub(crate) fn new(law: L, directions: Vec<[[f64; 3]; D]>) -> Self {
        Self { law, directions, factors: Vec::new(), map: None }
    }

    /// Directions at a point, if there are any for it.
    #[inline]
    fn along(&self, point: usize) -> Option<&[[f64; 3]; D]> {
        if D == 0 { Some(&[[0.0; 3]; D]) } else { self.directions.get(point) }
    }

    /// Value of the law's parameters and the directions at a point, if there are any for it.
    #[inline]
    fn at<T>(
        &self,
        point: usize,
        listed: &[f64],
        value: impl FnOnce(&[f64], &[[f64; 3]; D]) -> T,
    ) -> Option<T> {
        let directions = self.along(point)?;
        let mapped: Parameters;
        let parameters = match &self.map {
            None => listed,
            Some(map) => {
                mapped = map.at(point, listed);
                &mapped
            }
        };
        Some(value(parameters, directions))
    }

    fn mapped(&self) -> ParameterMap {
        self.map.clone().unwrap_or_else(|| ParameterMap::of(L::PARAMETERS))
    }

    /// Factor of the energy at a point.
    #[inline]
    fn factor(&self, point: usize) -> f64 {
        if self.factors.is_empty() { 1.0 } else { self.factors[point] }
    }
}

// What is never inlined is compiled once for all crates: the laws of the table in this one, at its level of optimisation.
impl<L: Law<D>, const D: usize> Material for AtPoints<L, D> {
    fn law(&self) -> LawFacts {
        LawFacts { name: L::NAME, directions: D, constants: self.law.constants() }
    }

    fn parameters(&self) -> &[&'static str] {
        self.map.as_ref().map_or(L::PARAMETERS, |map| &map.names)
    }

    fn bounds(&self, index: usize) -> RangeInclusive<f64> {
        L::bounds(self.map.as_ref().map_or(index, |map| map.places[index]))
    }

    fn points(&self) -> Option<usize> {
        let scaled = self.map.iter().flat_map(|map| &map.scaled).map(|(_, factors)| factors.len());
        let factors = scaled.chain([self.factors.len()]).find(|&points| points > 0);
        factors.or_else(|| (D > 0).then_some(self.directions.len()))
    }

    fn directions(&self, point: usize) -> &[[f64; 3]] {
        self.along(point).map_or(&[], <[_; D]>::as_slice)
    }

    #[inline(never)]
    fn energy(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> f64 {
        let energy = self.at(point, parameters, |parameters, directions| match barriers {
            None => self.law.energy(parameters, h, directions, &Exact),
            Some(barriers) => self.law.energy(parameters, h, directions, barriers),
        });
        energy.map_or(f64::INFINITY, |energy| self.factor(point) * energy)
    }

    #[inline(never)]
    fn stress(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> (f64, Mat3<f64>) {
        let found = self.at(point, parameters, |parameters, directions| match barriers {
            None => self.law.stress(parameters, h, directions, &Exact),
            Some(barriers) => self.law.stress(parameters, h, directions, barriers),
        });
        let Some((energy, stress)) = found else { return (f64::INFINITY, Mat3::ZERO) };
        let factor = self.factor(point);
        (factor * energy, times(factor, &stress))
    }

    #[inline(never)]
    fn response(&self, point: usize, parameters: &[f64], h: &Mat3<f64>) -> Response {
        let found = self.at(point, parameters, |p, directions| self.law.response(p, h, directions));
        let Some(found) = found else { return Response::INADMISSIBLE };
        if self.factors.is_empty() { found } else { stiffened(self.factor(point), &found) }
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Arc<dyn Material>> {
        let law = self.law.with_softer_volume(factor)?;
        Some(Arc::new(Self { law, ..self.clone() }))
    }

    fn stiffened(&self, mut factors: Vec<f64>) -> Arc<dyn Material> {
        factors.iter_mut().enumerate().for_each(|(point, factor)| *factor *= self.factor(point));
        Arc::new(Self { factors, ..self.clone() })
    }

    fn with_known(&self, held: &[Option<f64>]) -> Arc<dyn Material> {
        Arc::new(Self { map: Some(self.mapped().known(held)), ..self.clone() })
    }

    fn with_factors(&self, parameter: usize, factors: Vec<f64>) -> Arc<dyn Material> {
        let mut map = self.mapped();
        map.scaled.push((map.places[parameter], factors));
        Arc::new(Self { map: Some(map), ..self.clone() })
    }

    fn with_directions(&self, directions: Vec<[f64; 3]>) -> Arc<dyn Material> {
        let rows = directions.chunks_exact(D.max(1));
        let directions = rows.map(|row| std::array::from_fn(|d| row[d])).collect();
        Arc::new(Self { directions, ..self.clone() })
    }

    #[inline(never)]
    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64> {
        let rates = self.map.as_ref().map_or_else(|| rates.into(), |map| map.rates(point, rates));
        let rate = self.at(point, parameters, |parameters, directions| {
            self.law.stress_rate(parameters, &rates, h, directions)
        });
        rate.map_or(Mat3([[f64::NAN; 3]; 3]), |rate| times(self.factor(point), &rate))
    }
}

#[inline]
fn times(factor: f64, stress: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| factor * stress.at(i, j))
}

fn stiffened(factor: f64, found: &Response) -> Response {
    let tangent = found.tangent.map(|row| row.map(|entry| factor * entry));
    Response { energy: factor * found.energy, stress: times(factor, &found.stress), tangent }
}

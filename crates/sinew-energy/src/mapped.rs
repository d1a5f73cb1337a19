//! A material whose parameters are read from fewer entries of θ, or times a factor.

use crate::{Barriers, LawFacts, Material, Response};
use sinew_num::Mat3;
use smallvec::SmallVec;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Parameters of one point; on the stack for up to sixteen.
type Parameters = SmallVec<[f64; 16]>;

/// A material with known parameters, or with one that has a factor at each point.
#[derive(Clone, Debug)]
pub(crate) struct Mapped {
    material: Arc<dyn Material>,
    /// Names of the parameters that θ lists, and their places among all.
    names: Vec<&'static str>,
    places: Vec<usize>,
    /// Values of all parameters; those that θ lists are filled in.
    values: Parameters,
    /// Place of a parameter, and its factors point by point.
    scaled: Option<(usize, Vec<f64>)>,
}

impl Mapped {
    /// Known values of some parameters.
    pub(crate) fn known(material: Arc<dyn Material>, held: &[Option<f64>]) -> Self {
        let places: Vec<_> = (0..held.len()).filter(|&index| held[index].is_none()).collect();
        let names = places.iter().map(|&index| material.parameters()[index]).collect();
        let values = held.iter().map(|value| value.unwrap_or_default()).collect();
        Self { material, names, places, values, scaled: None }
    }

    /// One parameter times a factor at each point.
    pub(crate) fn scaled(material: Arc<dyn Material>, place: usize, factors: Vec<f64>) -> Self {
        let all = vec![None; material.parameters().len()];
        Self { scaled: Some((place, factors)), ..Self::known(material, &all) }
    }

    fn with(&self, material: Arc<dyn Material>) -> Arc<dyn Material> {
        Arc::new(Self { material, ..self.clone() })
    }

    /// Entries of all parameters at a point: those of θ among others.
    fn among(&self, mut all: Parameters, point: usize, listed: &[f64]) -> Parameters {
        self.places.iter().zip(listed).for_each(|(&place, &value)| all[place] = value);
        if let Some((place, factors)) = &self.scaled {
            all[*place] *= factors[point];
        }
        all
    }

    fn at(&self, point: usize, listed: &[f64]) -> Parameters {
        self.among(self.values.clone(), point, listed)
    }
}

impl Material for Mapped {
    fn law(&self) -> LawFacts {
        self.material.law()
    }

    fn parameters(&self) -> &[&'static str] {
        &self.names
    }

    fn bounds(&self, index: usize) -> RangeInclusive<f64> {
        self.material.bounds(self.places[index])
    }

    fn points(&self) -> Option<usize> {
        self.scaled.as_ref().map(|(_, factors)| factors.len()).or_else(|| self.material.points())
    }

    fn directions(&self, point: usize) -> &[[f64; 3]] {
        self.material.directions(point)
    }

    fn energy(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> f64 {
        self.material.energy(point, &self.at(point, parameters), h, barriers)
    }

    fn stress(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> (f64, Mat3<f64>) {
        self.material.stress(point, &self.at(point, parameters), h, barriers)
    }

    fn response(&self, point: usize, parameters: &[f64], h: &Mat3<f64>) -> Response {
        self.material.response(point, &self.at(point, parameters), h)
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Arc<dyn Material>> {
        Some(self.with(self.material.with_softer_volume(factor)?))
    }

    fn stiffened(&self, factors: Vec<f64>) -> Arc<dyn Material> {
        self.with(self.material.stiffened(factors))
    }

    fn with_directions(&self, directions: Vec<[f64; 3]>) -> Arc<dyn Material> {
        self.with(self.material.with_directions(directions))
    }

    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64> {
        let rates = self.among(SmallVec::from_elem(0.0, self.values.len()), point, rates);
        self.material.stress_rate(point, &self.at(point, parameters), &rates, h)
    }
}

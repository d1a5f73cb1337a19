//! Parameters whose values are known, so that θ does not list them.

use crate::{Barriers, Body, ForceBalance, Magnitude, Material, Parameter, Response, SceneError};
use sinew_num::Mat3;
use std::ops::RangeInclusive;
use std::sync::Arc;

impl Body {
    /// Body with known values of some parameters, of its law or its loads: θ lists the others, and emulators learn in those
    /// alone. A body of a [`ForceBalance`] takes [`ForceBalance::with_known`], as the balance has loads of its own.
    ///
    /// ```
    /// use sinew_energy::{Parameter, Scene, Support, laws::{ByYoungPoisson, NeoHookean}};
    /// use sinew_mesh::box_tetrahedra;
    ///
    /// let body = Scene::new(box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]), ByYoungPoisson(NeoHookean))
    ///     .parameter(Parameter::log("E", "kPa", 8.0..=16.0))
    ///     .parameter(Parameter::log("nu", "1", 0.3..=0.45))
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let stretched: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.0, 0.0]).collect();
    /// let energy = body.value(&stretched, &[10.0, 0.4]);
    /// let body = body.with_known(&[("nu", 0.4)])?;
    /// assert_eq!(body.parameters.len(), 1);
    /// assert_eq!(body.value(&stretched, &[10.0]), energy);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    ///
    /// A tension that is known acts from the first load step on; one that θ lists grows with the loads.
    ///
    /// # Errors
    /// A name that is not a parameter or is there twice, or a value that makes no sense.
    pub fn with_known(mut self, known: &[(&str, f64)]) -> Result<Self, SceneError> {
        let held = self.held(known)?;
        self.hold(&held);
        Ok(self)
    }

    /// Known values of the parameters, in their order.
    fn held(&self, known: &[(&str, f64)]) -> Result<Vec<Option<f64>>, SceneError> {
        let of_law = self.material.parameters().len();
        let mut held = vec![None; self.parameters.len().max(of_law)];
        for &(name, value) in known {
            let named = |p: &Parameter| p.name == name;
            let Some(index) = self.parameters.iter().position(named) else {
                let known = self.parameters.iter().map(|p| p.name.clone()).collect();
                return Err(SceneError::UnknownParameter { name: name.into(), known });
            };
            if !value.is_finite() {
                let what = format!("the known value of `{name}`");
                return Err(SceneError::NotFinite { what, value });
            }
            let bounds = if index < of_law { self.material.bounds(index) } else { value..=value };
            if !bounds.contains(&value) {
                let (least, most) = (*bounds.start(), *bounds.end());
                return Err(SceneError::KnownValue { name: name.into(), value, least, most });
            }
            if held[index].replace(value).is_some() {
                return Err(SceneError::KnownTwice { name: name.into() });
            }
        }
        Ok(held)
    }

    fn hold(&mut self, held: &[Option<f64>]) {
        let of_law = &held[..self.material.parameters().len()];
        if of_law.iter().any(Option::is_some) {
            self.material = Arc::new(Known::new(self.material.clone(), of_law));
        }
        self.pressures.iter_mut().for_each(|pressure| pressure.magnitude.hold(held));
        let known = |(p, value): (&Parameter, &Option<f64>)| Some((p.name.clone(), (*value)?));
        self.known.extend(self.parameters.iter().zip(held).filter_map(known));
        let mut held = held.iter();
        self.parameters.retain(|_| held.next().is_none_or(Option::is_none));
    }
}

impl ForceBalance {
    /// Balance with known values of some parameters, see [`Body::with_known`].
    ///
    /// # Errors
    /// As [`Body::with_known`].
    pub fn with_known(mut self, known: &[(&str, f64)]) -> Result<Self, SceneError> {
        let held = self.body.held(known)?;
        self.body.hold(&held);
        self.followers.iter_mut().for_each(|follower| follower.magnitude.hold(&held));
        Ok(self)
    }
}

impl Magnitude {
    /// Takes a known value in, or the place among the entries of θ that are left.
    fn hold(&mut self, held: &[Option<f64>]) {
        if let Self::Theta(index) = *self {
            let before = held.iter().take(index).flatten().count();
            let value = held.get(index).copied().flatten();
            *self = value.map_or(Self::Theta(index - before), Self::Fixed);
        }
    }
}

/// A material some of whose parameters are known.
#[derive(Debug)]
struct Known {
    material: Arc<dyn Material>,
    /// Names of the parameters that are left, and their places among all.
    names: Vec<&'static str>,
    places: Vec<usize>,
    /// Values of all parameters; those that are left are filled in.
    values: Vec<f64>,
}

impl Known {
    fn new(material: Arc<dyn Material>, held: &[Option<f64>]) -> Self {
        let places: Vec<_> = (0..held.len()).filter(|&index| held[index].is_none()).collect();
        let names = places.iter().map(|&index| material.parameters()[index]).collect();
        let values = held.iter().map(|value| value.unwrap_or_default()).collect();
        Self { material, names, places, values }
    }

    /// All entries from those that are left, beside these.
    fn among(&self, mut all: Vec<f64>, left: &[f64]) -> Vec<f64> {
        self.places.iter().zip(left).for_each(|(&place, &value)| all[place] = value);
        all
    }

    fn whole(&self, parameters: &[f64]) -> Vec<f64> {
        self.among(self.values.clone(), parameters)
    }

    fn with(&self, material: Arc<dyn Material>) -> Arc<dyn Material> {
        let Self { names, places, values, .. } = self;
        let (names, places, values) = (names.clone(), places.clone(), values.clone());
        Arc::new(Self { material, names, places, values })
    }
}

impl Material for Known {
    fn name(&self) -> &'static str {
        self.material.name()
    }

    fn parameters(&self) -> &[&'static str] {
        &self.names
    }

    fn bounds(&self, index: usize) -> RangeInclusive<f64> {
        self.material.bounds(self.places[index])
    }

    fn points(&self) -> Option<usize> {
        self.material.points()
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
        self.material.energy(point, &self.whole(parameters), h, barriers)
    }

    fn stress(
        &self,
        point: usize,
        parameters: &[f64],
        h: &Mat3<f64>,
        barriers: Option<&Barriers>,
    ) -> (f64, Mat3<f64>) {
        self.material.stress(point, &self.whole(parameters), h, barriers)
    }

    fn response(&self, point: usize, parameters: &[f64], h: &Mat3<f64>) -> Response {
        self.material.response(point, &self.whole(parameters), h)
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Arc<dyn Material>> {
        Some(self.with(self.material.with_softer_volume(factor)?))
    }

    fn stiffened(&self, factors: Vec<f64>) -> Arc<dyn Material> {
        self.with(self.material.stiffened(factors))
    }

    fn carried(&self, maps: &[Mat3<f64>]) -> Option<Arc<dyn Material>> {
        Some(self.with(self.material.carried(maps)?))
    }

    fn stress_rate(
        &self,
        point: usize,
        parameters: &[f64],
        rates: &[f64],
        h: &Mat3<f64>,
    ) -> Mat3<f64> {
        let rates = self.among(vec![0.0; self.values.len()], rates);
        self.material.stress_rate(point, &self.whole(parameters), &rates, h)
    }
}

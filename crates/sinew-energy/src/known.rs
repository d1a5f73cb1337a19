//! Parameters whose values are known, so that θ does not list them.

use crate::error::unknown_parameter;
use crate::{Body, Magnitude, Parameter, SceneError};

impl Body {
    /// Body with known values of some parameters, of its law or its loads: θ lists the others, and emulators learn in those
    /// alone.
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
        let body = &mut self.0;
        let of_law = &held[..body.material.parameters().len()];
        if of_law.iter().any(Option::is_some) {
            body.material = body.material.with_known(of_law);
        }
        let surfaces = body.pressures.iter_mut().chain(&mut body.followers);
        surfaces.for_each(|surface| surface.magnitude.hold(&held));
        let known = |(p, value): (&Parameter, &Option<f64>)| Some((p.name.clone(), (*value)?));
        body.known.extend(body.parameters.iter().zip(&held).filter_map(known));
        let mut held = held.iter();
        body.parameters.retain(|_| held.next().is_none_or(Option::is_none));
        Ok(self)
    }

    /// Known values of the parameters, in their order.
    fn held(&self, known: &[(&str, f64)]) -> Result<Vec<Option<f64>>, SceneError> {
        let of_law = self.material.parameters().len();
        let mut held = vec![None; self.parameters.len().max(of_law)];
        for &(name, value) in known {
            let named = |p: &Parameter| p.name == name;
            let Some(index) = self.parameters.iter().position(named) else {
                let known: Vec<_> = self.parameters.iter().map(|p| &p.name).collect();
                return Err(unknown_parameter(name, &known));
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
                return Err(SceneError::Body(format!(
                    "`{name}` is there twice among the known parameters; keep one value"
                )));
            }
        }
        Ok(held)
    }
}

impl Magnitude {
    /// Replaces an entry of θ by its known value, or renumbers it among the remaining entries.
    fn hold(&mut self, held: &[Option<f64>]) {
        if let Self::Theta(index) = *self {
            let before = held.iter().take(index).flatten().count();
            let value = held.get(index).copied().flatten();
            *self = value.map_or(Self::Theta(index - before), Self::Fixed);
        }
    }
}

//! A body lowered on an image, its states under other loads, and their observables.

mod anchor;
mod builder;
mod parts;

pub use builder::PatientBuilder;
pub use parts::{PatientStates, StateError};

use crate::observables::Quantity;
use crate::{Forward, ForwardError, Observed};
use anchor::Anchor;
use parts::{Parts, Result};
use sinew_energy::{Body, Fibres};
use sinew_num::dot;
use std::sync::{Arc, OnceLock, RwLock};

/// A body imaged under load, unloaded for each θ and loaded again in phases, with its observables.
///
/// θ are the parameters of the patient, in the unit of the scene: parameters of the law and, where [`crate::Setting`]s say so, factors
/// of loads. Each state of each θ is solved from a prediction by solved θ, the start or those that [`Forward::expect_among`] was told,
/// so that numbers depend on θ alone, not on the order of calls or the number of threads.
///
/// ```
/// use sinew_calibrate::{Forward, Observable, Patient};
/// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_mesh::TruncatedEllipsoid;
///
/// // A rubber cup that was imaged under a pressure of 1 kPa.
/// let wall = TruncatedEllipsoid::LAND.wall([1, 8, 4]).tetrahedra();
/// let image = Scene::new(wall, NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 5.0..=50.0))
///     .parameter(Parameter::log("lambda", "kPa", 20.0..=200.0))
///     .parameter(Parameter::linear("pressure", "kPa", 0.0..=3.0))
///     .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
///     .support(Support::clamped("base"))
///     .lower()?;
/// let patient = Patient::of(&image)
///     .parameters(["mu", "lambda"])
///     .image([("pressure", 1.0)])
///     .phase("filled", [("pressure", 2.0)])
///     .observe(Observable::volume("endo", "rest"))
///     .observe(Observable::volume("endo", "filled"))
///     .build()?;
/// let seen = patient.observe(&[20.0, 80.0], true)?;
/// let loaded = image.cavity_volumes(&vec![0.0; 3 * image.nodes])[0];
/// assert!(seen.values[0] < loaded && loaded < seen.values[1]); // mm³
///
/// // The softer the rubber, the smaller it was at rest.
/// assert!(seen.jacobian[0][0] > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Patient<'p> {
    parts: Parts<'p>,
    quantities: Vec<Box<dyn Quantity>>,
    /// θ of the anchor.
    start: Vec<f64>,
    anchor: OnceLock<Option<Anchor<'p>>>,
    /// θ among which most solves are expected.
    focus: RwLock<Option<Arc<Anchor<'p>>>>,
}

impl<'p> Patient<'p> {
    /// A patient of a body that was lowered on the image; its pressures may act on surfaces with a loose rim.
    pub fn of(image: &'p Body) -> PatientBuilder<'p> {
        PatientBuilder {
            image,
            parameters: Vec::new(),
            settings: Vec::new(),
            phases: Vec::new(),
            fibres: Some(Fibres::Carried),
            start: None,
            wall: None,
            segments: None,
            observables: Vec::new(),
            accuracy: 0.0,
        }
    }

    /// All states at θ, solved from a prediction about the start; without a start, checked by loading from rest.
    ///
    /// # Errors
    /// θ that makes no sense, no body at rest, or no stable equilibrium at a phase.
    pub fn states(&self, theta: &[f64], derivatives: bool) -> Result<PatientStates> {
        self.parts.check(theta)?;
        let focus = self.focus();
        let near = [focus.as_deref(), self.anchor()].into_iter().flatten();
        let near = near.min_by(|a, b| a.reach(theta).total_cmp(&b.reach(theta)));
        self.parts.solve(theta, near, derivatives)
    }

    /// States at θ in the order in which the phases were added, up to the first phase without a stable equilibrium; and why it has none.
    ///
    /// # Errors
    /// θ that makes no sense, or no body at rest.
    pub fn states_reached(&self, theta: &[f64]) -> Result<(PatientStates, Option<StateError>)> {
        self.parts.check(theta)?;
        self.parts.reached(theta, self.focus().as_deref())
    }

    /// All states at θ without a prediction. Loading the body at rest is checked to give the image.
    ///
    /// # Errors
    /// As for [`Patient::states`].
    pub fn states_checked(&self, theta: &[f64], derivatives: bool) -> Result<PatientStates> {
        self.parts.check(theta)?;
        self.parts.solve(theta, None, derivatives)
    }

    /// The solved start; none where it has no states.
    fn anchor(&self) -> Option<&Anchor<'p>> {
        self.anchor
            .get_or_init(|| self.parts.anchor(std::slice::from_ref(&self.start), None))
            .as_ref()
    }

    fn focus(&self) -> Option<Arc<Anchor<'p>>> {
        self.focus.read().ok().and_then(|focus| focus.clone())
    }

    /// Values of the observables in states, with derivatives where the states have them.
    pub fn see(&self, states: &PatientStates) -> Observed {
        self.seen_in(&states.moved, &states.slopes)
    }

    fn seen_in(&self, moved: &[Vec<f64>], slopes: &[Vec<Vec<f64>>]) -> Observed {
        let values = self.quantities.iter().map(|q| q.value(moved)).collect();
        let row = |quantity: &dyn Quantity| {
            let mut row = vec![0.0; self.parts.parameters.len()];
            for (state, gradient) in quantity.gradients(moved) {
                let slopes = row.iter_mut().zip(&slopes[state]);
                slopes.for_each(|(entry, slope)| *entry += dot(&gradient, slope));
            }
            row
        };
        let rows = self.quantities.iter().filter(|_| !slopes.is_empty());
        let jacobian = rows.map(|quantity| row(&**quantity)).collect();
        Observed { values, jacobian }
    }
}

impl Forward for Patient<'_> {
    fn parameters(&self) -> usize {
        self.parts.parameters.len()
    }

    fn observables(&self) -> usize {
        self.quantities.len()
    }

    fn expect_among(&self, thetas: &[Vec<f64>]) {
        let usable = thetas.first().is_some_and(|theta| self.parts.check(theta).is_ok());
        let anchor =
            usable.then(|| self.parts.anchor(thetas, self.anchor())).flatten().map(Arc::new);
        if let Ok(mut focus) = self.focus.write() {
            *focus = anchor;
        }
    }

    fn observe(&self, theta: &[f64], derivatives: bool) -> Result<Observed, ForwardError> {
        let focus = self.focus();
        let seen = match focus.as_deref().and_then(|focus| focus.at(theta)) {
            Some(solved) => {
                self.seen_in(&solved.moved, if derivatives { &solved.slopes } else { &[] })
            }
            None => self.see(&self.states(theta, derivatives)?),
        };
        let all = seen.values.iter().chain(seen.jacobian.iter().flatten());
        let wrong = all.copied().find(|value| !value.is_finite());
        wrong.map_or(Ok(seen), |value| {
            let reason = format!("an observable or its derivative is {value} at theta = {theta:?}");
            Err(ForwardError { reason })
        })
    }
}

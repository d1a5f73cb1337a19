//! A patient's body, data and unknown parameters, and the forward models made of them.

use crate::theta::outside;
use sinew_calibrate::{
    Observable, Patient, PatientBuilder, Problem, Segments, Setting, Unknown, WallCoordinates,
};
use sinew_energy::{Body, Parameter};
use sinew_report::format::trimmed;
use std::collections::BTreeMap;

/// Name of the factor of all uncertain pressures.
pub(super) const COMMON: &str = "pressure factor";
/// The state that the mesh shows.
pub(super) const IMAGE: &str = "image";

/// Unbalanced forces of a state \[relative to loads and reactions\]: observables are off by less than 1e-4 of their data's standard deviations.
const ACCURACY: f64 = 1e-6;

/// Values of loads and tensions \[kPa\] by phase.
pub(super) type Phases = BTreeMap<String, BTreeMap<String, f64>>;

/// A patient's body, data and unknown parameters; [`Prepared::patient`] is the forward model.
#[derive(Debug)]
pub struct Prepared {
    /// The body in the image.
    pub body: Body,
    /// Unknown parameters and data.
    pub problem: Problem,
    /// All that is observed, the data first.
    pub observables: Vec<Observable>,
    /// Places among them of what is reported beside the data: volumes of cavities in all states.
    pub reported: Vec<usize>,
    /// Values of loads and tensions \[kPa\] by phase.
    pub phases: BTreeMap<String, BTreeMap<String, f64>>,
    /// Pressures that fill cavities: facet set and name of the parameter.
    pub pressures: Vec<(String, String)>,
    /// Segments, if strains need them.
    pub segments: Option<Segments>,
    pub(super) wall: Option<WallCoordinates>,
    pub(super) at_rest: bool,
    pub(super) fibres: sinew_energy::Fibres,
    /// Parameters that each entry of a phase is multiplied by: of all phases, and of each.
    pub(super) uncertain: [bool; 2],
}

impl Prepared {
    /// The forward model.
    ///
    /// # Errors
    /// What makes no sense together, in words.
    pub fn patient(&self) -> Result<Patient<'_>, String> {
        let names = self.problem.unknowns.iter().map(|unknown| unknown.name.clone());
        let start = self.problem.theta(&vec![0.0; names.len()]);
        let observables = self.observables.clone();
        let base = self.base().parameters(names);
        let mut builder = PatientBuilder { start: Some(start), observables, ..base };
        for (phase, values) in &self.phases {
            let settings = self.settings(phase, values);
            builder = match phase == IMAGE {
                true => builder.image(settings),
                false => builder.phase(phase, settings),
            };
        }
        builder.build().map_err(|error| error.to_string())
    }

    /// The volumes of a cavity at pressures \[kPa\], for a pressure–volume curve. Other loads are those of the image. These
    /// pressures are known: factors of uncertain pressures apply to the image alone.
    ///
    /// # Errors
    /// A cavity whose pressure is not a parameter.
    pub fn curve(&self, cavity: &str, pressures: &[f64]) -> Result<Patient<'_>, String> {
        let found = self.pressures.iter().find(|(facets, _)| facets == cavity);
        let (_, name) = found.ok_or_else(|| format!("no pressure of {cavity} is a parameter"))?;
        let image = self.phases.get(IMAGE).cloned().unwrap_or_default();
        let phase = |pressure: &f64| {
            let mut values = image.clone();
            values.insert(name.clone(), *pressure);
            (format!("{} kPa", trimmed(*pressure, 4)), values)
        };
        let mut builder = self.base();
        builder = builder.image(self.settings(IMAGE, &image));
        for (phase, values) in pressures.iter().map(phase) {
            let plain = values.into_iter().map(|(name, value)| (name, Setting::from(value)));
            builder = builder.phase(&phase, plain.collect::<Vec<_>>());
            builder = builder.observe(Observable::volume(cavity, phase.as_str()));
        }
        builder.build().map_err(|error| error.to_string())
    }

    /// Places among the parameters of those that [`Prepared::curve`] has: all but factors of the pressures of other phases.
    pub fn curve_parameters(&self) -> Vec<usize> {
        let other = |(_, unknown): &(usize, &Unknown)| {
            self.phases.keys().any(|phase| phase != IMAGE && unknown.name == own_factor(phase))
        };
        let unknowns = self.problem.unknowns.iter().enumerate();
        unknowns.filter(|unknown| !other(unknown)).map(|(at, _)| at).collect()
    }

    fn base(&self) -> PatientBuilder<'_> {
        let unknowns = &self.problem.unknowns;
        let (start, places) =
            (self.problem.theta(&vec![0.0; unknowns.len()]), self.curve_parameters());
        PatientBuilder {
            fibres: (!self.at_rest).then_some(self.fibres),
            start: Some(places.iter().map(|&at| start[at]).collect()),
            wall: self.wall.as_ref(),
            segments: self.segments.as_ref(),
            accuracy: ACCURACY,
            ..Patient::of(&self.body).parameters(places.iter().map(|&at| unknowns[at].name.clone()))
        }
    }

    /// Size of the unit that the datum of an observable is given in.
    pub(super) fn size_of(&self, observable: usize) -> f64 {
        let datum = self.problem.data.iter().find(|datum| datum.observable == observable);
        datum.map_or(1.0, |datum| datum.size)
    }

    /// Settings of a phase: pressures times their factors.
    fn settings(&self, phase: &str, values: &BTreeMap<String, f64>) -> Vec<(String, Setting)> {
        let setting = |(name, value): (&String, &f64)| {
            let mut setting = Setting::from(*value);
            if self.pressures.iter().any(|(_, pressure)| pressure == name) {
                if self.uncertain[0] {
                    setting = setting.times(COMMON);
                }
                if self.uncertain[1] {
                    setting = setting.times(own_factor(phase));
                }
            }
            (name.clone(), setting)
        };
        values.iter().map(setting).collect()
    }

    /// Warnings about loads of phases outside their ranges.
    pub fn warnings(&self) -> Vec<String> {
        let mut found = Vec::new();
        for (phase, loads) in &self.phases {
            let load = |parameter: &Parameter| {
                let value = *loads.get(&parameter.name)?;
                (value != 0.0).then(|| (parameter.clone(), value))
            };
            let loads: (Vec<_>, Vec<_>) = self.body.parameters.iter().filter_map(load).unzip();
            let beyond = outside(&loads.0, &loads.1).into_iter();
            found.extend(beyond.map(|beyond| format!("phase {phase}: {beyond}")));
        }
        found
    }

    /// Adds the volumes of cavities in all states to what is observed.
    pub(super) fn report_volumes(&mut self) {
        let mut states: Vec<String> = vec!["rest".into()];
        // The image's own volume is known.
        states.extend(self.phases.keys().filter(|phase| *phase != IMAGE).cloned());
        for cavity in &self.body.cavities {
            for state in &states {
                let observable = Observable::volume(&cavity.name, state.as_str());
                let seen = self.observables.iter().position(|other| *other == observable);
                self.reported.push(seen.unwrap_or(self.observables.len()));
                self.observables.extend(seen.is_none().then_some(observable));
            }
        }
    }
}

/// Name of the factor of a phase's pressure.
pub(super) fn own_factor(phase: &str) -> String {
    format!("{COMMON} at {phase}")
}

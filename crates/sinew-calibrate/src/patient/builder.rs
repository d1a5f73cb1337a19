//! Builder of a patient.

use super::Patient;
use super::parts::Parts;
use crate::error::{Result, place_of, require};
use crate::observables::{CavityVolume, PointDisplacement, Quantity, SegmentStrain};
use crate::setting::Entry;
use crate::{Direction, Observable, PatientError, Segments, Setting, WallCoordinates};
use sinew_energy::{Body, Fibres, listed};
use sinew_fem::Unload;
use std::sync::{OnceLock, RwLock};

/// Settings of a state by the names of the entries of θ of the body.
type Settings = Vec<(String, Setting)>;

/// Collects what a [`Patient`] is made of.
#[derive(Clone, Debug)]
pub struct PatientBuilder<'p> {
    /// The body on the image.
    pub image: &'p Body,
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// Values of the body's other entries of θ in the image.
    pub settings: Settings,
    /// States under other loads or tensions.
    pub phases: Vec<(String, Settings)>,
    /// Convention of the fibres where the image is unloaded, carried with the tissue unless told; none where the image is the body at
    /// rest.
    pub fibres: Option<Fibres>,
    /// θ of the anchor, from which other θ are predicted, best near their middle. The default is the middle of the body's
    /// ranges, and 1 for the patient's other parameters.
    pub start: Option<Vec<f64>>,
    /// Coordinates of the wall, for circumferential, longitudinal and radial directions.
    pub wall: Option<&'p WallCoordinates>,
    /// Segments that strains are averaged over.
    pub segments: Option<&'p Segments>,
    /// The observables.
    pub observables: Vec<Observable>,
    /// Unbalanced forces that are enough for a state \[relative to loads and reactions\]; 0, the default, is what rounding errors amount to.
    pub accuracy: f64,
}

impl<'p> PatientBuilder<'p> {
    /// Names of the parameters: entries of θ of the body that are the same in all states, and names that settings multiply by.
    pub fn parameters<S: Into<String>>(mut self, names: impl IntoIterator<Item = S>) -> Self {
        self.parameters = names.into_iter().map(Into::into).collect();
        self
    }

    /// Values of the body's other entries of θ in the image; phases have them too unless they set others.
    pub fn image<N: Into<String>, S: Into<Setting>>(
        mut self,
        settings: impl IntoIterator<Item = (N, S)>,
    ) -> Self {
        self.settings = collected(settings);
        self
    }

    /// A state under other loads or tensions.
    pub fn phase<N: Into<String>, S: Into<Setting>>(
        mut self,
        name: impl Into<String>,
        settings: impl IntoIterator<Item = (N, S)>,
    ) -> Self {
        self.phases.push((name.into(), collected(settings)));
        self
    }

    /// Adds an observable.
    pub fn observe(mut self, observable: Observable) -> Self {
        self.observables.push(observable);
        self
    }

    /// The patient.
    ///
    /// # Errors
    /// Names, values, segments and points that make no sense, and bodies that cannot be unloaded.
    pub fn build(self) -> Result<Patient<'p>> {
        check_once(&self.states())?;
        check_once(&self.parameters.iter().map(String::as_str).collect::<Vec<_>>())?;
        require(!self.observables.is_empty(), || {
            "there is nothing to observe; add volumes, strains or displacements".into()
        })?;
        let mut loads = vec![("image".into(), self.entries("the image", &[&self.settings])?)];
        for (name, settings) in &self.phases {
            loads.push((name.clone(), self.entries(name, &[settings, &self.settings])?));
        }
        self.check_use(&loads)?;
        let start = self.anchor()?;
        let quantities = self.quantities()?;
        let unload = Unload::new(self.image)?.fibres(self.fibres.unwrap_or_default());
        let at_rest = self.fibres.is_none().then(|| unload.image_at_rest()).transpose()?;
        let Self { image, parameters, accuracy, .. } = self;
        let parts = Parts { image, unload, at_rest, parameters, loads, accuracy };
        let (anchor, focus) = (OnceLock::new(), RwLock::default());
        Ok(Patient { parts, quantities, start, anchor, focus })
    }

    /// Names of the entries of θ of the body.
    fn entry_names(&self) -> Vec<String> {
        self.image.parameters.iter().map(|parameter| parameter.name.clone()).collect()
    }

    /// Names of the states in the order of their displacements.
    fn states(&self) -> Vec<&str> {
        let phases = self.phases.iter().map(|(name, _)| name.as_str());
        ["image", "rest"].into_iter().chain(phases).collect()
    }

    /// Entries of θ of the body in a state: a parameter's, or else those of the first settings that have them.
    fn entries(&self, state: &str, settings: &[&Settings]) -> Result<Vec<Entry>> {
        let known = self.entry_names();
        for (name, setting) in settings[0] {
            place_of(name, &known, || {
                format!("{state} sets `{name}`, but the body's parameters are")
            })?;
            let value = setting.factor;
            require(value.is_finite(), || {
                format!("`{name}` is {value} in {state}; give a finite value")
            })?;
        }
        check_once(&settings[0].iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>())?;
        let place = |name: &String| {
            place_of(name, &self.parameters, || {
                format!("{state} multiplies by `{name}`, but the parameters of the patient are")
            })
        };
        let entry = |name: &String| {
            let set = settings.iter().copied().flatten().find(|(other, _)| other == name);
            let own = || self.parameters.contains(name).then(|| Setting::parameter(name.clone()));
            let setting = set.map(|(_, setting)| setting.clone()).or_else(own).ok_or_else(|| {
                PatientError::Input(format!(
                    "`{name}` has no value in {state}: give one, or list `{name}` among the parameters of the patient"
                ))
            })?;
            let parameters = setting.parameters.iter().map(place).collect::<Result<_, _>>()?;
            Ok(Entry { factor: setting.factor, parameters })
        };
        known.iter().map(entry).collect()
    }

    /// Checks that each parameter is read.
    fn check_use(&self, loads: &[(String, Vec<Entry>)]) -> Result<()> {
        let entries = || loads.iter().flat_map(|(_, entries)| entries);
        self.parameters.iter().enumerate().try_for_each(|(at, name)| {
            require(entries().any(|entry| entry.parameters.contains(&at)), || {
                let known = listed(&self.entry_names());
                format!("nothing reads the parameter `{name}`; the body's are {known}")
            })
        })
    }

    /// θ of the anchor.
    fn anchor(&self) -> Result<Vec<f64>> {
        let (body, centre) = (self.image, self.image.centre());
        let middle = |name: &String| {
            let of_body = body.parameters.iter().position(|parameter| parameter.name == *name);
            of_body.map_or(1.0, |at| centre[at])
        };
        let middle = || self.parameters.iter().map(middle).collect();
        let start: Vec<f64> = self.start.clone().unwrap_or_else(middle);
        let values = start.iter().copied().chain(std::iter::repeat(f64::NAN));
        let mut named = self.parameters.iter().zip(values);
        match named.find(|(_, value)| !value.is_finite()) {
            None => Ok(start),
            Some((name, value)) => Err(PatientError::Input(format!(
                "the start for `{name}` is {value}; give a positive value near the middle of its range"
            ))),
        }
    }

    fn quantities(&self) -> Result<Vec<Box<dyn Quantity>>> {
        let body = self.image;
        let quantity = |seen: &Observable| -> Result<Box<dyn Quantity>> {
            Ok(match seen {
                Observable::Volume { cavity, at } => {
                    let names: Vec<&String> = body.cavities.iter().map(|c| &c.name).collect();
                    let head = format!("no pressure acts in a cavity `{cavity}`");
                    let fault = || format!("{head}; those with a pressure are");
                    let cavity = body.cavities[place_of(cavity, &names, fault)?].clone();
                    let state = self.state(seen, at)?;
                    Box::new(CavityVolume { cavity, state, image: body.positions.clone() })
                }
                Observable::Strain { segment, direction, from, to } => {
                    let states = [self.state(seen, from)?, self.state(seen, to)?];
                    let points = self.lines(segment, *direction)?;
                    Box::new(SegmentStrain::new(body, &points, states))
                }
                Observable::Displacement { point, direction, from, to } => {
                    let states = [self.state(seen, from)?, self.state(seen, to)?];
                    Box::new(PointDisplacement::new(body, *point, *direction, states)?)
                }
            })
        };
        self.observables.iter().map(quantity).collect()
    }

    /// Place of a state among the displacements.
    fn state(&self, seen: &Observable, name: &str) -> Result<usize> {
        place_of(name, &self.states(), || {
            format!("{seen}: there is no phase `{name}`; the states are")
        })
    }

    /// Quadrature points of a segment, with a direction at each.
    fn lines(&self, segment: &str, direction: Direction) -> Result<Vec<(usize, [f64; 3])>> {
        let body = self.image;
        let segments = self.segments.ok_or_else(|| {
            PatientError::Input("strains are averaged over segments; give the patient some".into())
        })?;
        let (cells, points) = (body.cell_count(), body.points_per_cell);
        let wall = self.wall.map(|wall| ("coordinates of the wall", wall.heights.len()));
        let mut given = std::iter::once(("segments", segments.of_cell().len())).chain(wall);
        if let Some((what, given)) = given.find(|(_, given)| *given != cells) {
            return Err(PatientError::Input(format!(
                "the {what} are of {given} cells, the body has {cells}; make them of the mesh that was lowered"
            )));
        }
        let along = |point: usize| -> Result<[f64; 3]> {
            if direction == Direction::Fibre {
                let fibre = body.material.directions(point).first();
                return fibre.copied().ok_or_else(|| PatientError::Input("the law has no fibres, so there is no fibre strain; ask for a direction of the wall".into()));
            }
            let none = || {
                PatientError::Input(format!(
                    "a {direction} direction needs coordinates of the wall; give the patient those"
                ))
            };
            Ok(self.wall.ok_or_else(none)?.direction(point / points, direction))
        };
        let of_cell = |cell: usize| cell * points..(cell + 1) * points;
        let points = segments.cells_of(segment)?.into_iter().flat_map(of_cell);
        points.map(|point| Ok((point, along(point)?))).collect()
    }
}

fn collected<N: Into<String>, S: Into<Setting>>(
    settings: impl IntoIterator<Item = (N, S)>,
) -> Settings {
    settings.into_iter().map(|(name, value)| (name.into(), value.into())).collect()
}

/// Refuses a name that is there twice.
fn check_once(names: &[&str]) -> Result<()> {
    names.iter().enumerate().try_for_each(|(at, name)| {
        require(!names[..at].contains(name), || {
            format!(
                "`{name}` is there twice; `image` and `rest` are names of states that each patient has"
            )
        })
    })
}

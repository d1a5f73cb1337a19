//! From the tables of a patient file to a body, what is seen of it and what is unknown.

use super::PatientFile;
use super::tables::{Along, Entry, Fibres, Quantity};
use crate::case::{Case, CaseError, advise, number_and_unit, stress};
use sinew_calibrate::{
    At, Datum, Direction, Kind, Observable, Patient, PatientBuilder, Prior, Problem, Segments,
    Setting, Unknown, WallCoordinates,
};
use sinew_energy::Body;
use sinew_fem::fibres::Surfaces;
use sinew_mesh::AnyMesh;
use std::collections::BTreeMap;

/// Units of volume, and what they are in mm³.
const VOLUMES: [(&str, f64); 4] = [("mL", 1e3), ("cm3", 1e3), ("mm3", 1.0), ("L", 1e6)];
/// Units of length, and what they are in mm.
const LENGTHS: [(&str, f64); 3] = [("mm", 1.0), ("cm", 10.0), ("m", 1e3)];
/// Names of the factors of uncertain pressures.
const COMMON: &str = "pressure factor";
/// The state that the mesh shows.
const IMAGE: &str = "image";

/// A quantity that is reported beside the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// Name, such as `volume of endo at rest`.
    pub name: String,
    /// Place among the observables.
    pub observable: usize,
    /// Unit that people read.
    pub unit: &'static str,
    /// Size of that unit in mm and kPa.
    pub size: f64,
}

/// A patient's body, data and unknown parameters; [`Prepared::patient`] is the forward model.
#[derive(Debug)]
pub struct Prepared {
    /// The body in the image.
    pub body: Body,
    /// Unknown parameters and data.
    pub problem: Problem,
    /// All that is observed, the data first.
    pub observables: Vec<Observable>,
    /// Quantities that are reported beside the data: volumes of cavities in all states.
    pub reported: Vec<Seen>,
    /// Values of loads and tensions \[kPa\] by phase.
    pub phases: BTreeMap<String, BTreeMap<String, f64>>,
    /// Pressures that fill cavities: facet set and name of the parameter.
    pub pressures: Vec<(String, String)>,
    /// Segments, if strains need them.
    pub segments: Option<Segments>,
    wall: Option<WallCoordinates>,
    at_rest: bool,
    fibres: sinew_energy::Fibres,
    /// Parameters that each entry of a phase is multiplied by: of all phases, and of each.
    uncertain: [bool; 2],
}

impl PatientFile {
    /// The body with phases, data and priors.
    ///
    /// # Errors
    /// Names, units, phases and segments that are missing or make no sense, each with its line.
    pub fn prepare(&self) -> Result<Prepared, CaseError> {
        let (case, settings) = (&self.case, &self.tables.calibration);
        let body = case.body()?;
        let phases = self.values(&body)?;
        let wall = self.wall(&body)?;
        let segments = self.segments(&body, wall.as_ref())?;
        let (observables, data) = self.data(&body, &phases, segments.as_ref())?;
        let uncertain = [settings.pressure_common, settings.pressure_each].map(|sd| sd.is_some());
        let unknowns = self.unknowns(&body, &phases)?;
        let kinds = self.kinds(&data)?;
        let problem = Problem::new(unknowns, data, kinds);
        let problem = problem.map_err(|error| case.source.error(&["data"], error.to_string()))?;
        let mut prepared = Prepared {
            pressures: pressures(case, &body),
            at_rest: settings.image_at_rest,
            fibres: match settings.fibres {
                Fibres::Carried => sinew_energy::Fibres::Carried,
                Fibres::Kept => sinew_energy::Fibres::Kept,
            },
            reported: Vec::new(),
            body,
            problem,
            observables,
            phases,
            segments,
            wall,
            uncertain,
        };
        prepared.report_volumes();
        // Whatever else a patient needs is said before anything is solved.
        prepared.patient().map_err(|error| case.source.error(&["phases"], error))?;
        Ok(prepared)
    }

    /// Values of loads and tensions by phase \[kPa\].
    fn values(&self, body: &Body) -> Result<BTreeMap<String, BTreeMap<String, f64>>, CaseError> {
        let source = &self.case.source;
        let phases = &self.tables.phases;
        if !phases.contains_key(IMAGE) && !self.tables.calibration.image_at_rest {
            let reason = "the loads of the image are missing: add [phases.image] with a pressure, such as p = \"8 mmHg\", or \
                 image_at_rest = true under [calibration]";
            return Err(source.error(&["phases"], reason.into()));
        }
        let known = || body.parameters.iter().map(|p| p.name.as_str());
        let value = |phase: &str, name: &str, quantity: &Quantity| {
            let error = |reason: String| source.error(&["phases", phase, name], reason);
            if known().all(|other| other != name) {
                let advice = advise(name, known(), "parameters that are not known");
                return Err(error(format!("no parameter `{name}` is left to set{advice}")));
            }
            let text = match quantity {
                Quantity::Number(value) => {
                    return Err(error(format!(
                        "the unit is missing: write \"{value} mmHg\" or \"{value} kPa\""
                    )));
                }
                Quantity::Text(text) => text,
            };
            let (number, unit) = number_and_unit(text);
            match (number.parse::<f64>(), stress(unit)) {
                (Ok(value), Ok(unit)) if value.is_finite() => Ok(unit.in_scene(value)),
                (Ok(_), Err(_)) if unit.is_empty() => {
                    Err(error(format!("the unit is missing: write \"{number} mmHg\"")))
                }
                (Ok(_), Err(reason)) => Err(error(reason)),
                _ => {
                    Err(error(format!("`{text}` is not a number with a unit, such as \"8 mmHg\"")))
                }
            }
        };
        let of_phase = |(phase, entries): (&String, &BTreeMap<String, Quantity>)| {
            let entries =
                entries.iter().map(|(name, q)| Ok((name.clone(), value(phase, name, q)?)));
            Ok((phase.clone(), entries.collect::<Result<_, CaseError>>()?))
        };
        let mut found: BTreeMap<String, BTreeMap<String, f64>> =
            phases.iter().map(of_phase).collect::<Result<_, CaseError>>()?;
        if self.tables.calibration.image_at_rest {
            // No loads.
            let names: Vec<String> =
                found.values().flat_map(|entries| entries.keys().cloned()).collect();
            let image = found.entry(IMAGE.into()).or_default();
            names.into_iter().for_each(|name| {
                image.entry(name).or_insert(0.0);
            });
        }
        Ok(found)
    }

    fn wall(&self, body: &Body) -> Result<Option<WallCoordinates>, CaseError> {
        let Some(wall) = &self.tables.calibration.wall else { return Ok(None) };
        let error = |reason: String| self.case.source.error(&["calibration", "wall"], reason);
        let AnyMesh::Tetrahedra(mesh) = &*body.mesh else {
            let reason = format!(
                "coordinates of the wall need linear tetrahedra, not {}; set formulation = \"averaged\"",
                body.element().plural
            );
            return Err(error(reason));
        };
        let surfaces = Surfaces {
            endocardium: &wall.endocardium,
            epicardium: &wall.epicardium,
            base: &wall.base,
        };
        let found = WallCoordinates::new(mesh, &surfaces).map_err(|e| error(e.to_string()))?;
        match wall.septum {
            None => Ok(Some(found)),
            Some(septum) => Ok(Some(found.with_septum(septum).map_err(|e| error(e.to_string()))?)),
        }
    }

    fn segments(
        &self,
        body: &Body,
        wall: Option<&WallCoordinates>,
    ) -> Result<Option<Segments>, CaseError> {
        let Some(name) = &self.tables.calibration.segments else { return Ok(None) };
        let error = |reason: String| self.case.source.error(&["calibration", "segments"], reason);
        let of_wall = || {
            wall.ok_or_else(|| {
                error("segments need the surfaces of the wall: add wall = { endocardium = …, epicardium = …, base = …, septum = [x, y, z] }".into())
            })
        };
        let number = |text: &str| text.trim().parse::<usize>().ok().filter(|n| *n > 0);
        let found = match (name.split_once(':'), name.split_once('x')) {
            (Some(("field", field)), _) => Segments::by_field(&body.mesh, field),
            _ if name == "aha17" => of_wall()?.aha17(),
            (None, Some((levels, sectors))) => match (number(levels), number(sectors)) {
                (Some(levels), Some(sectors)) => of_wall()?.levels(levels, sectors),
                _ => return Err(error(unknown_division(name))),
            },
            _ => return Err(error(unknown_division(name))),
        };
        found.map(Some).map_err(|e| error(e.to_string()))
    }

    /// Observables and data, in the order of the file.
    fn data(
        &self,
        body: &Body,
        phases: &BTreeMap<String, BTreeMap<String, f64>>,
        segments: Option<&Segments>,
    ) -> Result<(Vec<Observable>, Vec<Datum>), CaseError> {
        let (mut observables, mut data) = (Vec::new(), Vec::new());
        for (number, entry) in self.tables.data.iter().enumerate() {
            let reader = Reader {
                case: &self.case,
                number: number.to_string(),
                entry,
                body,
                phases,
                segments,
                blank: self.blank,
            };
            for (observable, value) in reader.observables()? {
                let datum = reader.datum(&observable, value, observables.len())?;
                observables.push(observable);
                data.push(datum);
            }
        }
        Ok((observables, data))
    }

    fn unknowns(
        &self,
        body: &Body,
        phases: &BTreeMap<String, BTreeMap<String, f64>>,
    ) -> Result<Vec<Unknown>, CaseError> {
        let (source, settings) = (&self.case.source, &self.tables.calibration);
        let set = |name: &str| phases.values().any(|entries| entries.contains_key(name));
        let mut unknowns = Vec::new();
        for parameter in body.parameters.iter().filter(|parameter| !set(&parameter.name)) {
            let unit = Some(parameter.unit.name()).filter(|name| *name != "1").unwrap_or_default();
            let prior = match settings.priors.get(&parameter.name) {
                Some(prior) => Prior::LogNormal {
                    median: parameter.unit.in_scene(prior.median),
                    deviation: prior.sd,
                },
                None => Prior::LogUniform { range: parameter.range },
            };
            if parameter.range[0] <= 0.0 {
                let reason = "it is not known and its range begins at 0 or below, but unknown parameters are positive: give another range, or its \
                              value in [phases]";
                return Err(source.error(&["parameters", &parameter.name], reason.into()));
            }
            let size = parameter.unit.in_scene(1.0);
            unknowns.push(Unknown { size, ..Unknown::new(&parameter.name, unit, prior) });
        }
        if let Some(name) =
            settings.priors.keys().find(|name| unknowns.iter().all(|u| u.name != **name))
        {
            let advice =
                advise(name, unknowns.iter().map(|u| u.name.as_str()), "unknown parameters");
            let reason = format!("`{name}` is not an unknown parameter{advice}");
            return Err(source.error(&["calibration", "priors", name], reason));
        }
        let factor = |name: String, deviation: f64| {
            Unknown::new(name, "", Prior::LogNormal { median: 1.0, deviation })
        };
        unknowns.extend(settings.pressure_common.map(|sd| factor(COMMON.into(), sd)));
        if let Some(sd) = settings.pressure_each {
            unknowns.extend(phases.keys().map(|phase| factor(own_factor(phase), sd)));
        }
        Ok(unknowns)
    }

    fn kinds(&self, data: &[Datum]) -> Result<Vec<Kind>, CaseError> {
        let (source, settings) = (&self.case.source, &self.tables.calibration);
        let mut kinds: Vec<Kind> = Vec::new();
        for datum in data {
            if kinds.iter().all(|kind| kind.name != datum.kind) {
                kinds.push(Kind { name: datum.kind.clone(), ..Kind::default() });
            }
        }
        let names: Vec<String> = kinds.iter().map(|kind| kind.name.clone()).collect();
        let place = |key: &str, name: &String| {
            names.iter().position(|other| other == name).ok_or_else(|| {
                let advice = advise(name, names.iter().map(String::as_str), "kinds of the data");
                source.error(
                    &["calibration", key],
                    format!("there are no data of the kind `{name}`{advice}"),
                )
            })
        };
        for name in &settings.infer_noise {
            kinds[place("infer_noise", name)?].inferred = true;
        }
        for (name, quantity) in &settings.bias {
            let at = place("bias", name)?;
            let error = |reason: String| source.error(&["calibration", "bias", name], reason);
            kinds[at].bias = match (quantity, name.as_str()) {
                (Quantity::Number(value), "strain") => *value,
                (Quantity::Text(text), "volume") => sized(text, &VOLUMES).map_err(error)?,
                (Quantity::Text(text), "displacement") => sized(text, &LENGTHS).map_err(error)?,
                _ => return Err(error("give a number for strains, and one with its unit, such as \"5 mL\", for others".into())),
            };
        }
        Ok(kinds)
    }
}

impl Prepared {
    /// The forward model.
    ///
    /// # Errors
    /// What makes no sense together, in words.
    pub fn patient(&self) -> Result<Patient<'_>, String> {
        let builder =
            self.states(self.phases.iter().map(|(name, values)| (name.clone(), values.clone())));
        let builder = self.observables.iter().cloned().fold(builder, PatientBuilder::observe);
        builder.build().map_err(|error| error.to_string())
    }

    /// The volumes of a cavity at pressures \[kPa\], all other loads as in the image: what a pressure–volume curve is made of.
    /// Pressures are known, so factors of uncertain pressures are not parameters of it but of the image alone.
    ///
    /// # Errors
    /// A cavity whose pressure is not a parameter.
    pub fn curve(&self, cavity: &str, pressures: &[f64]) -> Result<Patient<'_>, String> {
        let found = self.pressures.iter().find(|(facets, _)| facets == cavity);
        let (_, name) = found.ok_or_else(|| format!("no pressure of {cavity} is a parameter"))?;
        let image = self.phases.get(IMAGE).cloned().unwrap_or_default();
        let phase = |(number, pressure): (usize, &f64)| {
            let mut values = image.clone();
            values.insert(name.clone(), *pressure);
            (format!("curve {number}"), values)
        };
        let mut builder = self.base();
        builder = builder.image(self.settings(IMAGE, &image));
        for (phase, values) in pressures.iter().enumerate().map(phase) {
            let plain = values.into_iter().map(|(name, value)| (name, Setting::from(value)));
            builder = builder.phase(&phase, plain.collect::<Vec<_>>());
            builder = builder.observe(Observable::volume(cavity, phase.as_str()));
        }
        builder.build().map_err(|error| error.to_string())
    }

    /// Places among the parameters of those that [`Prepared::curve`] has: all but factors of the pressures of other phases.
    pub fn curve_parameters(&self) -> Vec<usize> {
        let names = self.curve_names();
        let place = |unknown: &Unknown| names.contains(&unknown.name);
        (0..self.problem.unknowns.len()).filter(|&at| place(&self.problem.unknowns[at])).collect()
    }

    fn curve_names(&self) -> Vec<String> {
        let other = |name: &String| {
            self.phases.keys().any(|phase| phase != IMAGE && *name == own_factor(phase))
        };
        let names = self.problem.unknowns.iter().map(|unknown| unknown.name.clone());
        names.filter(|name| !other(name)).collect()
    }

    fn base(&self) -> PatientBuilder<'_> {
        let mut builder = Patient::of(&self.body).parameters(self.curve_names());
        builder = match self.at_rest {
            true => builder.image_is_at_rest(),
            false => builder.fibres(self.fibres),
        };
        if let Some(wall) = &self.wall {
            builder = builder.wall(wall);
        }
        if let Some(segments) = &self.segments {
            builder = builder.segments(segments);
        }
        let start = self.problem.theta(&vec![0.0; self.problem.unknowns.len()]);
        let start: Vec<f64> = self.curve_parameters().iter().map(|&at| start[at]).collect();
        builder.start(&start)
    }

    fn states(
        &self,
        phases: impl Iterator<Item = (String, BTreeMap<String, f64>)>,
    ) -> PatientBuilder<'_> {
        let names: Vec<String> = self.problem.unknowns.iter().map(|u| u.name.clone()).collect();
        let start = self.problem.theta(&vec![0.0; names.len()]);
        let mut builder = self.base().parameters(names).start(&start);
        for (phase, values) in phases {
            let settings = self.settings(&phase, &values);
            builder = match phase == IMAGE {
                true => builder.image(settings),
                false => builder.phase(phase, settings),
            };
        }
        builder
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

    /// Adds the volumes of cavities in all states to what is observed.
    fn report_volumes(&mut self) {
        let mut states: Vec<String> = vec!["rest".into()];
        // The image's own volume is known.
        states.extend(self.phases.keys().filter(|phase| *phase != IMAGE).cloned());
        for cavity in &self.body.cavities {
            for state in &states {
                let observable = Observable::volume(&cavity.name, state.as_str());
                let seen = self.observables.iter().position(|other| *other == observable);
                let place = seen.unwrap_or_else(|| {
                    self.observables.push(observable.clone());
                    self.observables.len() - 1
                });
                let (name, size) = (observable.to_string(), VOLUMES[0].1);
                self.reported.push(Seen { name, observable: place, unit: VOLUMES[0].0, size });
            }
        }
    }
}

/// Name of the factor of a phase's pressure.
fn own_factor(phase: &str) -> String {
    format!("{COMMON} at {phase}")
}

/// Facet sets of the loads whose pressure is a parameter, with its name.
fn pressures(case: &Case, body: &Body) -> Vec<(String, String)> {
    let pair = |load: &crate::case::Load| match (&load.pressure, &load.facets) {
        (Some(crate::case::Pressure::Parameter(name)), Some(facets)) => {
            let known = body.parameters.iter().all(|parameter| parameter.name != *name);
            (!known).then(|| (facets.clone(), name.clone()))
        }
        _ => None,
    };
    case.loads.iter().filter_map(pair).collect()
}

fn unknown_division(name: &str) -> String {
    format!(
        "`{name}` is not a division: write \"aha17\", \"4x6\" for four levels of six sectors, or \"field:NAME\" for a cell field"
    )
}

/// A number with one of some units, in units of the scene.
fn sized(text: &str, units: &[(&'static str, f64)]) -> Result<f64, String> {
    let (number, unit) = number_and_unit(text);
    let value: f64 = number.parse().map_err(|_| format!("`{text}` is not a number with a unit"))?;
    Ok(value * of_unit(unit, units)?.1)
}

fn of_unit(unit: &str, units: &[(&'static str, f64)]) -> Result<(&'static str, f64), String> {
    let found = units.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit));
    let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
    match found {
        Some(found) => Ok(*found),
        None if unit.is_empty() => {
            Err(format!("the unit is missing: add one of {}", names.join(", ")))
        }
        None => Err(format!("`{unit}` is not a unit here{}", advise(unit, names, "units"))),
    }
}

/// One entry of the data.
struct Reader<'a> {
    case: &'a Case,
    number: String,
    entry: &'a Entry,
    body: &'a Body,
    phases: &'a BTreeMap<String, BTreeMap<String, f64>>,
    segments: Option<&'a Segments>,
    /// Whether values are still to be made.
    blank: bool,
}

impl Reader<'_> {
    fn error(&self, key: &str, reason: impl Into<String>) -> CaseError {
        self.case.source.error(&["data", &self.number, key], reason.into())
    }

    /// Observables that it measures, with values.
    fn observables(&self) -> Result<Vec<(Observable, f64)>, CaseError> {
        let entry = self.entry;
        let phase =
            entry.phase.as_deref().ok_or_else(|| self.error("phase", "the phase is missing"))?;
        let at = self.state("phase", phase)?;
        let from = self.state("from", entry.from.as_deref().unwrap_or(IMAGE))?;
        match (&entry.volume, entry.strain, entry.displacement) {
            (Some(cavity), None, None) => {
                let known = || self.body.cavities.iter().map(|c| c.name.as_str());
                if known().all(|name| name != cavity) {
                    let advice = advise(cavity, known(), "cavities under a pressure");
                    return Err(
                        self.error("volume", format!("there is no cavity `{cavity}`{advice}"))
                    );
                }
                Ok(vec![(Observable::volume(cavity, at), self.value()?)])
            }
            (None, Some(along), None) => self.strains(direction(along), from, at),
            (None, None, Some(along)) => {
                let point = entry.point.ok_or_else(|| {
                    self.error("point", "the point is missing: point = [x, y, z] in mm")
                })?;
                Ok(vec![(Observable::displacement(point, along, from, at), self.value()?)])
            }
            _ => Err(self.error("volume", "write one of volume, strain and displacement")),
        }
    }

    fn strains(
        &self,
        direction: Direction,
        from: At,
        at: At,
    ) -> Result<Vec<(Observable, f64)>, CaseError> {
        let Some(segments) = self.segments else {
            return Err(self.error(
                "strain",
                "strains need segments: add segments = \"aha17\" under [calibration]",
            ));
        };
        let names = segments.names();
        let strain = |name: &String| Observable::strain(name, direction, from.clone(), at.clone());
        match (&self.entry.segment, &self.entry.values) {
            (None, _) if self.blank => Ok(names.iter().map(strain).map(|o| (o, 1.0)).collect()),
            (Some(segment), None) => {
                let name = segment.text();
                if !names.contains(&name) {
                    let advice = advise(&name, names.iter().map(String::as_str), "segments");
                    return Err(
                        self.error("segment", format!("there is no segment `{name}`{advice}"))
                    );
                }
                Ok(vec![(strain(&name), self.value()?)])
            }
            (None, Some(values)) if values.len() == names.len() => {
                Ok(names.iter().map(strain).zip(values.iter().copied()).collect())
            }
            (None, Some(values)) => Err(self.error(
                "values",
                format!("{} values for {} segments; give one for each", values.len(), names.len()),
            )),
            _ => Err(self
                .error("segment", "give a segment with its value, or the values of all segments")),
        }
    }

    fn value(&self) -> Result<f64, CaseError> {
        if self.blank {
            return Ok(1.0);
        }
        self.entry.value.ok_or_else(|| self.error("value", "the value is missing"))
    }

    fn state(&self, key: &str, name: &str) -> Result<At, CaseError> {
        if name != "rest" && name != IMAGE && !self.phases.contains_key(name) {
            let known = self.phases.keys().map(String::as_str).chain(["rest", IMAGE]);
            let advice = advise(name, known, "phases");
            return Err(self.error(key, format!("there is no phase `{name}`{advice}")));
        }
        Ok(At::from(name))
    }

    fn datum(&self, observable: &Observable, value: f64, place: usize) -> Result<Datum, CaseError> {
        let units: Option<&[(&str, f64)]> = match observable {
            Observable::Volume { .. } => Some(&VOLUMES),
            Observable::Strain { .. } => None,
            Observable::Displacement { .. } => Some(&LENGTHS),
        };
        let given = self.entry.unit.as_deref();
        let (unit, size) = match (units, given) {
            (None, None) => ("", 1.0),
            (None, Some(_)) => return Err(self.error("unit", "a strain has no unit; leave it out")),
            (Some(units), given) => of_unit(given.unwrap_or_default(), units)
                .map_err(|reason| self.error("unit", reason))?,
        };
        if !value.is_finite() {
            return Err(self.error(
                "value",
                format!("the value is {value}; give a finite number or leave the datum out"),
            ));
        }
        let kind = match observable {
            Observable::Volume { .. } => "volume",
            Observable::Strain { .. } => "strain",
            Observable::Displacement { .. } => "displacement",
        };
        let deviation = self.deviation(value)?;
        let named = Datum::new(observable.to_string(), kind, place, value * size, deviation * size);
        Ok(Datum { unit: unit.into(), size, ..named })
    }

    /// Standard deviation in the unit of the value.
    fn deviation(&self, value: f64) -> Result<f64, CaseError> {
        let missing = "the standard deviation is missing: sd = 0.02 in the unit of the value, or \"3 %\" of it";
        let deviation = match self.entry.sd.as_ref().ok_or_else(|| self.error("sd", missing))? {
            Quantity::Number(value) => *value,
            Quantity::Text(text) => {
                let share =
                    text.trim().strip_suffix('%').and_then(|n| n.trim().parse::<f64>().ok());
                let share = share.ok_or_else(|| {
                    self.error(
                        "sd",
                        format!("`{text}` is neither a number nor a share such as \"3 %\""),
                    )
                })?;
                0.01 * share * value.abs()
            }
        };
        match deviation.is_finite() && deviation > 0.0 {
            true => Ok(deviation),
            false => Err(self.error(
                "sd",
                format!("the standard deviation is {deviation}; give a positive number"),
            )),
        }
    }
}

fn direction(along: Along) -> Direction {
    match along {
        Along::Circumferential => Direction::Circumferential,
        Along::Longitudinal => Direction::Longitudinal,
        Along::Radial => Direction::Radial,
        Along::Fibre => Direction::Fibre,
    }
}

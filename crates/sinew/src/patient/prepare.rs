//! Preparation of a patient file: its body, observables and unknowns.

use super::PatientFile;
use super::measured::Reader;
use super::prepared::{COMMON, IMAGE, Phases, Prepared, own_factor};
use super::tables::{LogNormal, Quantity};
use crate::case::{Case, LENGTH, Result, STRESS, VOLUME, advise, stress};
use sinew_calibrate::{
    Datum, Kind, Observable, Prior, Problem, Segments, Unknown, WallCoordinates,
};
use sinew_energy::{Body, Parameter};
use sinew_fem::fibres::Surfaces;
use sinew_mesh::AnyMesh;

impl PatientFile {
    /// The body with phases, data and priors.
    ///
    /// # Errors
    /// Names, units, phases and segments that are missing or make no sense, each with its line.
    pub fn prepare(&self) -> Result<Prepared> {
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
            fibres: settings.fibres,
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
        prepared.patient().map_err(|error| case.source.error(&["data"], error))?;
        Ok(prepared)
    }

    /// Values of loads and tensions by phase \[kPa\].
    fn values(&self, body: &Body) -> Result<Phases> {
        let source = &self.case.source;
        let phases = &self.tables.phases;
        let at_rest = self.tables.calibration.image_at_rest;
        source.refuse_if(!at_rest && !phases.contains_key(IMAGE), &["phases"], || {
            "the loads of the image are missing: add [phases.image] with a pressure, such as p = \"8 mmHg\", or \
                 image_at_rest = true under [calibration]"
        })?;
        source.refuse_if(
            phases.contains_key("rest"),
            &["phases", "rest"],
            || "each patient has a state `rest`; give the phase another name",
        )?;
        let is_stress = |p: &&Parameter| stress(p.unit.name()).is_ok();
        let known = || body.parameters.iter().filter(is_stress).map(|p| p.name.as_str());
        let mut found = Phases::new();
        for (phase, entries) in phases {
            let values = found.entry(phase.clone()).or_default();
            for (name, quantity) in entries {
                let keys = ["phases", phase, name];
                source.refuse_if(known().all(|other| other != name), &keys, || {
                    let advice = advise(name, known(), "these are");
                    format!("a phase gives values of stresses that have a range in the case file, and `{name}` is not one of them{advice}")
                })?;
                let value = match quantity {
                    Quantity::Number(n) => {
                        Err(format!("the unit is missing: write \"{n} mmHg\" or \"{n} kPa\""))
                    }
                    Quantity::Text(text) => STRESS.sized(text),
                };
                let value = value.map_err(|reason| source.error(&keys, reason))?;
                values.insert(name.clone(), value);
            }
        }
        if at_rest {
            // No loads.
            let names: Vec<String> =
                found.values().flat_map(|entries| entries.keys().cloned()).collect();
            let image = found.entry(IMAGE.into()).or_default();
            names.into_iter().for_each(|name| {
                image.entry(name).or_insert(0.0);
            });
        }
        for (name, giver) in
            found.iter().flat_map(|(phase, all)| all.keys().map(move |n| (n, phase)))
        {
            for (phase, all) in &found {
                source.refuse_if(!all.contains_key(name), &["phases", phase], || {
                    format!(
                        "phase `{phase}` lacks `{name}`, which phase `{giver}` has; write its value, \"0 kPa\" where it does not act"
                    )
                })?;
            }
        }
        Ok(found)
    }

    fn wall(&self, body: &Body) -> Result<Option<WallCoordinates>> {
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
        let found = WallCoordinates::new(mesh, &surfaces);
        let found = match wall.septum {
            None => found,
            Some(septum) => found.and_then(|found| found.with_septum(septum.0)),
        };
        found.map(Some).map_err(|e| error(e.to_string()))
    }

    fn segments(&self, body: &Body, wall: Option<&WallCoordinates>) -> Result<Option<Segments>> {
        let Some(name) = &self.tables.calibration.segments else { return Ok(None) };
        let error = |reason: String| self.case.source.error(&["calibration", "segments"], reason);
        let of_wall = || {
            wall.ok_or_else(|| {
                error("segments need the surfaces of the wall: add wall = { endocardium = …, epicardium = …, base = …, septum = [x, y, z] }".into())
            })
        };
        let number = |text: &str| text.trim().parse::<usize>().ok().filter(|n| *n > 0);
        let grid = name.split_once('x').and_then(|(a, b)| Some((number(a)?, number(b)?)));
        let found = match (name.split_once(':'), grid) {
            (Some(("field", field)), _) => Segments::by_field(&body.mesh, field),
            _ if name == "aha17" => of_wall()?.aha17(),
            (None, Some((levels, sectors))) => of_wall()?.levels(levels, sectors),
            _ => {
                return Err(error(format!(
                    "`{name}` is not a division: write \"aha17\", \"4x6\" for four levels of six sectors, or \"field:NAME\" for a cell field"
                )));
            }
        };
        found.map(Some).map_err(|e| error(e.to_string()))
    }

    /// Observables and data, in the order of the file.
    fn data(
        &self,
        body: &Body,
        phases: &Phases,
        segments: Option<&Segments>,
    ) -> Result<(Vec<Observable>, Vec<Datum>)> {
        let (mut observables, mut data, mut entries) = (Vec::new(), Vec::new(), Vec::new());
        for (at, entry) in self.tables.data.iter().enumerate() {
            let number = at.to_string();
            let reader =
                Reader { file: self, number: number.clone(), entry, body, phases, segments };
            for (observable, value) in reader.observables()? {
                let same = observables.iter().position(|other| *other == observable);
                self.refuse_twice(&number, &observable, same.map(|place| entries[place]))?;
                let datum = reader.datum(&observable, value, observables.len())?;
                observables.push(observable);
                entries.push(at);
                data.push(datum);
            }
        }
        Ok((observables, data))
    }

    /// Refuses an entry of what another entry measures already: each copy would count as a measurement of its own.
    fn refuse_twice(&self, number: &str, seen: &Observable, other: Option<usize>) -> Result<()> {
        let (source, key) = (&self.case.source, other.unwrap_or_default().to_string());
        source.refuse_if(other.is_some(), &["data", number], || {
            let at = match source.line_of(&["data", &key]) {
                Some(line) => format!("in line {line}"),
                None => format!("in entry {key} of [[data]]"),
            };
            format!(
                "`{seen}` is given {at} already; keep one, or give the mean of repeated measurements with its standard deviation"
            )
        })
    }

    fn unknowns(&self, body: &Body, phases: &Phases) -> Result<Vec<Unknown>> {
        let (source, settings) = (&self.case.source, &self.tables.calibration);
        let set = |name: &str| phases.values().any(|entries| entries.contains_key(name));
        let usable = |prior: Prior, keys: &[&str]| match prior.fault() {
            Some(fault) => Err(source.error(&[&["calibration"], keys].concat(), fault)),
            None => Ok(prior),
        };
        let mut unknowns = Vec::new();
        for parameter in body.parameters.iter().filter(|parameter| !set(&parameter.name)) {
            let unit = Some(parameter.unit.name()).filter(|name| *name != "1").unwrap_or_default();
            let prior = match settings.priors.get(&parameter.name) {
                Some(&LogNormal { median, sd: deviation }) => {
                    let keys = ["priors", &parameter.name];
                    usable(Prior::LogNormal { median, deviation }, &keys)?;
                    self.check_median(parameter, median)?;
                    Prior::LogNormal { median: parameter.unit.in_scene(median), deviation }
                }
                None => Prior::LogUniform { range: parameter.range },
            };
            source.refuse_if(parameter.range[0] <= 0.0, &["parameters", &parameter.name], || {
                "it is not known and its range begins at 0 or below, but unknown parameters are positive: give another range, or its \
                              value in [phases]"
            })?;
            let size = parameter.unit.in_scene(1.0);
            unknowns.push(Unknown { size, ..Unknown::new(&parameter.name, unit, prior) });
        }
        for name in settings.priors.keys() {
            let mut known = unknowns.iter().map(|u| u.name.as_str());
            let wrong = known.clone().all(|unknown| unknown != name);
            source.refuse_if(wrong, &["calibration", "priors", name], || {
                let advice = advise(name, &mut known, "unknown parameters");
                format!("`{name}` is not an unknown parameter{advice}")
            })?;
        }
        let factor =
            |deviation: f64, key: &str| usable(Prior::LogNormal { median: 1.0, deviation }, &[key]);
        if let Some(sd) = settings.pressure_common {
            unknowns.push(Unknown::new(COMMON, "", factor(sd, "pressure_common")?));
        }
        if let Some(sd) = settings.pressure_each {
            let prior = factor(sd, "pressure_each")?;
            unknowns.extend(phases.keys().map(|phase| Unknown::new(own_factor(phase), "", prior)));
        }
        Ok(unknowns)
    }

    /// Refuses a median outside of the range of its parameter: one in another unit, mostly.
    fn check_median(&self, parameter: &Parameter, median: f64) -> Result<()> {
        let [low, high] = parameter.range.map(|end| parameter.unit.shown(end));
        let (name, unit) = (&parameter.name, parameter.unit.name());
        let wrong = !(low..=high).contains(&median);
        self.case.source.refuse_if(wrong, &["calibration", "priors", name], || {
            format!(
                "the median {median} is outside of the range of `{name}`, {low} to {high} in the unit {unit}; give it in that unit, or widen the range"
            )
        })
    }

    fn kinds(&self, data: &[Datum]) -> Result<Vec<Kind>> {
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
                let reason = format!("there are no data of the kind `{name}`{advice}");
                source.error(&["calibration", key], reason)
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
                (Quantity::Text(text), "volume") => VOLUME.sized(text).map_err(error)?,
                (Quantity::Text(text), "displacement") => LENGTH.sized(text).map_err(error)?,
                _ => return Err(error("give a number for strains, and one with its unit, such as \"5 mL\", for others".into())),
            };
        }
        Ok(kinds)
    }
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

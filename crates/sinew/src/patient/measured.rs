//! Entries of the data: what they are measurements of, with values and standard deviations.

use super::prepared::IMAGE;
use super::tables::{Entry, Quantity, Settings};
use crate::case::{Case, CaseError, LENGTH, VOLUME, advise};
use sinew_calibrate::{At, Datum, Direction, Observable, Segments};
use sinew_energy::Body;
use std::collections::BTreeMap;

/// One entry of the data.
pub(super) struct Reader<'a> {
    pub case: &'a Case,
    pub number: String,
    pub entry: &'a Entry,
    pub body: &'a Body,
    pub phases: &'a BTreeMap<String, BTreeMap<String, f64>>,
    pub segments: Option<&'a Segments>,
    /// Whether values are still to be made.
    pub blank: bool,
    pub settings: &'a Settings,
}

impl Reader<'_> {
    fn error(&self, key: &str, reason: impl Into<String>) -> CaseError {
        self.case.source.error(&["data", &self.number, key], reason.into())
    }

    /// Observables that it measures, with values.
    pub(super) fn observables(&self) -> Result<Vec<(Observable, f64)>, CaseError> {
        let entry = self.entry;
        let phase =
            entry.phase.as_deref().ok_or_else(|| self.error("phase", "the phase is missing"))?;
        let at = self.state("phase", phase)?;
        let from = self.state("from", entry.from.as_deref().unwrap_or(IMAGE))?;
        let is_volume = entry.volume.is_some();
        if self.same(&at, if is_volume { &At::Image } else { &from }) {
            let reason = match is_volume {
                true => {
                    "the volume in the image is that of the mesh, whatever the parameters are; leave it out"
                }
                false => {
                    "it is counted from the same state, and is zero whatever the parameters are; name another phase, or another one in `from`"
                }
            };
            return Err(self.error("phase", reason));
        }
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
            (None, Some(along), None) => self.strains(along, from, at),
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

    /// Whether two states are the same: by name, at rest, or by loads that are known exactly.
    fn same(&self, a: &At, b: &At) -> bool {
        let name = |at: &At| match at {
            At::Rest if self.settings.image_at_rest => IMAGE.to_string(),
            other => other.to_string(),
        };
        let [a, b] = [name(a), name(b)];
        let loads = |name: &String| self.phases.get(name);
        let known = self.settings.pressure_each.is_none();
        a == b || (known && loads(&a).is_some() && loads(&a) == loads(&b))
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

    pub(super) fn datum(
        &self,
        observable: &Observable,
        value: f64,
        place: usize,
    ) -> Result<Datum, CaseError> {
        let (kind, dimension) = match observable {
            Observable::Volume { .. } => ("volume", Some(VOLUME)),
            Observable::Strain { .. } => ("strain", None),
            Observable::Displacement { .. } => ("displacement", Some(LENGTH)),
        };
        let given = self.entry.unit.as_deref();
        let (unit, size) = match (dimension, given) {
            (None, None) => ("", 1.0),
            (None, Some(_)) => return Err(self.error("unit", "a strain has no unit; leave it out")),
            (Some(dimension), given) => dimension
                .unit(given.unwrap_or_default())
                .map_err(|reason| self.error("unit", reason))?,
        };
        if !value.is_finite() {
            return Err(self.error(
                "value",
                format!("the value is {value}; give a finite number or leave the datum out"),
            ));
        }
        let (deviation, is_share) = self.deviation()?;
        if is_share && !(kind == "volume" && value > 0.0) {
            let reason =
                "a share is for volumes that are positive; give the standard deviation as a number";
            return Err(self.error("sd", reason));
        }
        let deviation = if is_share { deviation } else { deviation * size };
        let named = Datum::new(observable.to_string(), kind, place, value * size, deviation);
        Ok(Datum { is_share, unit: unit.into(), size, ..named })
    }

    /// Standard deviation in the unit of the value, or a share, and whether it is a share.
    fn deviation(&self) -> Result<(f64, bool), CaseError> {
        let missing = "the standard deviation is missing: sd = 0.02 in the unit of the value, or \"3 %\" of a volume";
        let deviation = match self.entry.sd.as_ref().ok_or_else(|| self.error("sd", missing))? {
            Quantity::Number(value) => (*value, false),
            Quantity::Text(text) => {
                let share =
                    text.trim().strip_suffix('%').and_then(|n| n.trim().parse::<f64>().ok());
                let share = share.ok_or_else(|| {
                    self.error(
                        "sd",
                        format!("`{text}` is neither a number nor a share such as \"3 %\""),
                    )
                })?;
                (0.01 * share, true)
            }
        };
        match deviation.0.is_finite() && deviation.0 > 0.0 {
            true => Ok(deviation),
            false => Err(self.error(
                "sd",
                format!("the standard deviation is {}; give a positive number", deviation.0),
            )),
        }
    }
}

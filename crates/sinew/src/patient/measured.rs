//! Entries of the data: what they are measurements of, with values and standard deviations.

use super::PatientFile;
use super::prepared::{IMAGE, Phases};
use super::tables::{Entry, Quantity};
use crate::case::{CaseError, LENGTH, Result, VOLUME, advise, cell_name};
use sinew_calibrate::{Datum, Direction, Observable, Segments};
use sinew_energy::Body;

/// One entry of the data.
pub(super) struct Reader<'a> {
    pub file: &'a PatientFile,
    pub number: String,
    pub entry: &'a Entry,
    pub body: &'a Body,
    pub phases: &'a Phases,
    pub segments: Option<&'a Segments>,
}

impl Reader<'_> {
    fn error(&self, key: &str, reason: impl Into<String>) -> CaseError {
        self.file.case.source.error(&["data", &self.number, key], reason.into())
    }

    fn refuse_if<R: Into<String>>(
        &self,
        wrong: bool,
        key: &str,
        reason: impl FnOnce() -> R,
    ) -> Result<()> {
        self.file.case.source.refuse_if(wrong, &["data", &self.number, key], reason)
    }

    /// Observables that it measures, with values.
    pub(super) fn observables(&self) -> Result<Vec<(Observable, f64)>> {
        let entry = self.entry;
        let phase =
            entry.phase.as_deref().ok_or_else(|| self.error("phase", "the phase is missing"))?;
        let at = self.state("phase", phase)?;
        let from = self.state("from", entry.from.as_deref().unwrap_or(IMAGE))?;
        let is_volume = entry.volume.is_some();
        let given = [
            ("from", entry.from.is_some()),
            ("segment", entry.segment.is_some()),
            ("values", entry.values.is_some()),
            ("point", entry.point.is_some()),
        ];
        let (read, kind): (&[&str], _) = match entry.strain {
            _ if is_volume => (&[], "volume"),
            Some(_) => (&["from", "segment", "values"], "strain"),
            None => (&["from", "point"], "displacement"),
        };
        if let Some((key, _)) = given.iter().find(|(key, is)| *is && !read.contains(key)) {
            return Err(self.error(key, format!("a {kind} does not read it; leave it out")));
        }
        self.refuse_if(is_volume && self.same(&at, IMAGE), "phase", || {
            "the volume in the image is that of the mesh, whatever the parameters are; leave it out"
        })?;
        self.refuse_if(!is_volume && self.same(&at, &from), "phase", || {
            "it is counted from the same state, and is zero whatever the parameters are; name another phase, or another one in `from`"
        })?;
        match (&entry.volume, entry.strain, entry.displacement) {
            (Some(cavity), None, None) => {
                let known = || self.body.cavities.iter().map(|c| c.name.as_str());
                self.refuse_if(known().all(|name| name != cavity), "volume", || {
                    let advice = advise(cavity, known(), "cavities under a pressure");
                    format!("there is no cavity `{cavity}`{advice}")
                })?;
                Ok(vec![(Observable::volume(cavity, at), self.value()?)])
            }
            (None, Some(along), None) => self.strains(along, from, at),
            (None, None, Some(along)) => {
                let point = entry.point.ok_or_else(|| {
                    self.error("point", "the point is missing: point = [x, y, z] in mm")
                })?;
                Ok(vec![(Observable::displacement(point.0, along.0, from, at), self.value()?)])
            }
            _ => Err(self.error("volume", "write one of volume, strain and displacement")),
        }
    }

    fn strains(
        &self,
        direction: Direction,
        from: String,
        at: String,
    ) -> Result<Vec<(Observable, f64)>> {
        let Some(segments) = self.segments else {
            let reason = "strains need segments: add segments = \"aha17\" under [calibration]";
            return Err(self.error("strain", reason));
        };
        let names = segments.names();
        let strain = |name: &String| Observable::strain(name, direction, from.clone(), at.clone());
        match (&self.entry.segment, &self.entry.values) {
            (None, _) if self.file.blank => {
                Ok(names.iter().map(strain).map(|o| (o, 1.0)).collect())
            }
            (Some(segment), None) => {
                let name = cell_name(segment);
                self.refuse_if(!names.contains(&name), "segment", || {
                    let advice = advise(&name, names.iter().map(String::as_str), "segments");
                    format!("there is no segment `{name}`{advice}")
                })?;
                Ok(vec![(strain(&name), self.value()?)])
            }
            (None, Some(values)) => {
                let (found, wanted) = (values.len(), names.len());
                let reason = || format!("{found} values for {wanted} segments; give one for each");
                self.refuse_if(found != wanted, "values", reason)?;
                Ok(names.iter().map(strain).zip(values.iter().copied()).collect())
            }
            _ => Err(self
                .error("segment", "give a segment with its value, or the values of all segments")),
        }
    }

    /// Whether two states are the same: by name, at rest, or by loads that are known exactly.
    fn same(&self, a: &str, b: &str) -> bool {
        let name = |at| match at {
            "rest" if self.file.tables.calibration.image_at_rest => IMAGE,
            other => other,
        };
        let [a, b] = [name(a), name(b)];
        let loads = |name: &str| self.phases.get(name);
        let known = self.file.tables.calibration.pressure_each.is_none();
        a == b || (known && loads(a).is_some() && loads(a) == loads(b))
    }

    fn value(&self) -> Result<f64> {
        if self.file.blank {
            return Ok(1.0);
        }
        self.entry.value.ok_or_else(|| self.error("value", "the value is missing"))
    }

    fn state(&self, key: &str, name: &str) -> Result<String> {
        let known = || self.phases.keys().map(String::as_str).chain(["rest"]);
        let reason = || format!("there is no phase `{name}`{}", advise(name, known(), "phases"));
        self.refuse_if(known().all(|phase| phase != name), key, reason)?;
        Ok(name.into())
    }

    pub(super) fn datum(&self, observable: &Observable, value: f64, place: usize) -> Result<Datum> {
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
        self.refuse_if(!value.is_finite(), "value", || {
            format!("the value is {value}; give a finite number or leave the datum out")
        })?;
        let (deviation, is_share) = self.deviation()?;
        let fits = !is_share || (kind == "volume" && value > 0.0);
        let reason =
            "a share is for volumes that are positive; give the standard deviation as a number";
        self.refuse_if(!fits, "sd", || reason)?;
        let deviation = if is_share { deviation } else { deviation * size };
        let named = Datum::new(observable.to_string(), kind, place, value * size, deviation);
        Ok(Datum { is_share, unit: unit.into(), size, ..named })
    }

    /// Standard deviation in the unit of the value, or a share, and whether it is a share.
    fn deviation(&self) -> Result<(f64, bool)> {
        let missing = "the standard deviation is missing: sd = 0.02 in the unit of the value, or \"3 %\" of a volume";
        let deviation = match self.entry.sd.as_ref().ok_or_else(|| self.error("sd", missing))? {
            Quantity::Number(value) => (*value, false),
            Quantity::Text(text) => {
                let share =
                    text.trim().strip_suffix('%').and_then(|n| n.trim().parse::<f64>().ok());
                let wrong = || format!("`{text}` is neither a number nor a share such as \"3 %\"");
                (0.01 * share.ok_or_else(|| self.error("sd", wrong()))?, true)
            }
        };
        self.refuse_if(!(deviation.0.is_finite() && deviation.0 > 0.0), "sd", || {
            format!("the standard deviation is {}; give a positive number", deviation.0)
        })?;
        Ok(deviation)
    }
}

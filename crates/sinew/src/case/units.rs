//! Units that a case file may use.

use super::source::advise;
use sinew_energy::Unit;

/// One unit of stress in kPa. Letters may be large or small where only one unit can be meant.
///
/// ```
/// use sinew::case::stress_in_kpa;
/// assert_eq!(stress_in_kpa("mmHg"), Some(0.133322387415));
/// assert_eq!(stress_in_kpa("mmhg"), stress_in_kpa("mmHg"));
/// // A million or a thousandth of a pascal.
/// assert_eq!((stress_in_kpa("MPa"), stress_in_kpa("mPa")), (Some(1e3), None));
/// ```
pub fn stress_in_kpa(unit: &str) -> Option<f64> {
    STRESS.find(unit).map(|(_, kpa)| kpa)
}

/// A physical dimension with its units, and what they are in the units of scenes.
pub(crate) struct Dimension {
    name: &'static str,
    units: &'static [(&'static str, f64)],
}

/// Stress \[kPa\].
pub(crate) const STRESS: Dimension = Dimension {
    name: "stress",
    units: &[
        ("kPa", 1.0),
        ("mmHg", 0.133_322_387_415), // of mercury at 0 °C: 13.5951 g/cm³ · 9.80665 m/s² · 1 mm
        ("Pa", 1e-3),
        ("MPa", 1e3),
        ("dyn/cm2", 1e-4),
    ],
};

/// Length \[mm\].
pub(crate) const LENGTH: Dimension =
    Dimension { name: "length", units: &[("mm", 1.0), ("cm", 10.0), ("m", 1e3), ("um", 1e-3)] };

/// Volume \[mm³\].
pub(crate) const VOLUME: Dimension =
    Dimension { name: "volume", units: &[("mL", 1e3), ("cm3", 1e3), ("mm3", 1.0), ("L", 1e6)] };

/// Units whose first letter another prefix has in the other case: mega and milli.
const PREFIXED: [&str; 3] = ["MPa", "mm", "mm3"];

impl Dimension {
    /// A unit by its name.
    ///
    /// # Errors
    /// Error of a missing or unknown unit, with the known ones.
    pub(crate) fn unit(&self, unit: &str) -> Result<(&'static str, f64), String> {
        let names = || self.units.iter().map(|(name, _)| *name);
        let all = names().collect::<Vec<_>>().join(", ");
        if unit.is_empty() {
            return Err(format!("the unit is missing: add one of {all}"));
        }
        let written = unit.replace(['µ', 'μ'], "u").replace('²', "2").replace('³', "3");
        self.find(&written).ok_or_else(|| {
            let ambiguous = names().any(|name| name.eq_ignore_ascii_case(unit));
            // Of short names the most alike may be another unit: mm for nm.
            let is_short = unit.len() < 4 || names().all(|name| name.len() < 4);
            let advice = match (ambiguous, is_short) {
                (true, _) => {
                    format!(", as M is mega and m is milli{}", advise(unit, names(), "units"))
                }
                (_, true) => format!("; units of {}: {all}", self.name),
                _ => advise(unit, names(), &format!("units of {}", self.name)),
            };
            format!("`{unit}` is not a unit of {}{advice}", self.name)
        })
    }

    /// A number with a unit, in the unit of scenes.
    ///
    /// # Errors
    /// A text that does not begin with a number, or the error of [`Dimension::unit`].
    pub(crate) fn sized(&self, text: &str) -> Result<f64, String> {
        let (number, unit) = number_and_unit(text);
        let value: Option<f64> = number.parse().ok().filter(|value: &f64| value.is_finite());
        let value = value.ok_or_else(|| self.unread(text))?;
        Ok(value * self.unit(unit)?.1)
    }

    fn unread(&self, text: &str) -> String {
        format!("`{text}` is not a number with a unit, such as \"8 {}\"", self.units[0].0)
    }

    fn find(&self, unit: &str) -> Option<(&'static str, f64)> {
        let meant = |name: &str| {
            let prefix =
                !PREFIXED.contains(&name) || name.as_bytes().first() == unit.as_bytes().first();
            name == unit || (prefix && name.eq_ignore_ascii_case(unit))
        };
        self.units.iter().copied().find(|(name, _)| meant(name))
    }
}

/// A unit of stress among those of scenes in kPa.
///
/// # Errors
/// As for [`Dimension::unit`].
pub(crate) fn stress(unit: &str) -> Result<Unit, String> {
    STRESS.unit(unit).map(|(name, size)| Unit::sized(name, size))
}

/// Length of an organ \[mm\].
const ORGAN: f64 = 100.0;

/// The unit in which a length is within bounds \[mm\] and nearest to an organ's.
pub(super) fn length_within(length: f64, bounds: [f64; 2]) -> Option<&'static str> {
    let fits = |(_, mm): &&(&str, f64)| (bounds[0]..=bounds[1]).contains(&(length * mm));
    let away = |(_, mm): &(&str, f64)| (length * mm / ORGAN).ln().abs();
    let best = LENGTH.units.iter().filter(fits).min_by(|a, b| away(a).total_cmp(&away(b)));
    best.map(|(name, _)| *name)
}

/// Longest edge of the box around points \[length\].
pub(super) fn size(points: &[[f64; 3]]) -> f64 {
    sinew_mesh::extents(points).into_iter().fold(0.0, f64::max)
}

/// The number that a text begins with and what follows, such as `8` and `mmHg`; either may be empty.
pub(crate) fn number_and_unit(text: &str) -> (&str, &str) {
    let end = text.find(|c: char| !(c.is_ascii_digit() || " +-.eE".contains(c)));
    let (number, unit) = text.split_at(end.unwrap_or(text.len()));
    (number.trim(), unit.trim())
}

/// A number with a unit of stress, such as `"8 mmHg"` \[kPa\]; `None` for a name, which does not begin as a number does.
pub(super) fn quantity(text: &str) -> Option<Result<f64, String>> {
    let (number, unit) = number_and_unit(text);
    let Ok(value) = number.parse::<f64>() else {
        let is_name = text.trim().starts_with(|c: char| !(c.is_ascii_digit() || "+-.".contains(c)));
        return (!is_name).then(|| Err(STRESS.unread(text)));
    };
    let unit = if unit.is_empty() { "kPa" } else { unit };
    Some(stress(unit).map(|unit| unit.in_scene(value)))
}

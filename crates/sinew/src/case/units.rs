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
    find(&STRESSES, unit).map(|(_, kpa)| kpa)
}

/// Units, and what they are in kPa or mm.
type Table = [(&'static str, f64)];

/// Units of stress, and what they are in kPa.
const STRESSES: [(&str, f64); 5] = [
    ("kPa", 1.0),
    ("mmHg", 0.133_322_387_415), // of mercury at 0 °C: 13.5951 g/cm³ · 9.80665 m/s² · 1 mm
    ("Pa", 1e-3),
    ("MPa", 1e3),
    ("dyn/cm2", 1e-4),
];

/// Units of length, and what they are in mm.
const LENGTHS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("m", 1e3), ("um", 1e-3)];

/// Units whose first letter another prefix has in the other case: mega and milli.
const PREFIXED: [&str; 2] = ["MPa", "mm"];

fn find(table: &Table, unit: &str) -> Option<(&'static str, f64)> {
    let meant = |name: &str| {
        let prefix =
            !PREFIXED.contains(&name) || name.as_bytes().first() == unit.as_bytes().first();
        name == unit || (prefix && name.eq_ignore_ascii_case(unit))
    };
    table.iter().copied().find(|(name, _)| meant(name))
}

/// A unit of stress among those of scenes in kPa.
///
/// # Errors
/// Error of an unknown unit, with the known ones.
pub(crate) fn stress(unit: &str) -> Result<Unit, String> {
    named(&STRESSES, unit, "stress").map(|(name, size)| Unit::sized(name, size))
}

/// One unit of length in mm.
///
/// # Errors
/// As [`stress`].
pub(super) fn length(unit: &str) -> Result<f64, String> {
    named(&LENGTHS, unit, "length").map(|(_, mm)| mm)
}

/// Length of an organ \[mm\].
const ORGAN: f64 = 100.0;

/// The unit in which a length is within bounds \[mm\] and nearest to an organ's.
pub(super) fn length_within(length: f64, bounds: [f64; 2]) -> Option<&'static str> {
    let fits = |(_, mm): &&(&str, f64)| (bounds[0]..=bounds[1]).contains(&(length * mm));
    let away = |(_, mm): &(&str, f64)| (length * mm / ORGAN).ln().abs();
    let best = LENGTHS.iter().filter(fits).min_by(|a, b| away(a).total_cmp(&away(b)));
    best.map(|(name, _)| *name)
}

fn named(table: &'static Table, unit: &str, of: &str) -> Result<(&'static str, f64), String> {
    find(table, unit).ok_or_else(|| {
        let names = || table.iter().map(|(name, _)| *name);
        let ambiguous = names().any(|name| name.eq_ignore_ascii_case(unit));
        let advice = match ambiguous {
            true => ", as M is mega and m is milli".to_string() + &advise(unit, names(), "units"),
            false => advise(unit, names(), &format!("units of {of}")),
        };
        format!("`{unit}` is not a unit of {of}{advice}")
    })
}

/// The number that a text begins with and what follows, such as `8` and `mmHg`; either may be empty.
pub(crate) fn number_and_unit(text: &str) -> (&str, &str) {
    let end = text.find(|c: char| !(c.is_ascii_digit() || " +-.eE".contains(c)));
    let (number, unit) = text.split_at(end.unwrap_or(text.len()));
    (number.trim(), unit.trim())
}

/// A number with a unit of stress, such as `"8 mmHg"` \[kPa\]; `None` when it does not begin with a number.
pub(super) fn quantity(text: &str) -> Option<Result<f64, String>> {
    let (number, unit) = number_and_unit(text);
    let value: f64 = number.parse().ok()?;
    let unit = if unit.is_empty() { "kPa" } else { unit };
    Some(stress(unit).map(|unit| unit.in_scene(value)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_may_be_large_or_small_where_one_unit_is_meant() {
        for unit in ["mmhg", "MMHG", "kpa", "KPA", "pa", "MPA", "Mpa", "DYN/CM2"] {
            assert!(stress(unit).is_ok(), "{unit}");
        }
        assert_eq!((length("CM"), length("M"), length("UM")), (Ok(10.0), Ok(1e3), Ok(1e-3)));
        for error in [stress("mPa").unwrap_err(), length("Mm").unwrap_err()] {
            assert!(error.contains("M is mega and m is milli"), "{error}");
        }
        let error = stress("bar").unwrap_err();
        assert!(error.ends_with("units of stress: kPa, mmHg, Pa, MPa, dyn/cm2"), "{error}");
    }
}

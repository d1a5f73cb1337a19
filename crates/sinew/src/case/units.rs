//! Units that a case file may use.

/// One unit of stress in kPa.
///
/// ```
/// assert_eq!(sinew::case::stress_in_kpa("mmHg"), Some(0.133322387415));
/// assert_eq!(sinew::case::stress_in_kpa("bar"), None);
/// ```
pub fn stress_in_kpa(unit: &str) -> Option<f64> {
    STRESSES.iter().find(|(name, _)| *name == unit).map(|(_, kpa)| *kpa)
}

/// Units of stress, and what they are in kPa.
pub(super) const STRESSES: [(&str, f64); 5] = [
    ("kPa", 1.0),
    ("mmHg", 0.133_322_387_415), // of mercury at 0 °C: 13.5951 g/cm³ · 9.80665 m/s² · 1 mm
    ("Pa", 1e-3),
    ("MPa", 1e3),
    ("dyn/cm2", 1e-4),
];

/// Units of length, and what they are in mm.
pub(super) const LENGTHS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("m", 1e3), ("um", 1e-3)];

/// Names of units.
pub(super) fn names(units: &'static [(&str, f64)]) -> impl Iterator<Item = &'static str> {
    units.iter().map(|(name, _)| *name)
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
    Some(stress_in_kpa(unit).map(|kpa| kpa * value).ok_or_else(|| unit.to_string()))
}

//! Units of measured values.

use crate::case::{advise, number_and_unit};

/// Units of volume, and what they are in mm³.
pub(super) const VOLUMES: [(&str, f64); 4] = [("mL", 1e3), ("cm3", 1e3), ("mm3", 1.0), ("L", 1e6)];
/// Units of length, and what they are in mm.
pub(super) const LENGTHS: [(&str, f64); 3] = [("mm", 1.0), ("cm", 10.0), ("m", 1e3)];

/// A number with one of some units, in units of the scene.
pub(super) fn sized(text: &str, units: &[(&'static str, f64)]) -> Result<f64, String> {
    let (number, unit) = number_and_unit(text);
    let value: f64 = number.parse().map_err(|_| format!("`{text}` is not a number with a unit"))?;
    Ok(value * of_unit(unit, units)?.1)
}

pub(super) fn of_unit(
    unit: &str,
    units: &[(&'static str, f64)],
) -> Result<(&'static str, f64), String> {
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

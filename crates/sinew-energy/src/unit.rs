//! Units that people write and read parameters in.

use crate::Units;
use std::fmt;

/// Unit in which people write and read a parameter. θ and ranges are in the units of the scene; [`Unit::in_scene`] and
/// [`Unit::shown`] convert.
///
/// ```
/// use sinew_energy::Unit;
///
/// let mmhg = Unit::sized("mmHg", 0.133322387415); // kPa
/// let p = mmhg.in_scene(8.0);
/// assert_eq!((mmhg.shown(p), mmhg.format(p).as_str()), (8.0, "8 mmHg"));
/// assert_eq!(Unit::from("1").format(0.45), "0.45");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    name: String,
    size: f64,
}

/// Significant digits that distinguish any two numbers.
const DIGITS: usize = 17;

/// Range of numbers written without a power of ten.
const LEAST: f64 = 1e-4;
const MOST: f64 = 1e7;

impl Unit {
    /// A unit that equals `size` units of the scene.
    ///
    /// # Panics
    /// If the size is not positive and finite.
    pub fn sized(name: impl Into<String>, size: f64) -> Self {
        assert!(size > 0.0 && size.is_finite(), "a unit's size is positive and finite, not {size}");
        Self { name: name.into(), size }
    }

    /// Name, such as `"mmHg"`; `"1"` for numbers without unit.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of the unit of θ and ranges: its own, or the scene's unit of stress for a multiple of that.
    pub fn of_scene<'a>(&'a self, units: &'a Units) -> &'a str {
        if self.is_scene() { &self.name } else { &units.stress }
    }

    /// Whether it is the unit of the scene.
    pub fn is_scene(&self) -> bool {
        self.size == 1.0
    }

    /// Converts a value from this unit to that of the scene.
    pub fn in_scene(&self, value: f64) -> f64 {
        value * self.size
    }

    /// Converts a value from the unit of the scene to this one: the shortest decimal that [`Unit::in_scene`] converts
    /// back exactly, if any.
    pub fn shown(&self, value: f64) -> f64 {
        if self.is_scene() {
            return value;
        }
        let exact = value / self.size;
        let rounded = |digits| format!("{exact:.digits$e}").parse().unwrap_or(exact);
        (0..DIGITS).map(rounded).find(|&short| self.in_scene(short) == value).unwrap_or(exact)
    }

    /// A value in the unit of the scene, for people: `8 mmHg`.
    pub fn format(&self, value: f64) -> String {
        let shown = self.shown(value);
        let plain = shown == 0.0 || !shown.is_finite() || (LEAST..MOST).contains(&shown.abs());
        let number = if plain { shown.to_string() } else { format!("{shown:e}") };
        number + &self.suffix()
    }

    /// Suffix of a number: a space and the name; empty for numbers without unit.
    pub fn suffix(&self) -> String {
        if self.name == "1" { String::new() } else { format!(" {}", self.name) }
    }

    /// Head of a column of values: `p [mmHg]`, and the name alone for numbers without unit.
    pub fn head(&self, name: &str) -> String {
        if self.name == "1" { name.into() } else { format!("{name} [{}]", self.name) }
    }
}

impl<T: Into<String>> From<T> for Unit {
    /// A unit of the scene.
    fn from(name: T) -> Self {
        Self::sized(name, 1.0)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

//! Axes of a chart and their ticks.

use super::format::{digits, power_of_ten};

/// Most tick labels that fit side by side.
const MAX_LABELS: i32 = 8;
/// Below this many decades ticks between the powers of ten are labelled too.
const FINE_DECADES: f64 = 1.7;
/// Up to this many decades the ticks between powers of ten are drawn.
const MINOR_DECADES: f64 = 5.0;

/// A range of values, its spacing and its name.
pub(crate) struct Axis {
    logarithmic: bool,
    /// Value, or its log₁₀, at the two ends.
    range: (f64, f64),
    /// Markup of the name, with the unit.
    pub(super) name: String,
    /// Whether ticks carry numbers.
    pub(super) numbered: bool,
}

impl Axis {
    /// A logarithmic axis over the positive, finite ones of `values`, at least a decade
    /// long. `name` is markup.
    pub(crate) fn log(name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let logs = values.into_iter().filter(|&v| v > 0.0 && v.is_finite());
        let (low, high) = bounds(logs.map(f64::log10)).unwrap_or((-1.0, 0.0));
        let missing = (1.0 - (high - low)).max(0.0);
        let margin = 0.5 * missing + 0.04 * (high - low);
        Self {
            logarithmic: true,
            range: (low - margin, high + margin),
            name: name.into(),
            numbered: true,
        }
    }

    /// A linear axis from 0 to a little above the largest of `values`, without numbers.
    pub(crate) fn from_zero(
        name: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        let (_, high) = bounds(values).unwrap_or((0.0, 1.0));
        Self { logarithmic: false, range: (0.0, 1.06 * high), name: name.into(), numbered: false }
    }

    /// A linear axis over the finite ones of `values`, with a little room at both ends.
    pub(crate) fn linear(name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) =
            bounds(values.into_iter().filter(|v| v.is_finite())).unwrap_or((0.0, 1.0));
        // A single value still needs a range.
        let room = (0.04 * (high - low)).max(1e-3 * high.abs()).max(f64::MIN_POSITIVE);
        Self::between(name, [low - room, high + room])
    }

    /// A linear axis with the two ends.
    pub(crate) fn between(name: impl Into<String>, [low, high]: [f64; 2]) -> Self {
        Self { logarithmic: false, range: (low, high), name: name.into(), numbered: true }
    }

    /// Position of a value from 0 to 1, that of an end for values beyond.
    pub(super) fn clamped(&self, value: f64) -> f64 {
        let value = if self.logarithmic { value.max(0.0).log10() } else { value };
        let (low, high) = self.range;
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// Position of a value from 0 to 1, if it lies on the axis.
    pub(super) fn fraction(&self, value: f64) -> Option<f64> {
        let value = if self.logarithmic { value.log10() } else { value };
        let (low, high) = self.range;
        let fraction = (value - low) / (high - low);
        (-1e-9..=1.0 + 1e-9).contains(&fraction).then_some(fraction)
    }

    /// Ticks as value and label; minor ticks have none.
    pub(super) fn ticks(&self) -> Vec<(f64, Option<String>)> {
        if !self.numbered {
            return Vec::new();
        }
        if !self.logarithmic {
            return self.even_ticks();
        }
        let (low, high) = self.range;
        let decades = high - low;
        let stride = (decades.ceil() as i32 / MAX_LABELS + 1).max(1);
        let mut ticks = Vec::new();
        for exponent in low.floor() as i32..=high.ceil() as i32 {
            let power = 10f64.powi(exponent);
            if exponent.rem_euclid(stride) == 0 {
                let plain = decades < FINE_DECADES && (-2..4).contains(&exponent);
                let label = if plain { digits(power, 1) } else { power_of_ten(exponent) };
                ticks.push((power, Some(label)));
            }
            if decades <= MINOR_DECADES {
                ticks.extend((2..10).map(|multiple| {
                    let value = f64::from(multiple) * power;
                    let fine = decades < FINE_DECADES && matches!(multiple, 2 | 5);
                    (value, fine.then(|| digits(value, 1)))
                }));
            }
        }
        ticks.retain(|&(value, _)| self.fraction(value).is_some());
        ticks
    }
}

/// An end that is a tick but for rounding counts as one.
const ROUNDING: f64 = 1e-9;
/// About this many numbers on a linear axis.
const EVEN_TICKS: f64 = 5.0;

impl Axis {
    /// Multiples of 1, 2 or 5 times a power of ten.
    fn even_ticks(&self) -> Vec<(f64, Option<String>)> {
        let (low, high) = self.range;
        let rough = (high - low) / EVEN_TICKS;
        let power = 10f64.powf(rough.log10().floor());
        let step =
            power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= rough).unwrap_or(10.0);
        let decimals = (-(step * 1.000_1).log10().floor()).max(0.0) as usize;
        let plain = decimals <= 4 && high.abs().max(low.abs()) < 1e5;
        let label = |value: f64| match plain {
            true => format!("{value:.decimals$}").replace('-', "−"),
            false if value == 0.0 => "0".into(),
            false => digits(value, 2),
        };
        ((low / step - ROUNDING).ceil() as i64..=(high / step + ROUNDING).floor() as i64)
            .map(|multiple| multiple as f64 * step)
            .map(|value| (value, Some(label(value))))
            .collect()
    }
}

fn bounds(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().fold(None, |found, value| {
        let (low, high) = found.unwrap_or((value, value));
        Some((value.min(low), value.max(high)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_labels_powers_of_ten() {
        let axis = Axis::log("x", [2e-4, 3.0, -1.0, 0.0, f64::INFINITY]);
        let labels: Vec<_> = axis.ticks().into_iter().filter_map(|(_, label)| label).collect();
        assert_eq!(labels, ["10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
        assert!(axis.fraction(1e-5).is_none());
        assert!(axis.fraction(0.0).is_none());
    }

    #[test]
    fn a_short_range_still_has_labels() {
        let axis = Axis::log("x", [0.3, 0.31]);
        let labels: Vec<_> = axis.ticks().into_iter().filter_map(|(_, label)| label).collect();
        assert_eq!(labels, ["0.1", "0.2", "0.5"]);
    }

    #[test]
    fn a_linear_axis_labels_round_numbers() {
        let labels = |low: f64, high: f64| -> Vec<String> {
            Axis::between("x", [low, high]).ticks().into_iter().filter_map(|tick| tick.1).collect()
        };
        assert_eq!(labels(-0.1, 1.05), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(0.0, 10.0), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels(-1.2, 1.2), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(0.0, 3e-7), ["0", "1.0×10⁻⁷", "2.0×10⁻⁷", "3.0×10⁻⁷"]);
        let single = Axis::linear("x", [2.0]);
        assert!((single.fraction(2.0).unwrap() - 0.5).abs() < 1e-9);
        assert_eq!(single.clamped(-7.0), 0.0);
    }
}

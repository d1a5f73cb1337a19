//! Numbers and text for people.

use crate::case::Measure;
use std::time::{SystemTime, UNIX_EPOCH};

/// Text for HTML and SVG, in element content and in quoted attributes.
pub(crate) fn escape(text: &str) -> String {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    escaped.replace('"', "&quot;").replace('\'', "&#39;")
}

/// `digits` significant digits without trailing zeros, in powers of ten below 0.001 and from a million.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { format!("{value}") };
    }
    // Rounded first, so that 0.9999… becomes 1.
    let scientific = format!("{:.*e}", digits - 1, value);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').replace('-', "−"),
        false => text.replace('-', "−"),
    };
    if (-3..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return trimmed(&format!("{value:.decimals$}"));
    }
    format!("{}×{}", trimmed(mantissa), power_of_ten(exponent))
}

/// An error: relative ones from a hundredth of a percent on in percent.
pub(crate) fn error(value: f64, measure: Measure) -> String {
    if measure == Measure::Relative && value >= 0.999e-4 {
        return format!("{} %", significant(100.0 * value, 2));
    }
    significant(value, 2)
}

/// `10⁻³`
pub(crate) fn power_of_ten(exponent: i32) -> String {
    let superscript = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // ⁰ and ⁴ to ⁹ are neighbours in Unicode.
        other => char::from_u32(0x2070 + other.to_digit(10).unwrap_or(0)).unwrap_or(other),
    };
    let raised: String = exponent.to_string().chars().map(superscript).collect();
    format!("10{raised}")
}

/// A duration: `0.8 ms`, `0.35 s`, `12 s`, `3 min 05 s`.
pub(crate) fn seconds(value: f64) -> String {
    match value {
        v if v < 0.0995 => format!("{:.2} ms", 1e3 * v),
        v if v < 9.95 => format!("{v:.2} s"),
        v if v < 99.5 => format!("{v:.0} s"),
        v => format!("{} min {:02} s", v.round() as u64 / 60, v.round() as u64 % 60),
    }
}

/// A count with thin spaces between thousands: `12 300`.
pub(crate) fn count(value: u64) -> String {
    let plain = value.to_string();
    let mut grouped = String::new();
    for (index, digit) in plain.chars().enumerate() {
        if index > 0 && (plain.len() - index).is_multiple_of(3) {
            grouped.push('\u{202f}');
        }
        grouped.push(digit);
    }
    grouped
}

/// `2026-03-01 14:05:09 UTC`; times before 1970 as 1970.
pub(crate) fn utc(time: SystemTime) -> String {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let (days, second) = (since / 86_400, since % 86_400);
    // Howard Hinnant, "chrono-compatible low-level date algorithms": civil_from_days, years from 1 March.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + 400 * era + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn numbers_read_well() {
        let text = [4.16, -26.612, 0.99999999999, 1.2e-13, 0.0, 123456.0, -0.00123]
            .map(|value| significant(value, 8));
        assert_eq!(text, ["4.16", "−26.612", "1", "1.2×10⁻¹³", "0", "123456", "−0.00123"]);
        let errors = [0.9, 0.0034, 1e-4, 3.2e-9].map(|value| error(value, Measure::Relative));
        assert_eq!(errors, ["90 %", "0.34 %", "0.01 %", "3.2×10⁻⁹"]);
        assert_eq!(error(0.02, Measure::Absolute), "0.02");
        assert_eq!(
            [0.00123, 0.35, 12.3, 185.0].map(seconds),
            ["1.23 ms", "0.35 s", "12 s", "3 min 05 s"]
        );
    }

    #[test]
    fn dates_are_gregorian() {
        let at = |seconds| utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(at(951_827_696), "2000-02-29 12:34:56 UTC");
    }
}

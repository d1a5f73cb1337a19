//! Numbers and text for people.

use std::time::{SystemTime, UNIX_EPOCH};

/// Text for HTML and SVG, in element content and in quoted attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            // Control characters are not allowed in HTML, line ends and tabs are.
            c if c.is_control() && !matches!(c, '\n' | '\t') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Two significant digits as the thesis prints them: `0.087`, `15`, `6.5×10⁻³`.
pub(crate) fn two_digits(value: f64) -> String {
    digits(value, 2)
}

/// `digits` significant digits, in powers of ten below 0.01 and from 10 000.
pub(crate) fn digits(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { "–".into() };
    }
    // Rounded first, so that 0.00999 becomes 0.010 and not 1.0×10⁻².
    let scientific = format!("{:.*e}", digits - 1, value);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-2..4).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return format!("{value:.decimals$}");
    }
    format!("{mantissa}×{}", power_of_ten(exponent))
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

/// A duration: `12 µs`, `3.4 ms`, `2.1 s`, `3 min 20 s`, `1 h 05 min`.
pub(crate) fn seconds(value: f64) -> String {
    if value == 0.0 {
        "0".into()
    } else if value < 1e-6 {
        format!("{} ns", digits(value * 1e9, 2))
    } else if value < 1e-3 {
        format!("{} µs", digits(value * 1e6, 2))
    } else if value < 1.0 {
        format!("{} ms", digits(value * 1e3, 2))
    } else if value < 99.5 {
        format!("{} s", digits(value, 2))
    } else if value < 3600.0 {
        let whole = value.round() as u64;
        format!("{} min {:02} s", whole / 60, whole % 60)
    } else {
        let minutes = (value / 60.0).round() as u64;
        format!("{} h {:02} min", minutes / 60, minutes % 60)
    }
}

/// A factor: `1.1×`, `29×`, `4 100×`.
pub(crate) fn factor(value: f64) -> String {
    if value >= 1e6 {
        format!("{}×", digits(value, 2).replace('×', "·"))
    } else if value >= 99.5 {
        format!("{}×", count(digits_rounded(value, 2) as u64))
    } else {
        format!("{}×", digits(value, 2))
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

/// `value` rounded to `digits` significant digits.
pub(crate) fn digits_rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let unit = 10f64.powi(value.abs().log10().floor() as i32 + 1 - digits);
    (value / unit).round() * unit
}

/// `2026-03-01 14:05:09 UTC`. Times before 1970 are shown as 1970.
pub fn utc_timestamp(time: SystemTime) -> String {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let (days, second) = (since / 86_400, since % 86_400);
    // Howard Hinnant, "chrono-compatible low-level date algorithms": civil_from_days,
    // years counted from 1 March.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute) = (second / 3600, second / 60 % 60);
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{:02} UTC", second % 60)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn numbers_read_as_in_the_thesis() {
        for (value, text) in [
            (6.5e-3, "6.5×10⁻³"),
            (0.087, "0.087"),
            (0.01, "0.010"),
            (0.009_99, "0.010"),
            (1.7, "1.7"),
            (15.7, "16"),
            (9.96, "10"),
            (123.0, "123"),
            (12_345.0, "1.2×10⁴"),
            (-1.2e-9, "-1.2×10⁻⁹"),
            (0.0, "0"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(two_digits(value), text);
        }
    }

    #[test]
    fn durations_and_factors() {
        for (value, text) in [
            (2.1e-4, "210 µs"),
            (0.0123, "12 ms"),
            (2.14, "2.1 s"),
            (200.0, "3 min 20 s"),
            (3900.0, "1 h 05 min"),
        ] {
            assert_eq!(seconds(value), text);
        }
        assert_eq!(factor(1.09), "1.1×");
        assert_eq!(factor(295.2), "300×");
        assert_eq!(factor(4_123.0), "4\u{202f}100×");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn dates_follow_the_calendar() {
        for (since, text) in [
            (0, "1970-01-01 00:00:00 UTC"),
            (951_782_400, "2000-02-29 00:00:00 UTC"),
            (1_767_225_599, "2025-12-31 23:59:59 UTC"),
        ] {
            assert_eq!(utc_timestamp(UNIX_EPOCH + Duration::from_secs(since)), text);
        }
    }

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(
            escape("<a b='c' d=\"e\">&\u{7}"),
            "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt;&amp;\u{fffd}"
        );
    }
}

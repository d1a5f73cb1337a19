//! Numbers for people.

/// `digits` significant digits: `0.087`, `6.5×10⁻³`; in powers of ten below 0.01 and from 10 000.
/// NaN is written as `–`, infinity as `∞`.
pub fn digits(value: f64, digits: usize) -> String {
    number(value, digits, -2..4)
}

/// A value beside its error, down to the first digit of that, with `least` [`digits`]: `1.00000090×10⁶` beside 0.05.
///
/// ```
/// use sinew_report::format::digits_beside;
///
/// assert_eq!(digits_beside(1_000_000.9, 0.05, 3), "1.00000090×10⁶");
/// ```
pub fn digits_beside(value: f64, error: f64, least: usize) -> String {
    let place = |value: f64| value.abs().log10().floor();
    let needed = place(value) - place(error) + 1.0;
    // A cast saturates at 0.
    digits(value, least.max(if needed.is_finite() { needed.min(15.0) as usize } else { 0 }))
}

/// At most `digits` significant digits, without zeros at the end; in powers of ten below 0.001 and from a million.
pub fn trimmed(value: f64, digits: usize) -> String {
    let text = number(value, digits, -3..6);
    let (mantissa, power) = text.split_once('×').unwrap_or((&text, ""));
    if !mantissa.contains('.') {
        return text;
    }
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    if power.is_empty() { mantissa.into() } else { format!("{mantissa}×{power}") }
}

fn number(value: f64, digits: usize, plain: std::ops::Range<i32>) -> String {
    let sign = if value < 0.0 { "−" } else { "" };
    let value = value.abs();
    if value.is_nan() {
        return "–".into();
    } else if value == 0.0 {
        return "0".into();
    } else if value.is_infinite() {
        return format!("{sign}∞");
    }
    // Rounded first, so that 0.00999 becomes 0.010 and not 1.0×10⁻².
    let scientific = format!("{:.*e}", digits.max(1) - 1, value);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if plain.contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return format!("{sign}{value:.decimals$}");
    }
    format!("{sign}{mantissa}×{}", power_of_ten(exponent))
}

/// `10⁻³`
pub fn power_of_ten(exponent: i32) -> String {
    let superscript = |sign: char| match sign.to_digit(10) {
        Some(digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize).unwrap_or(sign),
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(superscript).collect::<String>())
}

/// A duration \[s\]: `12 µs`, `3.4 ms`, `2.1 s`, `3 min 20 s`, `1 h 05 min`.
pub fn seconds(value: f64) -> String {
    let whole = |unit: f64| (value / unit).round() as u64;
    match value {
        v if v == 0.0 || !v.is_finite() => digits(v, 2),
        v if v < 0.9995e-6 => format!("{} ns", digits(v * 1e9, 2)),
        v if v < 0.9995e-3 => format!("{} µs", digits(v * 1e6, 2)),
        v if v < 0.9995 => format!("{} ms", digits(v * 1e3, 2)),
        v if v < 99.5 => format!("{} s", digits(v, 2)),
        v if v < 3599.5 => format!("{} min {:02} s", whole(1.0) / 60, whole(1.0) % 60),
        _ => format!("{} h {:02} min", whole(60.0) / 60, whole(60.0) % 60),
    }
}

/// A factor: `1.1×`, `29×`, `4 100×`.
pub fn factor(value: f64) -> String {
    let whole = (99.5..1e6).contains(&value);
    let number = if whole { count(rounded(value, 2) as u64) } else { digits(value, 2) };
    format!("{number}×")
}

/// A count with thin spaces between thousands: `12 300`.
pub fn count(value: u64) -> String {
    let plain = value.to_string();
    let groups = plain.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join("\u{202f}")
}

/// `value` rounded to so many significant digits.
pub fn rounded(value: f64, digits: usize) -> f64 {
    // Through text, so that the result is the number that the digits name.
    format!("{value:.*e}", digits.max(1) - 1).parse().unwrap_or(value)
}

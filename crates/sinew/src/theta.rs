//! θ from the command line and from tables.

use crate::case::{number_and_unit, stress_in_kpa};
use sinew_energy::{Body, Parameter};
use sinew_report::format::trimmed;
use std::path::Path;

/// θ that cannot be read, with the place, the parameter and its range.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct ThetaText {
    place: String,
    reason: String,
}

/// θ by name, with units.
pub fn theta_in_words(body: &Body, theta: &[f64]) -> String {
    if theta.is_empty() {
        return "all parameters known".into();
    }
    let pair = |(p, value): (&Parameter, &f64)| {
        format!("{} = {}{}", p.name, trimmed(*value, 6), spoken(&p.unit))
    };
    body.parameters.iter().zip(theta).map(pair).collect::<Vec<_>>().join(", ")
}

/// A unit behind a number; nothing for numbers without one.
pub(crate) fn spoken(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// θ from `name=value` pairs separated by commas, in any order, such as `mu=75,lambda=80` or `p=7mmHg`. Without a unit a
/// value has that of its parameter.
///
/// # Errors
/// A name that is not a parameter, is missing or given twice; a value that is not a number, or has another unit.
///
/// ```
/// use sinew::{Parameter, Sampling, parse_theta};
/// let parameter = |name: &str| Parameter {
///     name: name.into(), unit: "kPa".into(), range: [1.0, 2.0], sampling: Sampling::Log,
/// };
/// let parameters = [parameter("mu"), parameter("lambda")];
/// assert_eq!(parse_theta("lambda=1.5, mu=2", &parameters).unwrap(), [2.0, 1.5]);
/// let error = parse_theta("mu=1,lamda=2", &parameters).unwrap_err().to_string();
/// assert!(error.contains("did you mean `lambda`?"), "{error}");
/// ```
pub fn parse_theta(text: &str, parameters: &[Parameter]) -> Result<Vec<f64>, ThetaText> {
    let error = |reason| ThetaText { place: "--theta".into(), reason };
    let (mut names, mut values) = (Vec::new(), Vec::new());
    for pair in text.split(',').map(str::trim).filter(|pair| !pair.is_empty()) {
        let (name, value) = pair
            .split_once('=')
            .ok_or_else(|| error(format!("`{pair}` is not a name=value pair, such as mu=75")))?;
        names.push(name.trim());
        values.push(value.trim());
    }
    let columns = columns(&names, parameters).map_err(error)?;
    let read = |(parameter, &column): (&Parameter, &usize)| number(values[column], "", parameter);
    parameters.iter().zip(&columns).map(read).collect::<Result<_, _>>().map_err(error)
}

/// θ from a CSV table: names in the first line, such as `mu,lambda` or `a,p [mmHg]`, in any order; a row per θ. Empty lines
/// and those that begin with `#` are left out.
///
/// # Errors
/// A file that cannot be read; a column that is not a parameter or missing; no row, or one with a number too few, too many or
/// that is none, with its line.
pub fn read_thetas(path: &Path, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>, ThetaText> {
    let file = path.display();
    let text = std::fs::read_to_string(path)
        .map_err(|error| ThetaText { place: file.to_string(), reason: error.to_string() })?;
    let error = |line: usize, reason| ThetaText { place: format!("{file}, line {line}"), reason };
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let Some((first, header)) = lines.next() else {
        return Err(error(
            1,
            format!("the table is empty; begin with a line of names: {}", listed(parameters)),
        ));
    };
    let heads: Vec<(&str, &str)> =
        header.trim_start_matches('\u{feff}').split(',').map(head).collect();
    let names: Vec<&str> = heads.iter().map(|(name, _)| *name).collect();
    let columns = columns(&names, parameters).map_err(|reason| error(first, reason))?;
    let row = |(line, text): (usize, &str)| {
        let cells: Vec<&str> = text.split(',').map(str::trim).collect();
        if cells.len() != heads.len() {
            let reason = format!(
                "{} values for the {} columns {}",
                cells.len(),
                heads.len(),
                names.join(", ")
            );
            return Err(error(line, reason));
        }
        let read = |(parameter, &column): (&Parameter, &usize)| {
            number(cells[column], heads[column].1, parameter)
        };
        let theta: Result<Vec<f64>, String> = parameters.iter().zip(&columns).map(read).collect();
        theta.map_err(|reason| error(line, reason))
    };
    let thetas: Vec<_> = lines.map(row).collect::<Result<_, _>>()?;
    match thetas.is_empty() {
        true => Err(error(first, "only names; add a row of numbers below them".into())),
        false => Ok(thetas),
    }
}

/// What to say about parameters outside their ranges.
pub fn outside(parameters: &[Parameter], theta: &[f64]) -> Vec<String> {
    let say = |(parameter, value): (&Parameter, &f64)| {
        let Parameter { name, unit, range: [low, high], .. } = parameter;
        // Rounding of a bound that went through a text does not call for a warning.
        let slack = 1e-9 * low.abs().max(high.abs());
        let inside = (low - slack..=high + slack).contains(value);
        (!inside).then(|| {
            let [value, low, high] = [*value, *low, *high].map(|x| trimmed(x, 12));
            format!("{name} = {value} {unit} is outside its range from {low} to {high} {unit}")
        })
    };
    parameters.iter().zip(theta).filter_map(say).collect()
}

/// Name and unit of a column, such as `p [mmHg]`.
fn head(text: &str) -> (&str, &str) {
    let text = text.trim().trim_matches('"');
    match text.split_once('[') {
        Some((name, unit)) => (name.trim(), unit.trim().trim_end_matches(']').trim()),
        None => (text, ""),
    }
}

/// Where each parameter stands among names.
fn columns(names: &[&str], parameters: &[Parameter]) -> Result<Vec<usize>, String> {
    let known = || parameters.iter().map(|parameter| parameter.name.as_str());
    if let Some(name) = names.iter().find(|name| known().all(|known| known != **name)) {
        return Err(format!(
            "`{name}` is not a parameter{}",
            crate::case::advise(name, known(), "parameters")
        ));
    }
    let column = |parameter: &Parameter| {
        let mut found = (0..names.len()).filter(|&column| names[column] == parameter.name);
        match (found.next(), found.next()) {
            (Some(column), None) => Ok(column),
            (Some(_), Some(_)) => Err(format!("`{}` is there twice", parameter.name)),
            (None, _) => Err(format!(
                "{} is missing; give all of {}",
                described(parameter),
                listed(parameters)
            )),
        }
    };
    parameters.iter().map(column).collect()
}

/// A value in the unit of its parameter; its own unit, or the given one, is converted.
fn number(text: &str, unit: &str, parameter: &Parameter) -> Result<f64, String> {
    let (digits, own) = number_and_unit(text);
    let value: f64 = match digits.parse() {
        Ok(value) if f64::is_finite(value) => value,
        _ => return Err(format!("`{text}` is not a finite number for {}", described(parameter))),
    };
    let unit = if own.is_empty() { unit } else { own };
    if unit.is_empty() || unit == parameter.unit {
        return Ok(value);
    }
    match (stress_in_kpa(unit), stress_in_kpa(&parameter.unit)) {
        (Some(given), Some(expected)) => Ok(value * given / expected),
        _ => Err(format!("`{text}` is in {unit}, but {}", described(parameter))),
    }
}

fn described(parameter: &Parameter) -> String {
    let Parameter { name, unit, range: [low, high], .. } = parameter;
    let unit = if unit == "1" { "" } else { unit };
    format!("{name} (from {low} to {high} {unit}").trim_end().to_string() + ")"
}

fn listed(parameters: &[Parameter]) -> String {
    parameters.iter().map(|parameter| parameter.name.as_str()).collect::<Vec<_>>().join(",")
}

//! θ from the command line and from tables.

use crate::case::{advise, number_and_unit, stress};
use sinew_emulate::is_inside;
use sinew_energy::{Body, Parameter, Unit, Units, requirement};
use sinew_mesh::text_of;
use sinew_report::format::trimmed;
use std::ops::RangeInclusive;
use std::path::Path;

/// θ that cannot be read, with the place, the parameter and its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct ThetaText {
    pub(crate) place: String,
    pub(crate) reason: String,
}

/// θ by name, in the parameters' own units.
pub fn theta_in_words(body: &Body, theta: &[f64]) -> String {
    values_in_words(&body.parameters, theta)
}

/// [`theta_in_words`] of parameters without a body.
pub fn values_in_words(parameters: &[Parameter], theta: &[f64]) -> String {
    if theta.is_empty() {
        return "all parameters known".into();
    }
    let pair = |(p, value): (&Parameter, &f64)| format!("{} = {}", p.name, said(p, *value, 6));
    parameters.iter().zip(theta).map(pair).collect::<Vec<_>>().join(", ")
}

/// Heads of columns of parameters in their own units, such as `p [mmHg]`.
pub fn heads(parameters: &[Parameter]) -> Vec<String> {
    parameters.iter().map(|parameter| parameter.unit.head(&parameter.name)).collect()
}

/// A parameter with its range, in its own unit: `p from 4 to 10 mmHg`.
pub fn range_in_words(parameter: &Parameter) -> String {
    format!("{} {}", parameter.name, range(parameter))
}

fn range(parameter: &Parameter) -> String {
    let ends = |digits| parameter.range.map(|end| trimmed(parameter.unit.shown(end), digits));
    // Ends of a narrow range are told apart.
    let [low, high] = if ends(6)[0] == ends(6)[1] { ends(12) } else { ends(6) };
    format!("from {low} to {high}{}", parameter.unit.suffix())
}

/// A value in the parameter's own unit.
fn said(parameter: &Parameter, value: f64, digits: usize) -> String {
    let shown = parameter.unit.shown(value);
    let number = if shown.is_nan() { "NaN".into() } else { trimmed(shown, digits) };
    number + &parameter.unit.suffix()
}

/// θ from `name=value` pairs separated by commas, in any order, such as `mu=75,lambda=80` or `p=7mmHg`. Without a unit a
/// value has that of its parameter.
///
/// # Errors
/// A name that is not a parameter, is missing or given twice; a value that is not a number, or has another unit.
///
/// ```
/// use sinew::{Parameter, parse_theta};
/// let parameters = ["mu", "lambda"].map(|name| Parameter::log(name, "kPa", 1.0..=2.0));
/// assert_eq!(parse_theta("lambda=1.5, mu=2000 Pa", &parameters).unwrap(), [2.0, 1.5]);
/// let error = parse_theta("mu=1,lamda=2", &parameters).unwrap_err().to_string();
/// assert!(error.contains("did you mean `lambda`?"), "{error}");
/// ```
pub fn parse_theta(text: &str, parameters: &[Parameter]) -> Result<Vec<f64>, ThetaText> {
    parse_theta_but(text, parameters, None)
}

/// [`parse_theta`] of a text that may lack one parameter, which is given by its place and its value then.
///
/// # Errors
/// As [`parse_theta`].
pub fn parse_theta_but(
    text: &str,
    parameters: &[Parameter],
    spare: Option<(usize, f64)>,
) -> Result<Vec<f64>, ThetaText> {
    let error = |reason| ThetaText { place: format!("--theta {text}"), reason };
    let (mut names, mut values) = (Vec::new(), Vec::new());
    for pair in text.split(',').map(str::trim).filter(|pair| !pair.is_empty()) {
        let (name, value) = pair
            .split_once('=')
            .ok_or_else(|| error(format!("`{pair}` is not a name=value pair, such as mu=75")))?;
        if value.contains('=') {
            return Err(error(format!("`{pair}` holds two pairs; separate them by commas")));
        }
        names.push(name.trim());
        values.push(value.trim());
    }
    let spare = spare.filter(|&(index, _)| !names.contains(&parameters[index].name.as_str()));
    if let Some((index, _)) = spare {
        names.push(&parameters[index].name);
        values.push("0");
    }
    let mut theta = named(&names, &values, parameters).map_err(error)?;
    if let Some((index, value)) = spare {
        theta[index] = value;
    }
    Ok(theta)
}

/// θ from names and texts such as `("p", "7 mmHg")`, in any order, as [`parse_theta`].
///
/// # Errors
/// As [`parse_theta`].
///
/// ```
/// use sinew::{Parameter, theta_of};
/// let parameters = ["mu", "lambda"].map(|name| Parameter::log(name, "kPa", 1.0..=2.0));
/// assert_eq!(theta_of(&[("lambda", "1.5"), ("mu", "2000 Pa")], &parameters).unwrap(), [2.0, 1.5]);
/// ```
pub fn theta_of<T: AsRef<str>>(
    pairs: &[(T, T)],
    parameters: &[Parameter],
) -> Result<Vec<f64>, ThetaText> {
    let (names, values): (Vec<&str>, Vec<&str>) =
        pairs.iter().map(|(name, value)| (name.as_ref().trim(), value.as_ref().trim())).unzip();
    let error = |reason| ThetaText { place: "theta".into(), reason };
    named(&names, &values, parameters).map_err(error)
}

/// Values by name, each in its parameter's unit unless it names its own.
fn named(names: &[&str], values: &[&str], parameters: &[Parameter]) -> Result<Vec<f64>, String> {
    let columns = columns(names, parameters)?;
    let read = |(parameter, &column): (&Parameter, &usize)| {
        number(values[column], &parameter.unit, parameter)
    };
    parameters.iter().zip(&columns).map(read).collect()
}

/// A parameter, by its place in θ, with the ends of a way along it, from `name=START..END` such as `p=0..8mmHg`. Without a unit
/// an end has that of its parameter; beside an end in another unit only 0 may have none.
///
/// # Errors
/// A text of another form, a name that is not a parameter, an end that is not a number or has another unit, ends that are the same,
/// an end whose unit may be either of two.
///
/// ```
/// use sinew::{Parameter, parse_way};
/// let parameters = ["mu", "p"].map(|name| Parameter::linear(name, "kPa", 1.0..=2.0));
/// assert_eq!(parse_way("p=0..2000 Pa", &parameters).unwrap(), (1, [0.0, 2.0]));
/// let error = parse_way("q=0..2", &parameters).unwrap_err().to_string();
/// assert!(error.contains("`q` is not a parameter"), "{error}");
/// ```
pub fn parse_way(text: &str, parameters: &[Parameter]) -> Result<(usize, [f64; 2]), ThetaText> {
    let error = |reason| ThetaText { place: format!("--along {text}"), reason };
    let ends = text.split_once('=').and_then(|(name, ends)| Some((name, ends.split_once("..")?)));
    let Some((name, (start, end))) = ends else {
        return Err(error("give a parameter and two ends, such as p=0..8mmHg".into()));
    };
    let index = place(name.trim(), parameters).map_err(error)?;
    let parameter = &parameters[index];
    let (start, end) = (start.trim(), end.trim());
    if end.starts_with('.') {
        let reason = "write two points between the ends, such as 8..16, and fractions as 0.16";
        return Err(error(reason.into()));
    }
    let read = |text| number(text, &parameter.unit, parameter).map_err(error);
    let ends = [read(start)?, read(end)?];
    // 0 is the same in all units.
    for (bare, value, other) in [(start, ends[0], end), (end, ends[1], start)] {
        let (without, unit) = (number_and_unit(bare).1.is_empty(), number_and_unit(other).1);
        let size = |unit: &Unit| unit.in_scene(1.0);
        let differs = unit_of(unit, parameter).is_ok_and(|u| size(&u) != size(&parameter.unit));
        if without && value != 0.0 && differs {
            let own = parameter.unit.name();
            let reason = format!(
                "`{bare}` has no unit, and the other end is in {unit}; write {bare}{own} or {bare}{unit}"
            );
            return Err(error(reason));
        }
    }
    match ends[0] == ends[1] {
        true => {
            Err(error(format!("both ends are {}; give two values", parameter.unit.format(ends[0]))))
        }
        false => Ok((index, ends)),
    }
}

/// θ of the frames of a way along a parameter, given by its place in θ with two ends; there is one frame more than steps.
///
/// ```
/// assert_eq!(sinew::thetas_along(&[7.0, 0.0], (1, [0.0, 8.0]), 2)[1], [7.0, 4.0]);
/// ```
pub fn thetas_along(theta: &[f64], (index, ends): (usize, [f64; 2]), steps: u32) -> Vec<Vec<f64>> {
    let at = |frame: u32| {
        let part = f64::from(frame) / f64::from(steps.max(1));
        let mut theta = theta.to_vec();
        // Without rounding at either end.
        theta[index] = (1.0 - part) * ends[0] + part * ends[1];
        theta
    };
    (0..=steps).map(at).collect()
}

/// θ from a CSV table, as [`read_rows`]; every row must be one.
///
/// # Errors
/// As [`read_rows`], and the first row that cannot be read.
pub fn read_thetas(path: &Path, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>, ThetaText> {
    read_rows(path, parameters)?.into_iter().map(|(_, row)| row).collect()
}

/// A line of a table, counted from 1, and what stands there.
pub type TableRow = (usize, Result<Vec<f64>, ThetaText>);

/// θ from a CSV table: names in the first line, such as `mu,lambda` or `a,p [mmHg]`, in any order; a row per θ. Without a unit
/// in its head a column has that of its parameter. Empty lines and those that begin with `#` are left out, but for
/// names behind a `#` right above the numbers, as NumPy writes them. A row with a number
/// too few, too many or malformed is an error of its own, with its line.
///
/// # Errors
/// A file that cannot be read; a column that is missing, is not a parameter or has another unit; no row.
pub fn read_rows(path: &Path, parameters: &[Parameter]) -> Result<Vec<TableRow>, ThetaText> {
    let file = path.display();
    let unread = |reason: String| ThetaText {
        place: format!("--theta {file}"),
        reason: format!("{reason}; name a CSV table, or give {}", example(parameters)),
    };
    let text = table_text(path).map_err(unread)?;
    let error = |line: usize, reason| ThetaText { place: format!("{file}, line {line}"), reason };
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !is_comment(line));
    // NumPy writes names behind a #, in the last comment before the numbers.
    let comments = (1..).zip(text.lines()).take_while(|(_, line)| is_comment(line));
    let named = comments.map(|(at, line)| (at, line.trim().trim_start_matches('#'))).last();
    let is_number = |row: &str| row.split(',').any(|cell| cell.trim().parse::<f64>().is_ok());
    let named = named.filter(|(_, line)| {
        let heads = cells(line);
        let names: Vec<&str> = heads.iter().map(|text| head(text).0).collect();
        let below = lines.clone().next().is_some_and(|(_, row)| is_number(row));
        below && columns(&names, parameters).is_ok()
    });
    let Some((first, header)) = named.or_else(|| lines.next()) else {
        let names = listed(parameters);
        return Err(error(1, format!("the table is empty; begin with a line of names: {names}")));
    };
    let heads = cells(header);
    let heads: Vec<(&str, &str)> = heads.iter().map(|text| head(text)).collect();
    let names: Vec<&str> = heads.iter().map(|(name, _)| *name).collect();
    let columns = columns(&names, parameters).map_err(|reason| {
        let other = [';', '\t'].into_iter().find(|&mark| header.contains(mark));
        let advice = match other {
            Some(_) => "; separate columns by commas, with points in decimals",
            None if matches!(names[0], "" | "case") => {
                "; leave the first column out (in pandas: to_csv with index=False)"
            }
            None if reason.contains("; parameters: ") => {
                "; name them alone in the first line, by commas, each with its unit as in `p [mmHg]`"
            }
            None => "",
        };
        error(first, reason + advice)
    })?;
    let unit = |(p, &column): (&Parameter, &usize)| match heads[column].1 {
        "" => Ok(p.unit.clone()),
        given => unit_of(given, p)
            .map_err(|reason| error(first, format!("the column `{}`: {reason}", names[column]))),
    };
    let units: Vec<Unit> = parameters.iter().zip(&columns).map(unit).collect::<Result<_, _>>()?;
    let row = |line: usize, text: &str| {
        let cells = cells(text);
        if cells.len() != heads.len() {
            let (found, wanted, names) = (cells.len(), heads.len(), names.join(", "));
            let reason = format!(
                "{found} values for the {wanted} columns {names}; give one for each column"
            );
            return Err(error(line, reason));
        }
        let read = |((parameter, &column), unit): ((&Parameter, &usize), &Unit)| {
            number(&cells[column], unit, parameter)
        };
        let theta: Result<Vec<f64>, String> =
            parameters.iter().zip(&columns).zip(&units).map(read).collect();
        theta.map_err(|reason| error(line, reason))
    };
    let rows: Vec<_> = lines.map(|(line, text)| (line, row(line, text))).collect();
    match rows.is_empty() {
        true => Err(error(first, "only names; add a row of numbers below them".into())),
        false => Ok(rows),
    }
}

/// Text of a table; the reason where there is none. Lines may be in Latin-1.
pub(crate) fn table_text(path: &Path) -> Result<String, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    match bytes.contains(&0) {
        true => Err("it is not text, or is text in UTF-16, to be saved in UTF-8".into()),
        false => {
            let lines: Vec<String> = bytes.split(|&byte| byte == b'\n').map(text_of).collect();
            Ok(lines.join("\n").trim_start_matches('\u{feff}').into())
        }
    }
}

pub(crate) fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.trim().starts_with('#')
}

/// Cells of a line of a CSV table, without quotes; commas between quotes are part of a cell, and doubled quotes there are one.
pub(crate) fn cells(line: &str) -> Vec<String> {
    let mut quoted = false;
    let divides = |c: char| {
        quoted ^= c == '"';
        c == ',' && !quoted
    };
    let bare = |cell: &str| match cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')) {
        Some(quoted) => quoted.trim().replace("\"\"", "\""),
        None => cell.into(),
    };
    line.split(divides).map(|cell| bare(cell.trim())).collect()
}

/// Requires values that the body's law has a meaning for.
///
/// # Errors
/// The first value outside, in words.
pub fn admissible(body: &Body, theta: &[f64]) -> Result<(), String> {
    let of_law = body.material.parameters().len();
    for (index, (parameter, &value)) in body.parameters.iter().zip(theta).enumerate() {
        let bounds = if index < of_law { body.material.bounds(index) } else { f64::MIN..=f64::MAX };
        if !bounds.contains(&value) {
            let required = required(parameter, &body.units, &bounds, value);
            let (name, value) = (&parameter.name, parameter.unit.format(value));
            return Err(format!("{name} = {value} makes no sense; it must be {required}"));
        }
    }
    Ok(())
}

/// Bounds of a parameter's law, for a value outside; these have numbers in the unit of the scene, which is said where the parameter
/// has another.
pub(crate) fn required(
    parameter: &Parameter,
    units: &Units,
    bounds: &RangeInclusive<f64>,
    value: f64,
) -> String {
    let words = requirement(bounds, value);
    match parameter.unit.is_scene() || !words.contains(|c: char| c.is_ascii_digit()) {
        true => words,
        false => format!("{words} ({})", parameter.unit.of_scene(units)),
    }
}

/// Warnings about parameters outside their ranges.
pub fn outside(parameters: &[Parameter], theta: &[f64]) -> Vec<String> {
    let say = |(parameter, value): (&Parameter, &f64)| {
        (!is_inside(parameter, *value)).then(|| {
            let value = said(parameter, *value, 12);
            format!("{} = {value} is outside its range {}", parameter.name, range(parameter))
        })
    };
    parameters.iter().zip(theta).filter_map(say).collect()
}

/// Name and unit of a column, such as `p [mmHg]`.
pub(crate) fn head(text: &str) -> (&str, &str) {
    match text.split_once('[') {
        Some((name, unit)) => (name.trim(), unit.trim().trim_end_matches(']').trim()),
        None => (text, ""),
    }
}

/// Place in θ of the parameter of a name.
fn place(name: &str, parameters: &[Parameter]) -> Result<usize, String> {
    parameters.iter().position(|parameter| parameter.name == name).ok_or_else(|| {
        let known = parameters.iter().map(|parameter| parameter.name.as_str());
        format!("`{name}` is not a parameter{}", advise(name, known, "parameters"))
    })
}

/// Place of each parameter among names.
fn columns(names: &[&str], parameters: &[Parameter]) -> Result<Vec<usize>, String> {
    names.iter().try_for_each(|name| place(name, parameters).map(drop))?;
    let column = |parameter: &Parameter| {
        let mut found = (0..names.len()).filter(|&column| names[column] == parameter.name);
        match (found.next(), found.next()) {
            (Some(column), None) => Ok(column),
            (Some(_), Some(_)) => Err(format!("`{}` is there twice; keep one", parameter.name)),
            (None, _) => Err(format!(
                "{} is missing; give all of {}",
                described(parameter),
                listed(parameters)
            )),
        }
    };
    parameters.iter().map(column).collect()
}

/// A value in the unit of the scene; it is in the given unit unless it names its own.
fn number(text: &str, unit: &Unit, parameter: &Parameter) -> Result<f64, String> {
    let (digits, own) = number_and_unit(text);
    let value: f64 = match digits.parse() {
        Ok(value) if f64::is_finite(value) => value,
        _ if text.is_empty() => {
            return Err(format!("there is no value for {}", described(parameter)));
        }
        _ => return Err(format!("`{text}` is not a finite number for {}", described(parameter))),
    };
    match own {
        "" => Ok(unit.in_scene(value)),
        own if own.starts_with(',') => Err(format!(
            "`{text}` has a comma; write decimals with a point, and thousands without a mark"
        )),
        own => unit_of(own, parameter)
            .map(|unit| unit.in_scene(value))
            .map_err(|reason| format!("`{text}`: {reason}")),
    }
}

/// A unit that values of a parameter are given in.
fn unit_of(given: &str, parameter: &Parameter) -> Result<Unit, String> {
    if given == parameter.unit.name() {
        return Ok(parameter.unit.clone());
    }
    if let Ok(own) = stress(parameter.unit.name()) {
        let given = stress(given)?;
        // Both are known in kPa, which the scene need not be in.
        let per_kpa = parameter.unit.in_scene(1.0) / own.in_scene(1.0);
        return Ok(Unit::sized(given.name(), given.in_scene(per_kpa)));
    }
    let (name, own) = (&parameter.name, parameter.unit.name());
    Err(match own {
        "1" => format!("{name} is a number without unit, not in {given}; leave the unit out"),
        own => format!("{name} is in {own}, not in {given}"),
    })
}

fn described(parameter: &Parameter) -> String {
    format!("{} ({})", parameter.name, range(parameter))
}

/// θ on a command line: `mu=75,p=8`.
fn example(parameters: &[Parameter]) -> String {
    let pair = |p: &Parameter| format!("{}={}", p.name, p.unit.shown(p.range[0]));
    parameters.iter().map(pair).collect::<Vec<_>>().join(",")
}

fn listed(parameters: &[Parameter]) -> String {
    parameters.iter().map(|parameter| parameter.name.as_str()).collect::<Vec<_>>().join(",")
}

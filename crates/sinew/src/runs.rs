//! Stored runs of any solver: tables of numbers, arrays of displacements, and the files of their emulators' predictions.

use crate::case::advise;
use crate::npz;
use crate::output::{clear, failed, quoted};
use crate::theta::{ThetaText, cells, head, is_comment, one_each, outside, table_text};
use sinew_emulate::{Output, Predicted, Result as EmulatorResult, RunsEmulator, share_of};
use sinew_energy::Parameter;
use sinew_mesh::{AnyMesh, Field, MeshError};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Runs with their parameters, whose ranges are those of the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Runs {
    /// Parameters.
    pub parameters: Vec<Parameter>,
    /// Their values, run by run.
    pub thetas: Vec<Vec<f64>>,
    /// Results.
    pub outputs: Vec<Output>,
    /// Mesh of displacements.
    pub mesh: Option<AnyMesh>,
}

impl Runs {
    /// Reads a CSV table with a row per run and names in its first line, such as `mu [kPa],volume [ml]`. `parameters` lists the
    /// columns of the parameters, by names separated by commas or as the number of first columns. `outputs` lists
    /// those to be emulated; all others without it. Empty lines and those that begin with `#` are left out.
    ///
    /// # Errors
    /// A file that cannot be read, a column that is missing or has one value only, a cell that is not a finite number, two runs with
    /// the same parameters, too few runs; with line and column.
    pub fn read_table(
        path: &Path,
        parameters: Option<&str>,
        outputs: Option<&str>,
    ) -> Result<Self, ThetaText> {
        let file = path.display();
        let at = |place: &str, reason| ThetaText { place: format!("{file}{place}"), reason };
        let text = table_text(path).map_err(|reason| at("", reason))?;
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !is_comment(line));
        let (first, header) = lines.next().ok_or_else(|| at("", "the table is empty".into()))?;
        let heads = cells(header);
        let heads: Vec<(&str, &str)> = heads.iter().map(|text| head(text)).collect();
        let names: Vec<&str> = heads.iter().map(|(name, _)| *name).collect();
        let line = |line: usize, reason| at(&format!(", line {line}"), reason);
        if let Some(number) = names.iter().find(|name| name.parse::<f64>().is_ok()) {
            let reason =
                format!("`{number}` is no name; begin with a line of names of the columns");
            return Err(line(first, reason));
        }
        let chosen = |option: &str, list: &str| {
            columns(list, &names)
                .map_err(|reason| line(first, format!("{option} {list}: {reason}")))
        };
        let list = parameters.ok_or_else(|| {
            let names = names.join(", ");
            let how =
                "name the columns of the parameters, or tell how many come first: --parameters";
            line(first, format!("{how}; the columns are: {names}"))
        })?;
        let inputs = chosen("--parameters", list)?;
        let others = (0..names.len()).filter(|column| !inputs.contains(column)).collect();
        let results: Vec<usize> = outputs.map_or(Ok(others), |list| chosen("--outputs", list))?;
        if let Some(&both) = results.iter().find(|column| inputs.contains(column)) {
            let reason = format!("`{}` is among parameters and outputs; keep one", names[both]);
            return Err(line(first, reason));
        }
        if results.is_empty() {
            return Err(line(first, "no column is left for an output".into()));
        }
        let (mut rows, mut numbers) = (Vec::new(), Vec::new());
        for (number, text) in lines {
            let cells = cells(text);
            one_each(&cells, &names).map_err(|reason| line(number, reason))?;
            let value = |&column: &usize| match cells[column].parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(line(number, wrong(names[column], &cells[column]))),
            };
            let row = inputs.iter().chain(&results).map(value);
            rows.push(row.collect::<Result<Vec<f64>, _>>()?);
            numbers.push(number);
        }
        let column = |place: usize| -> Vec<f64> { rows.iter().map(|row| row[place]).collect() };
        let output = |(place, &column_of): (usize, &usize)| {
            let values = column(inputs.len() + place);
            let (name, unit) = heads[column_of];
            varied(name, &values).map_err(|reason| at("", reason))?;
            let unit = if unit.is_empty() { "1" } else { unit }.into();
            let values = values.into_iter().map(|value| vec![value]).collect();
            Ok(Output { name: name.into(), unit, values })
        };
        let outputs = results.iter().enumerate().map(output).collect::<Result<_, ThetaText>>()?;
        let thetas = rows.iter().map(|row| row[..inputs.len()].to_vec()).collect();
        let heads: Vec<_> = inputs.iter().map(|&column| heads[column]).collect();
        let said = |run: usize| format!("line {}", numbers[run]);
        Self::of(&heads, thetas, outputs, said).map_err(|reason| at("", reason))
    }

    /// Reads an archive of `numpy.savez`: `theta` (runs × parameters) and `displacements` (runs × nodes × 3), in the order of the
    /// nodes of a mesh file and in its unit. `parameters` lists names, `x1`, `x2` and so on without it.
    ///
    /// # Errors
    /// A file that cannot be read, arrays whose shapes do not fit each other or the mesh, and as [`Runs::read_table`].
    pub fn read_fields(
        path: &Path,
        mesh: &Path,
        parameters: Option<&str>,
    ) -> Result<Self, ThetaText> {
        let at = |path: &Path, reason| ThetaText { place: path.display().to_string(), reason };
        let array = |name| npz::read(path, name).map_err(|error| at(path, error.to_string()));
        let ((shape, theta), (of_fields, fields)) = (array("theta")?, array("displacements")?);
        let (&[runs, count], &[cases, nodes, 3]) = (&shape[..], &of_fields[..]) else {
            let [theta, fields] = [&shape, &of_fields].map(|shape| by(shape));
            let wanted = "give runs × parameters and runs × nodes × 3";
            let reason = format!("theta is {theta} and displacements are {fields}; {wanted}");
            return Err(at(path, reason));
        };
        if runs != cases || count == 0 {
            let reason = format!("theta has {runs} runs and displacements {cases}; give as many");
            return Err(at(path, reason));
        }
        let (read, report) = sinew_mesh::read(mesh).map_err(|error| at(mesh, error.to_string()))?;
        let points = read.points().len();
        if points != nodes {
            let changes: String = report.changes().iter().map(|said| format!("; {said}")).collect();
            let reason = format!("{points} nodes for {nodes} of the displacements{changes}");
            return Err(at(mesh, reason));
        }
        let lost = |values: &[f64], each: usize| {
            values.iter().position(|value| !value.is_finite()).map(|place| place / each)
        };
        if let Some(run) = lost(&theta, count).or(lost(&fields, 3 * nodes)) {
            return Err(at(
                path,
                format!("run {run}, counted from 0, is not finite; leave it out"),
            ));
        }
        let names = match parameters {
            Some(list) => cells(list),
            None => (1..=count).map(|place| format!("x{place}")).collect(),
        };
        if names.len() != count {
            let reason = format!("--parameters: {} names for {count} parameters", names.len());
            return Err(at(path, reason));
        }
        let heads: Vec<_> = names.iter().map(|name| head(name)).collect();
        let thetas = theta.chunks(count).map(<[f64]>::to_vec).collect();
        let values = fields.chunks(3 * nodes).map(<[f64]>::to_vec).collect();
        let output = Output { name: "displacement".into(), unit: "mm".into(), values };
        let runs = Self::of(&heads, thetas, vec![output], |run| format!("run {run}"));
        let runs = runs.map_err(|reason| at(path, reason))?;
        Ok(Self { mesh: Some(read), ..runs })
    }

    /// Checks runs, and finds the ranges of their parameters.
    fn of(
        heads: &[(&str, &str)],
        thetas: Vec<Vec<f64>>,
        outputs: Vec<Output>,
        said: impl Fn(usize) -> String,
    ) -> Result<Self, String> {
        let (found, least) = (thetas.len(), 2 * (heads.len() + 1));
        if found < least {
            let count = heads.len();
            return Err(format!("{found} runs of {count} parameters; give at least {least}"));
        }
        let mut seen = HashMap::new();
        for (run, theta) in thetas.iter().enumerate() {
            let bits: Vec<u64> = theta.iter().map(|value| value.to_bits()).collect();
            if let Some(first) = seen.insert(bits, run) {
                let (first, second) = (said(first), said(run));
                return Err(format!("{first} and {second} have the same parameters; keep one"));
            }
        }
        let range = |(place, &(name, unit)): (usize, &(&str, &str))| {
            let values: Vec<f64> = thetas.iter().map(|theta| theta[place]).collect();
            varied(name, &values)?;
            Ok(parameter(name, unit, values))
        };
        let parameters = heads.iter().enumerate().map(range).collect::<Result<_, String>>()?;
        Ok(Self { parameters, thetas, outputs, mesh: None })
    }

    /// Emulator of the runs.
    ///
    /// # Errors
    /// As [`RunsEmulator::fit`].
    pub fn train(self) -> EmulatorResult<RunsEmulator> {
        RunsEmulator::fit(self.parameters, &self.thetas, &self.outputs, self.mesh)
    }
}

/// A shape in words.
fn by(shape: &[usize]) -> String {
    shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ")
}

/// Places of the columns of a list.
fn columns(list: &str, names: &[&str]) -> Result<Vec<usize>, String> {
    if let Ok(count) = list.trim().parse::<usize>() {
        return match (1..=names.len()).contains(&count) {
            true => Ok((0..count).collect()),
            false => Err(format!("there are {} columns", names.len())),
        };
    }
    let place = |name: String| {
        let mut found = (0..names.len()).filter(|&column| names[column] == name);
        match (found.next(), found.next()) {
            (Some(column), None) => Ok(column),
            (Some(_), Some(_)) => Err(format!("`{name}` is there twice; rename one")),
            (None, _) => {
                let advice = advise(&name, names.iter().copied(), "the columns are");
                Err(format!("there is no column `{name}`{advice}"))
            }
        }
    };
    cells(list).into_iter().map(place).collect()
}

/// A cell that is no number, in words.
fn wrong(name: &str, cell: &str) -> String {
    match cell {
        "" => format!("there is no value in the column `{name}`; leave failed runs out"),
        cell => {
            format!("`{cell}` in the column `{name}` is not a finite number; leave failed runs out")
        }
    }
}

/// Requires more than one value.
fn varied(name: &str, values: &[f64]) -> Result<(), String> {
    let Some(first) = values.first() else { return Ok(()) };
    match values.iter().any(|value| value != first) {
        true => Ok(()),
        false => Err(format!(
            "`{name}` is {first} in all runs, which tell nothing about it; leave it out of --parameters and --outputs"
        )),
    }
}

/// A parameter over the range of its values, by their logarithm if that brings the median nearer to the middle of the range.
fn parameter(name: &str, unit: &str, mut values: Vec<f64>) -> Parameter {
    values.sort_by(f64::total_cmp);
    let (low, high, median) = (values[0], values[values.len() - 1], values[values.len() / 2]);
    let unit = if unit.is_empty() { "1" } else { unit };
    let linear = Parameter::linear(name, unit, low..=high);
    let log = Parameter::log(name, unit, low..=high);
    let off = |of: &Parameter| (share_of(of, median) - 0.5).abs();
    if low > 0.0 && off(&log) < off(&linear) { log } else { linear }
}

/// Writes predictions into a folder, which is made: `cases.csv` with a row per case. Of displacements also `cases.npz`, and for the first
/// `pictures` cases a VTU file each with `cases.pvd`, which lists them.
///
/// # Errors
/// A file that cannot be written.
pub fn write_predictions(
    folder: &Path,
    emulator: &RunsEmulator,
    found: &[(Vec<f64>, Vec<Predicted>)],
    pictures: usize,
) -> Result<(), MeshError> {
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    clear(folder).map_err(failed(folder))?;
    let table = folder.join("cases.csv");
    std::fs::write(&table, lines(emulator, found)).map_err(failed(&table))?;
    let Some(mesh) = &emulator.mesh else { return Ok(()) };
    let theta: Vec<f64> = found.iter().flat_map(|(theta, _)| theta.clone()).collect();
    let fields: Vec<f64> = found.iter().flat_map(|(_, found)| found[0].values.clone()).collect();
    let (cases, nodes, count) = (found.len(), mesh.points().len(), emulator.parameters.len());
    let archive = folder.join("cases.npz");
    let arrays: [npz::Named<'_>; 3] = [
        ("theta", &[cases, count], &theta),
        ("displacement", &[cases, nodes, 3], &fields),
        ("points", &[nodes, 3], mesh.points().as_flattened()),
    ];
    npz::write(&archive, &arrays).map_err(failed(&archive))?;
    let mut series = Vec::new();
    for (case, (theta, found)) in found.iter().enumerate().take(pictures) {
        let mut mesh = mesh.clone();
        let field = Field::vectors(found[0].values.as_chunks::<3>().0);
        mesh.point_fields_mut().insert("displacement".into(), field);
        let numbers = emulator.parameters.iter().zip(theta);
        let numbers: Vec<_> = numbers.map(|(p, &value)| (p.unit.head(&p.name), value)).collect();
        let name = PathBuf::from(format!("{case:04}.vtu"));
        mesh.write_vtu_with(folder.join(&name), &numbers)?;
        series.push((case as f64, name));
    }
    let series: Vec<_> = series.iter().map(|(time, file)| (*time, file.as_path())).collect();
    sinew_mesh::write_pvd(folder.join("cases.pvd"), &series)
}

/// Lines of the table of predictions.
fn lines(emulator: &RunsEmulator, found: &[(Vec<f64>, Vec<Predicted>)]) -> String {
    let mut heads = vec!["case".to_string()];
    heads.extend(emulator.parameters.iter().map(|p| p.unit.head(&p.name)));
    for left in emulator.left_out() {
        let unit = sinew_energy::Unit::from(left.unit.as_str());
        let bound = match emulator.mesh {
            None => {
                heads.push(unit.head(&left.name));
                format!("{} half-width of 95 %", left.name)
            }
            Some(_) => {
                heads.extend(["mean u", "largest u"].map(|name| unit.head(name)));
                "95 % bound of the root mean square error".into()
            }
        };
        heads.push(unit.head(&bound));
    }
    heads.push("outside their ranges".into());
    let line = |(case, (theta, found)): (usize, &(Vec<f64>, Vec<Predicted>))| {
        let mut cells = vec![case.to_string()];
        cells.extend(theta.iter().map(f64::to_string));
        for Predicted { values, half_width } in found {
            match emulator.mesh {
                None => cells.push(values[0].to_string()),
                Some(_) => {
                    cells.extend(crate::output::mean_and_largest(values).map(|u| u.to_string()))
                }
            }
            cells.push(half_width.to_string());
        }
        cells.push(quoted(&outside(&emulator.parameters, theta).join("; ")));
        cells.join(",")
    };
    let heads: Vec<String> = heads.iter().map(|head| quoted(head)).collect();
    let lines = found.iter().enumerate().map(line);
    std::iter::once(heads.join(",")).chain(lines).map(|line| line + "\n").collect()
}

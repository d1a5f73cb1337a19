//! Stored runs of any solver: tables of numbers, arrays of displacements, and the files of their emulators' predictions.

mod marks;
mod posterior;
mod table;

use crate::npz;
use crate::output::{csv_line, failed, write_series, write_table};
use crate::theta::{ThetaText, cells, head, heads, outside};
pub use posterior::{Measured, RunsPosterior};
use sinew_emulate::{
    Error as EmulatorError, Observer, Output, Predicted, RunsEmulator, Warning, share_of,
};
use sinew_energy::{Parameter, Unit};
use sinew_mesh::{AnyMesh, DISPLACEMENT, Field, MeshError, to_npy};
use std::collections::HashMap;
use std::ops::RangeInclusive;
use std::path::Path;
use table::{Table, is_flag};

/// Distance of a node from that of a mesh file over the largest coordinate that is rounding of a text file.
const SAME_POINTS: f64 = 1e-4;
/// Distance from the points of a mesh over their size below which vectors are positions: a displacement that doubles all coordinates in
/// every run is none of a body.
const NEAR_POINTS: f64 = 0.5;
/// Largest magnitudes of values whose squares, and those of errors of 1e-16 of them, are numbers.
const SIZES: RangeInclusive<f64> = 1e-100..=1e100;

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
    /// Runs that may have failed, and those that were left out.
    pub warnings: Vec<String>,
}

impl Runs {
    /// Emulator of these runs, with their warnings before its own.
    ///
    /// # Errors
    /// As [`RunsEmulator::fit`].
    pub fn fit(self, observer: &mut dyn Observer) -> Result<RunsEmulator, EmulatorError> {
        let Self { parameters, thetas, outputs, mesh, warnings } = self;
        for concern in &warnings {
            let (stage, concern) = ("runs".into(), concern.clone());
            observer.warning(&Warning::Training { stage, concern });
        }
        let mut fitted = RunsEmulator::fit(parameters, &thetas, &outputs, mesh, observer)?;
        fitted.warnings.splice(0..0, warnings);
        Ok(fitted)
    }

    /// Reads a CSV table with a row per run and names in its first line, such as `mu [kPa],volume [ml]`. `parameters` lists the
    /// columns of the parameters, by names separated by commas; a name with a comma stands in quotes. `outputs` lists those to be emulated; all
    /// others without it. Empty lines, those that begin with `#`, and failed runs, by a column `failure`, `failed`, `converged`, `success` or `status`, are left out.
    ///
    /// # Errors
    /// A file that cannot be read, a column that is missing or has one value only, a cell that is not a finite number, two runs with
    /// the same parameters, too few runs; with line and column.
    pub fn read_table(
        path: &Path,
        parameters: &str,
        outputs: Option<&str>,
    ) -> Result<Self, ThetaText> {
        let table = Table::read(path)?;
        let inputs = table.columns(parameters)?;
        let is_other =
            |&column: &usize| !inputs.contains(&column) && !is_flag(&table.heads[column]);
        let others = (0..table.heads.len()).filter(is_other).collect();
        let results: Vec<usize> = outputs.map_or(Ok(others), |list| table.columns(list))?;
        if results.is_empty() || results.iter().any(|column| inputs.contains(column)) {
            return Err(table.error(table.first, "give outputs that are not parameters".into()));
        }
        let thetas = table.numbers(&inputs)?;
        let rows = table.numbers(&results)?;
        let output = |(place, &column): (usize, &usize)| {
            let (name, unit) = table.head(column);
            let unit = if unit.is_empty() { "1" } else { unit }.into();
            let values = rows.iter().map(|row| vec![row[place]]).collect();
            Output { name: name.into(), unit, values }
        };
        let outputs = results.iter().enumerate().map(output).collect();
        table.runs(&inputs, thetas, outputs)
    }

    /// Reads a table whose `column` names a VTU file for each run, beside the table, with its displacements as a field of vectors at nodes:
    /// `displacement`, or the only one. All files have one mesh, at rest.
    ///
    /// # Errors
    /// As [`Runs::read_table`]; files that cannot be read, differ in their mesh, or have no such field.
    pub fn read_files(path: &Path, parameters: &str, column: &str) -> Result<Self, ThetaText> {
        let table = Table::read(path)?;
        let inputs = table.columns(parameters)?;
        let [column] = table.columns(column)?[..] else {
            return Err(table.error(table.first, "name one column of files".into()));
        };
        let mut first: Option<(AnyMesh, String)> = None;
        let mut values = Vec::with_capacity(table.rows.len());
        for (line, cells) in &table.rows {
            let file = path.with_file_name(&cells[column]);
            let wrong = |reason: String| table.error(*line, reason);
            let (mesh, _) = sinew_mesh::read(&file).map_err(|error| wrong(error.to_string()))?;
            let said = |reason: String| wrong(format!("{}: {reason}", file.display()));
            let (name, field) = displacements(&mesh).map_err(said)?;
            values.push(field);
            let (first, named) = first.get_or_insert_with(|| (mesh.clone(), name.clone()));
            if name != *named {
                let reason = format!(
                    "its vectors are `{name}`, those of the first file `{named}`; call the displacement `displacement` in all"
                );
                return Err(said(reason));
            }
            if first.points() != mesh.points() || first.cells() != mesh.cells() {
                let reason =
                    "the mesh is not that of the first file; write all at rest, on one mesh";
                return Err(said(reason.into()));
            }
        }
        let output = Output { name: "displacement".into(), unit: "1".into(), values };
        let runs = table.runs(&inputs, table.numbers(&inputs)?, vec![output])?;
        let (mesh, _) = first.expect("runs have files");
        runs.on(mesh).map_err(|reason| table.error(0, reason))
    }

    /// Reads an archive of `numpy.savez`: `theta` (runs × parameters) and `displacements` (runs × nodes × 3), in the order of the
    /// nodes of a mesh file and in its unit, which no file names. `parameters` lists their names, with units if any: `mu [kPa],lambda [kPa]`.
    /// Names in an array `parameters` and nodes in `points` are compared with these.
    ///
    /// # Errors
    /// A file that cannot be read, arrays whose shapes do not fit each other or the mesh, other names or nodes, and as [`Runs::read_table`].
    pub fn read_fields(path: &Path, mesh: &Path, parameters: &str) -> Result<Self, ThetaText> {
        let at = |path: &Path, reason| ThetaText { place: path.display().to_string(), reason };
        let array = |name| npz::read(path, name).map_err(|error| at(path, error.to_string()));
        let ((of_theta, theta), (of_fields, fields)) = (array("theta")?, array("displacements")?);
        let (read, report) = sinew_mesh::read(mesh).map_err(|error| at(mesh, error.to_string()))?;
        if report.in_micrometres {
            let reason = "CARP files are in µm and are read in mm, and displacements are in the unit of the mesh: write it as VTU in their unit";
            return Err(at(mesh, reason.into()));
        }
        let points = read.points().len();
        let count = of_theta.last().copied().unwrap_or_default();
        if of_theta.len() != 2 || count == 0 || of_fields != [of_theta[0], points, 3] {
            let [theta, fields] = [&of_theta, &of_fields]
                .map(|shape| shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" × "));
            let changes: String = report.changes().iter().map(|said| format!(", {said}")).collect();
            let reason = format!(
                "theta is {theta} and displacements are {fields}; give runs × parameters and runs × {points} × 3, for the nodes of {}{changes}",
                mesh.display()
            );
            return Err(at(path, reason));
        }
        let names = cells(parameters);
        let mut heads: Vec<_> = names.iter().map(|name| head(name)).collect();
        if heads.len() != count {
            let reason = format!("{} names for {count} parameters", heads.len());
            return Err(at(Path::new("--parameters"), reason));
        }
        let named = npz::texts(path, "parameters").map_err(|error| at(path, error.to_string()))?;
        let named = named.unwrap_or_default();
        let of_file: Vec<_> = named.iter().map(|name| head(name)).collect();
        let agrees = |(given, own): (&(&str, &str), &(&str, &str))| {
            given.0 == own.0 && (given.1 == own.1 || given.1.is_empty() || own.1.is_empty())
        };
        let same = of_file.len() == count && heads.iter().zip(&of_file).all(agrees);
        if !named.is_empty() && !same {
            let reason = format!(
                "`parameters` of the file are {}; give --parameters in this order and these units",
                named.join(", ")
            );
            return Err(at(path, reason));
        }
        // Units that are not given are those of the file.
        let left = heads.iter_mut().zip(&of_file).filter(|(head, _)| head.1.is_empty());
        left.for_each(|(head, own)| head.1 = own.1);
        if let Ok((_, of_file)) = npz::read(path, "points") {
            let nodes = read.points().as_flattened();
            let size = nodes.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            let far = |(a, b): (&f64, &f64)| (a - b).abs() > SAME_POINTS * size;
            if of_file.len() != nodes.len() || of_file.iter().zip(nodes).any(far) {
                let reason = format!(
                    "`points` of the file are not the nodes of {}; give the mesh of these runs, its nodes in their order and unit",
                    mesh.display()
                );
                return Err(at(path, reason));
            }
        }
        let thetas = theta.chunks(count).map(<[f64]>::to_vec).collect();
        let values = fields.chunks(3 * points).map(<[f64]>::to_vec).collect();
        let output = Output { name: "displacement".into(), unit: "1".into(), values };
        let runs = Self::new(&heads, thetas, vec![output], |run| format!("run {run}"));
        runs.and_then(|runs| runs.on(read)).map_err(|reason| at(path, reason))
    }

    /// Runs with the mesh of their displacements.
    ///
    /// # Errors
    /// Displacements that are positions.
    pub fn on(self, mesh: AnyMesh) -> Result<Self, String> {
        let points = mesh.points().as_flattened();
        let are_near = |values: &Vec<f64>| {
            let off = values.iter().zip(points).map(|(value, point)| value - point);
            let size = points.iter().map(|x| x * x).sum::<f64>();
            off.map(|off| off * off).sum::<f64>() < NEAR_POINTS.powi(2) * size
        };
        match self.outputs.iter().find(|of| of.values.iter().all(are_near)) {
            Some(Output { name, .. }) => Err(format!(
                "the values of {name} are close to the points of the mesh in all runs: they are positions; give displacements, which are positions less these points"
            )),
            None => Ok(Self { mesh: Some(mesh), ..self }),
        }
    }

    /// Runs by names and units of their parameters; `said` names a run in errors.
    ///
    /// # Errors
    /// Too few runs, two with the same parameters, a parameter or output with one value only, with one that is not finite, or far from order one.
    pub fn new(
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
        let names =
            heads.iter().map(|(name, _)| *name).chain(outputs.iter().map(|of| &of.name[..]));
        let names: Vec<&str> = names.collect();
        for (place, name) in names.iter().enumerate() {
            if name.is_empty() || names[..place].contains(name) {
                let fault = if name.is_empty() { "has no name" } else { "is there twice" };
                return Err(format!(
                    "the column `{name}` {fault}; rename it, or leave it out (--outputs)"
                ));
            }
        }
        for Output { name, values, .. } in &outputs {
            let unusable = |of: &Vec<f64>| of.iter().any(|value| !value.is_finite());
            if let Some(run) = values.iter().position(unusable) {
                let (run, advice) = (said(run), "leave failed runs out");
                return Err(format!("{run} has values of {name} that are not finite; {advice}"));
            }
            match values.first().map_or(&[][..], |first| &first[..]) {
                [] => return Err(format!("`{name}` is empty")),
                [_] => varied(name, &values.concat())?,
                first if values.iter().all(|values| values == first) => {
                    return Err(format!(
                        "the vectors of {name} are the same in all runs; give displacements, which follow from the parameters"
                    ));
                }
                _ => {}
            }
            sized(name, values.iter().flatten())?;
        }
        let mut seen = HashMap::new();
        for (run, theta) in thetas.iter().enumerate() {
            if theta.iter().any(|value| !value.is_finite()) {
                return Err(format!("{} has parameters that are not finite", said(run)));
            }
            let bits: Vec<u64> = theta.iter().map(|value| value.to_bits()).collect();
            if let Some(first) = seen.insert(bits, run) {
                let (first, second) = (said(first), said(run));
                return Err(format!("{first} and {second} have the same parameters; keep one"));
            }
        }
        let range = |(place, &(name, unit)): (usize, &(&str, &str))| {
            let values: Vec<f64> = thetas.iter().map(|theta| theta[place]).collect();
            varied(name, &values)?;
            sized(name, &values)?;
            Ok(parameter(name, unit, values))
        };
        let parameters = heads.iter().enumerate().map(range).collect::<Result<_, String>>()?;
        let column = |place: usize| thetas.iter().map(|theta| theta[place]).collect::<Vec<_>>();
        let inputs = (0..heads.len()).map(|place| (heads[place].0, column(place), false));
        let results = outputs.iter().map(|of| (&of.name[..], marks::largest(&of.values), true));
        let doubts = inputs
            .chain(results)
            .flat_map(|(name, values, is_output)| marks::doubts(name, &values, is_output, &said));
        let warnings = doubts.collect();
        Ok(Self { parameters, thetas, outputs, mesh: None, warnings })
    }
}

impl Table<'_> {
    fn runs(
        &self,
        inputs: &[usize],
        thetas: Vec<Vec<f64>>,
        outputs: Vec<Output>,
    ) -> Result<Runs, ThetaText> {
        let heads: Vec<_> = inputs.iter().map(|&column| self.head(column)).collect();
        let said = |run: usize| format!("line {}", self.rows[run].0);
        let runs = Runs::new(&heads, thetas, outputs, said);
        let mut runs = runs.map_err(|reason| self.error(0, reason))?;
        if let [(first, column), ..] = &self.failed[..] {
            let count = self.failed.len();
            let told = format!(
                "{count} failed runs are left out, the first in line {first}: the column `{column}` says so"
            );
            runs.warnings.push(told);
        }
        Ok(runs)
    }
}

/// Displacements at the nodes of a mesh, by their name or as the only field of vectors, with that name.
fn displacements(mesh: &AnyMesh) -> Result<(String, Vec<f64>), String> {
    let fields = || mesh.point_fields().iter().filter(|(_, field)| field.components == 3);
    let names: Vec<&str> = fields().map(|(name, _)| name.as_str()).collect();
    let name = match &names[..] {
        names if names.contains(&"displacement") => "displacement",
        [name] => name,
        [] => {
            return Err("there is no field of vectors at nodes; write the displacement".into());
        }
        _ => {
            let names = names.join(", ");
            return Err(format!("vectors at nodes are {names}; call that to learn `displacement`"));
        }
    };
    let values = mesh.point_fields()[name].to_f64().into_owned();
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => Err(format!("the displacement of node {} is not finite", place / 3)),
        None => Ok((name.into(), values)),
    }
}

/// Requires more than one value.
fn varied(name: &str, values: &[f64]) -> Result<(), String> {
    let Some(&first) = values.first() else { return Err(format!("`{name}` is empty")) };
    match values.iter().all(|value| *value == first) {
        true => {
            Err(format!("`{name}` is {first} in all runs; leave it out (--parameters, --outputs)"))
        }
        false => Ok(()),
    }
}

/// Requires values whose squares are numbers.
fn sized<'v>(name: &str, values: impl IntoIterator<Item = &'v f64>) -> Result<(), String> {
    let largest = values.into_iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    match SIZES.contains(&largest) {
        true => Ok(()),
        false => Err(format!(
            "the largest magnitude of {name} is {largest:.1e}: choose units in which the values are of order one"
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
    write_table(folder, &lines(emulator, found))?;
    let Some(mesh) = &emulator.mesh else { return Ok(()) };
    let theta: Vec<f64> = found.iter().flat_map(|(theta, _)| theta.clone()).collect();
    let fields: Vec<f64> = found.iter().flat_map(|(_, found)| found[0].values.clone()).collect();
    let (cases, nodes, count) = (found.len(), mesh.points().len(), emulator.parameters.len());
    let archive = folder.join("cases.npz");
    let arrays = [
        ("theta".into(), to_npy(&[cases, count], &theta)),
        (DISPLACEMENT.into(), to_npy(&[cases, nodes, 3], &fields)),
    ];
    npz::write(&archive, arrays).map_err(failed(&archive))?;
    let picture = |(case, (_, found)): (usize, &(Vec<f64>, Vec<Predicted>))| {
        let mut mesh = mesh.clone();
        let field = Field::vectors(found[0].values.as_chunks::<3>().0);
        mesh.point_fields_mut().insert(DISPLACEMENT.into(), field);
        (case, case as f64, mesh, Vec::new())
    };
    write_series(folder, found.iter().enumerate().take(pictures).map(picture))
}

/// Lines of the table of predictions.
fn lines(emulator: &RunsEmulator, found: &[(Vec<f64>, Vec<Predicted>)]) -> String {
    let number = emulator.mesh.is_none();
    let mut heads = vec!["case".to_string()];
    heads.extend(self::heads(&emulator.parameters));
    for left in emulator.left_out() {
        let unit = Unit::from(left.unit.as_str());
        heads.extend(number.then(|| unit.head(&left.name)));
        heads.push(unit.head(&format!("95 % error of {}", left.name)));
    }
    heads.push("outside their ranges".into());
    let line = |(case, (theta, found)): (usize, &(Vec<f64>, Vec<Predicted>))| {
        let mut cells = vec![case.to_string()];
        cells.extend(theta.iter().map(f64::to_string));
        for Predicted { values, half_width } in found {
            cells.extend(values.iter().filter(|_| number).chain([half_width]).map(f64::to_string));
        }
        cells.push(outside(&emulator.parameters, theta).join("; "));
        csv_line(&cells)
    };
    csv_line(&heads) + &found.iter().enumerate().map(line).collect::<String>()
}

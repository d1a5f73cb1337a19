//! Output files of the program: fields for ParaView, tables and arrays.

mod table;

use crate::npz;
use crate::stresses::{StressField, add_stresses, stress_fields};
use crate::theta::{heads, theta_in_words};
use sinew_emulate::{Failure, Simulations, Warning, alike};
pub use sinew_energy::metrics::mean_and_largest;
use sinew_energy::metrics::volume_ratios;
use sinew_energy::{Body, Unit};
use sinew_fem::{CellStress, TraceEnd, mixed_stresses};
use sinew_mesh::{AnyMesh, DISPLACEMENT, Field, MeshError, to_npy, to_npy_of};
use sinew_report::format::digits;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use table::RESIDUAL;
pub use table::csv_line;
pub(crate) use table::{motion_heads, volume_heads};

/// One row of results: what was asked for, and what was found or why nothing was.
#[derive(Clone, Debug, Default)]
pub struct Row<'a> {
    /// θ in the units of the scene; empty where it could not be read.
    pub theta: Vec<f64>,
    /// Displacements node by node \[length\], one by each name of [`Results`]; empty without a displacement.
    pub fields: Vec<&'a [f64]>,
    /// Pressures of mixed elements at [`sinew_energy::PressureField::nodes`] \[stress\], of the first of them; empty without such a field.
    pub pressure: &'a [f64],
    /// Quality of the displacements, where that was asked for.
    pub quality: Option<Quality>,
    /// Other reasons for mistrust.
    pub warnings: Vec<String>,
    /// Reason of a missing displacement.
    pub failure: Option<String>,
}

impl<'a> Row<'a> {
    /// A solution by its place, with what to doubt of it.
    pub fn solved(found: &'a Simulations, place: usize) -> Self {
        let theta = &found.thetas[place];
        let doubts = [(&found.jumped, Warning::Jumped), (&found.unstable, Warning::Unstable)];
        let doubts = doubts.into_iter().filter(|(thetas, _)| thetas.contains(theta));
        Self {
            theta: theta.clone(),
            fields: vec![&found.fields[place]],
            pressure: found.pressures.get(place).map_or(&[], Vec::as_slice),
            warnings: doubts.map(|(_, warning)| warning.to_string()).collect(),
            ..Self::default()
        }
    }
}

/// Quality of an answer.
#[derive(Clone, Debug, Default)]
pub struct Quality {
    /// Estimated mean nodal error \[length\].
    pub mean: Option<f64>,
    /// Estimated largest nodal error \[length\].
    pub largest: Option<f64>,
    /// Estimated error in the energy norm [%].
    pub energy_norm: Option<f64>,
    /// Method of these estimates, or the reason why there are none.
    pub kind: String,
    /// Unbalanced nodal forces, relative to loads and reactions.
    pub residual: Option<f64>,
}

/// Answers to all rows that were asked for, in their order, failures among them.
#[derive(Debug)]
pub struct Results<'a> {
    /// Their body.
    pub body: &'a Body,
    /// Origins of the displacements, such as `"predicted"`; the first is what the others are compared with. Its array is `displacement`, those
    /// of the others are `displacement_predicted` and the like.
    pub names: Vec<&'a str>,
    /// The rows.
    pub rows: Vec<Row<'a>>,
    /// Whether pictures and arrays hold stress, strain and fibres of the first of these displacements.
    pub stresses: bool,
}

/// Largest archive of fields that is written unasked \[bytes\].
pub const MOST_BYTES: usize = 64 << 20;

impl<'a> Results<'a> {
    /// Solutions of a body at θ, a row for each, failures among them.
    pub fn of(body: &'a Body, thetas: &[Vec<f64>], found: &'a Simulations) -> Self {
        let row = |(theta, place): (&Vec<f64>, Result<usize, String>)| match place {
            Ok(place) => Row::solved(found, place),
            Err(why) => Row { theta: theta.clone(), failure: Some(why), ..Row::default() },
        };
        let rows = thetas.iter().zip(by_row(thetas, found)).map(row).collect();
        Self { body, names: vec!["solved"], rows, stresses: false }
    }

    /// Writes into a folder, which is made: `cases.csv` with a row per case; `cases.npz`, whose fields are NaN where a row has
    /// none; `NNNN.vtu`, numbered as the rows, for the first `pictures` rows that have a field, and `cases.pvd` that lists
    /// them. Files of that name from an earlier run are removed. Parameters are in their own units. An archive above
    /// [`MOST_BYTES`] is written only with `arrays`; its size in bytes is returned where it was left out.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(
        &self,
        folder: &Path,
        pictures: usize,
        arrays: bool,
    ) -> Result<Option<usize>, MeshError> {
        let left_out = self.write_tables(folder, arrays)?;
        self.write_pictures(folder, pictures, |case| case as f64)?;
        Ok(left_out)
    }

    /// Adds rows to the table of a folder that [`Results::write`] wrote `written` rows in: the next part of a table whose fields do not fit in
    /// memory together.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub fn append(&self, folder: &Path, written: usize) -> Result<(), MeshError> {
        let path = folder.join("cases.csv");
        let append = || {
            let mut file = File::options().read(true).append(true).open(&path)?;
            let mut heads = String::new();
            BufReader::new(&file).read_line(&mut heads)?;
            file.write_all(self.lines(written, heads.contains(RESIDUAL)).concat().as_bytes())
        };
        append().map_err(failed(&path))
    }

    /// [`Results::write`] of states along a parameter by its place in θ, all with pictures: the time of `cases.pvd` is its
    /// value, and `curve.csv` has displacements and volumes of cavities against it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_along(&self, folder: &Path, parameter: usize) -> Result<(), MeshError> {
        self.write_tables(folder, true)?;
        let curve = folder.join(CURVE);
        std::fs::write(&curve, self.curve(parameter)).map_err(failed(&curve))?;
        self.write_pictures(folder, self.rows.len(), |case| self.along(parameter, case))
    }

    /// Value of a parameter in its own unit.
    fn along(&self, parameter: usize, case: usize) -> f64 {
        self.body.parameters[parameter].unit.shown(self.rows[case].theta[parameter])
    }

    /// Makes the folder, removes an earlier run's files and writes the table and, unless they are too large, the arrays; returns
    /// their size in bytes where they were left out.
    fn write_tables(&self, folder: &Path, arrays: bool) -> Result<Option<usize>, MeshError> {
        write_table(folder, &self.table())?;
        // Stress and strain: two tensors, two triples, two numbers, and a direction with two more.
        let of_stresses = if self.stresses { 31 * self.body.cell_count() } else { 0 };
        let of_row = 3 * self.names.len() * self.body.nodes + of_stresses;
        let bytes = size_of::<f64>() * self.rows.len() * of_row;
        let left_out = (!arrays && bytes > MOST_BYTES).then_some(bytes);
        if left_out.is_none() {
            let archive = folder.join("cases.npz");
            self.write_arrays(&archive).map_err(failed(&archive))?;
        }
        Ok(left_out)
    }

    /// Writes the first pictures and the list of them, each with its time.
    fn write_pictures(
        &self,
        folder: &Path,
        pictures: usize,
        time: impl Fn(usize) -> f64,
    ) -> Result<(), MeshError> {
        let drawn = (0..self.rows.len()).filter(|&case| !self.rows[case].fields.is_empty());
        let picture = |case: usize| {
            let theta = shown(self.body, &self.rows[case].theta);
            let numbers = heads(&self.body.parameters).into_iter().zip(theta).collect();
            (case, time(case), self.picture(case), numbers)
        };
        write_series(folder, drawn.take(pictures).map(picture))
    }

    fn write_arrays(&self, path: &Path) -> io::Result<()> {
        let (cases, nodes, count) = (self.rows.len(), self.body.nodes, self.body.parameters.len());
        let theta = self.rows.iter().flat_map(|row| match row.theta.is_empty() {
            true => vec![f64::NAN; count],
            false => shown(self.body, &row.theta),
        });
        let theta: Vec<f64> = theta.collect();
        let missing = vec![f64::NAN; 3 * nodes];
        let field = |(place, name): (usize, String)| {
            let of = |row: &Row<'_>| row.fields.get(place).map_or(&missing[..], |u| *u).to_vec();
            let values: Vec<f64> = self.rows.iter().flat_map(of).collect();
            (name, to_npy(&[cases, nodes, 3], &values))
        };
        let points = to_npy(&[nodes, 3], self.body.positions.as_flattened());
        let first =
            [("theta".to_string(), to_npy(&[cases, count], &theta)), ("points".into(), points)];
        let fields = self.arrays().into_iter().enumerate().map(field);
        let heads = texts(&heads(&self.body.parameters));
        let last = [("cells".to_string(), self::cells(self.body)), ("parameters".into(), heads)];
        npz::write(path, first.into_iter().chain(fields).chain(self.stress_arrays()).chain(last))
    }

    /// Names of the displacements as arrays.
    fn arrays(&self) -> Vec<String> {
        let others = self.names.iter().skip(1).map(|name| format!("{DISPLACEMENT}_{name}"));
        std::iter::once(DISPLACEMENT.into()).chain(others).collect()
    }

    /// Stress and strain of cells as arrays by name, NaN where a row has none.
    fn stress_arrays(&self) -> Vec<(String, Vec<u8>)> {
        let of_row = |case| Some(stress_fields(&self.cell_stresses(case)?));
        let rows = (0..self.rows.len()).filter(|_| self.stresses);
        let found: Vec<Option<Vec<StressField>>> = rows.map(of_row).collect();
        let Some(like) = found.iter().flatten().next() else { return Vec::new() };
        let array = |(index, field): (usize, &StressField)| {
            let missing = vec![f64::NAN; field.values.len()];
            let values = |fields: &Option<Vec<StressField>>| {
                fields.as_ref().map_or(&missing, |fields| &fields[index].values).clone()
            };
            let shape = [vec![found.len(), self.body.cell_count()], field.shape()].concat();
            let values: Vec<f64> = found.iter().flat_map(values).collect();
            (field.name.into(), to_npy(&shape, &values))
        };
        like.iter().enumerate().map(array).collect()
    }

    /// Stress and strain of the cells of a row; `None` where there is no displacement, or one that inverts a cell.
    fn cell_stresses(&self, case: usize) -> Option<Vec<CellStress>> {
        let Row { theta, fields, pressure, .. } = &self.rows[case];
        mixed_stresses(self.body, fields.first()?, pressure, theta).ok()
    }

    /// One case on its mesh.
    fn picture(&self, case: usize) -> AnyMesh {
        let mut mesh = (*self.body.mesh).clone();
        let fields = &self.rows[case].fields;
        for (name, field) in self.arrays().into_iter().zip(fields) {
            let field = Field::vectors(field.as_chunks::<3>().0);
            mesh.point_fields_mut().insert(name, field);
        }
        for (name, field) in self.names.iter().zip(fields).skip(1) {
            let apart = sinew_energy::metrics::displacement_error(fields[0], field);
            mesh.point_fields_mut().insert(format!("difference_{name}"), Field::scalars(apart));
        }
        if let Some(of_nodes) = self.body.nodal_pressure(self.rows[case].pressure) {
            mesh.point_fields_mut().insert("pressure".into(), Field::scalars(of_nodes));
        }
        if let Some(cells) = self.stresses.then(|| self.cell_stresses(case)).flatten() {
            add_stresses(&mut mesh, self.body, &cells);
        }
        mesh
    }
}

/// θ in the parameters' own units.
fn shown(body: &Body, theta: &[f64]) -> Vec<f64> {
    body.parameters.iter().zip(theta).map(|(p, &value)| p.unit.shown(value)).collect()
}

/// Nodes of the cells as an npy file.
fn cells(body: &Body) -> Vec<u8> {
    let count = body.mesh.cell_count();
    let nodes = body.mesh.cells();
    let bytes: Vec<u8> = nodes.iter().flat_map(|&node| (node as i64).to_le_bytes()).collect();
    to_npy_of("<i8", &[count, nodes.len() / count.max(1)], &bytes)
}

/// Texts as an npy file, of one length.
fn texts(texts: &[String]) -> Vec<u8> {
    let length = texts.iter().map(|text| text.chars().count()).max().unwrap_or(1);
    let padded = |text: &String| -> Vec<char> {
        text.chars().chain(std::iter::repeat('\0')).take(length).collect()
    };
    let letters = texts.iter().flat_map(padded);
    let bytes: Vec<u8> = letters.flat_map(|letter| u32::from(letter).to_le_bytes()).collect();
    to_npy_of(&format!("<U{length}"), &[texts.len()], &bytes)
}

/// Table of a path along a parameter.
const CURVE: &str = "curve.csv";

/// Names the file of an error.
pub(crate) fn failed(path: &Path) -> impl FnOnce(io::Error) -> MeshError {
    let path = path.to_path_buf();
    move |source| MeshError::File { path, source }
}

/// Makes a folder of results, removes what an earlier run left there, and writes its table.
pub(crate) fn write_table(folder: &Path, text: &str) -> Result<(), MeshError> {
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    clear(folder).map_err(failed(folder))?;
    let table = folder.join("cases.csv");
    std::fs::write(&table, text).map_err(failed(&table))
}

/// A picture: number of its case, time, mesh with its fields, numbers of the whole mesh by name.
type Picture = (usize, f64, AnyMesh, Vec<(String, f64)>);

/// Writes pictures, and the list of them where there are some.
pub(crate) fn write_series(
    folder: &Path,
    pictures: impl Iterator<Item = Picture>,
) -> Result<(), MeshError> {
    let mut series = Vec::new();
    for (case, time, mesh, numbers) in pictures {
        let name = PathBuf::from(format!("{case:04}.vtu"));
        mesh.write_vtu_with(folder.join(&name), &numbers)?;
        series.push((time, name));
    }
    if series.is_empty() {
        return Ok(());
    }
    let series: Vec<_> = series.iter().map(|(time, file)| (*time, file.as_path())).collect();
    sinew_mesh::write_pvd(folder.join("cases.pvd"), &series)
}

/// Removes what an earlier run wrote, and nothing else.
///
/// # Errors
/// A folder that is not there, a file that cannot be removed.
pub fn clear(folder: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let picture = name.strip_suffix(".vtu").is_some_and(|number| {
            number.len() >= 4 && number.bytes().all(|digit| digit.is_ascii_digit())
        });
        if picture || ["cases.csv", "cases.npz", "cases.pvd", CURVE].contains(&&*name) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// Place of the solution of each θ that was solved for, or why it has none.
pub fn by_row(thetas: &[Vec<f64>], found: &Simulations) -> Vec<Result<usize, String>> {
    let (mut failures, mut solved) = (found.failures.iter().peekable(), 0..found.fields.len());
    // Samples of another machine differ by rounding.
    let place = |theta: &Vec<f64>| match failures.next_if(|failure| alike(&failure.theta, theta)) {
        Some(Failure { reason, .. }) if reason.starts_with(NO_EQUILIBRIUM) => {
            Some(Err(reason.clone()))
        }
        Some(Failure { reason, .. }) => Some(Err(format!("{NO_EQUILIBRIUM}: {reason}"))),
        None => solved.next().map(Ok),
    };
    thetas.iter().filter_map(place).collect()
}

const NO_EQUILIBRIUM: &str = "no equilibrium";

/// Place where a path of equilibria ended, and why.
pub fn end_in_words(body: &Body, end: &TraceEnd) -> String {
    let [reached, beyond] = [&end.reached, &end.beyond].map(|theta| theta_in_words(body, theta));
    let branch = "the nearest equilibrium there is on another branch: a limit point or a bifurcation lies between them";
    let why = end.error.as_ref().map_or(branch.into(), ToString::to_string);
    format!("the path ends between {reached} and {beyond}: {why}")
}

/// Least and largest volume ratio J over the quadrature points.
pub fn least_and_largest_ratio(body: &Body, displacement: &[f64]) -> [f64; 2] {
    let bounds = [f64::INFINITY, f64::NEG_INFINITY];
    let ratios = volume_ratios(body, displacement).into_iter();
    ratios.fold(bounds, |[least, most], ratio| [least.min(ratio), most.max(ratio)])
}

/// Mean and largest nodal displacement for people: `mean 15.47 mm, largest 37.50 mm`.
pub fn displacement_in_words(displacement: &[f64], unit: &str) -> String {
    let [mean, largest] = mean_and_largest(displacement).map(|length| digits(length, 4));
    let unit = Unit::from(unit).suffix();
    format!("mean {mean}{unit}, largest {largest}{unit}")
}

//! Output files of the program: fields for ParaView, tables and arrays.

use crate::npz;
use crate::stresses::{StressField, add_stresses, stress_fields};
use crate::theta::outside;
use rayon::prelude::*;
pub use sinew_energy::metrics::mean_and_largest;
use sinew_energy::metrics::volume_ratios;
use sinew_energy::{Body, Cavity};
use sinew_fem::{CellStress, held_sets, mixed_stresses, reactions};
use sinew_mesh::{DISPLACEMENT, Field, MeshError, to_npy_of};
use sinew_report::format::digits;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Displacements of some cases, by how they were found.
#[derive(Debug)]
pub struct Fields<'a> {
    /// Their body.
    pub body: &'a Body,
    /// Parameters, case by case.
    pub thetas: &'a [Vec<f64>],
    /// A name such as `"solved"`, and displacements case by case, node by node \[length\].
    pub found: Vec<(&'a str, Vec<Vec<f64>>)>,
}

impl Fields<'_> {
    /// Writes all of them as [`Results::write`] does, with pictures of the first cases.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, pictures: usize) -> Result<(), MeshError> {
        let row = |(case, theta): (usize, &Vec<f64>)| Row {
            theta: theta.clone(),
            fields: self.found.iter().map(|(_, fields)| &fields[case][..]).collect(),
            ..Row::default()
        };
        let rows = self.thetas.iter().enumerate().map(row).collect();
        let names = self.found.iter().map(|(name, _)| *name).collect();
        Results { body: self.body, names, rows, stresses: false }
            .write(folder, pictures, true)
            .map(|_| ())
    }
}

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

/// Head of the column of residuals.
const RESIDUAL: &str = "residual relative to the forces";

/// Largest archive of fields that is written unasked \[bytes\].
pub const MOST_BYTES: usize = 64 << 20;

impl Results<'_> {
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
    /// value, and `curve.csv` has displacements and volumes of cavities against it. `values` has one number per row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_along(
        &self,
        folder: &Path,
        parameter: usize,
        values: &[f64],
    ) -> Result<(), MeshError> {
        self.write_tables(folder, true)?;
        let curve = folder.join(CURVE);
        std::fs::write(&curve, self.curve(parameter, values)).map_err(failed(&curve))?;
        self.write_pictures(folder, self.rows.len(), |case| values[case])
    }

    /// Displacements and volumes of cavities against a parameter.
    fn curve(&self, parameter: usize, values: &[f64]) -> String {
        let (body, length) = (self.body, &self.body.units.length);
        let along = &body.parameters[parameter];
        let mut heads = vec![along.unit.head(&along.name)];
        heads.extend(["mean", "largest"].map(|of| format!("{of} u [{length}]")));
        heads.extend(body.cavities.iter().map(|c| format!("volume of {} [{length}3]", c.name)));
        let mut text = csv_line(&heads);
        for (row, value) in self.rows.iter().zip(values) {
            let Some(field) = row.fields.first() else { continue };
            let mut cells = vec![*value];
            cells.extend(mean_and_largest(field));
            cells.extend(body.cavity_volumes(field));
            text += &csv_line(&cells);
        }
        text
    }

    /// Makes the folder, removes an earlier run's files and writes the table and, unless they are too large, the arrays; returns
    /// their size in bytes where they were left out.
    fn write_tables(&self, folder: &Path, arrays: bool) -> Result<Option<usize>, MeshError> {
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
        clear(folder).map_err(failed(folder))?;
        let table = folder.join("cases.csv");
        std::fs::write(&table, self.table()).map_err(failed(&table))?;
        let of_row = 3 * self.names.len() * self.body.nodes + self.stress_numbers();
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
        let mut series = Vec::new();
        let drawn = (0..self.rows.len()).filter(|&case| !self.rows[case].fields.is_empty());
        for case in drawn.take(pictures) {
            let name = format!("{case:04}.vtu");
            let theta = shown(self.body, &self.rows[case].theta);
            let heads = self.body.parameters.iter().map(|p| p.unit.head(&p.name));
            let numbers: Vec<_> = heads.zip(theta).collect();
            self.picture(case).write_vtu_with(folder.join(&name), &numbers)?;
            series.push((time(case), PathBuf::from(name)));
        }
        if !series.is_empty() {
            let series: Vec<_> =
                series.iter().map(|(time, file)| (*time, file.as_path())).collect();
            sinew_mesh::write_pvd(folder.join("cases.pvd"), &series)?;
        }
        Ok(())
    }

    fn write_arrays(&self, path: &Path) -> io::Result<()> {
        let (cases, nodes, count) = (self.rows.len(), self.body.nodes, self.body.parameters.len());
        let missing = vec![f64::NAN; 3 * nodes];
        let theta = self.rows.iter().flat_map(|row| match row.theta.is_empty() {
            true => vec![f64::NAN; count],
            false => shown(self.body, &row.theta),
        });
        let theta: Vec<f64> = theta.collect();
        let field = |name: usize| -> Vec<f64> {
            let of =
                |row: &Row<'_>| row.fields.get(name).map_or(&missing[..], |field| *field).to_vec();
            self.rows.iter().flat_map(of).collect()
        };
        let fields: Vec<Vec<f64>> = (0..self.names.len()).map(field).collect();
        let shapes = ([cases, count], [cases, nodes, 3], [nodes, 3]);
        let mut arrays: Vec<npz::Named<'_>> = vec![
            ("theta", &shapes.0, &theta),
            ("points", &shapes.2, self.body.positions.as_flattened()),
        ];
        let names = self.arrays();
        let named = names.iter().zip(&fields);
        arrays.extend(named.map(|(name, values)| (&name[..], &shapes.1[..], &values[..])));
        let stresses = self.stress_arrays();
        arrays
            .extend(stresses.iter().map(|(name, shape, values)| (*name, &shape[..], &values[..])));
        npz::write(path, &arrays, &[("cells", cells(self.body)), ("parameters", heads(self.body))])
    }

    /// Names of the displacements as arrays.
    fn arrays(&self) -> Vec<String> {
        let others = self.names.iter().skip(1).map(|name| format!("{DISPLACEMENT}_{name}"));
        std::iter::once(DISPLACEMENT.into()).chain(others).collect()
    }

    /// Numbers of stress, strain and fibres in a row of the arrays.
    fn stress_numbers(&self) -> usize {
        // Two tensors, two triples, two numbers, and a direction with two more.
        const MOST: usize = 31;
        if self.stresses { MOST * self.body.cell_count() } else { 0 }
    }

    /// Stress and strain of cells for the arrays: name, shape, and numbers, NaN where a row has none.
    fn stress_arrays(&self) -> Vec<(&'static str, Vec<usize>, Vec<f64>)> {
        let of_row = |case| Some(stress_fields(self.body, &self.cell_stresses(case)?));
        let rows = (0..self.rows.len()).filter(|_| self.stresses);
        let found: Vec<Option<Vec<StressField>>> = rows.map(of_row).collect();
        let Some(like) = found.iter().flatten().next() else { return Vec::new() };
        let array = |(index, field): (usize, &StressField)| {
            let missing = vec![f64::NAN; field.values.len()];
            let values = |fields: &Option<Vec<StressField>>| {
                fields.as_ref().map_or(&missing, |fields| &fields[index].values).clone()
            };
            let shape = [vec![found.len(), self.body.cell_count()], field.shape()].concat();
            (field.name, shape, found.iter().flat_map(values).collect())
        };
        like.iter().enumerate().map(array).collect()
    }

    /// Stress and strain of the cells of a row; `None` where there is no displacement, or one that inverts a cell.
    fn cell_stresses(&self, case: usize) -> Option<Vec<CellStress>> {
        let Row { theta, fields, pressure, .. } = &self.rows[case];
        mixed_stresses(self.body, fields.first()?, pressure, theta).ok()
    }

    /// One case on its mesh.
    fn picture(&self, case: usize) -> sinew_mesh::AnyMesh {
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

    /// A row per case: its number, θ, then for each way to find it the mean and the largest nodal displacement, the total
    /// potential energy, empty where there is no potential, the volumes of cavities, the least and the largest J, and the reactions of supports; how good it is; parameters outside their ranges; warnings; why it failed.
    fn table(&self) -> String {
        let judged = self.rows.iter().any(|row| row.quality.is_some());
        csv_line(&self.heads(judged)) + &self.lines(0, judged).concat()
    }

    /// Lines of the rows, numbered from the first on.
    fn lines(&self, first: usize, judged: bool) -> Vec<String> {
        let row = |(case, row): (usize, &Row<'_>)| self.line(first + case, row, judged);
        self.rows.par_iter().enumerate().map(row).collect()
    }

    fn heads(&self, judged: bool) -> Vec<String> {
        let (body, length, stress) = (self.body, &self.body.units.length, &self.body.units.stress);
        let mut heads = vec!["case".to_string()];
        heads.extend(body.parameters.iter().map(|p| p.unit.head(&p.name)));
        for name in &self.names {
            heads.push(format!("{name} mean u [{length}]"));
            heads.push(format!("{name} largest u [{length}]"));
            heads.push(format!("{name} energy [{stress} {length}3]"));
            let volume = |c: &Cavity| format!("{name} volume of {} [{length}3]", c.name);
            heads.extend(body.cavities.iter().map(volume));
            heads.extend(["least", "largest"].map(|of| format!("{name} {of} J")));
            for (set, _) in held_sets(body) {
                let head = |axis| format!("{name} reaction {axis} at {set} [{stress} {length}2]");
                heads.extend(["x", "y", "z"].map(head));
            }
        }
        if judged {
            heads.extend(["mean", "largest"].map(|of| format!("estimated {of} error [{length}]")));
            heads.push("estimated error in the energy norm [%]".into());
            heads.push("estimate".into());
            heads.push(RESIDUAL.into());
        }
        heads.extend(["outside their ranges", "warnings", "failure"].map(String::from));
        heads
    }

    fn line(&self, case: usize, row: &Row<'_>, judged: bool) -> String {
        let body = self.body;
        let mut cells = vec![case.to_string()];
        cells.extend(match row.theta.is_empty() {
            true => vec![String::new(); body.parameters.len()],
            false => shown(body, &row.theta).iter().map(f64::to_string).collect(),
        });
        for field in &row.fields {
            cells.extend(mean_and_largest(field).map(|x| x.to_string()));
            let energy = body.has_potential().then(|| body.value(field, &row.theta));
            cells.push(energy.map_or(String::new(), |energy| energy.to_string()));
            cells.extend(body.cavity_volumes(field).iter().map(f64::to_string));
            cells.extend(least_and_largest_ratio(body, field).map(|ratio| ratio.to_string()));
            // Mixed elements without their pressures have none.
            match reactions(body, field, row.pressure, &row.theta) {
                Ok(forces) => cells.extend(forces.iter().flatten().map(f64::to_string)),
                Err(_) => cells.extend(vec![String::new(); 3 * held_sets(body).count()]),
            }
        }
        if row.fields.is_empty() {
            let each = 5 + body.cavities.len() + 3 * held_sets(body).count();
            cells.extend(vec![String::new(); self.names.len() * each]);
        }
        if judged {
            let number =
                |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            let Quality { mean, largest, energy_norm, kind, residual } =
                row.quality.clone().unwrap_or_default();
            cells.extend([mean, largest, energy_norm].map(number));
            cells.extend([kind, number(residual)]);
        }
        cells.push(outside(&body.parameters, &row.theta).join("; "));
        cells.push(row.warnings.join("; "));
        cells.push(row.failure.clone().unwrap_or_default());
        csv_line(&cells)
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

/// Names of the parameters with their units as an npy file of texts of one length.
fn heads(body: &Body) -> Vec<u8> {
    let heads: Vec<String> = body.parameters.iter().map(|p| p.unit.head(&p.name)).collect();
    let length = heads.iter().map(|head| head.chars().count()).max().unwrap_or(1);
    let padded = |head: &String| -> Vec<char> {
        head.chars().chain(std::iter::repeat('\0')).take(length).collect()
    };
    let bytes: Vec<u8> =
        heads.iter().flat_map(padded).flat_map(|letter| u32::from(letter).to_le_bytes()).collect();
    to_npy_of(&format!("<U{length}"), &[heads.len()], &bytes)
}

/// A line of a CSV table, its cells in quotes where they need to be.
pub(crate) fn csv_line<T: ToString>(cells: &[T]) -> String {
    let quoted = |cell: &T| match cell.to_string() {
        text if text.contains([',', '"', '\n']) => {
            format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " "))
        }
        text => text,
    };
    cells.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// Table of a path along a parameter.
const CURVE: &str = "curve.csv";

/// Names the file of an error.
pub(crate) fn failed(path: &Path) -> impl FnOnce(io::Error) -> MeshError {
    let path = path.to_path_buf();
    move |source| MeshError::File { path, source }
}

/// Removes what an earlier run wrote, and nothing else.
pub(crate) fn clear(folder: &Path) -> io::Result<()> {
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

/// Least and largest volume ratio J over the quadrature points.
pub fn least_and_largest_ratio(body: &Body, displacement: &[f64]) -> [f64; 2] {
    let bounds = [f64::INFINITY, f64::NEG_INFINITY];
    let ratios = volume_ratios(body, displacement).into_iter();
    ratios.fold(bounds, |[least, most], ratio| [least.min(ratio), most.max(ratio)])
}

/// Mean and largest nodal displacement for people: `mean 15.47 mm, largest 37.50 mm`.
pub fn displacement_in_words(displacement: &[f64], unit: &str) -> String {
    let [mean, largest] = mean_and_largest(displacement).map(|length| digits(length, 4));
    format!("mean {mean} {unit}, largest {largest} {unit}")
}

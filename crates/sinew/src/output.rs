//! What the program writes: fields for ParaView, tables and arrays.

use crate::npz;
use crate::theta::outside;
use rayon::prelude::*;
use sinew_energy::Body;
pub use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{CellStress, Fibre, cell_stresses};
use sinew_mesh::{Field, FieldValues, MeshError};
use sinew_report::format::digits;
use std::io;
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
    /// Displacements node by node \[length\], one by each name of [`Results`]; empty where there is none.
    pub fields: Vec<&'a [f64]>,
    /// How good they are, where that was asked for.
    pub quality: Option<Quality>,
    /// Other reasons for mistrust.
    pub warnings: Vec<String>,
    /// Why there is no displacement.
    pub failure: Option<String>,
}

/// How good an answer is.
#[derive(Clone, Debug, Default)]
pub struct Quality {
    /// Estimated mean nodal error \[length\].
    pub mean: Option<f64>,
    /// Estimated largest nodal error \[length\].
    pub largest: Option<f64>,
    /// Estimated error in the energy norm [%].
    pub energy_norm: Option<f64>,
    /// How these were found, or why there are none.
    pub kind: String,
    /// Unbalanced nodal forces, relative to loads and reactions.
    pub residual: Option<f64>,
}

/// Answers to all rows that were asked for, in their order, failures among them.
#[derive(Debug)]
pub struct Results<'a> {
    /// Their body.
    pub body: &'a Body,
    /// How displacements were found, such as `"predicted"`; the first is what the others are compared with.
    pub names: Vec<&'a str>,
    /// The rows.
    pub rows: Vec<Row<'a>>,
    /// Whether pictures hold stress, strain and fibres of the first of these displacements.
    pub stresses: bool,
}

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
        let error = |path: &Path| {
            let path = path.to_path_buf();
            move |source| MeshError::File { path, source }
        };
        std::fs::create_dir_all(folder).map_err(error(folder))?;
        clear(folder).map_err(error(folder))?;
        let table = folder.join("cases.csv");
        std::fs::write(&table, self.table()).map_err(error(&table))?;
        let bytes = size_of::<f64>() * self.rows.len() * self.names.len() * 3 * self.body.nodes;
        let left_out = (!arrays && bytes > MOST_BYTES).then_some(bytes);
        if left_out.is_none() {
            let archive = folder.join("cases.npz");
            self.write_arrays(&archive).map_err(error(&archive))?;
        }
        let mut series = Vec::new();
        let shown = (0..self.rows.len()).filter(|&case| !self.rows[case].fields.is_empty());
        for case in shown.take(pictures) {
            let name = format!("{case:04}.vtu");
            let theta = self.body.parameters.iter().zip(&self.rows[case].theta);
            let numbers: Vec<_> =
                theta.map(|(p, &value)| (p.unit.head(&p.name), p.unit.shown(value))).collect();
            self.picture(case).write_vtu_with(folder.join(&name), &numbers)?;
            series.push((case as f64, PathBuf::from(name)));
        }
        if !series.is_empty() {
            let series: Vec<_> =
                series.iter().map(|(time, file)| (*time, file.as_path())).collect();
            sinew_mesh::write_pvd(folder.join("cases.pvd"), &series)?;
        }
        Ok(left_out)
    }

    fn write_arrays(&self, path: &Path) -> io::Result<()> {
        let (cases, nodes, count) = (self.rows.len(), self.body.nodes, self.body.parameters.len());
        let missing = vec![f64::NAN; 3 * nodes];
        let mut theta = Vec::with_capacity(cases * count);
        for row in &self.rows {
            match row.theta.is_empty() {
                true => theta.extend(vec![f64::NAN; count]),
                false => theta.extend(shown(self.body, &row.theta)),
            }
        }
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
        let named = self.names.iter().zip(&fields);
        arrays.extend(named.map(|(name, values)| (*name, &shapes.1[..], &values[..])));
        npz::write(path, &arrays)
    }

    /// One case on its mesh.
    fn picture(&self, case: usize) -> sinew_mesh::AnyMesh {
        let mut mesh = (*self.body.mesh).clone();
        let fields = &self.rows[case].fields;
        for (name, field) in self.names.iter().zip(fields) {
            let field = Field::vectors(field.as_chunks::<3>().0);
            mesh.point_fields_mut().insert(format!("u_{name}"), field);
        }
        for (name, field) in self.names.iter().zip(fields).skip(1) {
            let apart = sinew_energy::metrics::displacement_error(fields[0], field);
            mesh.point_fields_mut().insert(format!("difference_{name}"), Field::scalars(apart));
        }
        if self.stresses {
            let (theta, field) = (&self.rows[case].theta, fields[0]);
            // A displacement that inverts a cell has no stress.
            if let Ok(cells) = cell_stresses(self.body, field, theta) {
                add_stresses(&mut mesh, self.body, &cells);
            }
        }
        mesh
    }

    /// A row per case: its number, θ, then for each way to find it the mean and the largest nodal displacement, the total
    /// potential energy and the volumes of cavities; how good it is; parameters outside their ranges; warnings; why it failed.
    fn table(&self) -> String {
        let judged = self.rows.iter().any(|row| row.quality.is_some());
        let row = |(case, row): (usize, &Row<'_>)| self.line(case, row, judged);
        let lines: Vec<String> = self.rows.par_iter().enumerate().map(row).collect();
        let heads: Vec<String> = self.heads(judged).iter().map(|head| quoted(head)).collect();
        std::iter::once(heads.join(",")).chain(lines).map(|line| line + "\n").collect()
    }

    fn heads(&self, judged: bool) -> Vec<String> {
        let (body, length, stress) = (self.body, &self.body.units.length, &self.body.units.stress);
        let mut heads = vec!["case".to_string()];
        heads.extend(body.parameters.iter().map(|p| p.unit.head(&p.name)));
        for name in &self.names {
            heads.push(format!("{name} mean u [{length}]"));
            heads.push(format!("{name} largest u [{length}]"));
            heads.push(format!("{name} energy [{stress} {length}3]"));
            let volume = |cavity: &sinew_energy::Cavity| {
                format!("{name} volume of {} [{length}3]", cavity.name)
            };
            heads.extend(body.cavities.iter().map(volume));
        }
        if judged {
            heads.extend(["mean", "largest"].map(|of| format!("estimated {of} error [{length}]")));
            heads.push("estimated error in the energy norm [%]".into());
            heads.push("estimate".into());
            heads.push("residual relative to the forces".into());
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
            let [mean, largest] = mean_and_largest(field);
            cells.extend([mean, largest, body.value(field, &row.theta)].map(|x| x.to_string()));
            cells.extend(body.cavity_volumes(field).iter().map(f64::to_string));
        }
        if row.fields.is_empty() {
            let each = 3 + body.cavities.len();
            cells.extend(vec![String::new(); self.names.len() * each]);
        }
        if judged {
            let number =
                |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            let Quality { mean, largest, energy_norm, kind, residual } =
                row.quality.clone().unwrap_or_default();
            cells.extend([mean, largest, energy_norm].map(number));
            cells.extend([quoted(&kind), number(residual)]);
        }
        cells.push(quoted(&outside(&body.parameters, &row.theta).join("; ")));
        cells.push(quoted(&row.warnings.join("; ")));
        cells.push(quoted(row.failure.as_deref().unwrap_or_default()));
        cells.join(",")
    }
}

/// θ in the parameters' own units.
fn shown(body: &Body, theta: &[f64]) -> Vec<f64> {
    body.parameters.iter().zip(theta).map(|(p, &value)| p.unit.shown(value)).collect()
}

/// A text as a cell of a CSV table.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " ")),
        false => text.into(),
    }
}

/// Removes what an earlier run wrote, and nothing else.
fn clear(folder: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let picture = name.strip_suffix(".vtu").is_some_and(|number| {
            number.len() >= 4 && number.bytes().all(|digit| digit.is_ascii_digit())
        });
        if picture || ["cases.csv", "cases.npz", "cases.pvd"].contains(&&*name) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// Mean and largest nodal displacement for people: `mean 15.47 mm, largest 37.50 mm`.
pub fn displacement_in_words(displacement: &[f64], unit: &str) -> String {
    let [mean, largest] = mean_and_largest(displacement).map(|length| digits(length, 4));
    format!("mean {mean} {unit}, largest {largest} {unit}")
}

/// Adds stress, strain and fibres to a mesh, at its cells and averaged to its nodes by volume.
fn add_stresses(mesh: &mut sinew_mesh::AnyMesh, body: &Body, cells: &[CellStress]) {
    let fibres: Option<Vec<Fibre>> = cells.iter().map(|cell| cell.fibre).collect();
    let fibres = fibres.unwrap_or_default();
    let tensor = |of: fn(&CellStress) -> &[[f64; 3]; 3]| -> (usize, Vec<f64>) {
        (9, cells.iter().flat_map(|cell| of(cell).as_flattened().to_vec()).collect())
    };
    let triple = |of: fn(&CellStress) -> [f64; 3]| (3, cells.iter().flat_map(of).collect());
    let fibre = |of: fn(&Fibre) -> f64| (1, fibres.iter().map(of).collect());
    let fields: [(&str, (usize, Vec<f64>)); 8] = [
        ("cauchy_stress", tensor(|cell| &cell.cauchy)),
        ("green_lagrange_strain", tensor(|cell| &cell.green_lagrange)),
        ("principal_stresses", triple(|cell| cell.principal_stresses)),
        ("principal_stretches", triple(|cell| cell.principal_stretches)),
        ("volume_ratio", (1, cells.iter().map(|cell| cell.volume_ratio).collect())),
        ("fibre", (3, fibres.iter().flat_map(|fibre| fibre.direction).collect())),
        ("fibre_stretch", fibre(|fibre| fibre.stretch)),
        ("fibre_stress", fibre(|fibre| fibre.stress)),
    ];
    for (name, (components, values)) in fields {
        if values.is_empty() {
            continue;
        }
        // A direction and its opposite are one fibre, and have no mean.
        if name != "fibre" {
            let values = FieldValues::Float(at_nodes(body, components, &values));
            mesh.point_fields_mut().insert(name.into(), Field { components, values });
        }
        let values = FieldValues::Float(values);
        mesh.cell_fields_mut().insert(name.into(), Field { components, values });
    }
}

/// Values of cells averaged to nodes by the volumes of the cells.
pub(crate) fn at_nodes(body: &Body, components: usize, values: &[f64]) -> Vec<f64> {
    let (mut sums, mut weights) = (vec![0.0; components * body.nodes], vec![0.0; body.nodes]);
    let volumes = body.volumes.chunks(body.points_per_cell).map(|of| of.iter().sum::<f64>());
    for ((nodes, volume), row) in body.cell_nodes().zip(volumes).zip(values.chunks(components)) {
        for &node in nodes {
            weights[node] += volume;
            let sums = &mut sums[components * node..][..components];
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += volume * value);
        }
    }
    sums.chunks_mut(components).zip(&weights).for_each(|(row, weight)| {
        row.iter_mut().for_each(|value| *value /= weight.max(f64::MIN_POSITIVE));
    });
    sums
}

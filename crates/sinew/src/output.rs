//! What the program writes: fields for ParaView, tables and arrays.

use crate::npz;
use sinew_energy::Body;
use sinew_mesh::{Field, MeshError};
use sinew_report::format::digits;
use std::fmt::Write as _;
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
    /// Writes `cases.csv`, `cases.npz` and, for the first `pictures` cases, `NNNN.vtu` with `cases.pvd` that lists them
    /// into a folder, which is made.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, pictures: usize) -> Result<(), MeshError> {
        let file = |name: &str| folder.join(name);
        let error = |path: &Path| {
            let path = path.to_path_buf();
            move |source| MeshError::File { path, source }
        };
        std::fs::create_dir_all(folder).map_err(error(folder))?;
        std::fs::write(file("cases.csv"), self.table()).map_err(error(&file("cases.csv")))?;
        self.write_arrays(&file("cases.npz")).map_err(error(&file("cases.npz")))?;
        let mut series = Vec::new();
        for case in 0..self.thetas.len().min(pictures) {
            let name = format!("{case:04}.vtu");
            self.picture(case).write_vtu(file(&name))?;
            series.push((case as f64, PathBuf::from(name)));
        }
        let series: Vec<_> = series.iter().map(|(time, file)| (*time, file.as_path())).collect();
        sinew_mesh::write_pvd(file("cases.pvd"), &series)
    }

    fn write_arrays(&self, path: &Path) -> io::Result<()> {
        let (cases, nodes) = (self.thetas.len(), self.body.nodes);
        let theta = self.thetas.concat();
        let shapes = ([cases, self.body.parameters.len()], [cases, nodes, 3], [nodes, 3]);
        let fields: Vec<_> =
            self.found.iter().map(|(name, fields)| (*name, fields.concat())).collect();
        let mut arrays: Vec<npz::Named<'_>> = vec![
            ("theta", &shapes.0, &theta),
            ("points", &shapes.2, self.body.positions.as_flattened()),
        ];
        arrays.extend(fields.iter().map(|(name, values)| (*name, &shapes.1[..], &values[..])));
        npz::write(path, &arrays)
    }

    /// One case on its mesh.
    fn picture(&self, case: usize) -> sinew_mesh::AnyMesh {
        let mut mesh = (*self.body.mesh).clone();
        let rows = |field: &[f64]| field.as_chunks::<3>().0.to_vec();
        let first = &self.found[0].1[case];
        for (name, fields) in &self.found {
            let field = rows(&fields[case]);
            mesh.point_fields_mut().insert(format!("u_{name}"), Field::vectors(&field));
        }
        for (name, fields) in self.found.iter().skip(1) {
            let apart = sinew_energy::metrics::displacement_error(first, &fields[case]);
            mesh.point_fields_mut().insert(format!("difference_{name}"), Field::scalars(apart));
        }
        mesh
    }

    /// A row per case: θ, then for each way to find it the mean and the largest nodal displacement, the total potential
    /// energy and the volumes of cavities.
    fn table(&self) -> String {
        let (body, length, stress) = (self.body, &self.body.units.length, &self.body.units.stress);
        let mut heads: Vec<String> =
            body.parameters.iter().map(|p| format!("{} [{}]", p.name, p.unit)).collect();
        for (name, _) in &self.found {
            heads.push(format!("{name} mean u [{length}]"));
            heads.push(format!("{name} largest u [{length}]"));
            heads.push(format!("{name} energy [{stress} {length}3]"));
            let volume = |cavity: &sinew_energy::Cavity| {
                format!("{name} volume of {} [{length}3]", cavity.name)
            };
            heads.extend(body.cavities.iter().map(volume));
        }
        let mut text = heads.join(",") + "\n";
        for (case, theta) in self.thetas.iter().enumerate() {
            let mut row: Vec<String> = theta.iter().map(f64::to_string).collect();
            for (_, fields) in &self.found {
                let field = &fields[case];
                let [mean, largest] = mean_and_largest(field);
                row.extend([mean, largest, body.value(field, theta)].map(|x| x.to_string()));
                row.extend(body.cavity_volumes(field).iter().map(f64::to_string));
            }
            let _ = writeln!(text, "{}", row.join(","));
        }
        text
    }
}

/// Mean and largest nodal displacement \[length\].
pub fn mean_and_largest(displacement: &[f64]) -> [f64; 2] {
    let lengths =
        displacement.as_chunks::<3>().0.iter().map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt());
    let (sum, largest) =
        lengths.fold((0.0, 0.0), |(sum, largest): (f64, f64), u| (sum + u, largest.max(u)));
    [sum / (displacement.len() / 3).max(1) as f64, largest]
}

/// Mean and largest nodal displacement for people: `mean 15.47 mm, largest 37.50 mm`.
pub fn displacement_in_words(displacement: &[f64], unit: &str) -> String {
    let [mean, largest] = mean_and_largest(displacement).map(|length| digits(length, 4));
    format!("mean {mean} {unit}, largest {largest} {unit}")
}

//! The case at rest of a body imaged under load.

use crate::stresses::volumes_at_rest;
use crate::{Case, CaseError};
use sinew_energy::Body;
use sinew_fem::Unloaded;
use sinew_mesh::{AnyMesh, Field};
use std::ffi::OsStr;
use std::path::Path;
use toml::{Table, Value};

/// Fields of the directions in a mesh at rest, and their keys in a case file.
const DIRECTIONS: [(&str, &str); 2] = [("fibre", "field"), ("sheet", "sheets")];

impl Case {
    /// The case of a body at rest, on its mesh in memory; `image` is the body that it was unloaded from.
    ///
    /// # Errors
    /// As [`Case::text_at_rest`].
    pub fn at_rest(&self, image: &Body, unloaded: &Unloaded) -> Result<Self, CaseError> {
        let text = self.text_at_rest(unloaded, None)?;
        Ok(Self::parse(&text, &self.name)?.on(mesh_at_rest(image, unloaded)))
    }

    /// Text of the case file of a body at rest: that of the image with another mesh file or none, sets and directions in the mesh, without
    /// the phases and data of a patient. A mesh file gives it its name.
    ///
    /// # Errors
    /// A case that came from no text.
    pub fn text_at_rest(
        &self,
        unloaded: &Unloaded,
        file: Option<&Path>,
    ) -> Result<String, CaseError> {
        let broken = |reason: String| {
            self.source.error(&[], format!("the case cannot be written again: {reason}"))
        };
        let mut root: Table =
            self.text().parse().map_err(|error: toml::de::Error| broken(error.to_string()))?;
        let text = |name: Option<&OsStr>| {
            Value::String(name.unwrap_or_default().to_string_lossy().into_owned())
        };
        // Bodies at rest of one case are told from each other by their files, also in the folder of their results.
        let name = match file {
            Some(file) => text(file.file_stem()),
            None => Value::String(format!("{} at rest", self.name)),
        };
        root.insert("name".into(), name);
        let file = file.map(|file| ("file".to_string(), text(file.file_name())));
        root.insert("mesh".into(), Value::Table(Table::from_iter(file)));
        let rest = &unloaded.rest;
        let formulation = if rest.patches.is_empty() { "plain" } else { "averaged" };
        root.insert("formulation".into(), Value::String(formulation.into()));
        // A patient file is none at rest: its image would be unloaded again.
        root.retain(|key, _| !["select", "phases", "data", "calibration"].contains(&key));
        let count = rest.material.directions(0).len();
        if count > 0 {
            let named = DIRECTIONS.into_iter().take(count);
            let fields = named.map(|(name, key)| (key.into(), Value::String(name.into())));
            root.insert("fibres".into(), Value::Table(fields.collect()));
        }
        toml::to_string(&root).map_err(|error| broken(error.to_string()))
    }
}

/// Mesh at rest, with sets and directions, the displacement to the image (`u_to_image`) and the ratio of volumes (`det_f`).
pub fn mesh_at_rest(image: &Body, unloaded: &Unloaded) -> AnyMesh {
    let rest = &unloaded.rest;
    let mut mesh = (*rest.mesh).clone();
    let to_image = Field::vectors(unloaded.displacement().as_chunks::<3>().0);
    mesh.point_fields_mut().insert("u_to_image".into(), to_image);
    let volumes = volumes_at_rest(rest).zip(volumes_at_rest(image));
    let ratios = volumes.map(|(rest, image)| rest / image).collect();
    mesh.cell_fields_mut().insert("det_f".into(), Field::scalars(ratios));
    let count = rest.material.directions(0).len();
    for (direction, (name, _)) in DIRECTIONS.into_iter().enumerate().take(count) {
        let rows: Vec<_> = (0..rest.cell_count()).map(|cell| mean(rest, cell, direction)).collect();
        mesh.point_fields_mut().remove(name);
        mesh.cell_fields_mut().insert(name.into(), Field::vectors(&rows));
    }
    mesh
}

/// The mean direction of a cell; that of its point where it has one.
fn mean(rest: &Body, cell: usize, direction: usize) -> [f64; 3] {
    let points = rest.points_per_cell;
    let at = |point: usize| rest.material.directions(point)[direction];
    if points == 1 {
        return at(cell);
    }
    let sum = (cell * points..(cell + 1) * points)
        .fold([0.0; 3], |sum: [f64; 3], point| std::array::from_fn(|i| sum[i] + at(point)[i]));
    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    sum.map(|x| x / length)
}

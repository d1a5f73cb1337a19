//! Fields for ParaView: the median and the worst case of every method.

use anyhow::Result;
use sinew_energy::metrics::displacement_error;
use sinew_mesh::{Field, TetMesh, write_pvd, write_vtu};
use std::path::{Path, PathBuf};

/// One test case with the displacements of several methods.
#[derive(Debug)]
pub struct FieldCase<'a> {
    /// File name without extension, such as `pi_worst`.
    pub name: String,
    /// True displacement \[mm\].
    pub truth: &'a [f64],
    /// Methods by key, with their displacements \[mm\].
    pub predictions: Vec<(&'a str, &'a [f64])>,
}

/// Writes one VTU file per case, with `u_fem`, `u_METHOD` and `error_METHOD` \[mm\] at the nodes, and a
/// PVD file that lists them as a series.
pub fn write(folder: &Path, mesh: &TetMesh, cases: &[FieldCase<'_>]) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let mut files = Vec::new();
    for case in cases {
        let mut mesh = mesh.clone();
        mesh.point_fields.insert("u_fem".into(), Field::vectors(&rows(case.truth)));
        for (method, prediction) in &case.predictions {
            let error = displacement_error(case.truth, prediction);
            mesh.point_fields.insert(format!("u_{method}"), Field::vectors(&rows(prediction)));
            mesh.point_fields.insert(format!("error_{method}"), Field::scalars(error));
        }
        let file = format!("{}.vtu", case.name);
        write_vtu(folder.join(&file), &mesh)?;
        files.push(PathBuf::from(file));
    }
    let series: Vec<_> =
        files.iter().enumerate().map(|(time, file)| (time as f64, file.as_path())).collect();
    write_pvd(folder.join("cases.pvd"), &series)?;
    Ok(())
}

/// A flat displacement as one row per node.
pub(crate) fn rows(displacement: &[f64]) -> Vec<[f64; 3]> {
    displacement.as_chunks::<3>().0.to_vec()
}

//! The iterations of a solve as meshes, for ParaView.

use crate::Progress;
use crate::elements::cells::{per_cell, volume_ratios};
use crate::elements::supports::part;
use sinew_energy::Body;
use sinew_mesh::{AnyMesh, Field, MeshError, write_pvd};
use std::path::{Path, PathBuf};

/// The reference mesh of a body with the state of an iteration.
fn iteration_mesh(potential: &Body, progress: &Progress<'_>) -> AnyMesh {
    let rows = |values: &[f64]| Field::vectors(values.as_chunks::<3>().0);
    let forces = progress.forces.as_chunks::<3>().0.iter().enumerate();
    let residual: Vec<_> =
        forces.flat_map(|(node, force)| part(potential, node, force, false)).collect();
    let ratios = volume_ratios(potential, progress.displacement);
    let ratios = per_cell(&ratios, potential.points_per_cell, f64::min);
    let mut mesh = AnyMesh::clone(&potential.mesh);
    mesh.point_fields_mut().insert("displacement".into(), rows(progress.displacement));
    mesh.point_fields_mut().insert("residual_force".into(), rows(&residual));
    mesh.cell_fields_mut().insert("volume_ratio".into(), Field::scalars(ratios));
    mesh
}

/// Writes one VTU file per iteration, and a PVD file that plays them in order.
///
/// They show the mesh at rest with the point fields `displacement` \[length\] and `residual_force` (unbalanced at
/// free degrees of freedom, zero at prescribed ones; \[stress·length²\]) and the cell field `volume_ratio` (the
/// least J of each cell).
///
/// ```no_run
/// # fn f(potential: &sinew_energy::Body) -> Result<(), Box<dyn std::error::Error>> {
/// use sinew_fem::{IterationSeries, Options, Solver};
/// let mut series = IterationSeries::new(potential, "out/beam");
/// let solved = Solver::new(potential)?
///     .solve_watched(&[75.0, 75.0], &Options::default(), &mut |progress| series.add(progress));
/// series.finish()?; // out/beam.pvd, out/beam_0000.vtu, …: of a failed solve as well
/// solved?;
/// # Ok(()) }
/// ```
pub struct IterationSeries<'p> {
    potential: &'p Body,
    stem: PathBuf,
    written: Vec<PathBuf>,
    failure: Option<MeshError>,
}

impl<'p> IterationSeries<'p> {
    /// A series of files whose names begin with `stem`, in a folder that exists.
    pub fn new(potential: &'p Body, stem: impl AsRef<Path>) -> Self {
        let stem = stem.as_ref().to_path_buf();
        Self { potential, stem, written: Vec::new(), failure: None }
    }

    /// Writes the next file. An error ends the series; [`IterationSeries::finish`] returns it.
    pub fn add(&mut self, progress: &Progress<'_>) {
        if self.failure.is_some() {
            return;
        }
        let path = self.path(&format!("_{:04}.vtu", self.written.len()));
        match iteration_mesh(self.potential, progress).write_vtu(&path) {
            Ok(()) => self.written.push(path),
            Err(failure) => self.failure = Some(failure),
        }
    }

    /// Writes the PVD file, whose times are the numbers of the iterations: its path.
    ///
    /// # Errors
    /// The first file that could not be written.
    pub fn finish(self) -> Result<PathBuf, MeshError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        let path = self.path(".pvd");
        let names = self.written.iter().map(|path| Path::new(path.file_name().unwrap_or_default()));
        let series: Vec<_> = (0u32..).map(f64::from).zip(names).collect();
        write_pvd(&path, &series)?;
        Ok(path)
    }

    fn path(&self, ending: &str) -> PathBuf {
        let mut path = self.stem.clone().into_os_string();
        path.push(ending);
        path.into()
    }
}

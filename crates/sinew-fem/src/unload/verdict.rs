//! Checks of a body at rest after the search.

use super::connected::connected;
use super::error::UnloadError;
use super::image::Image;
use super::options::UnloadOptions;
use super::state::Trial;
use super::unloaded::Loading;
use crate::elements::system::Unknowns;
use crate::{LoadSteps, Options, SolveError, Solver};
use sinew_mesh::{TriangleMesh, self_intersections};
use std::time::Instant;

/// Largest distance to the image after loading [relative to the largest displacement]: rounding errors, amplified by an
/// ill-conditioned stiffness.
const SAME: f64 = 1e-6;

impl Image<'_> {
    /// Checks a body at rest: that it does not cross itself, that the image is one of its stable equilibria, and that loading leads there.
    pub(super) fn judge(
        &self,
        trial: &Trial,
        theta: &[f64],
        options: &UnloadOptions,
    ) -> Result<Option<Loading>, UnloadError> {
        self.check_crossings(trial)?;
        let rest = &trial.rest;
        let mut system = self.system.like(rest)?;
        let residual = system.assemble(&Unknowns::of(&trial.displacement), theta, 1.0, None);
        let (shift, negative_pivots) = system.factorise(false).ok_or(SolveError::Singular)?;
        if negative_pivots > 0 {
            return Err(UnloadError::Unstable { negative_pivots });
        }
        let Some(forward) = &options.load else { return Ok(None) };
        let shown = connected(&mut system, trial, theta, forward, (residual, shift));
        if shown.is_some() {
            return Ok(shown);
        }
        let start = Instant::now();
        let mut loaded = load(self, trial, theta, forward)?;
        let same = SAME * trial.motion.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
        let mut apart = farthest(&loaded.0, &trial.displacement);
        if apart.0 > same {
            let rising = Options { load_steps: LoadSteps::Always, ..*forward };
            loaded = load(self, trial, theta, &rising)?;
            apart = farthest(&loaded.0, &trial.displacement);
        }
        let (distance, node) = apart;
        if distance > same {
            return Err(UnloadError::OtherBranch { distance, node });
        }
        let seconds = start.elapsed().as_secs_f64();
        Ok(Some(Loading { distance, iterations: loaded.1, seconds }))
    }

    fn check_crossings(&self, trial: &Trial) -> Result<(), UnloadError> {
        let rest = &trial.rest.mesh;
        if rest.element().dimension != 3 {
            return Ok(());
        }
        let (triangles, cells) = rest.boundary_triangles();
        let points = rest.points().to_vec();
        let surface = TriangleMesh { points, cells: triangles, ..TriangleMesh::default() };
        let found = self_intersections(&surface);
        if found.is_empty() {
            return Ok(());
        }
        let points = self.system.body.positions.clone();
        let before = self_intersections(&TriangleMesh { points, ..surface });
        let new: Vec<_> = found.iter().filter(|pair| !before.contains(pair)).collect();
        match new.first() {
            None => Ok(()),
            Some(pair) => {
                let cells = pair.map(|triangle| cells[triangle]);
                Err(UnloadError::CrossesItself { pairs: new.len(), cells })
            }
        }
    }
}

/// Loads a body from rest: the displacement \[length\], and how many iterations it took.
fn load(
    image: &Image<'_>,
    trial: &Trial,
    theta: &[f64],
    options: &Options,
) -> Result<(Vec<f64>, usize), UnloadError> {
    let mut solver = Solver::of(image.system.like(&trial.rest)?);
    let found = solver.solve(theta, options).map_err(UnloadError::NotLoaded)?;
    Ok((found.displacement, found.history.steps()))
}

/// Largest distance of a node between two displacements \[length\], and the node.
fn farthest(first: &[f64], second: &[f64]) -> (f64, usize) {
    let nodes = first.as_chunks::<3>().0.iter().zip(second.as_chunks::<3>().0);
    let distances = nodes.map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt());
    let largest = distances.zip(0..).max_by(|a, b| a.0.total_cmp(&b.0));
    largest.unwrap_or((0.0, 0))
}

//! Checks of a body at rest after the search: by a state halfway on the curve of its equilibria, or by loading it.

use crate::elements::{Residual, State, System, Unknowns};
use crate::linear::{difference, dot, norm};
use crate::solve::{ON_THE_WAY, Path, Plane, Point};
use crate::unload::state::{Image, Loading, Trial, UnloadOptions};
use crate::unload::{Result, UnloadError};
use crate::{Line, LoadSteps, Options, SolveError, Solver};
use sinew_energy::metrics::{displacement_error, mean_and_largest};
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
    ) -> Result<Option<Loading>> {
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
        let load = |options: &Options| -> Result<_> {
            let mut solver = Solver::of(self.system.like(rest)?);
            let found = solver.solve(theta, options).map_err(UnloadError::NotLoaded)?;
            Ok((found.displacement, found.history.steps()))
        };
        let mut loaded = load(forward)?;
        let same = SAME * trial.motion.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
        let mut apart = farthest(&loaded.0, &trial.displacement);
        if apart.0 > same {
            let rising = Options { load_steps: LoadSteps::Always, ..*forward };
            loaded = load(&rising)?;
            apart = farthest(&loaded.0, &trial.displacement);
        }
        let (distance, node) = apart;
        if distance > same {
            return Err(UnloadError::OtherBranch { distance, node });
        }
        let seconds = start.elapsed().as_secs_f64();
        Ok(Some(Loading { distance, iterations: loaded.1, seconds }))
    }

    fn check_crossings(&self, trial: &Trial) -> Result<()> {
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
        let Some(pair) = new.first() else { return Ok(()) };
        let cells = pair.map(|triangle| cells[triangle]);
        Err(UnloadError::CrossesItself { pairs: new.len(), cells })
    }
}

/// Largest distance of a node between two displacements \[length\], and the node.
fn farthest(first: &[f64], second: &[f64]) -> (f64, usize) {
    let distances = displacement_error(first, second).into_iter().zip(0..);
    distances.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
}

/// Largest distance to the image of its extrapolation from half-way \[relative to its displacement\]. Ventricles of the box have 0.06 to 0.13; those
/// beyond are loaded from rest.
const NEAR: f64 = 0.25;
/// Largest slope at an end of a monotone cubic \[relative to its secant\] (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 1980).
const MONOTONE: f64 = 3.0;

/// The path to the image, whose stiffness was factorised last, with this shift and residual; `None` where doubt remains.
///
/// A state's place s on the path is the projection of its displacement u on that of the image, relative to the latter. The search for the equilibrium
/// at s = ½, whose load factor λ is unknown, starts on the parabola u(s) through rest and the image with the tangent there. This equilibrium
/// has to be stable, the parabola through rest and it, with its tangent, has to end near the image, and λ(s) has to be monotone.
fn connected(
    system: &mut System<'_>,
    trial: &Trial,
    theta: &[f64],
    options: &Options,
    (residual, shift): (Residual, f64),
) -> Option<Loading> {
    let start = Instant::now();
    let image: Vec<f64> = system.sparsity.gather(&trial.displacement).collect();
    let length = norm(&image);
    let moved_supports = system.body.prescribed.iter().flatten().any(|&u| u != 0.0);
    if moved_supports || length == 0.0 {
        return None;
    }
    let by_displacement: Vec<f64> = image.iter().map(|u| u / (length * length)).collect();
    // Change of the displacement with s, and of s with the load factor.
    let tangent = |by_load: &[f64]| -> (Vec<f64>, f64) {
        let rate = dot(&by_displacement, by_load);
        (by_load.iter().map(|u| u / rate).collect(), rate)
    };
    let mut path = Path::from_rest(system, Line::of_loads(theta), options);
    path.release_stresses();
    let state = State::whole(&trial.displacement, theta);
    let rate = path.system.rate_on(&path.line, state);
    let (correction, _) = path.system.solve(&residual.values, shift).ok()?;
    let (by_load, _) = path.system.solve(&rate, shift).ok()?;
    let (along, end) = tangent(&by_load);
    let parabola = image.iter().zip(&along).map(|(u, along)| 0.75 * u - 0.25 * along);
    let unknowns = Unknowns::of(&path.system.sparsity.scattered(parabola));
    let guess = Point { at: 0.5, place: 1.0 - 0.5 / end, unknowns, stress: None };
    let plane = Plane { normal: (by_displacement.clone(), 0.0), distance: 0.5 };
    let half = path.meeting(Some(&plane), guess, ON_THE_WAY)?;
    let (extrapolated, middle) = tangent(&half.by_place);
    let off = difference(&extrapolated, &image);
    let most = MONOTONE * 2.0;
    let monotone = 0.0 < middle
        && 1.0 <= most * half.place.min(1.0 - half.place) * middle
        && 1.0 <= most * (1.0 - half.place) * end;
    // Written so that a NaN leaves doubt.
    let near = norm(&off) <= NEAR * length;
    if half.negative_pivots > 0 || !monotone || !near {
        return None;
    }
    let [_, distance] = mean_and_largest(&path.system.sparsity.scattered(correction));
    let (iterations, seconds) = (path.log.iterations.len(), start.elapsed().as_secs_f64());
    Some(Loading { distance, iterations, seconds })
}

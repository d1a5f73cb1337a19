//! Check that a path of stable equilibria leads from the body at rest to its image, by one equilibrium half-way.

use super::state::Trial;
use super::unloaded::Loading;
use crate::Options;
use crate::elements::state::State;
use crate::elements::system::{Residual, System, Unknowns};
use crate::linear::vector::{dot, norm};
use crate::solve::path::Path;
use crate::solve::plane::Plane;
use crate::solve::search::Point;
use sinew_energy::metrics::mean_and_largest;
use std::time::Instant;

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
pub(super) fn connected(
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
    let mut path = Path::to_load(system, theta, options);
    path.release_stresses();
    let state = State { displacement: &trial.displacement, theta, load_factor: 1.0, pressure: &[] };
    let rate = path.system.rate_on(&path.line, state);
    let solve = |right: Vec<f64>| path.system.solve(right.iter().map(|r| -r).collect(), shift);
    let (correction, _) = solve(residual.values).ok()?;
    let (by_load, _) = solve(rate).ok()?;
    let (along, end) = tangent(&by_load);
    let mut displacement = vec![0.0; trial.displacement.len()];
    let parabola = image.iter().zip(&along).map(|(u, along)| 0.75 * u - 0.25 * along);
    path.system.sparsity.scatter(parabola, &mut displacement);
    let unknowns = Unknowns::of(&displacement);
    let guess = Point { at: 0.5, place: 1.0 - 0.5 / end, unknowns, stress: None };
    let plane = Plane { normal: (by_displacement.clone(), 0.0), distance: 0.5 };
    let enough = options.accuracy_on_the_way;
    let half = path.meeting(Some(&plane), guess, enough)?;
    let (extrapolated, middle) = tangent(&half.by_place);
    let off: Vec<f64> = extrapolated.iter().zip(&image).map(|(to, u)| to - u).collect();
    let most = MONOTONE * 2.0;
    let monotone = 0.0 < middle
        && 1.0 <= most * half.place.min(1.0 - half.place) * middle
        && 1.0 <= most * (1.0 - half.place) * end;
    // Written so that a NaN leaves doubt.
    let near = norm(&off) <= NEAR * length;
    if half.negative_pivots > 0 || !monotone || !near {
        return None;
    }
    let mut to_equilibrium = vec![0.0; displacement.len()];
    path.system.sparsity.scatter(correction, &mut to_equilibrium);
    let [_, distance] = mean_and_largest(&to_equilibrium);
    let (iterations, seconds) = (path.log.iterations.len(), start.elapsed().as_secs_f64());
    Some(Loading { distance, iterations, seconds })
}

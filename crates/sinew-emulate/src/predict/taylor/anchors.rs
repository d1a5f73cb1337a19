//! Further solved states of an expansion, one after the other where its error is largest.

use crate::coordinates::{Anchor, Motions};
use crate::parameters::{self, in_words};
use crate::predict::taylor::derivatives::{first_order, second_order};
use crate::recipe::progress::{Counter, Observer};
use crate::{Body, Design, Error, Result};
use sinew_fem::{Options, Solver};
use std::ops::ControlFlow;

/// Parameter sets among which anchors are chosen.
const CANDIDATES: usize = 1000;
/// Candidates of the largest variance whose displacement is predicted, and those of them whose error is estimated by Newton steps.
const PREDICTED: usize = 100;
const CHECKED: usize = 4;
/// Deviations of the parameters over which derivatives at an anchor are differences: their error is of second order.
const STEP: f64 = 0.02;

/// Motions that go through `count` solved states: the one at the centre of the ranges, which they are about, and others that are added where the
/// error is largest (greedy reduced basis; Hesthaven, Rozza & Stamm 3.2). Candidates are 1000 parameter sets of Sobol's sequence. The four with the
/// largest product of the interpolation's standard deviation and the predicted displacement are checked by Newton steps. The one with the
/// largest error estimate is solved. One without an estimate counts as farthest.
///
/// # Errors
/// An anchor that has no equilibrium, an observer that breaks.
pub fn with_anchors(
    solver: &mut Solver<'_>,
    motions: Motions,
    count: usize,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Motions> {
    if count < 2 {
        return Ok(motions);
    }
    let body = solver.body();
    let mut candidates = Design::Sobol.sample(&body.parameters, CANDIDATES, seed)?;
    let mut counter = Counter::new(observer, "anchors", 1, count);
    let mut anchors = vec![anchor(solver, &body.centre(), motions.origin(), 1)?];
    let mut through = motions.clone().through(&anchors)?;
    while anchors.len() < count {
        let (theta, start) = farthest(solver, &through, &mut candidates)?;
        let solved = match &start {
            Some(near) => solver.solve_from(near, &theta, &Options::default()),
            None => solver.solve(&theta, &Options::default()),
        };
        let number = anchors.len() + 1;
        let solved = solved.map_err(|error| lacking(body, number, &theta, error.to_string()))?;
        anchors.push(anchor(solver, &theta, &solved.displacement, number)?);
        through = motions.clone().through(&anchors)?;
        if let ControlFlow::Break(()) = counter.step(1, "") {
            return Err(Error::Interrupted { stage: "anchors".into() });
        }
    }
    counter.finish(&format!("{count} solved states"));
    Ok(through)
}

/// Takes the candidate of the largest error, with a state near to its equilibrium where there is one.
fn farthest(
    solver: &mut Solver<'_>,
    motions: &Motions,
    candidates: &mut Vec<Vec<f64>>,
) -> Result<(Vec<f64>, Option<Vec<f64>>)> {
    let (body, scaling) = (solver.body(), parameters::scaling(solver.body())?);
    let place = |theta: &Vec<f64>| Ok(scaling.standardise(theta)?);
    let places: Vec<Vec<f64>> = candidates.iter().map(place).collect::<Result<_>>()?;
    let variance = |x: &Vec<f64>| motions.anchors().map_or(Ok(1.0), |anchors| anchors.variance(x));
    let variances: Vec<f64> = places.iter().map(variance).collect::<std::result::Result<_, _>>()?;
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| variances[b].total_cmp(&variances[a]));
    let scored = order.into_iter().take(PREDICTED).map(|index| {
        let predicted = motions.expansion_at(&places[index], body)?;
        let squares =
            predicted.as_chunks::<3>().0.iter().map(|u| u.iter().map(|u| u * u).sum::<f64>());
        Ok((variances[index] * squares.fold(0.0, f64::max), index, predicted))
    });
    let mut scored: Vec<(f64, usize, Vec<f64>)> = scored.collect::<Result<_>>()?;
    scored.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
    let mut best: Option<(f64, usize, Option<Vec<f64>>)> = None;
    for (_, place, predicted) in scored.into_iter().take(CHECKED) {
        let estimate = solver.error_estimate(&predicted, &candidates[place])?;
        let (error, near) = match estimate.distance {
            Ok(distance) => (distance.largest, Some(distance.equilibrium)),
            Err(_) => (f64::INFINITY, None),
        };
        if best.as_ref().is_none_or(|(largest, ..)| error > *largest) {
            best = Some((error, place, near));
        }
    }
    let (_, place, near) = best.ok_or_else(|| {
        Error::Refused("no answer was found; solve it from rest (sinew solve)".into())
    })?;
    Ok((candidates.swap_remove(place), near))
}

/// Why there is no anchor.
fn lacking(body: &Body, number: usize, theta: &[f64], reason: String) -> Error {
    Error::Anchor { number, theta: in_words(body, theta), reason }
}

/// A solved state with its Taylor polynomial.
fn anchor(solver: &mut Solver<'_>, theta: &[f64], state: &[f64], number: usize) -> Result<Anchor> {
    let at = parameters::scaling(solver.body())?.standardise(theta)?;
    let first = first_order(solver, state, theta)?;
    let from = |away: &[f64]| -> Result<Vec<f64>> {
        let mut moved = state.to_vec();
        for (change, away) in first.iter().zip(away) {
            moved.iter_mut().zip(change).for_each(|(u, change)| *u += away * change);
        }
        Ok(moved)
    };
    let second = second_order(solver, &at, &from, STEP)?;
    let reason = "a step of its derivatives inverts a cell";
    let second = second.ok_or_else(|| lacking(solver.body(), number, theta, reason.into()))?;
    let changes = std::iter::once(state.to_vec()).chain(first.iter().cloned()).chain(second);
    Ok(Anchor { at, changes: changes.collect() })
}

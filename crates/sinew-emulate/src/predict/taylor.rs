//! Taylor expansion of second order about the solution at the centre of the parameters' ranges.

use crate::coordinates::{Anchor, Motions, halves};
use crate::parameters::{self, in_words};
use crate::recipe::progress::{Counter, Observer};
use crate::{Body, Design, Error, Result};
use sinew_energy::Barriers;
use sinew_fem::{Options, SolveError, Solver};
use sinew_num::{difference, dot, try_in_parallel};

/// Short name of the recipe, and what it makes.
pub(crate) const KEY: &str = "taylor";
pub(crate) fn about(anchors: usize) -> String {
    let solutions = if anchors == 1 { "one solution" } else { &format!("{anchors} solutions") };
    format!("Taylor expansion of second order about {solutions}")
}

/// Parameter sets that parts of the orders are tried at.
const TRIED: usize = 16;

/// Taylor expansion of second order about the solution at the centre of the parameters' ranges: derivatives by the implicit function
/// theorem, second order with the stiffness of that solution, both in rigid motions of the body's clusters, so that rotations do not
/// stretch. It may go through further solutions (anchors), with their derivatives.
pub(crate) fn solved(
    body: &Body,
    anchors: usize,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Motions> {
    let mut solver = Solver::new(body)?;
    let centre = solver.solve(&body.centre(), &Options::default())?;
    let motions = about_solved(&mut solver, &centre.displacement, seed)?;
    with_anchors(&mut solver, motions, anchors, seed, observer)
}

/// Taylor expansion about a known solution at the centre of the parameters' ranges.
pub(crate) fn about_solved(solver: &mut Solver<'_>, solved: &[f64], seed: u64) -> Result<Motions> {
    let body = solver.body();
    let tried = Design::LatinHypercube.sample(&body.parameters, TRIED, seed)?;
    let motions = Motions::about(solved, &halves(&body.positions), body, &body.centre())?;
    Ok(expand(solver, motions, &tried)?.0)
}

/// Displacement of an expansion at θ, node by node \[length\].
pub(crate) fn at(motions: &Motions, body: &Body, theta: &[f64]) -> Result<Vec<f64>> {
    Ok(motions.expansion_at(&parameters::scaling(body)?.standardise(theta)?, body)?)
}

/// Motions with their Taylor polynomial in the parameters; a network learns the remainder. The derivatives of the solution
/// are also features of the graph's nodes, in units of outputs. They hold the effect of fibres, loads and supports on each
/// part of the body.
///
/// The first order takes one linear system per parameter, at the motions' origin. The second order comes from one Newton
/// step after the first order, at a deviation in each parameter and in each pair of parameters, with the factor at the
/// origin. An order that overshoots, as under exponential laws, is damped.
///
/// Returns these motions, and those of first order for the features.
#[doc(alias = "following")]
pub fn expand(
    solver: &mut Solver<'_>,
    motions: Motions,
    thetas: &[Vec<f64>],
) -> Result<(Motions, Motions)> {
    /// Distances in standardised parameters at which second order is taken, the next where the one before inverts a cell.
    const DEVIATIONS: [f64; 3] = [1.0, 0.5, 0.25];
    let body = solver.body();
    let centre = body.centre();
    let mut changes = first_order(solver, motions.origin(), &centre)?;
    let first = motions.clone().with_expansion(&changes, body)?;
    for deviation in DEVIATIONS {
        let from = |away: &[f64]| Ok(first.expansion_at(away, body)?);
        let products = match second_order(solver, &vec![0.0; centre.len()], &from, deviation) {
            Err(Error::Solve(SolveError::Inadmissible { .. })) => continue,
            found => found?,
        };
        changes.extend(products);
        let both = motions.clone().with_expansion(&changes, body)?;
        // A body that no load moves has no amplitude.
        let with_amplitude = motions.with_amplitude(&changes, centre.len(), body).ok();
        let forms = std::iter::once(both).chain(with_amplitude);
        return Ok((damped(forms, body, thetas)?, first));
    }
    Ok((damped([first.clone()], body, thetas)?, first))
}

/// Changes of a displacement with each standardised parameter; its stiffness is factorised last.
fn first_order(solver: &mut Solver<'_>, state: &[f64], theta: &[f64]) -> Result<Vec<Vec<f64>>> {
    let slopes = parameters::scaling(solver.body())?.slopes(theta);
    let mut changes = solver.sensitivity_at(state, theta)?;
    for (change, slope) in changes.iter_mut().zip(slopes) {
        change.iter_mut().for_each(|u| *u /= slope);
    }
    Ok(changes)
}

/// Damping factors of first and second order, and the form, with the lowest energy at `thetas`. Energies above a small
/// share of the loads' work count by their logarithm, so that no single parameter set decides.
fn damped(
    forms: impl IntoIterator<Item = Motions>,
    body: &Body,
    thetas: &[Vec<f64>],
) -> Result<Motions> {
    /// Parts of both that are tried.
    const PARTS: [[f64; 2]; 6] =
        [[1.0, 1.0], [1.0, 0.6], [1.0, 0.3], [1.0, 0.0], [0.7, 0.0], [0.4, 0.0]];
    /// The small part of the work.
    const PRECISE: f64 = 0.01;
    let of_first_order = body.parameters.len();
    let all = |form: Motions| PARTS.map(|parts| (0.0, form.clone().damped(parts, of_first_order)));
    let mut tried: Vec<(f64, Motions)> = forms.into_iter().flat_map(all).collect();
    let guarded = body.clone().with_barriers(Barriers::default());
    let scaling = parameters::scaling(body)?;
    let work = work(body, tried[0].1.origin());
    for theta in thetas {
        let at = scaling.standardise(theta)?;
        let energy = |(_, motions): &(f64, Motions)| -> Result<f64> {
            Ok(guarded.value(&motions.expansion_at(&at, body)?, theta))
        };
        let energies = try_in_parallel(&tried, energy)?;
        let least = energies.iter().copied().fold(f64::INFINITY, f64::min);
        // Loads that are zero at the centre do no work there: then the energies' own size is the scale.
        let scale = PRECISE * if work > 0.0 { work } else { least.abs() };
        // If all energies are infinite, none is preferred.
        for ((loss, _), energy) in tried.iter_mut().zip(energies).filter(|_| least.is_finite()) {
            let excess = energy - least;
            *loss += if excess > 0.0 { (excess / scale).ln_1p() } else { 0.0 };
        }
    }
    tried.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(tried.swap_remove(0).1)
}

/// Changes of the displacement with the products of two standardised parameters, from states of first order, `from`, so far from a state
/// `at` whose stiffness was factorised last.
///
/// # Errors
/// [`SolveError::Inadmissible`] where one of these states inverts a cell.
fn second_order(
    solver: &mut Solver<'_>,
    at: &[f64],
    from: &dyn Fn(&[f64]) -> Result<Vec<f64>>,
    deviation: f64,
) -> Result<Vec<Vec<f64>>> {
    let body = solver.body();
    let (count, scaling) = (body.parameters.len(), parameters::scaling(body)?);
    let factor = 0.5 / deviation.powi(2);
    // Mean Newton step at both ends of a direction: odd orders cancel.
    let mut missing = |axes: &[usize]| -> Result<Vec<f64>> {
        let mut sum = vec![0.0; 3 * body.nodes];
        for sign in [deviation, -deviation] {
            let away: Vec<f64> =
                (0..count).map(|p| if axes.contains(&p) { sign } else { 0.0 }).collect();
            let from = from(&away)?;
            let moved: Vec<f64> = at.iter().zip(&away).map(|(x, away)| x + away).collect();
            let theta = scaling.unstandardise(&moved)?;
            let to = solver.simplified_step(&from, &theta)?;
            for (sum, (to, from)) in sum.iter_mut().zip(to.iter().zip(&from)) {
                *sum += factor * (to - from);
            }
        }
        Ok(sum)
    };
    // The origin need not be in equilibrium itself.
    let at_origin = missing(&[])?;
    let square = |p: usize| Ok(difference(&missing(&[p])?, &at_origin));
    let squares: Vec<Vec<f64>> = (0..count).map(square).collect::<Result<_>>()?;
    let mut products = Vec::with_capacity(count * (count + 1) / 2);
    for p in 0..count {
        products.push(squares[p].clone());
        for q in p + 1..count {
            let mut both = missing(&[p, q])?;
            let alone = squares[p].iter().zip(&squares[q]).zip(&at_origin);
            both.iter_mut().zip(alone).for_each(|(both, ((p, q), at_origin))| {
                *both -= p + q + at_origin;
            });
            products.push(both);
        }
    }
    Ok(products)
}

/// A displacement that inverts a cell is halved until it does not.
pub fn admissible(body: &Body, displacement: &[f64]) -> Vec<f64> {
    let (mut anchor, centre) = (displacement.to_vec(), body.centre());
    while !body.value(&anchor, &centre).is_finite() {
        anchor.iter_mut().for_each(|u| *u *= 0.5);
    }
    anchor
}

/// Work of the loads, or the energy where there are none to speak of \[energy\].
pub fn work(body: &Body, displacement: &[f64]) -> f64 {
    let energy = body.value(displacement, &body.centre());
    body.load_value(displacement, &body.centre()).abs().max(energy.abs())
}

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
        let (number, options) = (anchors.len() + 1, Options::default());
        let solved = match &start {
            Some(near) => solver.solve_from(near, &theta, &options),
            None => solver.solve(&theta, &options),
        };
        let solved = solved.map_err(|error| lacking(body, number, &theta, error.to_string()))?;
        anchors.push(anchor(solver, &theta, &solved.displacement, number)?);
        through = motions.clone().through(&anchors)?;
        let _ = counter.step(1, "");
        counter.check()?;
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
    let places = candidates.iter().map(|theta| scaling.standardise(theta));
    let places: Vec<Vec<f64>> = places.collect::<std::result::Result<_, _>>()?;
    let variance = |x: &Vec<f64>| motions.anchors().map_or(Ok(1.0), |anchors| anchors.variance(x));
    let variances: Vec<f64> = places.iter().map(variance).collect::<std::result::Result<_, _>>()?;
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| variances[b].total_cmp(&variances[a]));
    let scored = order.into_iter().take(PREDICTED).map(|index| {
        let predicted = motions.expansion_at(&places[index], body)?;
        let squares = predicted.chunks_exact(3).map(|u| dot(u, u));
        Ok((variances[index] * squares.fold(0.0, f64::max), index, predicted))
    });
    let mut scored: Vec<(f64, usize, Vec<f64>)> = scored.collect::<Result<_>>()?;
    scored.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
    let checked = scored.into_iter().take(CHECKED).map(|(_, place, predicted)| {
        let estimate = solver.error_estimate(&predicted, &candidates[place])?;
        let near = estimate.distance.ok();
        Ok((near.as_ref().map_or(f64::INFINITY, |near| near.largest), place, near))
    });
    let checked: Vec<_> = checked.collect::<Result<_>>()?;
    let largest =
        checked.into_iter().reduce(|best, next| if next.0 > best.0 { next } else { best });
    let (_, place, near) = largest.expect("more candidates than anchors");
    Ok((candidates.swap_remove(place), near.map(|near| near.equilibrium)))
}

/// Why there is no anchor.
fn lacking(body: &Body, number: usize, theta: &[f64], reason: String) -> Error {
    let (theta, most) = (in_words(body, theta), number - 1);
    Error::Refused(format!(
        "anchor {number} at {theta} has no solution: {reason}; narrow the ranges of the parameters, or ask for {most} anchors at most"
    ))
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
    let second = second_order(solver, &at, &from, STEP).map_err(|error| match error {
        Error::Solve(SolveError::Inadmissible { .. }) => {
            let reason = "a step of its derivatives inverts a cell".into();
            lacking(solver.body(), number, theta, reason)
        }
        other => other,
    })?;
    let changes = std::iter::once(state.to_vec()).chain(first.iter().cloned()).chain(second);
    Ok(Anchor { at, changes: changes.collect() })
}

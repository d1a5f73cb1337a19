//! First and second derivatives of a solution in the parameters, as an expansion of motions.

use crate::coordinates::Motions;
use crate::{Body, Result, parameters};
use rayon::prelude::*;
use sinew_energy::Barriers;
use sinew_fem::{SolveError, Solver};

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
        if let Some(products) = second_order(solver, &vec![0.0; centre.len()], &from, deviation)? {
            changes.extend(products);
            let both = motions.clone().with_expansion(&changes, body)?;
            let count = body.parameters.len();
            // A body that no load moves has no amplitude.
            let with_amplitude = motions.with_amplitude(&changes, count, body).ok();
            let forms = std::iter::once(both).chain(with_amplitude);
            return Ok((damped(forms, body, thetas)?, first));
        }
    }
    Ok((damped([first.clone()], body, thetas)?, first))
}

/// Changes of a displacement with each standardised parameter; its stiffness is factorised last.
pub(super) fn first_order(
    solver: &mut Solver<'_>,
    state: &[f64],
    theta: &[f64],
) -> Result<Vec<Vec<f64>>> {
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
    let (guarded, scaling) =
        (body.clone().with_barriers(Barriers::default()), parameters::scaling(body)?);
    let work = work(body, tried[0].1.origin());
    for theta in thetas {
        let at = scaling.standardise(theta)?;
        let energy = |(_, motions): &(f64, Motions)| -> Result<f64> {
            Ok(guarded.value(&motions.expansion_at(&at, body)?, theta))
        };
        let energies: Vec<f64> = tried.par_iter().map(energy).collect::<Result<_>>()?;
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
/// `at` whose stiffness was factorised last; `None` where one of them inverts a cell.
pub(super) fn second_order(
    solver: &mut Solver<'_>,
    at: &[f64],
    from: &dyn Fn(&[f64]) -> Result<Vec<f64>>,
    deviation: f64,
) -> Result<Option<Vec<Vec<f64>>>> {
    let body = solver.body();
    let (count, scaling) = (body.parameters.len(), parameters::scaling(body)?);
    let factor = 0.5 / deviation.powi(2);
    // Mean Newton step at both ends of a direction: odd orders cancel.
    let mut missing = |axes: &[usize]| -> Result<Option<Vec<f64>>> {
        let mut sum = vec![0.0; 3 * body.nodes];
        for sign in [deviation, -deviation] {
            let away: Vec<f64> =
                (0..count).map(|p| if axes.contains(&p) { sign } else { 0.0 }).collect();
            let from = from(&away)?;
            let moved: Vec<f64> = at.iter().zip(&away).map(|(x, away)| x + away).collect();
            let theta = scaling.unstandardise(&moved)?;
            match solver.simplified_step(&from, &theta) {
                Ok(to) => {
                    for (sum, (to, from)) in sum.iter_mut().zip(to.iter().zip(&from)) {
                        *sum += factor * (to - from);
                    }
                }
                Err(SolveError::Inadmissible { .. }) => return Ok(None),
                Err(other) => return Err(other.into()),
            }
        }
        Ok(Some(sum))
    };
    // The origin need not be in equilibrium itself.
    let Some(at_origin) = missing(&[])? else { return Ok(None) };
    let mut squares = Vec::with_capacity(count);
    for p in 0..count {
        let Some(mut square) = missing(&[p])? else { return Ok(None) };
        square.iter_mut().zip(&at_origin).for_each(|(square, at_origin)| *square -= at_origin);
        squares.push(square);
    }
    let mut products = Vec::with_capacity(count * (count + 1) / 2);
    for p in 0..count {
        products.push(squares[p].clone());
        for q in p + 1..count {
            let Some(mut both) = missing(&[p, q])? else { return Ok(None) };
            let alone = squares[p].iter().zip(&squares[q]).zip(&at_origin);
            both.iter_mut().zip(alone).for_each(|(both, ((p, q), at_origin))| {
                *both -= p + q + at_origin;
            });
            products.push(both);
        }
    }
    Ok(Some(products))
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

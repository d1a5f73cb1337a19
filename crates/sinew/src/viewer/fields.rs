//! Stress and strain at the surface, as regressions over θ.

use super::compact::{Compact, Sampled, ViewerError, relative};
use super::surface::Surface;
use crate::stresses::at_nodes;
use rayon::prelude::*;
use sinew_emulate::PodRegression;
use sinew_energy::Body;
use sinew_fem::{CellStress, cell_stresses};
use sinew_report::{Quantity, Source};
use sinew_sample::quantile;

/// Highest total degree of the polynomials.
const DEGREE: usize = 5;
/// Part of the values that rounding may cost: a step of colour is larger.
const ROUNDING: f64 = 1e-3;
/// Shares of all values between which colours lie.
const COLOURED: [f64; 2] = [0.005, 0.995];
/// Predictions without an inverted cell that a regression needs.
const LEAST: usize = 50;

/// A quantity with the mean relative distance of its regression from values of the predictions.
pub(super) struct Colour {
    pub(super) quantity: Quantity,
    pub(super) error: f64,
}

/// Fibre stretch and stress, or the largest principal ones of an isotropic law; nothing where most predictions invert cells.
pub(super) fn colours(
    body: &Body,
    surface: &Surface,
    fitted: &Sampled,
    checked: &Sampled,
) -> Result<Vec<Colour>, ViewerError> {
    type Read = fn(&CellStress) -> f64;
    let fibres = !body.material.directions(0).is_empty();
    let stress = body.units.stress.as_str();
    let own: [(&str, &str, Read); 2] = match fibres {
        true => [
            ("Fibre stretch", "1", |cell| cell.fibre.map_or(1.0, |fibre| fibre.stretch)),
            ("Fibre stress", stress, |cell| cell.fibre.map_or(0.0, |fibre| fibre.stress)),
        ],
        false => [
            ("Largest stretch", "1", |cell| cell.principal_stretches[0]),
            ("Largest stress", stress, |cell| cell.principal_stresses[0]),
        ],
    };
    let [fitted, checked] = [fitted, checked].map(|sampled| stressed(body, sampled));
    if fitted.thetas.len() < LEAST || checked.thetas.is_empty() {
        return Ok(Vec::new());
    }
    let mut colours = Vec::new();
    for (name, unit, read) in own {
        let of = |cells: &Vec<CellStress>| -> Vec<f64> {
            let values: Vec<f64> = cells.iter().map(read).collect();
            let nodes = at_nodes(body, 1, &values);
            surface.nodes.iter().map(|&node| nodes[node]).collect()
        };
        let values = |of_cells: &Stressed| of_cells.cells.par_iter().map(of).collect::<Vec<_>>();
        let (samples, truth) = (values(&fitted), values(&checked));
        let regression =
            PodRegression::fit_polynomial(&body.parameters, &fitted.thetas, &samples, DEGREE)?;
        let compact = Compact::of(regression, None, &fitted.thetas, ROUNDING)?;
        let all = truth.concat();
        let scale = COLOURED.map(|share| quantile(&all, share));
        let truth = Sampled { thetas: checked.thetas.clone(), fields: truth };
        let error = relative(&compact, &truth, Clone::clone)?;
        let quantity = Quantity {
            name: name.into(),
            unit: unit.into(),
            source: Source::Model,
            scale,
            logarithmic: false,
            model: Some(compact.packed()),
        };
        colours.push(Colour { quantity, error });
    }
    Ok(colours)
}

/// Predictions that invert no cell, with their stresses.
struct Stressed {
    thetas: Vec<Vec<f64>>,
    cells: Vec<Vec<CellStress>>,
}

fn stressed(body: &Body, sampled: &Sampled) -> Stressed {
    let pairs = sampled.thetas.par_iter().zip(&sampled.fields);
    let found = pairs.filter_map(|(theta, field)| {
        cell_stresses(body, field, theta).ok().map(|cells| (theta.clone(), cells))
    });
    let (thetas, cells) = found.collect::<Vec<_>>().into_iter().unzip();
    Stressed { thetas, cells }
}

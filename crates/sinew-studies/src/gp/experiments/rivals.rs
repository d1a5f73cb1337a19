//! A fit as it comes beside a solver for the same equation and least squares, on the same data.

use crate::gp::experiment::{Experiment, Scale};
use crate::gp::floor::{self, Family};
use crate::gp::inference::{Approach, Inference, NOISE, Sampling};
use crate::gp::lines;
use crate::gp::problems::{self, Setting};
use crate::gp::row::Method;
use anyhow::Result;

/// Four problems with values and points at random places.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let each: [(Setting<2>, Family<2>, usize); 4] = [
        (problems::heat_1()?, lines::heat_1, 25),
        (problems::layer()?, lines::layer, 30),
        (problems::wave_1()?, lines::wave_1, 25),
        (problems::advection_diffusion()?, lines::advection_diffusion, 25),
    ];
    let mut cases = Vec::new();
    for (setting, family, count) in each {
        let sampling = Sampling { values: count, collocation: count, error: NOISE };
        let inference = Inference::sampled(&setting, Approach::Constrained, sampling, scale);
        let inference = Inference { complete: true, ..inference.undrawn() };
        cases.push(inference.case().at("as it comes"));
        cases.push(floor::case(&setting, (Method::Lines, family), sampling, scale));
    }
    Ok(Experiment {
        title: "Beside lines and least squares",
        about: "25 or 30 values with 2.5 % noise. The Gaussian process adds collocation points and answers with its own intervals; \
                seconds are those of both. The rival solves the equation by finite differences along x and the trapezoidal rule in \
                time, knows its load and conditions everywhere, and takes parameters by least squares, with intervals by Student's t.",
        cases,
    })
}

//! A screened Poisson equation with mixed conditions (§4.8.5), θ known.

use crate::gp::experiment::{Experiment, Scale, no_figures};
use crate::gp::inference::{Error, Sampling, approaches};
use crate::gp::problems;
use anyhow::Result;

/// Pseudo-observations of the PCGP, ten for each edge.
const BOUNDARY_POINTS: usize = 40;

/// Ten noisy values each of u and f.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let setting = problems::helmholtz()?;
    let sampling = Sampling { values: 10, collocation: 10, error: Error::Known(0.01) };
    let [constrained, penalised, unconstrained] =
        approaches(&setting, sampling, BOUNDARY_POINTS, [0.2, 0.3, 0.1], scale);
    Ok(Experiment {
        title: "Helmholtz (§4.8.5, Fig. 4.11)",
        about: "Ten values each of u and f with a standard error of 0.01, which the model knows.",
        cases: vec![constrained.thesis(1.2e-3, &[]), penalised, unconstrained.thesis(1.0e-2, &[])],
        figures: no_figures,
    })
}

//! Heat-BVP-1 and Heat-BVP-2 (§4.8.2): the diffusivity from noisy values.

use crate::gaussian::experiment::{Experiment, Scale, no_figures};
use crate::gaussian::floor;
use crate::gaussian::inference::{About, Approach, Inference, NOISE, Sampling};
use crate::gaussian::problems;
use anyhow::Result;

/// Pseudo-observations of the PCGP, as in Fig. 4.7.
pub const BOUNDARY_POINTS: [usize; 2] = [90, 100];

/// 25 noisy values and 25 collocation points on a rod.
pub fn one_dimension(scale: Scale) -> Result<Experiment> {
    let setting = problems::heat_1()?;
    let sampling = Sampling { values: 25, collocation: 25, error: NOISE };
    let inference = |approach| Inference::sampled(&setting, approach, sampling, scale);
    let boundary = BOUNDARY_POINTS[0];
    Ok(Experiment {
        title: "Heat-BVP-1 (§4.8.2, Fig. 4.5)",
        about: "25 values with 2.5 % noise, 25 collocation points. The corners alone fix θ here, so this is \
                hardly a test of inference.",
        cases: vec![
            inference(Approach::Constrained).case(About::thesis(4.9e-5, &[(1.0, 1e-3)]), 0.1),
            inference(Approach::Penalised(boundary))
                .case(About::default().at(format!("N_b = {boundary}")), 0.3),
            inference(Approach::Unconstrained).case(About::default(), 0.03),
        ],
        figures: no_figures,
    })
}

/// 50 noisy values and 50 collocation points on a square.
pub fn two_dimensions(scale: Scale) -> Result<Experiment> {
    let setting = problems::heat_2()?;
    let sampling = Sampling { values: 50, collocation: 50, error: NOISE };
    let inference = |approach| Inference::sampled(&setting, approach, sampling, scale);
    let boundary = BOUNDARY_POINTS[1];
    Ok(Experiment {
        title: "Heat-BVP-2 (§4.8.2, Fig. 4.5)",
        about: "50 values with 2.5 % noise, 50 collocation points. The thesis removed by hand all restarts of \
                the PCGP that ended in the trivial solution; here nothing is removed.",
        cases: vec![
            inference(Approach::Constrained).case(About::thesis(5.8e-4, &[(0.994, 1e-3)]), 0.4),
            inference(Approach::Penalised(boundary))
                .case(About::default().at(format!("N_b = {boundary}")), 1.5),
            inference(Approach::Unconstrained).case(About::default(), 0.15),
            floor::case(&setting, floor::heat_2, sampling, About::default(), scale),
        ],
        figures: no_figures,
    })
}

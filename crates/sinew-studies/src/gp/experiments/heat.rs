//! Heat-BVP-1 and Heat-BVP-2 (§4.8.2): the diffusivity from noisy values.

use crate::gp::experiment::{Experiment, Scale, no_figures};
use crate::gp::floor;
use crate::gp::inference::{NOISE, Sampling, approaches};
use crate::gp::problems;
use crate::gp::row::Method;
use anyhow::Result;

/// Pseudo-observations of the PCGP, as in Fig. 4.7.
pub(super) const BOUNDARY_POINTS: [usize; 2] = [90, 100];

/// 25 noisy values and 25 collocation points on a rod.
pub(super) fn one_dimension(scale: Scale) -> Result<Experiment> {
    let setting = problems::heat_1()?;
    let sampling = Sampling { values: 25, collocation: 25, error: NOISE };
    let [constrained, penalised, unconstrained] =
        approaches(&setting, sampling, BOUNDARY_POINTS[0], [0.1, 0.3, 0.03], scale);
    let constrained = constrained.thesis(4.9e-5, &[(1.0, 1e-3)]);
    Ok(Experiment {
        title: "Heat-BVP-1 (§4.8.2, Fig. 4.5)",
        about: "25 values with 2.5 % noise, 25 collocation points. The corners alone fix θ here, so this is \
                hardly a test of inference.",
        cases: vec![constrained, penalised, unconstrained],
        figures: no_figures,
    })
}

/// 50 noisy values and 50 collocation points on a square.
pub(super) fn two_dimensions(scale: Scale) -> Result<Experiment> {
    let setting = problems::heat_2()?;
    let sampling = Sampling { values: 50, collocation: 50, error: NOISE };
    let [constrained, penalised, unconstrained] =
        approaches(&setting, sampling, BOUNDARY_POINTS[1], [0.4, 1.5, 0.15], scale);
    let constrained = constrained.thesis(5.8e-4, &[(0.994, 1e-3)]);
    let floor = floor::case(&setting, (Method::LeastSquares, floor::heat_2), sampling, scale);
    Ok(Experiment {
        title: "Heat-BVP-2 (§4.8.2, Fig. 4.5)",
        about: "50 values with 2.5 % noise, 50 collocation points. The thesis removed by hand all restarts of \
                the PCGP that ended in the trivial solution; here nothing is removed.",
        cases: vec![constrained, penalised, unconstrained, floor],
        figures: no_figures,
    })
}

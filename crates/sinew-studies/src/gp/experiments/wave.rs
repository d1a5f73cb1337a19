//! Wave-BVP-1 and Wave-BVP-2 (§4.8.3): the speed of waves, and how restarts reach it.

use crate::gp::experiment::{Case, Experiment, Scale, no_figures};
use crate::gp::floor;
use crate::gp::inference::{Approach, Inference, NOISE, Sampling};
use crate::gp::problems::{self, Setting};
use crate::gp::row::Method;
use anyhow::Result;
use sinew_gp::Evidence;

const SAMPLING: Sampling = Sampling { values: 25, collocation: 25, error: NOISE };

/// HCGP, UCGP and PCGP from ten starts, and the first two by the joint evidence, as in the thesis; with seconds of the
/// HCGP and figures that the thesis prints of the first two.
fn cases(
    setting: &Setting<2>,
    seconds: f64,
    printed: [(f64, (f64, f64)); 2],
    scale: Scale,
) -> Vec<Case> {
    let traced = |approach| Inference::sampled(setting, approach, SAMPLING, scale).traced();
    let approaches = [(Approach::Constrained, seconds), (Approach::Unconstrained, 0.1)];
    let automatic =
        approaches.into_iter().zip(printed).map(|((approach, cost), (err_u, theta))| {
            traced(approach).case(cost).thesis(err_u, &[theta])
        });
    let penalised = traced(Approach::Penalised(100)).case(2.5).at("N_b = 100");
    let joint = approaches.map(|(approach, cost)| {
        let joint = Inference { evidence: Evidence::Joint, ..traced(approach) };
        joint.case(cost).at("joint evidence")
    });
    automatic.chain([penalised]).chain(joint).collect()
}

/// Free ends, initial value and velocity.
pub(super) fn free_ends(scale: Scale) -> Result<Experiment> {
    let setting = problems::wave_1()?;
    let printed = [(5.2e-4, (1.01, 0.01)), (1.5e-1, (0.53, 0.01))];
    let mut cases = cases(&setting, 0.6, printed, scale);
    cases.push(floor::case(&setting, (Method::LeastSquares, floor::wave_1), SAMPLING, scale));
    Ok(Experiment {
        title: "Wave-BVP-1 (§4.8.3, Figs. 4.8, 4.9)",
        about: "25 values with 2.5 % noise, 25 collocation points, ten restarts. The Cramér–Rao bound of the \
                standard deviation of θ is 0.0103. Restarts maximise unit information (the equation counts \
                for one value) unless rows say joint, which the thesis maximises: that one is unbounded here. The library's hyperpriors of amplitudes \
                and lengthscales keep HCGPs from it, UCGPs not always.",
        cases,
        figures: no_figures,
    })
}

/// Periodic, starting at rest.
pub(super) fn periodic(scale: Scale) -> Result<Experiment> {
    let setting = problems::wave_2()?;
    let printed = [(3.3e-3, (1.01, 0.01)), (4.0e-1, (0.06, 0.01))];
    Ok(Experiment {
        title: "Wave-BVP-2 (§4.8.3, Figs. 4.8, 4.9)",
        about: "25 values with 2.5 % noise, 25 collocation points, ten restarts. Initial data are sin πx and rest \
                at t = ½, which the printed solution satisfies. The PCGP observes that jumps between the ends are \
                zero. Joint evidence and unit information as for Wave-BVP-1.",
        cases: cases(&setting, 0.5, printed, scale),
        figures: no_figures,
    })
}

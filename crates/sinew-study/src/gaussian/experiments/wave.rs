//! Wave-BVP-1 and Wave-BVP-2 (§4.8.3): the speed of waves, and how restarts reach it.

use crate::gaussian::experiment::{Experiment, Scale, no_figures};
use crate::gaussian::inference::{About, Approach, Inference, NOISE, Sampling};
use crate::gaussian::problems::{self, Setting};
use anyhow::Result;

const SAMPLING: Sampling = Sampling { values: 25, collocation: 25, error: NOISE };

fn traced(setting: &Setting<2>, approach: Approach, scale: Scale) -> Inference<2> {
    Inference::sampled(setting, approach, SAMPLING, scale).traced()
}

/// Free ends, initial value and velocity.
pub fn free_ends(scale: Scale) -> Result<Experiment> {
    let setting = problems::wave_1()?;
    let printed = [
        (Approach::Constrained, About::thesis(5.2e-4, &[(1.01, 0.01)]), 0.8),
        (Approach::Unconstrained, About::thesis(1.5e-1, &[(0.53, 0.01)]), 0.4),
        (Approach::Penalised(100), About::default().at("N_b = 100"), 2.5),
    ];
    let case = |(approach, about, cost)| traced(&setting, approach, scale).case(about, cost);
    Ok(Experiment {
        title: "Wave-BVP-1 (§4.8.3, Figs. 4.8, 4.9)",
        about: "25 values with 2.5 % noise, 25 collocation points, ten restarts. The Cramér–Rao bound of the \
                standard deviation of θ is 0.0103.",
        cases: printed.into_iter().map(case).collect(),
        figures: no_figures,
    })
}

/// Periodic, starting at rest.
pub fn periodic(scale: Scale) -> Result<Experiment> {
    let setting = problems::wave_2()?;
    let printed = [
        (Approach::Constrained, About::thesis(3.3e-3, &[(1.01, 0.01)]), 0.6),
        (Approach::Unconstrained, About::thesis(4.0e-1, &[(0.06, 0.01)]), 0.4),
    ];
    let case = |(approach, about, cost)| traced(&setting, approach, scale).case(about, cost);
    Ok(Experiment {
        title: "Wave-BVP-2 (§4.8.3, Figs. 4.8, 4.9)",
        about: "25 values with 2.5 % noise, 25 collocation points, ten restarts. Initial data are sin πx and rest \
                at t = ½, which the printed solution satisfies. No PCGP: periodicity is no statement about \
                single points.",
        cases: printed.into_iter().map(case).collect(),
        figures: no_figures,
    })
}

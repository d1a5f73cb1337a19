//! Linear problems from noisy values (§4.8.2 to §4.8.5): heat, waves, advection and diffusion, Helmholtz.

use crate::gp::draw;
use crate::gp::experiment::{Case, Experiment, Scale};
use crate::gp::floor;
use crate::gp::inference::{Approach, Error, Inference, NOISE, Sampling, approaches};
use crate::gp::problems::{self, Setting};
use crate::gp::row::Row;
use anyhow::Result;
use sinew_gp::Evidence;
use sinew_report::Figure;

/// 25 noisy values and 25 collocation points on a rod.
pub(super) fn heat_1(scale: Scale) -> Result<Experiment> {
    let setting = problems::heat_1()?;
    let sampling = Sampling { values: 25, collocation: 25, error: NOISE };
    Ok(Experiment {
        title: "Heat-BVP-1 (§4.8.2, Fig. 4.5)",
        about: "25 values with 2.5 % noise, 25 collocation points. The corners alone fix θ here, so this is \
                hardly a test of inference.",
        cases: approaches(&setting, sampling, 90, scale),
    })
}

/// 50 noisy values and 50 collocation points on a square.
pub(super) fn heat_2(scale: Scale) -> Result<Experiment> {
    let setting = problems::heat_2()?;
    let sampling = Sampling { values: 50, collocation: 50, error: NOISE };
    let mut cases = approaches(&setting, sampling, 100, scale);
    cases.push(floor::case(&setting, floor::heat_2, sampling, scale));
    Ok(Experiment {
        title: "Heat-BVP-2 (§4.8.2, Fig. 4.5)",
        about: "50 values with 2.5 % noise, 50 collocation points. The thesis removed by hand all restarts of \
                the PCGP that ended in the trivial solution; here nothing is removed.",
        cases,
    })
}

const WAVES: Sampling = Sampling { values: 25, collocation: 25, error: NOISE };

/// HCGP, UCGP and PCGP from ten starts, and the first two by the joint evidence, as in the thesis.
fn waves(setting: &Setting<2>, scale: Scale) -> Vec<Case> {
    let traced = |approach| Inference::sampled(setting, approach, WAVES, scale).traced();
    let approaches = [Approach::Constrained, Approach::Unconstrained];
    let automatic = approaches.map(|approach| traced(approach).case()).into_iter();
    let penalised = traced(Approach::Penalised(100)).case().at("N_b = 100");
    let joint = approaches.map(|approach| {
        let joint = Inference { evidence: Evidence::Joint, ..traced(approach) };
        joint.case().at("joint evidence")
    });
    automatic.chain([penalised]).chain(joint).collect()
}

/// Free ends, initial value and velocity.
pub(super) fn wave_1(scale: Scale) -> Result<Experiment> {
    let setting = problems::wave_1()?;
    let mut cases = waves(&setting, scale);
    cases.push(floor::case(&setting, floor::wave_1, WAVES, scale));
    Ok(Experiment {
        title: "Wave-BVP-1 (§4.8.3, Figs. 4.8, 4.9)",
        about: "25 values with 2.5 % noise, 25 collocation points, ten restarts. The Cramér–Rao bound of the \
                standard deviation of θ is 0.0103. Restarts maximise unit information (the equation counts \
                for one value) unless rows say joint, which the thesis maximises: that one is unbounded here. The library's hyperpriors of amplitudes \
                and lengthscales keep HCGPs from it, UCGPs not always.",
        cases,
    })
}

/// Periodic, starting at rest.
pub(super) fn wave_2(scale: Scale) -> Result<Experiment> {
    let setting = problems::wave_2()?;
    Ok(Experiment {
        title: "Wave-BVP-2 (§4.8.3, Figs. 4.8, 4.9)",
        about: "25 values with 2.5 % noise, 25 collocation points, ten restarts. Initial data are sin πx and rest \
                at t = ½, which the printed solution satisfies. The PCGP observes that jumps between the ends are \
                zero. Joint evidence and unit information as for Wave-BVP-1.",
        cases: waves(&setting, scale),
    })
}

/// Values, and as many collocation points.
const SIZES: [usize; 4] = [10, 25, 75, 150];

/// HCGP and UCGP on data sets of four sizes.
pub(super) fn advection_diffusion(scale: Scale) -> Result<Experiment> {
    let setting = problems::advection_diffusion()?;
    let mut cases = Vec::new();
    for &size in &SIZES[..scale.pick(SIZES.len(), 2)] {
        let sampling = Sampling { values: size, collocation: size, error: NOISE };
        let total = 2.0 * size as f64;
        for approach in [Approach::Constrained, Approach::Unconstrained] {
            let inference = Inference::sampled(&setting, approach, sampling, scale);
            let inference = if size == SIZES[0] { inference } else { inference.undrawn() };
            cases.push(inference.case().at(format!("{size} + {size}")).sweep(total));
        }
        let floor = floor::case(&setting, floor::advection_diffusion, sampling, scale);
        cases.push(floor.at(format!("{size} values")).sweep(total));
    }
    Ok(Experiment {
        title: "Advection-diffusion (§4.8.4, Fig. 4.10)",
        about: "As many values with 2.5 % noise as collocation points; θ = (0.05, 0.025). The thesis prints numbers \
                for 10 + 10 only (0.252 there is read as 0.0252).",
        cases,
    })
}

/// Errors over the number of data.
pub(super) fn more_data(rows: &[Row]) -> Figure {
    let charts = [
        draw::sweep(["solution", "mean |u − û|"], rows, |row| Some(row.err_u())),
        draw::sweep(["parameters", "‖θ − θ̂‖"], rows, Row::err_theta),
    ];
    Figure {
        title: "More data (Fig. 4.10 c, d)".into(),
        caption: "Medians over the data sets, and their range.".into(),
        panels: charts.into(),
    }
}

/// Ten noisy values each of u and f; ten pseudo-observations of the PCGP on each edge.
pub(super) fn helmholtz(scale: Scale) -> Result<Experiment> {
    let setting = problems::helmholtz()?;
    let sampling = Sampling { values: 10, collocation: 10, error: Error::Known(0.01) };
    Ok(Experiment {
        title: "Helmholtz (§4.8.5, Fig. 4.11)",
        about: "Ten values each of u and f with a standard error of 0.01, which the model knows.",
        cases: approaches(&setting, sampling, 40, scale),
    })
}

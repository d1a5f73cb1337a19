//! Advection and diffusion (§4.8.4): two parameters, and what more data bring.

use crate::gp::draw;
use crate::gp::experiment::{Experiment, Scale};
use crate::gp::floor;
use crate::gp::inference::{Approach, Inference, NOISE, Sampling};
use crate::gp::problems;
use crate::gp::row::{Method, Row};
use anyhow::Result;
use sinew_report::{Figure, Panel};

/// Values, and as many collocation points.
const SIZES: [usize; 4] = [10, 25, 75, 150];

/// HCGP and UCGP on data sets of four sizes.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let setting = problems::advection_diffusion()?;
    let mut cases = Vec::new();
    for &size in &SIZES[..scale.pick(SIZES.len(), 2)] {
        let sampling = Sampling { values: size, collocation: size, error: NOISE };
        let total = 2.0 * size as f64;
        for approach in [Approach::Constrained, Approach::Unconstrained] {
            // Quadratic for small systems, cubic for large ones.
            let cost = (size as f64 / 80.0).powi(2) * (0.5 + size as f64 / 300.0);
            let inference = Inference::sampled(&setting, approach, sampling, scale);
            let inference = if size == SIZES[0] { inference } else { inference.undrawn() };
            let case = inference.case(cost).at(format!("{size} + {size}")).sweep(total);
            cases.push(match (approach, size) {
                (Approach::Constrained, 10) => case.thesis(9e-3, &[(0.054, 1e-3), (0.0252, 1e-4)]),
                _ => case,
            });
        }
        let floor = floor::case(
            &setting,
            (Method::LeastSquares, floor::advection_diffusion),
            sampling,
            scale,
        );
        cases.push(floor.at(format!("{size} values")).sweep(total));
    }
    Ok(Experiment {
        title: "Advection-diffusion (§4.8.4, Fig. 4.10)",
        about: "As many values with 2.5 % noise as collocation points; θ = (0.05, 0.025). The thesis prints numbers \
                for 10 + 10 only (0.252 there is read as 0.0252).",
        cases,
        figures,
    })
}

fn figures(rows: &[Row]) -> Vec<Figure> {
    let panels = draw::sweeps("Advection-diffusion", "N_u + N_f", &rows.iter().collect::<Vec<_>>());
    vec![Figure {
        title: "More data (Fig. 4.10 c, d)".into(),
        caption: "Medians over the data sets, and their range.".into(),
        panels: panels.into_iter().map(Panel::Chart).collect(),
    }]
}

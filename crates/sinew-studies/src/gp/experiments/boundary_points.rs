//! Number of pseudo-observations that a PCGP needs (Fig. 4.6).

use crate::gp::draw;
use crate::gp::experiment::{Case, Experiment, Scale};
use crate::gp::inference::{Approach, Inference, NOISE, Sampling};
use crate::gp::problems::{self, Setting};
use crate::gp::row::{Method, Row};
use anyhow::Result;
use sinew_report::{Chart, Figure, Level, Panel};

const COUNTS: [usize; 6] = [10, 25, 50, 75, 100, 150];

/// PCGPs of growing size beside the HCGP.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let mut cases = of(&problems::heat_1()?, 25, scale);
    if !scale.quick {
        cases.extend(of(&problems::heat_2()?, 50, scale));
    }
    Ok(Experiment {
        title: "Boundary points of the PCGP (§4.8.2, Fig. 4.6)",
        about: "The heat problems with 2.5 % noise and a growing number N_b of pseudo-observations. In the \
                thesis the PCGP comes near the HCGP for N_b > 75 on Heat-BVP-1; on Heat-BVP-2 it fails for \
                N_b < 25, and restarts with û ≈ 0 were removed by hand. Here nothing is removed.",
        cases,
        figures,
    })
}

fn of<const D: usize>(setting: &Setting<D>, size: usize, scale: Scale) -> Vec<Case> {
    let sampling = Sampling { values: size, collocation: size, error: NOISE };
    let inference = |approach| Inference::sampled(setting, approach, sampling, scale).undrawn();
    let mut cases = vec![inference(Approach::Constrained).case(0.1)];
    for &count in &COUNTS[..scale.pick(COUNTS.len(), 2)] {
        let total = (2 * size + count) as f64;
        // Quadratic in the size of the covariance, and more where t, x and y all vary.
        let cost = 0.15 * (D as f64).powi(2) * (total / 150.0).powi(2);
        let case = inference(Approach::Penalised(count)).case(cost);
        cases.push(case.at(format!("N_b = {count}")).sweep(count as f64));
    }
    cases
}

fn figures(rows: &[Row]) -> Vec<Figure> {
    let mut panels = Vec::new();
    for problem in ["Heat-BVP-1", "Heat-BVP-2"] {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.label.problem == problem).collect();
        let Some(constrained) = rows.iter().find(|row| row.label.method == Method::Hcgp) else {
            continue;
        };
        let medians = [Some(constrained.err_u()), constrained.err_theta()];
        for (chart, median) in draw::sweeps(problem, "N_b", &rows).into_iter().zip(medians) {
            let level =
                |value| Level { name: "HCGP".into(), value, upright: false, published: false };
            let levels = median.map(|found| level(found.q50)).into_iter().collect();
            panels.push(Panel::Chart(Chart { levels, ..chart }));
        }
    }
    vec![Figure {
        title: "Errors over the number of boundary points (Fig. 4.6)".into(),
        caption: "Medians over the data sets, and their range; the dashed line is the HCGP.".into(),
        panels,
    }]
}

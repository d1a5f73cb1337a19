//! Noise from 0 to 10 % on both heat problems (Fig. 4.7).

use super::heat::BOUNDARY_POINTS;
use crate::gp::draw;
use crate::gp::experiment::{Case, Experiment, Scale};
use crate::gp::inference::{Approach, Error, Inference, Sampling};
use crate::gp::problems::{self, Setting};
use crate::gp::row::Row;
use anyhow::Result;
use sinew_report::{Figure, Panel};

/// Noise in percent of the standard deviation of u.
const LEVELS: [f64; 5] = [0.0, 2.5, 5.0, 7.5, 10.0];

/// All three priors at all levels.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let [first, second] = BOUNDARY_POINTS;
    let mut cases = of(&problems::heat_1()?, (25, first), [0.1, 0.3, 0.03], scale);
    if !scale.quick {
        cases.extend(of(&problems::heat_2()?, (50, second), [0.4, 1.3, 0.15], scale));
    }
    Ok(Experiment {
        title: "Noise (§4.8.2, Fig. 4.7)",
        about: "The heat problems again with other noise. The thesis shows curves only; what it says of them: \
                UCGPs deteriorate rapidly, PCGPs and HCGPs gently.",
        cases,
        figures,
    })
}

fn of<const D: usize>(
    setting: &Setting<D>,
    (size, boundary): (usize, usize),
    costs: [f64; 3],
    scale: Scale,
) -> Vec<Case> {
    let approaches =
        [Approach::Constrained, Approach::Penalised(boundary), Approach::Unconstrained];
    let levels = scale.pick(&LEVELS[..], &LEVELS[1..3]);
    levels
        .iter()
        .flat_map(|level| approaches.into_iter().zip(costs).map(move |pair| (*level, pair)))
        .map(|(level, (approach, cost))| {
            let error = Error::Relative(level / 100.0);
            let sampling = Sampling { values: size, collocation: size, error };
            let inference = Inference::sampled(setting, approach, sampling, scale).undrawn();
            inference.case(cost).at(format!("{level} % noise")).sweep(level)
        })
        .collect()
}

fn figures(rows: &[Row]) -> Vec<Figure> {
    let panels = ["Heat-BVP-1", "Heat-BVP-2"].into_iter().flat_map(|problem| {
        let rows = rows.iter().filter(|row| row.label.problem == problem);
        draw::sweeps(problem, "noise [%]", &rows.collect::<Vec<_>>())
    });
    vec![Figure {
        title: "Errors over noise (Fig. 4.7)".into(),
        caption: "Medians over the data sets, and their range.".into(),
        panels: panels.map(Panel::Chart).collect(),
    }]
}

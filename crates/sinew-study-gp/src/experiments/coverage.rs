//! How often 95 % intervals hold the truth, over many data sets.

use crate::draw::BAND;
use crate::experiment::{Case, Experiment, Purpose, Scale, Task, no_figures};
use crate::inference::{About, Approach, Inference, NOISE, Sampling};
use crate::problems::{self, Setting};
use crate::row::{Covered, Findings, Run};
use anyhow::Result;
use sinew_gp::{GpError, NutsOptions, nuts};
use std::time::Instant;

/// Nominal share.
const LEVEL: f64 = 0.95;
/// Random places where bands are compared with u.
const PLACES: usize = 200;
const SAMPLING: Sampling = Sampling { values: 25, collocation: 25, error: NOISE };

const ABOUT: &str = "25 values with 2.5 % noise and 25 collocation points. NUTS over all parameters; per data set one interval for each parameter, and the share of 200 random \
                     places where the band about u holds it.";

/// Heat-BVP-1.
pub fn heat_1(scale: Scale) -> Result<Experiment> {
    Ok(of("Intervals on Heat-BVP-1", problems::heat_1()?, scale))
}

/// Wave-BVP-1.
pub fn wave_1(scale: Scale) -> Result<Experiment> {
    Ok(of("Intervals on Wave-BVP-1", problems::wave_1()?, scale))
}

/// Advection and diffusion.
pub fn advection_diffusion(scale: Scale) -> Result<Experiment> {
    Ok(of("Intervals on advection-diffusion", problems::advection_diffusion()?, scale))
}

fn of(title: &'static str, setting: Setting<2>, scale: Scale) -> Experiment {
    let inference = Inference::sampled(&setting, Approach::Constrained, SAMPLING, scale);
    let label = inference.label(About::default().at("NUTS"));
    let run = move |task: &Task| run(&inference, task);
    let cases = vec![Case { label, cost: 5.0, run: Box::new(run) }];
    Experiment { title, about: ABOUT, cases, figures: no_figures }
}

fn run(inference: &Inference<2>, task: &Task) -> Result<Run> {
    let setting = &inference.setting;
    let observed = (inference.observe)(setting, task)?;
    let start = Instant::now();
    let fit = inference.fit(&observed, task)?;
    let defaults = NutsOptions::default();
    let ensemble = nuts(
        &fit,
        &NutsOptions {
            warmup: inference.scale.pick(defaults.warmup, 10),
            draws: inference.scale.pick(defaults.draws, 10),
            seed: task.seed_for(Purpose::Draws),
        },
    )?;
    let seconds = start.elapsed().as_secs_f64();
    let intervals = setting
        .truth
        .iter()
        .map(|truth| ensemble.interval(&truth.name, LEVEL))
        .collect::<Result<Vec<_>, GpError>>()?;
    let held = |([low, high], value): (&[f64; 2], f64)| (*low..=*high).contains(&value);
    let places = setting.problem.domain().sample(PLACES, task.seed_for(Purpose::Draws))?;
    let prediction = ensemble.predict(&places)?;
    let inside = |(number, place): (usize, &[f64; 2])| {
        let distance = ((setting.solution)(*place) - prediction.mean[number]).abs();
        distance <= BAND * prediction.deviation[number]
    };
    let inside = places.iter().enumerate().filter(|pair| inside(*pair)).count();
    let theta = setting
        .truth
        .iter()
        .map(|truth| fit.parameter(&truth.name))
        .collect::<Result<Vec<_>, GpError>>()?;
    let found = Findings {
        theta,
        jitter: Some(fit.outcome().jitter),
        collapsed: fit.outcome().collapsed,
        covered: Some(Covered {
            theta: intervals.iter().zip(&setting.truth).map(|(i, t)| held((i, t.value))).collect(),
            intervals,
            u: inside as f64 / PLACES as f64,
        }),
        ..Findings::default()
    };
    Ok(Run::new(setting.error(&places, &prediction.mean), seconds, found)?)
}

//! The thesis' two gravity beams (§3.3.1), what the thesis reached on them, and lines of `samples.csv`.

use crate::published::Published;
use anyhow::{Context, Result};
use sinew_emulate::{CaseErrors, METRICS};
use sinew_energy::Parameter;
use sinew_report::Distribution;

/// A beam.
#[derive(Debug)]
pub struct Beam {
    /// Short name for files, those of `fixtures/beam` too, and the command line.
    pub name: &'static str,
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// Medians that the thesis prints.
    pub(crate) thesis: Published,
}

/// Both.
pub static BEAMS: [Beam; 2] = [
    Beam {
        name: "once",
        scene: "OnceClampedBeam",
        thesis: Published {
            source: "the thesis’",
            errors: &[
                ("dd", printed([6.5e-3, 0.18, 0.11, 1.7])),
                ("pi", printed([2.0e-2, 8.7e-2, 2.0e-2, 6.6e-2])),
            ],
            displacement: Some([15.7, 50.1]),
        },
    },
    Beam {
        name: "twice",
        scene: "TwiceClampedBeam",
        thesis: Published {
            source: "the thesis’",
            errors: &[
                ("dd", printed([1.1e-2, 0.80, 0.10, 5.3])),
                ("pi", printed([9.6e-3, 3.8e-3, 7.9e-4, 1.6e-3])),
            ],
            displacement: Some([2.3, 6.0]),
        },
    },
];

const fn printed([err_u, err_f, err_i1, err_pi]: [f64; 4]) -> [Option<f64>; 5] {
    [Some(err_u), Some(err_f), Some(err_i1), Some(err_pi), None]
}

/// The head of the table, with a column for each of the parameters that all scenes have, such as `mu_kPa`.
pub fn head(parameters: &[Parameter]) -> String {
    let theta = parameters.iter().map(|p| format!("{}_{},", p.name, p.unit)).collect::<String>();
    let spread = |error| ["mean", "median", "max"].map(|of| format!("{error}_{of},")).concat();
    let errors = ["err_u_mm", "err_F_pct", "err_I1_pct"].map(spread).concat();
    format!("scene,sample,method,{theta}{errors}err_Pi_pct\n")
}

/// The lines of one method on one scene.
pub fn lines(
    scene: &str,
    method: &str,
    thetas: &[Vec<f64>],
    cases: &[CaseErrors],
) -> Result<String> {
    let mut text = String::new();
    for (sample, (theta, case)) in thetas.iter().zip(cases).enumerate() {
        text += &format!("{scene},{sample},{method}");
        theta.iter().for_each(|value| text += &format!(",{value}"));
        for metric in &METRICS[..3] {
            let found = Distribution::of(metric.of(case).to_vec());
            let found = found.context("an error of a test case is not a number")?;
            text += &format!(",{:e},{:e},{:e}", found.mean, found.q50, found.q100);
        }
        text += &format!(",{:e}\n", case.err_pi);
    }
    Ok(text)
}

//! `samples.csv`: one line per test case and method.

use anyhow::{Context, Result};
use sinew_emulate::{CaseErrors, METRICS};
use sinew_energy::Parameter;
use sinew_report::Distribution;

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

//! `samples.csv`: one line per test case and method.

use super::Method;
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
///
/// # Errors
/// An error that is not a number.
pub fn lines(
    scene: &str,
    method: Method,
    thetas: &[Vec<f64>],
    cases: &[CaseErrors],
) -> Result<String> {
    let mut text = String::new();
    for (sample, (theta, case)) in thetas.iter().zip(cases).enumerate() {
        text += &format!("{scene},{sample},{}", method.key());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_per_case_under_its_head() {
        let parameters = ["mu", "lambda"].map(|name| Parameter::log(name, "kPa", 50.0..=100.0));
        let errors = vec![0.25, 0.5, 0.75];
        let mut case = CaseErrors {
            err_u: errors.clone(),
            err_f: errors.clone(),
            err_i1: errors,
            err_pi: 0.5,
            err_volume: Vec::new(),
            relative: 0.1,
            energy_excess: 0.0,
        };
        let row = |case: &CaseErrors| {
            lines("once", Method::FemWarm, &[vec![60.0, 70.5]], std::slice::from_ref(case))
        };
        let (head, line) = (head(&parameters), row(&case).unwrap());
        assert!(head.starts_with("scene,sample,method,mu_kPa,lambda_kPa,err_u_mm_mean,"), "{head}");
        assert!(line.starts_with("once,0,fem_warm,60,70.5,5e-1,5e-1,7.5e-1,"), "{line}");
        assert!(line.ends_with(",5e-1\n"));
        assert_eq!(head.split(',').count(), line.split(',').count());
        case.err_f[1] = f64::NAN;
        assert!(row(&case).is_err());
    }
}

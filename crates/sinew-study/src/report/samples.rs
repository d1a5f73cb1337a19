//! `samples.csv`: one line per test case and method.

use std::io::Write;

use serde::{Deserialize, Serialize};

use super::Method;
use anyhow::{Result, ensure};
use sinew_report::Distribution;

/// Mean, median and largest value of an error over the nodes or elements of one case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Largest value.
    pub max: f64,
}

impl Spread {
    /// The spread of `samples`; `None` if there are none or one is NaN.
    pub fn of(samples: Vec<f64>) -> Option<Self> {
        Distribution::of(samples).map(|found| Self {
            mean: found.mean,
            median: found.q50,
            max: found.q100,
        })
    }
}

/// Errors of one method on one test case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SampleRow {
    /// Number of the test case, from 0, the same for all methods.
    pub sample: usize,
    /// The method.
    pub method: Method,
    /// Parameters in the order of the scene.
    pub theta: Vec<f64>,
    /// Displacement error over the nodes \[mm\].
    pub err_u_mm: Spread,
    /// Error of the deformation gradient over the elements \[%\].
    pub err_f_pct: Spread,
    /// Error of the first invariant over the elements \[%\].
    pub err_i1_pct: Spread,
    /// Error of the total potential energy \[%\].
    pub err_pi_pct: f64,
}

/// All test cases of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneSamples {
    /// Name of the scene.
    pub scene: String,
    /// Name of each parameter with its unit, e.g. `mu_kPa`: a column of the file.
    pub theta_names: Vec<String>,
    /// The lines.
    pub rows: Vec<SampleRow>,
}

/// Writes the samples of all scenes as CSV (RFC 4180, but with `\n`), with one column
/// for each parameter name of any scene; it is empty for scenes without that parameter.
///
/// # Errors
/// If θ of a row and the names of its scene differ in number, or `writer` fails.
pub fn write_samples(scenes: &[SceneSamples], writer: &mut impl Write) -> Result<()> {
    let columns = theta_columns(scenes);
    let mut text = String::from("scene,sample,method");
    for name in &columns {
        text.push(',');
        text.push_str(&quoted(name));
    }
    for error in ["err_u_mm", "err_F_pct", "err_I1_pct"] {
        for statistic in ["mean", "median", "max"] {
            text.push_str(&format!(",{error}_{statistic}"));
        }
    }
    text.push_str(",err_Pi_pct\n");
    for scene in scenes {
        for row in &scene.rows {
            push_row(&mut text, scene, row, &columns)?;
        }
    }
    Ok(writer.write_all(text.as_bytes())?)
}

fn theta_columns(scenes: &[SceneSamples]) -> Vec<&str> {
    let mut columns: Vec<&str> = Vec::new();
    for name in scenes.iter().flat_map(|scene| &scene.theta_names) {
        if !columns.contains(&name.as_str()) {
            columns.push(name);
        }
    }
    columns
}

fn push_row(
    text: &mut String,
    scene: &SceneSamples,
    row: &SampleRow,
    columns: &[&str],
) -> Result<()> {
    let (found, expected) = (row.theta.len(), scene.theta_names.len());
    let name = &scene.scene;
    ensure!(
        found == expected,
        "{found} parameters of sample {} of {name}, expected {expected}",
        row.sample
    );
    text.push_str(&format!("{},{},{}", quoted(&scene.scene), row.sample, row.method.key()));
    for column in columns {
        let position = scene.theta_names.iter().position(|name| name == column);
        match position {
            Some(index) => text.push_str(&format!(",{}", row.theta[index])),
            None => text.push(','),
        }
    }
    for spread in [row.err_u_mm, row.err_f_pct, row.err_i1_pct] {
        text.push_str(&format!(",{:e},{:e},{:e}", spread.mean, spread.median, spread.max));
    }
    text.push_str(&format!(",{:e}\n", row.err_pi_pct));
    Ok(())
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(name: &str, theta: &[&str], values: &[f64]) -> SceneSamples {
        let spread = Spread::of(vec![0.25, 0.5, 0.75]).unwrap();
        SceneSamples {
            scene: name.to_owned(),
            theta_names: theta.iter().map(|&name| name.to_owned()).collect(),
            rows: vec![SampleRow {
                sample: 7,
                method: Method::FemWarm,
                theta: values.to_vec(),
                err_u_mm: spread,
                err_f_pct: spread,
                err_i1_pct: spread,
                err_pi_pct: 0.5,
            }],
        }
    }

    #[test]
    fn one_line_per_row_with_the_union_of_parameters() {
        let scenes = [
            scene("once", &["mu_kPa", "lambda_kPa"], &[60.0, 70.5]),
            scene("a,b", &["lambda_kPa", "p_mmHg"], &[8.0, 4.0]),
        ];
        let mut bytes = Vec::new();
        write_samples(&scenes, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(
            lines[0].starts_with("scene,sample,method,mu_kPa,lambda_kPa,p_mmHg,err_u_mm_mean,")
        );
        assert!(lines[1].starts_with("once,7,fem_warm,60,70.5,,5e-1,5e-1,7.5e-1,"));
        assert!(lines[2].starts_with("\"a,b\",7,fem_warm,,8,4,"));
        assert!(lines[2].ends_with(",5e-1"));
    }

    #[test]
    fn refuses_parameters_without_a_name() {
        let wrong = [scene("once", &["mu_kPa"], &[60.0, 70.0])];
        assert!(write_samples(&wrong, &mut Vec::new()).is_err());
    }
}

//! One line of a table: an error and a time, over several data sets, beside the thesis' figure.

use serde::{Deserialize, Serialize};
use sinew_report::{Distribution, Figure, ReportError};

/// How the boundary conditions are accounted for (§4.8), and by what kind of function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Gaussian process with the conditions built in
    Hcgp,
    /// Gaussian process with pseudo-observations of the conditions
    Pcgp,
    /// Gaussian process that ignores the conditions
    Ucgp,
    /// Neural network with the conditions built in
    Hcnn,
    /// The same, trained on the strong form of the equation (1.21)
    StrongForm,
    /// The same, trained on the energy (1.22)
    EnergyForm,
    /// Least squares for the equation's parameters with its exact solutions: what noise alone leaves
    LeastSquares,
}

impl Method {
    /// Name in tables.
    pub fn label(self) -> &'static str {
        let (strong, energy) = ("PINN, strong form", "PINN, energy form");
        ["HCGP", "PCGP", "UCGP", "HCNN", strong, energy, "noise floor"][self as usize]
    }

    /// Name in files and style classes.
    pub fn key(self) -> &'static str {
        ["hcgp", "pcgp", "ucgp", "hcnn", "strong", "energy", "floor"][self as usize]
    }
}

/// Where one random start of a fit led.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestartEnd {
    /// Evaluations of evidence and gradient.
    pub evaluations: usize,
    /// Logarithm of the evidence.
    pub log_evidence: f64,
    /// The equation's parameters.
    pub theta: Vec<f64>,
    /// Whether it takes all data for noise.
    pub collapsed: bool,
}

/// Whether 95 % intervals of one data set held the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Covered {
    /// The interval of each parameter.
    pub intervals: Vec<[f64; 2]>,
    /// Whether each holds the true value.
    pub theta: Vec<bool>,
    /// Share of a grid where the band about u holds it.
    pub u: f64,
}

/// What a fit gives beside error and time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// Mean |f − f̂|, where the thesis has it.
    pub err_f: Option<f64>,
    /// The equation's parameters as inferred, in the order of the case's truth.
    pub theta: Vec<f64>,
    /// Evaluations of evidence (or loss) and gradient, over all restarts; none if they are not counted.
    pub evaluations: Option<usize>,
    /// Relative jitter of the covariance at the end; none without a covariance.
    pub jitter: Option<f64>,
    /// Whether it ended in the trivial solution that takes all data for noise.
    pub collapsed: bool,
    /// All restarts that reached an end.
    pub restarts: Vec<RestartEnd>,
    /// Intervals against the truth, where that is the question.
    pub covered: Option<Covered>,
    /// Drawings, for the first data set only.
    pub figures: Vec<Figure>,
}

/// One fit to one data set, always with error and time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    err_u: f64,
    seconds: f64,
    /// What else it gives.
    pub found: Findings,
}

impl Run {
    /// A fit with mean |u − û| of `err_u` (4.50) that took `seconds` of one thread.
    ///
    /// # Errors
    /// If one of the two is not finite or negative.
    pub fn new(err_u: f64, seconds: f64, found: Findings) -> Result<Self, ReportError> {
        for (field, value) in [("err_u", err_u), ("seconds", seconds)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(ReportError::Number(field.into(), value));
            }
        }
        Ok(Self { err_u, seconds, found })
    }

    /// Mean |u − û| over a grid (4.50).
    pub fn err_u(&self) -> f64 {
        self.err_u
    }

    /// Time of prior, model and all restarts on one thread \[s\].
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
}

/// What the thesis prints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thesis {
    /// Mean |u − û|.
    pub err_u: Option<f64>,
    /// Mean |f − f̂|.
    pub err_f: Option<f64>,
    /// Inferred parameters; empty if not printed.
    pub theta: Vec<f64>,
    /// One unit of the last printed digit of each.
    pub digit: Vec<f64>,
}

impl Thesis {
    /// ‖θ − θ̂‖ of the printed parameters, half a digit of rounding included; none if not printed.
    pub fn err_theta(&self, truth: &[Truth]) -> Option<f64> {
        let squares: f64 = (self.theta.iter().zip(&self.digit))
            .zip(truth)
            .map(|((printed, digit), truth)| ((printed - truth.value).abs() + 0.5 * digit).powi(2))
            .sum();
        (!self.theta.is_empty()).then(|| squares.sqrt())
    }
}

/// A parameter of the equation with the value that data are made with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
}

/// What a row is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// The boundary value problem.
    pub problem: String,
    /// What distinguishes the row within it, such as `N_f = 4`; may be empty.
    pub setting: String,
    /// Method.
    pub method: Method,
    /// The number that varies in a sweep.
    pub abscissa: Option<f64>,
    /// Parameters to be inferred.
    pub truth: Vec<Truth>,
    /// The thesis' figures.
    pub thesis: Thesis,
}

/// How often intervals held the truth, over many data sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// Data sets whose interval held it, for each parameter.
    pub theta: Vec<usize>,
    /// The share that this is, and the ends of its own 95 % interval (Wilson 1927).
    pub theta_share: Vec<[f64; 3]>,
    /// Share of the domain where the band held u, with its range over the data sets.
    pub u_share: Distribution,
    /// The same on average.
    pub u_mean: f64,
}

/// One method on one problem, over all data sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What it is about.
    pub label: Label,
    /// Number of data sets behind every figure.
    pub runs: usize,
    err_u: Distribution,
    seconds: Distribution,
    /// Mean |f − f̂|.
    pub err_f: Option<Distribution>,
    /// ‖θ − θ̂‖ (4.50).
    pub err_theta: Option<Distribution>,
    /// Each parameter as inferred.
    pub theta: Vec<Distribution>,
    /// Evaluations over all restarts of a fit.
    pub evaluations: Option<Distribution>,
    /// Largest relative jitter.
    pub jitter: Option<f64>,
    /// Data sets that ended in the trivial solution.
    pub collapsed: usize,
    /// Data sets that gave no result, by reason.
    pub failures: Vec<String>,
    /// The restarts of the first data set.
    pub restarts: Vec<RestartEnd>,
    /// How often intervals held the truth.
    pub coverage: Option<Coverage>,
}

impl Row {
    /// Of the runs of one case; `None` without runs.
    pub fn of(label: Label, runs: &[Run], failures: Vec<String>) -> Option<Self> {
        let spread =
            |value: &dyn Fn(&Run) -> f64| Distribution::of(runs.iter().map(value).collect());
        let optional = |value: &dyn Fn(&Run) -> Option<f64>| {
            runs.iter().map(value).collect::<Option<Vec<f64>>>().and_then(Distribution::of)
        };
        let distance = |run: &Run| {
            let squares =
                run.found.theta.iter().zip(&label.truth).map(|(x, t)| (x - t.value).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let theta = (0..label.truth.len())
            .filter_map(|number| spread(&|run| run.found.theta[number]))
            .collect();
        Some(Self {
            runs: runs.len(),
            err_u: spread(&Run::err_u)?,
            seconds: spread(&Run::seconds)?,
            err_f: optional(&|run| run.found.err_f),
            err_theta: spread(&distance).filter(|_| !label.truth.is_empty()),
            theta,
            evaluations: optional(&|run| run.found.evaluations.map(|count| count as f64)),
            jitter: runs.iter().filter_map(|run| run.found.jitter).reduce(f64::max),
            collapsed: runs.iter().filter(|run| run.found.collapsed).count(),
            failures,
            restarts: runs[0].found.restarts.clone(),
            coverage: coverage(runs, label.truth.len()),
            label,
        })
    }

    /// Mean |u − û| over a grid (4.50).
    pub fn err_u(&self) -> &Distribution {
        &self.err_u
    }

    /// Time of prior, model and all restarts on one thread \[s\].
    pub fn seconds(&self) -> &Distribution {
        &self.seconds
    }
}

fn coverage(runs: &[Run], parameters: usize) -> Option<Coverage> {
    let covered: Vec<&Covered> =
        runs.iter().map(|run| run.found.covered.as_ref()).collect::<Option<_>>()?;
    let theta: Vec<usize> = (0..parameters)
        .map(|number| covered.iter().filter(|covered| covered.theta[number]).count())
        .collect();
    Some(Coverage {
        theta_share: theta.iter().map(|held| wilson(*held, runs.len())).collect(),
        theta,
        u_share: Distribution::of(covered.iter().map(|covered| covered.u).collect())?,
        u_mean: covered.iter().map(|covered| covered.u).sum::<f64>() / runs.len() as f64,
    })
}

/// A share with its 95 % interval by the score method (Wilson 1927), which holds near 0 and 1 too.
fn wilson(held: usize, of: usize) -> [f64; 3] {
    const NORMAL_95: f64 = 1.959_964;
    let (n, z2) = (of as f64, NORMAL_95 * NORMAL_95);
    let share = held as f64 / n;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = NORMAL_95 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    [share, (centre - half).max(0.0), (centre + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label() -> Label {
        Label {
            problem: "Heat".into(),
            setting: String::new(),
            method: Method::Hcgp,
            abscissa: None,
            truth: vec![Truth { name: "theta".into(), value: 1.0 }],
            thesis: Thesis {
                err_u: Some(1e-3),
                theta: vec![1.01],
                digit: vec![0.01],
                ..Thesis::default()
            },
        }
    }

    #[test]
    fn a_run_needs_error_and_time() {
        let run = |err_u, seconds| Run::new(err_u, seconds, Findings::default());
        assert!(run(1e-3, 0.5).is_ok());
        for (err_u, seconds) in [(f64::NAN, 0.5), (1e-3, f64::INFINITY), (1e-3, -1.0)] {
            assert!(run(err_u, seconds).is_err());
        }
    }

    #[test]
    fn rows_are_medians_with_ranges_and_need_a_run() {
        assert!(Row::of(label(), &[], Vec::new()).is_none());
        let runs: Vec<Run> = [0.98, 1.005, 1.03]
            .iter()
            .map(|theta| {
                let found = Findings { theta: vec![*theta], ..Findings::default() };
                Run::new(2e-3 * theta, 0.1, found).unwrap()
            })
            .collect();
        let row = Row::of(label(), &runs, Vec::new()).unwrap();
        assert_eq!((row.theta[0].q0, row.theta[0].q50, row.theta[0].q100), (0.98, 1.005, 1.03));
        assert!((row.err_theta.unwrap().q50 - 0.02).abs() < 1e-12);
        let printed = row.label.thesis.err_theta(&row.label.truth).unwrap();
        assert!((printed - 0.015).abs() < 1e-12, "half a digit of rounding counts");
    }

    #[test]
    fn a_binomial_interval_stays_between_zero_and_one() {
        let all = wilson(20, 20);
        assert!(all[0] == 1.0 && (all[2] - 1.0).abs() < 1e-12);
        assert!((all[1] - 0.8389).abs() < 1e-3);
        let most = wilson(188, 200);
        assert!((most[1] - 0.898).abs() < 2e-3 && (most[2] - 0.965).abs() < 2e-3);
    }
}

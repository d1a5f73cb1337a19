//! One line of a table: an error and a time, over several data sets, beside the thesis' figure.

use serde::{Deserialize, Serialize};
use sinew_report::{Distribution, Figure, ReportError};

/// Treatment of the boundary conditions (§4.8), and kind of function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Gaussian process with the conditions built in
    Hcgp,
    /// Gaussian process with pseudo-observations of the conditions
    Pcgp,
    /// Gaussian process that ignores the conditions
    Ucgp,
    /// Neural network with the conditions built in
    Hcnn,
    /// Network trained on the strong form of the equation (1.21)
    StrongForm,
    /// Network trained on the energy (1.22)
    EnergyForm,
    /// Least squares for the equation's parameters with its exact solutions: what noise alone leaves
    LeastSquares,
}

impl Method {
    pub(crate) fn label(self) -> &'static str {
        let (strong, energy) = ("PINN, strong form", "PINN, energy form");
        ["HCGP", "PCGP", "UCGP", "HCNN", strong, energy, "noise floor"][self as usize]
    }
}

/// Result of one random start of a fit.
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

/// One fit to one data set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Mean |u − û| over a grid (4.50).
    pub err_u: f64,
    /// Time of prior, model and all restarts on one thread \[s\].
    pub seconds: f64,
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
    /// Drawings, for the first data set only.
    pub figures: Vec<Figure>,
}

impl Run {
    /// Row with numbers that can be printed.
    pub(crate) fn checked(self) -> Result<Self, ReportError> {
        let positive = [("err_u", self.err_u), ("seconds", self.seconds)];
        let sizes = self.theta.iter().map(|value| ("θ", value.abs()));
        let mut numbers = positive.into_iter().chain(sizes);
        match numbers.find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            Some((field, value)) => Err(ReportError::Number(field.into(), value)),
            None => Ok(self),
        }
    }
}

/// A parameter of the equation with the value that data are made with.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
}

/// Subject of a row.
#[derive(Clone, Debug)]
pub struct Label {
    /// The boundary value problem.
    pub problem: String,
    /// Label of the row within it, such as `N_f = 4`; may be empty.
    pub setting: String,
    /// Method.
    pub method: Method,
    /// The number that varies in a sweep.
    pub abscissa: Option<f64>,
    /// Parameters to be inferred.
    pub truth: Vec<Truth>,
}

/// One method on one problem, over all data sets.
#[derive(Clone, Debug)]
pub struct Row {
    /// Subject.
    pub label: Label,
    /// Values of every data set, in order; one at least.
    pub(crate) runs: Vec<Run>,
    /// Data sets that gave no result, by reason.
    pub failures: Vec<String>,
}

impl Row {
    /// Row of the runs of one case; `None` without runs.
    pub fn of(label: Label, runs: Vec<Run>, failures: Vec<String>) -> Option<Self> {
        (!runs.is_empty()).then_some(Self { label, runs, failures })
    }

    /// Median and range of a number of all runs.
    pub(crate) fn spread(&self, value: impl Fn(&Run) -> f64) -> Distribution {
        Distribution::of(self.runs.iter().map(value).collect()).expect("a row has runs")
    }

    /// Median, where all runs have the value.
    pub(crate) fn optional(&self, value: impl Fn(&Run) -> Option<f64>) -> Option<Distribution> {
        self.runs.iter().map(value).collect::<Option<_>>().and_then(Distribution::of)
    }

    /// Mean |u − û| over a grid (4.50).
    pub(crate) fn err_u(&self) -> Distribution {
        self.spread(|run| run.err_u)
    }

    /// ‖θ − θ̂‖ (4.50); none without parameters.
    pub(crate) fn err_theta(&self) -> Option<Distribution> {
        let truth = &self.label.truth;
        let distance = |run: &Run| {
            let squares = run.theta.iter().zip(truth).map(|(x, t)| (x - t.value).powi(2));
            squares.sum::<f64>().sqrt()
        };
        (!truth.is_empty()).then(|| self.spread(distance))
    }

    /// Each parameter as inferred.
    pub(crate) fn theta(&self) -> Vec<Distribution> {
        (0..self.label.truth.len()).map(|number| self.spread(|run| run.theta[number])).collect()
    }
}

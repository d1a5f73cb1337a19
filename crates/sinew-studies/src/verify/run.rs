//! Running benchmarks one after the other.

use crate::verify::case::{Case, Effort, Row, Rows};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Results of a case.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The benchmark that ran.
    pub case: Case,
    /// Wall-clock time of all of it \[s\].
    pub seconds: f64,
    /// The rows up to the end or the failure.
    pub rows: Vec<Row>,
    /// Why there are no more rows: an error or a panic.
    pub failure: Option<String>,
}

impl Outcome {
    /// Whether the case ran to its end and every row lies in its band. A case without rows shows nothing, and
    /// does not pass.
    pub fn passes(&self) -> bool {
        self.failure.is_none() && !self.rows.is_empty() && self.rows.iter().all(Row::passes)
    }
}

/// Runs one case; errors and panics end up in the outcome.
pub fn run(case: &Case, effort: Effort) -> Outcome {
    let start = Instant::now();
    let mut rows = Rows::default();
    let result = catch_unwind(AssertUnwindSafe(|| (case.run)(effort, &mut rows)));
    let failure = match result {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(format!("{error:#}")),
        Err(panic) => Some(format!("panicked: {}", message(&*panic))),
    };
    Outcome { case: *case, seconds: start.elapsed().as_secs_f64(), rows: rows.0, failure }
}

fn message(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

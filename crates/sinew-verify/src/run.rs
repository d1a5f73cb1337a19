//! Running benchmarks one after the other.

use crate::case::{Case, Effort, Row, Rows};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// What a case gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Short name.
    pub name: String,
    /// What was solved.
    pub title: String,
    /// Where the reference values come from.
    pub provenance: String,
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

/// Runs one case; errors and panics end up in the outcome. `report` sees every row when it is there.
pub fn run(case: &Case, effort: Effort, report: &mut dyn FnMut(&Row)) -> Outcome {
    let start = Instant::now();
    let mut rows = Rows::new(report);
    let result = catch_unwind(AssertUnwindSafe(|| (case.run)(effort, &mut rows)));
    let failure = match result {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(format!("{error:#}")),
        Err(panic) => Some(format!("panicked: {}", message(&*panic))),
    };
    Outcome {
        name: case.name.into(),
        title: case.title.into(),
        provenance: case.provenance.into(),
        seconds: start.elapsed().as_secs_f64(),
        rows: rows.into_vec(),
        failure,
    }
}

fn message(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::case::{Band, Cost, Formulation, Label};

    /// A case of two meshes whose finer one lies in its band.
    pub(crate) const GOOD: Case = Case {
        name: "fake",
        title: "A made-up <case>",
        provenance: "made up",
        run: |_, rows| two_meshes(rows, 0.01),
    };
    /// One whose coarser mesh does not.
    pub(crate) const BAD: Case = Case { run: |_, rows| two_meshes(rows, 0.05), ..GOOD };
    /// One that ends with an error.
    pub(crate) const BROKEN: Case = Case {
        run: |_, rows| {
            two_meshes(rows, 0.01)?;
            Err(anyhow::anyhow!("no equilibrium").context("on the fine mesh"))
        },
        ..GOOD
    };

    fn two_meshes(rows: &mut Rows<'_>, fine: f64) -> anyhow::Result<()> {
        for (unknowns, error) in [(100, 4.0 * fine), (1000, fine)] {
            let label = Label::new(Formulation::P2, format!("{unknowns}"), "deflection [mm]");
            let cost = Cost { unknowns, seconds: 1e-4 * unknowns as f64 };
            rows.relative(label, [1.0 + error, 1.0], Band::below(0.1), cost)?;
        }
        Ok(())
    }

    #[test]
    fn cases_pass_when_all_rows_do() {
        let mut seen = 0;
        let outcome = run(&GOOD, Effort::Quick, &mut |_| seen += 1);
        assert!(outcome.passes() && seen == 2);
        assert!(!run(&BAD, Effort::Quick, &mut |_| ()).passes());
    }

    #[test]
    fn errors_and_panics_are_failures_that_keep_the_rows() {
        let panics = Case {
            run: |_, rows| {
                two_meshes(rows, 0.01)?;
                panic!("index {}", 7)
            },
            ..GOOD
        };
        let outcomes = [BROKEN, panics].map(|case| run(&case, Effort::Full, &mut |_| ()));
        let failures = outcomes.each_ref().map(|outcome| outcome.failure.as_deref());
        let expected = ["on the fine mesh: no equilibrium", "panicked: index 7"];
        assert_eq!(failures, expected.map(Some));
        assert!(outcomes.iter().all(|outcome| outcome.rows.len() == 2 && !outcome.passes()));
    }
}

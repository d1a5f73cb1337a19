//! Equilibria.

use super::{Answer, Batch, CaseArguments, ThetaArguments, Written, solved};
use anyhow::Result;
use clap::Args;
use sinew::case::hardly_moves;
use sinew::output::displacement_in_words;
use sinew::{Body, Simulations};
use sinew_report::format::trimmed;

/// Which equilibria.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes cases.csv, cases.npz, NNNN.vtu and cases.pvd for ParaView into OUT/solve. Parameters outside their ranges are
solved with a warning. A row of a table that fails is a row of cases.csv with the reason, and the exit code is not 0.

Example: sinew solve IdealVentricle --theta a=0.18,b=2.6,a_f=3.3,b_f=2.7,p=8mmHg")]
pub(crate) struct Solve {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    theta: ThetaArguments,
    #[command(flatten)]
    written: Written,
}

impl Solve {
    pub(crate) fn run(&self) -> Result<()> {
        let (_, body, folder) = self.case.open()?;
        let mut batch = self.theta.read(&body)?;
        let thetas = batch.thetas();
        let found = solved(&body, &thetas, "solve", None)?;
        close_failures(&body, &mut batch, &thetas, &found);
        batch.print(&body, |place| said(&body, &found.fields[place]));
        if let Some(warning) = found.fields.iter().find_map(|field| hardly_moves(&body, field)) {
            eprintln!("warning: {warning}");
        }
        let answer = |field| Answer { fields: vec![field], ..Answer::default() };
        let answers = found.fields.iter().map(|field| answer(field)).collect();
        batch.write(&body, &["solved"], answers, &self.written, &folder.join("solve"))
    }
}

/// Closes the rows that have no equilibrium.
fn close_failures(body: &Body, batch: &mut Batch, thetas: &[Vec<f64>], found: &Simulations) {
    let rows: Vec<usize> = batch.open().collect();
    let mut failures = found.failures.iter().peekable();
    for (row, theta) in rows.into_iter().zip(thetas) {
        if let Some(failure) = failures.next_if(|failure| failure.theta == *theta) {
            batch.fail(body, row, format!("no equilibrium: {}", failure.reason));
        }
    }
}

/// Displacement and cavities of an equilibrium.
fn said(body: &Body, field: &[f64]) -> String {
    let unit = &body.units.length;
    let volumes = body.cavities.iter().zip(body.cavity_volumes(field));
    let volumes: String = volumes
        .map(|(cavity, v)| format!(", volume of {} {} {unit}3", cavity.name, trimmed(v, 6)))
        .collect();
    format!(": displacement {}{volumes}", displacement_in_words(field, unit))
}

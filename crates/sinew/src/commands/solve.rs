//! Equilibria.

use super::along::Way;
use super::{
    Batch, CaseArguments, ThetaArguments, Written, make_folder, refuse, solved_by, warn_of_locking,
};
use anyhow::Result;
use clap::Args;
use sinew::case::Formulation;
use sinew::output::{Row, displacement_in_words, least_and_largest_ratio};
use sinew::{Body, Case, Simulations, Warning};
use sinew_fem::{LoadSteps, Options, compare_formulations, locking};
use sinew_report::format::trimmed;
use std::path::Path;

/// Equilibria to find.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/solve.txt"))]
pub(crate) struct Solve {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    theta: ThetaArguments,
    #[command(flatten)]
    written: Written,
    #[command(flatten)]
    way: Way,
    /// Also solve the first case with quadratic elements, and print the difference
    #[arg(long)]
    check_mesh: bool,
    /// Raise the load in increments from rest; of several stable equilibria, find the one that a slowly rising load reaches
    #[arg(long)]
    load_steps: bool,
}

impl Solve {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.case.open_lowered()?;
        let body = &body;
        if let Some(way) = self.way.given() {
            let folder = folder.join("solve");
            return self.way.follow(way, body, &self.theta, self.written.fields, &folder);
        }
        if self.check_mesh {
            check_cells(body)?;
        }
        let (batch, folder) = (self.theta.read(body, None)?, folder.join("solve"));
        make_folder(&folder)?;
        batch.in_parts(body, &self.written, |batch| self.part(batch, (&case, body), &folder))
    }

    /// Solves and writes a part of the rows; returns how many failed.
    fn part(&self, mut batch: Batch, (case, body): (&Case, &Body), folder: &Path) -> Result<usize> {
        let thetas = batch.thetas();
        let load_steps = if self.load_steps { LoadSteps::Always } else { LoadSteps::WhenNeeded };
        let options = Options { load_steps, ..Options::default() };
        let found = &solved_by(body, &thetas, "solve", None, &options)?;
        close_failures(body, &mut batch, &thetas, found);
        if let (Some(theta), Some(field)) = (found.thetas.first(), found.fields.first()) {
            warn_of_locking(locking(body, theta, field));
        }
        batch.print(body, |place| said(body, &found.fields[place]));
        if self.check_mesh && batch.is_first() {
            check_mesh(case.clone(), body, found)?;
        }
        batch.write(body, &["solved"], answers(found), &self.written, folder)
    }
}

/// Equilibria as they are written.
fn answers(found: &Simulations) -> Vec<Row<'_>> {
    let Simulations { thetas, fields, pressures, jumped, .. } = found;
    let answer = |place: usize| {
        let jumps = jumped.iter().filter(|theta| **theta == thetas[place]);
        Row {
            fields: vec![&fields[place]],
            pressure: pressures.get(place).map_or(&[], Vec::as_slice),
            warnings: jumps.map(|_| Warning::Jumped.to_string()).collect(),
            ..Row::default()
        }
    };
    (0..fields.len()).map(answer).collect()
}

/// Closes the rows that have no equilibrium.
fn close_failures(body: &Body, batch: &mut Batch, thetas: &[Vec<f64>], found: &Simulations) {
    let rows: Vec<usize> = batch.open().collect();
    let mut failures = found.failures.iter().peekable();
    for (row, theta) in rows.into_iter().zip(thetas) {
        if let Some(failure) = failures.next_if(|failure| failure.theta == *theta) {
            let said = failure.reason.starts_with("no equilibrium");
            let head = if said { "" } else { "no equilibrium: " };
            batch.fail(body, row, format!("{head}{}", failure.reason));
        }
    }
}

/// Displacement, cavities and volume ratios of an equilibrium.
fn said(body: &Body, field: &[f64]) -> String {
    let unit = &body.units.length;
    let volumes = body.cavities.iter().zip(body.cavity_volumes(field));
    let volumes: String = volumes
        .map(|(cavity, v)| format!(", volume of {} {} {unit}3", cavity.name, trimmed(v, 6)))
        .collect();
    let [least, largest] = least_and_largest_ratio(body, field).map(|ratio| trimmed(ratio, 3));
    let moved = displacement_in_words(field, unit);
    format!(": displacement {moved}{volumes}, J {least} to {largest}")
}

/// Refuses cells that have no quadratic form here, before solving.
fn check_cells(body: &Body) -> Result<()> {
    let element = body.element();
    match element.corners {
        _ if element.is_quadratic() => refuse(format!(
            "--check-mesh: the cells are {} already; compare with a finer mesh (--mesh FILE)",
            element.plural
        )),
        8 => refuse(
            "--check-mesh: quadratic cells are not made of hexahedra here; compare with a finer mesh (--mesh FILE), or with \
             tetrahedra"
                .into(),
        ),
        _ => Ok(()),
    }
}

/// Solves the first case in quadratic cells, and tells how far it is from there.
fn check_mesh(case: Case, body: &Body, found: &Simulations) -> Result<()> {
    let (Some(theta), Some(own)) = (found.thetas.first(), found.fields.first()) else {
        return Ok(());
    };
    let better = case.with_formulation(Formulation::Quadratic).lowered()?;
    let (theta, stage) = (std::slice::from_ref(theta), "solve in quadratic cells");
    let other = solved_by(&better, theta, stage, None, &Options::default())?;
    let Some(field) = other.fields.first() else {
        let why = other.failures.first().map_or("", |failure| &failure.reason);
        anyhow::bail!("--check-mesh: no equilibrium with quadratic elements: {why}");
    };
    let difference = compare_formulations(body, own, &better, field)?;
    println!("{} against {}: {difference}", body.element().plural, better.element().plural);
    println!("solved in {:.2} s and {:.2} s", found.solve_seconds[0], other.solve_seconds[0]);
    Ok(())
}

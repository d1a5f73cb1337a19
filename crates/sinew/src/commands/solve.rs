//! Equilibria, and paths of them along a parameter.

use super::{
    Batch, CaseArguments, STEPWISE, ThetaArguments, Usage, Written, make_folder, refuse, single,
    tell_solved, tell_states, warn,
};
use anyhow::{Result, bail};
use clap::Args;
use sinew::case::{Formulation, branched_in_words};
use sinew::output::{
    Results, Row, by_row, displacement_in_words, end_in_words, least_and_largest_ratio,
};
use sinew::{
    Body, Case, Parameter, Simulations, admissible, outside, parse_way, range_in_words, simulate,
    thetas_along,
};
use sinew_emulate::{Counter, Terminal, simulate_by};
use sinew_fem::{LoadSteps, Options, Solver, Trace, compare_formulations};
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
    /// Solve along a path of one parameter: NAME=START..END, such as p=0..8mmHg. An end without unit has the parameter's, and is
    /// refused beside another one, but for 0. START is reached from rest by load increments; --theta gives the others
    #[arg(long, value_name = "NAME=START..END", conflicts_with_all = ["check_mesh", "load_steps", "pictures", "arrays"])]
    along: Option<String>,
    /// Steps of the path; there is one frame more than steps
    #[arg(long, value_name = "COUNT", default_value_t = 20, requires = "along", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
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
        if let Some(way) = &self.along {
            return self.follow(way, body, &folder.join("solve"));
        }
        if self.check_mesh {
            check_cells(body)?;
        }
        let folder = folder.join("solve");
        let batch = self.theta.read(body, None, Some(&folder))?;
        make_folder(&folder)?;
        batch.in_parts(&self.written, |batch| self.part(batch, (&case, body), &folder))
    }

    /// Solves and writes a part of the rows; returns how many failed.
    fn part(
        &self,
        mut batch: Batch<'_>,
        (case, body): (&Case, &Body),
        folder: &Path,
    ) -> Result<usize> {
        let thetas = batch.thetas();
        let load_steps = if self.load_steps { LoadSteps::Always } else { LoadSteps::WhenNeeded };
        let options = Options { load_steps, ..Options::default() };
        let terminal = &mut Terminal::default();
        let found = &simulate_by(body, &thetas, "solve", None, &options, terminal)?;
        batch.tell_states(&found.thetas, found.fields.iter().map(Vec::as_slice));
        warn(branched_in_words(body, found, STEPWISE));
        let solved = |place| Row::solved(found, place);
        let answers =
            batch.answered(by_row(&thetas, found).into_iter().map(|place| place.map(solved)));
        batch.print(|place| said(body, &found.fields[place]));
        if self.check_mesh && batch.is_first() {
            check_mesh(case.clone(), body, found)?;
        }
        batch.write(&["solved"], answers, &self.written, folder)
    }

    /// Follows a path of one parameter, and writes what is found.
    fn follow(&self, way: &str, body: &Body, folder: &Path) -> Result<()> {
        let (index, ends) = parse_way(way, &body.parameters)?;
        let given = self.theta.read(body, Some(index), Some(folder))?.thetas();
        let theta = single("--along", &given)?;
        let thetas = thetas_along(theta, (index, ends), self.frames);
        for end in [&thetas[0], &thetas[thetas.len() - 1]] {
            admissible(body, end).map_err(|why| Usage(format!("--along {way}: {why}")))?;
        }
        tell(&body.parameters[index], ends);
        let Trace { solutions: frames, end } = traced(body, &thetas)?;
        let rows = frames.iter().map(|frame| Row {
            theta: frame.theta.clone(),
            fields: vec![&frame.displacement],
            pressure: &frame.pressure,
            ..Row::default()
        });
        let (names, rows, stresses) = (vec!["solved"], rows.collect(), self.written.fields);
        let results = Results { body, names, rows, stresses };
        results.write_along(folder, index)?;
        let fields = frames.iter().map(|frame| &frame.displacement[..]);
        tell_states(body, &thetas[..frames.len()], fields);
        println!("written: {}", folder.display());
        match end {
            None => Ok(()),
            Some(end) => {
                let (found, asked, end) = (frames.len(), thetas.len(), end_in_words(body, &end));
                bail!("{found} of {asked} frames were found and written; {end}")
            }
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
    let kind = element.plural;
    let why = match element.corners {
        _ if element.is_quadratic() => {
            format!("the cells are {kind} already; compare with a finer mesh (--mesh FILE)")
        }
        8 => format!(
            "quadratic cells are not made of {kind} here; compare with a finer mesh (--mesh FILE), or with tetrahedra"
        ),
        _ => return Ok(()),
    };
    refuse(format!("--check-mesh: {why}"))
}

/// Solves the first case in quadratic cells, and tells how far it is from there.
fn check_mesh(case: Case, body: &Body, found: &Simulations) -> Result<()> {
    let (Some(theta), Some(own)) = (found.thetas.first(), found.fields.first()) else {
        return Ok(());
    };
    let better = case.with_formulation(Formulation::Quadratic).lowered()?;
    let (theta, stage) = (std::slice::from_ref(theta), "solve in quadratic cells");
    let other = simulate(&better, theta, stage, None, &mut Terminal::default())?;
    tell_solved(&better, &other);
    let Some(field) = other.fields.first() else {
        let why = other.failures.first().map_or("", |failure| &failure.reason);
        bail!("--check-mesh: no equilibrium with quadratic elements: {why}");
    };
    let difference = compare_formulations(body, own, &better, field)?;
    println!("{} against {}: {difference}", body.element().plural, better.element().plural);
    println!("solved in {:.2} s and {:.2} s", found.solve_seconds[0], other.solve_seconds[0]);
    Ok(())
}

/// Prints a path as it was read, and tells ends outside their range on standard error.
fn tell(parameter: &Parameter, ends: [f64; 2]) {
    println!("{}", range_in_words(&Parameter { range: ends, ..parameter.clone() }));
    let parameters = std::slice::from_ref(parameter);
    warn(ends.iter().flat_map(|&end| outside(parameters, &[end])));
}

/// Frames as far as the path goes.
fn traced(body: &Body, thetas: &[Vec<f64>]) -> Result<Trace> {
    let (options, mut terminal) = (Options::default(), Terminal::default());
    let mut counter = Counter::new(&mut terminal, "follow", 0, thetas.len());
    let count = || counter.step(1, "");
    let trace = Solver::new(body)?.trace(thetas, &options, count)?;
    counter.finish(&format!("{} frames", trace.solutions.len()));
    Ok(trace)
}

//! Rows, one program on one mesh each, as Markdown.

use serde::{Deserialize, Serialize};
use sinew_report::Provenance;
use std::fmt::Write;

const TITLES: [(&str, &str); 3] = [
    ("linear", "Linear tetrahedra, one point"),
    ("quadratic", "Quadratic tetrahedra, four points"),
    ("hexahedra", "Hexahedra, eight points"),
];

/// A table for each kind of element, which program is first at each size, and what imports and compilers take.
pub(super) fn markdown(rows: &[Row]) -> String {
    let mut text = String::new();
    for (name, title) in TITLES {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.elements == name).collect();
        if !rows.is_empty() {
            text += &format!("### {title}\n\n{}\n{}\n", of_elements(&rows), first(&rows));
        }
    }
    let run = Provenance::of_this_run("cargo xtask", env!("CARGO_MANIFEST_DIR"));
    let date = run.finished.split(' ').next().unwrap_or_default().to_string();
    text + &format!(
        "### Imports and compilation\n\n{}\n`{}`, {}, {date}, one thread each.\n",
        beforehand(rows),
        run.command,
        run.machine
    )
}

/// Rows of the same mesh, one after the other.
fn meshes<'a>(rows: &'a [&'a Row]) -> impl Iterator<Item = &'a [&'a Row]> {
    rows.chunk_by(|a, b| a.nodes == b.nodes && a.cells == b.cells)
}

fn solved(row: &Row) -> Option<&Solved> {
    match &row.outcome {
        Outcome::Solved(solved) => Some(solved),
        Outcome::Missing { .. } => None,
    }
}

/// Programs that solved a mesh, the fastest first, with their seconds of set-up and solve.
fn order<'a>(mesh: &[&'a Row]) -> Vec<(&'a str, f64)> {
    let all =
        mesh.iter().filter_map(|row| solved(row).map(|s| (&*row.program, s.setup_s + s.solve_s)));
    let mut all: Vec<_> = all.collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

fn of_elements(rows: &[&Row]) -> String {
    let mut text = String::from(
        "| nodes, cells | program | load steps | Newton steps | of the linear solver | set-up \\[CPU s\\] | solve \\[CPU s\\] | GB | apex \\[mm\\] | energy \\[kPa mm³\\] |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for mesh in meshes(rows) {
        let best = order(mesh).first().map(|(name, _)| *name);
        for (place, row) in mesh.iter().enumerate() {
            let size =
                if place == 0 { format!("{}, {}", row.nodes, row.cells) } else { String::new() };
            let bold = if best == Some(&row.program) { "**" } else { "" };
            let line = match &row.outcome {
                Outcome::Missing { missing } => format!("{missing} | | | | | | | |"),
                Outcome::Solved(s) => {
                    let energy = match place {
                        0 => format!("{:.9}", s.energy),
                        _ => format!("{:+.0e} of it", s.energy_apart),
                    };
                    let linear = Some(s.linear_iterations).filter(|count| *count > 0);
                    let linear = linear.map_or_else(String::new, |count| count.to_string());
                    format!(
                        "{} | {} | {linear} | {} | {} | {:.2} | {:.6} | {energy} |",
                        s.load_steps,
                        s.iterations,
                        digits(s.setup_s),
                        digits(s.solve_s),
                        s.peak_gb,
                        s.apex[2]
                    )
                }
            };
            let _ = writeln!(text, "| {size} | {bold}{}{bold} | {line}", row.program);
        }
    }
    text
}

/// Two digits, or all before the point.
fn digits(seconds: f64) -> String {
    let decimals = match seconds {
        s if s >= 10.0 => 0,
        s if s >= 1.0 => 1,
        s if s >= 0.1 => 2,
        _ => 3,
    };
    format!("{seconds:.decimals$}")
}

fn first(rows: &[&Row]) -> String {
    let mut text = String::from("First by set-up and solve:");
    for mesh in meshes(rows) {
        let mut order = order(mesh);
        let [(name, seconds), ..] = order[..] else { continue };
        let of = |name: &str| name.split(',').next().unwrap_or_default().to_string();
        let winner = of(name);
        order.retain(|(other, _)| of(other) != winner);
        let next = order.first().map_or_else(String::new, |(other, more)| {
            format!(", {} times before {other}", digits(more / seconds))
        });
        let _ = write!(text, " {} nodes: {name} ({} s{next});", mesh[0].nodes, digits(seconds));
    }
    text.trim_end_matches(';').to_string() + ".\n"
}

/// The largest seconds of each program and kind of element: later runs find compiled forms of FEniCS.
fn beforehand(rows: &[Row]) -> String {
    let mut text = String::from("| program | version | linear solver | imports \\[CPU s\\] |");
    TITLES.iter().for_each(|(name, _)| text += &format!(" compilation, {name} |"));
    text += "\n|---|---|---|---|---|---|---|\n";
    let mut names: Vec<&str> = Vec::new();
    rows.iter().for_each(|row| {
        if !names.contains(&&*row.program) {
            names.push(&row.program);
        }
    });
    for name in names {
        let own: Vec<&Row> = rows.iter().filter(|row| row.program == name).collect();
        let most = |of: fn(&Solved) -> f64, kind: &str| {
            let own = own.iter().filter(|row| kind.is_empty() || row.elements == kind);
            own.filter_map(|row| solved(row)).map(of).reduce(f64::max)
        };
        let shown = |seconds: Option<f64>| seconds.map_or_else(String::new, digits);
        let Some(any) = own.iter().find_map(|row| solved(row)) else {
            if let Outcome::Missing { missing } = &own[0].outcome {
                let _ = writeln!(text, "| {name} | missing: {missing} | | | | | |");
            }
            continue;
        };
        let _ = write!(
            text,
            "| {name} | {} | {} | {} |",
            any.version,
            any.solver,
            shown(most(|s| s.import_s, ""))
        );
        TITLES
            .iter()
            .for_each(|(kind, _)| text += &format!(" {} |", shown(most(|s| s.compile_s, kind))));
        text += "\n";
    }
    text
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Row {
    pub elements: String,
    pub nodes: usize,
    pub cells: usize,
    pub program: String,
    #[serde(flatten)]
    pub outcome: Outcome,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Outcome {
    Solved(Solved),
    /// Why there is none, and how the program is installed.
    Missing {
        missing: String,
    },
}

/// Smaller times of two solves; seconds of the CPU.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Solved {
    pub version: String,
    /// Linear solver.
    pub solver: String,
    pub import_s: f64,
    pub compile_s: f64,
    /// Mesh, spaces and unknowns.
    pub setup_s: f64,
    pub solve_s: f64,
    /// Part of it that assembles stiffnesses, where the program tells.
    pub assembly_s: Option<f64>,
    pub load_steps: usize,
    /// Newton's method.
    pub iterations: usize,
    pub linear_iterations: usize,
    pub energy: f64,
    /// Difference of energies from Sinew's \[relative\].
    #[serde(default)]
    pub energy_apart: f64,
    /// Displacement of the apex of the endocardium \[mm\].
    pub apex: [f64; 3],
    /// Largest distance of a displacement from Sinew's \[relative to the largest\].
    pub apart: f64,
    pub peak_gb: f64,
}

/// Row of Sinew with the size of the mesh that it made.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Own {
    pub nodes: usize,
    pub cells: usize,
    #[serde(flatten)]
    pub solved: Solved,
}

impl Outcome {
    /// Outcome with the difference of its energy from Sinew's.
    pub(super) fn beside(self, truth: f64) -> Self {
        match self {
            Self::Solved(solved) => {
                Self::Solved(Solved { energy_apart: solved.energy / truth - 1.0, ..solved })
            }
            missing @ Self::Missing { .. } => missing,
        }
    }

    pub(super) fn in_words(&self) -> String {
        match self {
            Self::Solved(solved) => format!(
                "{:.2} and {:.2} CPU s, {} iterations, energy {:.14e}",
                solved.setup_s, solved.solve_s, solved.iterations, solved.energy
            ),
            Self::Missing { missing } => missing.clone(),
        }
    }
}

//! A ventricle under pressure by Sinew and by the other programs that are installed, on the same meshes in one run.

mod own;
mod table;

use super::by_size::three;
use super::mean_ventricle::BULK_MODULUS;
use crate::program;
use anyhow::{Context, Result, ensure};
use clap::ValueEnum;
use sinew_emulate::store;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use table::{Outcome, Own, Row, Solved};

/// Largest difference of energies at equal quadrature \[relative\]: what Newton's method leaves at a residual of 1e-9 is far below.
const BAR: f64 = 1e-10;

/// Seconds are of the CPU, one thread each.
#[derive(clap::Args)]
pub struct Arguments {
    /// Python with NGSolve, FElupe and scikit-fem; fixtures/rivals/PROVENANCE.md has the packages
    #[arg(long, default_value = "python3")]
    python: PathBuf,
    /// Python with legacy FEniCS
    #[arg(long, default_value = "/usr/bin/python3")]
    fenics: PathBuf,
    /// Folder of meshes, rows and table
    #[arg(long, default_value = "target/rivals")]
    out: PathBuf,
    /// Elements [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    elements: Vec<Kind>,
    /// Other programs [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    programs: Vec<Program>,
    /// Cells through the wall, around and along, such as 4,48,40 [default: five sizes from 500 to 29 000 nodes]
    #[arg(long, value_parser = three)]
    cells: Vec<[usize; 3]>,
    /// Bulk modulus in kPa
    #[arg(long, default_value_t = BULK_MODULUS)]
    bulk_modulus: f64,
    /// CPU seconds of a solve beyond which a program is left out of larger meshes
    #[arg(long, default_value_t = 60.0)]
    limit: f64,
    /// Sinew alone, on one mesh, which is written into this folder
    #[arg(long, hide = true)]
    own: Option<PathBuf>,
    /// Factors at all sizes, with --own
    #[arg(long, hide = true)]
    factor: bool,
}

/// Cells of the meshes, all of the same wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Linear tetrahedra, one point
    Linear,
    /// Quadratic tetrahedra with straight edges, four points
    Quadratic,
    /// Trilinear hexahedra, eight points
    Hexahedra,
}

impl Kind {
    /// Cells of the five sizes: 507, 2163, 6084, 14 885 and 28 231 nodes; quadratic 555, 2163, 6125, 14 885 and 28 847.
    fn sizes(self) -> [[usize; 3]; 5] {
        match self {
            Self::Quadratic => [[1, 8, 6], [1, 16, 12], [2, 24, 14], [2, 32, 25], [3, 40, 28]],
            _ => [[2, 16, 11], [2, 32, 24], [3, 40, 40], [4, 64, 50], [6, 72, 60]],
        }
    }
}

/// The other programs, by the linear solver where they have several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum Program {
    FenicsMumps,
    FenicsGamg,
    Ngsolve,
    Felupe,
    ScikitFem,
}

impl Program {
    fn title(self) -> &'static str {
        match self {
            Self::FenicsMumps => "FEniCS 2019, MUMPS",
            Self::FenicsGamg => "FEniCS 2019, GAMG",
            Self::Ngsolve => "NGSolve",
            Self::Felupe => "FElupe",
            Self::ScikitFem => "scikit-fem",
        }
    }
}

/// Writes `rows.json` and `table.md` after every size, and prints the table.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.own {
        return own::run(arguments, folder);
    }
    std::fs::create_dir_all(&arguments.out)?;
    // Compiled anew, so that the table says what it costs.
    std::fs::remove_dir_all(arguments.out.join("compiled")).or_else(absent)?;
    let mut rows: Vec<Row> = Vec::new();
    for &kind in chosen(&arguments.elements) {
        let sizes = match &arguments.cells[..] {
            [] => kind.sizes().to_vec(),
            given => given.to_vec(),
        };
        let mut slow = BTreeMap::new();
        for cells in sizes {
            rows.extend(one_mesh(arguments, kind, cells, &mut slow)?);
            store::write_json(&arguments.out.join("rows.json"), &rows)?;
            std::fs::write(arguments.out.join("table.md"), table::markdown(&rows))?;
        }
    }
    println!("{}", table::markdown(&rows));
    let apart: Vec<String> = rows.iter().filter_map(beyond).collect();
    ensure!(apart.is_empty(), "energies differ by more than {BAR:e}: {}", apart.join("; "));
    Ok(())
}

/// Choices that were given; all without one.
fn chosen<T: ValueEnum>(given: &[T]) -> &[T] {
    if given.is_empty() { T::value_variants() } else { given }
}

fn absent(error: std::io::Error) -> std::io::Result<()> {
    if error.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}

fn beyond(row: &Row) -> Option<String> {
    let Outcome::Solved(solved) = &row.outcome else { return None };
    // Written so that a NaN is beyond it as well.
    let within = solved.energy_apart.abs() <= BAR;
    let place = || format!("{}, {} nodes: {:.1e}", row.program, row.nodes, solved.energy_apart);
    (!within).then(place)
}

/// Rows of all programs on one mesh; `slow` says why a program is left out of the next.
fn one_mesh(
    arguments: &Arguments,
    kind: Kind,
    cells: [usize; 3],
    slow: &mut BTreeMap<Program, String>,
) -> Result<Vec<Row>> {
    let elements = program::key(kind);
    let [a, b, c] = cells;
    let folder = arguments.out.join(format!("{elements}-{a}-{b}-{c}"));
    let sinew = |factor: bool| -> Result<Own> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["measure", "rivals", "--elements", &elements]);
        command.args(["--cells", &format!("{a},{b},{c}"), "--own"]).arg(&folder);
        command.args(factor.then_some("--factor"));
        command.arg(format!("--bulk-modulus={}", arguments.bulk_modulus));
        let said = last_line(&mut command)?;
        serde_json::from_str(&said).with_context(|| format!("Sinew said: {said}"))
    };
    let own = sinew(false)?;
    let truth = own.solved.energy;
    let row = |program: &str, outcome: Outcome| {
        eprintln!("{} nodes of {elements}: {program}: {}", own.nodes, outcome.in_words());
        Row {
            elements: elements.clone(),
            nodes: own.nodes,
            cells: own.cells,
            program: program.into(),
            outcome: outcome.beside(truth),
        }
    };
    let mut rows = vec![row("Sinew", Outcome::Solved(own.solved.clone()))];
    if own.solved.linear_iterations > 0 {
        rows.push(row("Sinew, factors", Outcome::Solved(sinew(true)?.solved)));
    }
    for &program in chosen(&arguments.programs) {
        if let Some(why) = slow.get(&program) {
            rows.push(row(program.title(), Outcome::Missing { missing: why.clone() }));
            continue;
        }
        let outcome = rival(arguments, program, &folder)?;
        let seconds = match &outcome {
            Outcome::Solved(Solved { solve_s, .. }) if *solve_s <= arguments.limit => None,
            Outcome::Solved(Solved { solve_s, .. }) => Some(format!("{solve_s:.0} CPU s")),
            Outcome::Missing { missing } => Some(missing.clone()),
        };
        if let Some(why) = seconds {
            slow.insert(program, format!("left out: {why} at {} nodes", own.nodes));
        }
        rows.push(row(program.title(), outcome));
    }
    Ok(rows)
}

/// Outcome of another program on the mesh of a folder.
fn rival(arguments: &Arguments, program: Program, folder: &Path) -> Result<Outcome> {
    let python = match program {
        Program::FenicsMumps | Program::FenicsGamg => &arguments.fenics,
        _ => &arguments.python,
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/rivals/ventricle.py");
    let mut command = Command::new(python);
    command
        .arg(script)
        .arg(program::key(program))
        .arg(folder)
        .arg(format!("--limit={}", arguments.limit))
        .arg(format!("--bulk-modulus={}", arguments.bulk_modulus));
    let said = match last_line(&mut command) {
        Ok(said) => said,
        Err(error) => return Ok(Outcome::Missing { missing: format!("{error:#}") }),
    };
    serde_json::from_str(&said).with_context(|| format!("{} said: {said}", program.title()))
}

fn last_line(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_owned();
    command.env("RAYON_NUM_THREADS", "1").stderr(Stdio::piped());
    let output =
        command.output().with_context(|| format!("{} could not be started", name.display()))?;
    let said = String::from_utf8_lossy(&output.stdout);
    let error = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.success(),
        "{} ended with {}: {}",
        name.display(),
        output.status,
        error.lines().last().unwrap_or_default()
    );
    Ok(said.lines().last().unwrap_or_default().into())
}

//! The whole study: scenes, simulations, emulators, rivals, report.

use crate::beams::options::BeamOptions;
use crate::beams::recipes::{self, Samples};
use crate::beams::scenes::{self, BEAMS, Beam};
use crate::program::{self, Growing};
use anyhow::{Context, Result};
use sinew::output::{Results, Row};
use sinew::{Case, Comparison, TestSet};
use sinew_emulate::{Terminal, median_and_worst, store};
use sinew_report::{Block, Section};
use std::path::{Path, PathBuf};

/// Newton steps that predictions are corrected by for the evaluation beside the report.
const CORRECTIONS: usize = 2;

/// Runs `reproduce-beam` and writes its report; the path of `report.html`.
///
/// # Errors
/// Whatever keeps the report from being made: options that contradict an interrupted run, a solver or a
/// training that fails, files that cannot be written.
pub fn reproduce_beam(options: &BeamOptions) -> Result<PathBuf> {
    let about = "Error and time on the same meshes, parameters and machine.";
    let names = ["Emulators against finite elements", about];
    let mut growing = Growing::new(names, (options.seed, options.quick), options, |report| {
        let [all, met] = report.verdicts();
        match all {
            0 => String::new(),
            _ => format!("{met} of {all} medians that the thesis prints are met or bettered."),
        }
    })?;
    begin(options)?;
    options.backend.device()?;
    growing.report.notes = NOTES.map(String::from).to_vec();
    growing.report.definitions = program::definitions(DEFINITIONS);
    let mut lines = String::new();
    let mut page = options.out.join("report.html");
    let wanted = |beam: &&Beam| options.scene.as_ref().is_none_or(|name| name == beam.name);
    for beam in BEAMS.iter().filter(wanted) {
        let (section, note) = run_scene(options, beam, &mut lines)?;
        growing.report.notes.push(note);
        page = growing.add(section, &options.out)?;
        store::write_bytes(&options.out.join("samples.csv"), lines.as_bytes())?;
    }
    Ok(page)
}

const DEFINITIONS: [(&str, &str); 3] = [
    ("quantiles", "over all nodes or elements of all test cases together, linearly interpolated"),
    (
        "densities",
        "Gaussian kernel on log₁₀ of the error, at least 0.08 decades wide; integral 1; exact zeros have no place on them",
    ),
    (
        "✓ and ✗",
        "our median is, or is not, at or below what the thesis prints, in the two digits it prints",
    ),
];

/// Prepares the output folder: empties it of an earlier run, or sees to it that the earlier run can be continued.
fn begin(options: &BeamOptions) -> Result<()> {
    let folders = BEAMS.each_ref().map(|beam| beam.name.to_string());
    let stored = program::begin_in(&options.out, &folders, options.resume, options)?;
    stored.map_or(Ok(()), |stored| program::same_options(&stored, options, &options.out))
}

const NOTES: [&str; 2] = [
    "Errors are over all test cases and over the nodes that no support holds; the thesis counts all nodes, which makes its medians \
     a little smaller.",
    "The truth is our finite-element solution on the same linear tetrahedra, as in the thesis. The rows fem_cold and fem_warm compare \
     that solution with an independent program on the same mesh, not with the continuum.",
];

/// The section of one scene and a note on its mesh; adds to the lines of `samples.csv`.
fn run_scene(options: &BeamOptions, beam: &Beam, lines: &mut String) -> Result<(Section, String)> {
    let case = Case::read(Path::new(beam.scene))?;
    eprintln!("\n{}: {}", case.name, case.about);
    let folder = options.out.join(beam.name);
    let body = case.body()?;
    let count = Samples::of(options).test;
    let (test, test_s) = program::test_set(&body, count, options.seed, &folder)?;
    let mut comparison = Comparison::new(&test)?;
    let mut shown = Vec::new();
    if lines.is_empty() {
        *lines = scenes::head(&body.parameters);
    }
    let mut found = vec![("fem", test.fields.clone())];
    for (key, recipe) in recipes::recipes(options) {
        let folder = folder.join(key);
        let training = recipes::training(options, &recipe, &folder);
        let emulator = recipe.train(&body, &training, &mut Terminal::default())?;
        let cases = comparison.add(key, &emulator, &test, CORRECTIONS)?;
        let last = comparison.methods.last().context("a method was added")?;
        store::write_json(&folder.join("evaluation.json"), &last.evaluation)?;
        *lines += &scenes::lines(beam.name, key, &test.thetas, &cases)?;
        shown.extend(median_and_worst(&cases));
        found.push((key, emulator.predict(&test.thetas)?.fields()));
    }
    write_fields(&folder.join("fields"), &test, shown, found)?;
    let mut section = beam.thesis.section(&comparison, beam.name, beam.scene)?;
    let times = comparison.methods[0].evaluation.times;
    let batch_s = test_s / test.thetas.len() as f64;
    let solver = scenes::compare(beam, &body, [times.solver_cold_s, times.solver_warm_s, batch_s])?;
    section.blocks.insert(0, Block::Text(format!("{}.", case.about)));
    section.blocks.extend([
        Block::Text("The solver against FEniCS on the same mesh:".into()),
        Block::Table(solver.table),
    ]);
    *lines += &solver.samples;
    let note = format!(
        "{}: at mu = lambda = 75 kPa this mesh of linear tetrahedra is {:.2} mm (median over the nodes) from a solution with \
         quadratic ones. Emulators inherit that error; no row shows it.",
        beam.scene, solver.discretisation_mm
    );
    Ok((section, note))
}

/// Writes the fields of the median and the worst case of every method.
fn write_fields(
    folder: &Path,
    test: &TestSet<'_>,
    mut shown: Vec<usize>,
    found: Vec<(&str, Vec<Vec<f64>>)>,
) -> Result<()> {
    shown.sort_unstable();
    shown.dedup();
    let row = |&case: &usize| Row {
        theta: test.thetas[case].clone(),
        fields: found.iter().map(|(_, fields)| &fields[case][..]).collect(),
        ..Row::default()
    };
    let rows = shown.iter().map(row).collect();
    let names = found.iter().map(|(name, _)| *name).collect();
    let results = Results { body: test.body, names, rows, stresses: false };
    results.write(folder, shown.len(), true)?;
    Ok(())
}

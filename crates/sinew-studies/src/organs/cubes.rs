//! The twisting cube on the thesis' five meshes (Table 3.2): one network goes from the coarsest to the finest.

use crate::organs::options::Options;
use crate::organs::run::{QUICK, begin, test_set, train};
use crate::organs::scenes::{CUBES as KEY, MESHES, Mesh};
use crate::program;
use crate::program::peak_kb;
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use sinew::recipe::PhysicsInformed;
use sinew::{Body, Case, Emulator, Recipe, TestSet};
use sinew_emulate::{Budget, Evaluation};
use sinew_report::format::count;
use sinew_report::{Block, Cell, Chart, Column, Row, Section, Series, Style, Table};
use std::path::{Path, PathBuf};

/// One network on one mesh.
#[derive(Debug, Serialize, Deserialize)]
struct Outcome {
    nodes: usize,
    network: String,
    /// Mean nodal error in the middle of the cube \[mm\].
    slice_mm: f64,
    evaluation: Evaluation,
    /// Most memory that the process has used so far \[GB\], where the system tells.
    memory_gb: Option<f64>,
}

/// Trains on the coarsest mesh, goes on to each finer one, and compares with networks that start from scratch there.
pub(crate) fn section(options: &Options) -> Result<Section> {
    let meshes = if options.quick { &MESHES[..2] } else { &MESHES };
    let mut table = Table::new(
        [
            Column::new("slice", "mm")
                .about("mean of ‖u − û‖ over the nodes nearest to the plane x = 5 mm"),
            Column::new("err_u", "mm").about("‖u − û‖ at every node that is free to move"),
            Column::new("err_I1", "%").about("|I₁ − Î₁| / I₁ at every quadrature point"),
        ],
        [
            Column::new("decoder", "s").about("one parameter set on the known mesh"),
            Column::new("in full", "s").about("the same with the message passing"),
            Column::new("train", "s").once().about("on this mesh"),
        ],
        [Column::new("memory", "GB").about("most that the process has used so far")],
    );
    let mut chart = Chart::new("Prediction time", ["nodes", "time [s]"], [true; 2]);
    begin(options, KEY)?;
    let mut before: Option<PathBuf> = None;
    let [mut full, mut decoder] = [Vec::new(), Vec::new()];
    for mesh in meshes {
        let folder = options.out.join(KEY).join(mesh.cells.to_string());
        let found = program::kept(&folder.join("outcomes.json"), options.resume, || {
            outcomes(options, mesh, before.clone(), &folder)
        })?;
        for outcome in found {
            let times = &outcome.evaluation.times;
            full.push([outcome.nodes as f64, times.predict_full_s]);
            decoder.push([outcome.nodes as f64, times.predict_decoder_s]);
            table.push(row(&outcome, mesh.thesis)?)?;
        }
        before = Some(folder.join(if before.is_none() { "own" } else { "fine-tuned" }));
    }
    for (name, points) in [("in full", full), ("decoder", decoder)] {
        chart = chart.with(Series::new(name, Style::Marked, points));
    }
    let about = "Thesis Table 3.2: the twisting cube on five meshes. One network is trained by energy on the coarsest and goes on \
                 to each finer mesh; beside it networks that start from scratch with the same time. The thesis trains one per \
                 mesh, for 150 to 2325 minutes of a GPU.";
    let blocks = vec![
        Block::Text(about.into()),
        Block::Table(table),
        Block::charts("Time against mesh size", "One parameter set.", [chart]),
    ];
    Ok(Section { name: KEY.into(), title: "TwistingCube on five meshes".into(), blocks })
}

fn outcomes(
    options: &Options,
    mesh: &Mesh,
    before: Option<PathBuf>,
    folder: &Path,
) -> Result<Vec<Outcome>> {
    let mut case = Case::read(Path::new("TwistingCube"))?;
    let cells = if options.quick { mesh.cells / 3 } else { mesh.cells };
    case.mesh.cuboid.as_mut().context("a cube")?.cells.0 = [cells; 3];
    case.name = format!("TwistingCube-{cells}");
    let body = case.body()?;
    eprintln!("\nTwistingCube, {} nodes", count(body.nodes as u64));
    let test = test_set(options, &body, mesh.cases, folder)?;
    let budget = options.training(mesh.minutes, QUICK[2]);
    let mut runs = Vec::new();
    if before.is_some() {
        runs.push(("pre-trained", "pre-trained", Budget::Steps(0), before.clone()));
        runs.push(("fine-tuned", "fine-tuned", budget, before.clone()));
    }
    if mesh.own || before.is_none() {
        runs.push(("from scratch", "own", budget, None));
    }
    let recipe = Recipe::from(PhysicsInformed::default());
    let mut outcomes = Vec::new();
    for (network, name, budget, start) in runs {
        let emulator = train(options, &body, &recipe, budget, start, &folder.join(name))?;
        outcomes.push(outcome(network, &body, &emulator, &test)?);
    }
    Ok(outcomes)
}

fn outcome(
    network: &str,
    body: &Body,
    emulator: &Emulator<'_>,
    test: &TestSet<'_>,
) -> Result<Outcome> {
    let fields = emulator.predict(&test.thetas)?.fields();
    let cases = test.cases(&fields)?;
    let middle = |node: &usize| (body.positions[*node][0] - 5.0).abs();
    let free = body.free_nodes();
    let nearest = free.iter().map(middle).fold(f64::INFINITY, f64::min);
    let slice: Vec<usize> =
        (0..free.len()).filter(|&row| middle(&free[row]) < nearest + 1e-9).collect();
    let errors = cases.iter().flat_map(|case| slice.iter().map(|&row| case.err_u[row]));
    let slice_mm = errors.sum::<f64>() / (slice.len() * cases.len()) as f64;
    let evaluation = emulator.evaluate(test, 1)?;
    let network = network.to_string();
    let memory_gb = peak_kb().map(|kb| kb / (1024.0 * 1024.0));
    Ok(Outcome { nodes: body.nodes, network, slice_mm, evaluation, memory_gb })
}

fn row(outcome: &Outcome, [slice, full, decoder]: [f64; 3]) -> Result<Row> {
    let Evaluation { raw, times, .. } = &outcome.evaluation;
    let printed = |seconds: f64, of: f64| Cell {
        note: format!("thesis, on a GPU: {of:.1e}"),
        ..Cell::from(seconds)
    };
    let slice = Cell::from(outcome.slice_mm).against("thesis", Some(slice));
    let row = Row::new(outcome.network.clone(), slice, printed(times.predict_decoder_s, decoder))?;
    let subject = format!("{} nodes", count(outcome.nodes as u64));
    let row = Row { subject, ..row }.error(raw.err_u.q50).error(raw.err_i1.q50);
    let row = row.time(printed(times.predict_full_s, full)).time(times.prepare_s + times.train_s);
    Ok(row.other(outcome.memory_gb))
}

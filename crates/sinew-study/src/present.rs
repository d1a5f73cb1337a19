//! What a scene's outcomes become: fields for ParaView and the scene's part of the report.

use crate::fields::{self, FieldCase};
use crate::outcome::{Outcome, time_columns};
use crate::report::Method;
use crate::scenes::Beam;
use crate::simulate::Simulations;
use anyhow::Result;
use sinew_emulate::{CurvePoint, METRICS, Metric};
use sinew_report::format::{count, trimmed};
use sinew_report::{
    Block, Chart, Column, Level, Provenance, Report, Row, Section, Series, Style, Surfaces, Table,
};
use std::path::Path;

/// Writes the fields of the median and the worst case of every method.
pub(crate) fn write_fields(
    folder: &Path,
    beam: &Beam,
    simulations: &Simulations<'_>,
    outcomes: &[Outcome],
) -> Result<()> {
    let emulators: Vec<&Outcome> =
        outcomes.iter().filter(|outcome| !outcome.method.is_solver()).collect();
    let mut cases = Vec::new();
    for outcome in &emulators {
        for (kind, case) in ["median", "worst"].into_iter().zip(outcome.median_and_worst) {
            cases.push(FieldCase {
                name: format!("{}_{kind}", outcome.method.key()),
                truth: &simulations.test.fields[case],
                predictions: emulators
                    .iter()
                    .map(|other| (other.method.key(), &other.predictions[case][..]))
                    .collect(),
            });
        }
    }
    fields::write(folder, &beam.scene.mesh, &cases)
}

/// The report of all scenes.
pub(crate) fn report(provenance: Provenance, notes: Vec<String>, scenes: Vec<Section>) -> Report {
    let names: Vec<_> = scenes.iter().map(|scene| scene.title.as_str()).collect();
    let about = format!(
        "{}: error and time on the same meshes, parameters and machine.",
        names.join(" and ")
    );
    let mut report = Report::new("Emulators against finite elements", about, provenance);
    report.sections = scenes;
    let [all, met] = report.verdicts();
    if all > 0 {
        report.headline =
            format!("{met} of {all} medians that the thesis prints are met or bettered.");
    }
    report.notes = notes;
    report.definitions = [
        ("quantiles", "over all nodes or elements of all test cases together, linearly interpolated"),
        ("densities", "Gaussian kernel on log₁₀ of the error, at least 0.08 decades wide; integral 1"),
        ("✓ and ✗", "our median is, or is not, at or below what the thesis prints, in the two digits it prints"),
    ]
    .map(|(term, text)| (term.to_string(), text.to_string()))
    .to_vec();
    report
}

/// The scene's part of the report.
pub(crate) fn section(
    beam: &Beam,
    body: &sinew_energy::Body,
    train_samples: usize,
    simulations: &Simulations<'_>,
    outcomes: &[Outcome],
) -> Result<Section> {
    let steps = Column::new("steps", "").about("optimiser steps");
    let mut table = Table::new(METRICS.each_ref().map(column), time_columns(), [steps]);
    table.baseline = Some(Method::FemWarm.label().into());
    let mut sorted: Vec<_> = outcomes.iter().collect();
    sorted.sort_by_key(|outcome| outcome.method);
    for outcome in sorted {
        let mut row = outcome.row.clone();
        for (metric, cell) in row.errors.iter_mut().enumerate() {
            let printed = beam.thesis.median(outcome.method, metric);
            *cell = std::mem::take(cell).against("the thesis’", printed);
        }
        table.push(row)?;
    }
    let mut blocks = vec![
        Block::Text(beam.description.into()),
        Block::Facts(facts(beam, body, train_samples, simulations)),
        Block::List(table.summary()),
        Block::charts(
            "Speed against error",
            "Median displacement error and time of one prediction: from scratch, on the known geometry, in a batch. \
             Lower left is better.",
            [Chart::speed_against_error(&table, 0)],
        ),
        Block::charts(
            "Error densities",
            "Kernel densities of log₁₀ of all test errors. Dashed lines are medians of all samples, dotted lines those \
             that the thesis prints (for the hybrid of the better of its two methods). Exact zeros have no place on a \
             logarithmic axis; medians and quantiles include them.",
            (0..METRICS.len()).map(|error| Chart::densities(&table, error)),
        ),
    ];
    let trained: Vec<_> = outcomes.iter().filter(|outcome| !outcome.history.is_empty()).collect();
    blocks.push(curves(&trained, &table, beam));
    blocks.push(energies(&trained));
    blocks.push(Block::Surfaces(surfaces(beam, simulations, outcomes)?));
    blocks.insert(3, Block::Table(table));
    Ok(Section { name: beam.name.into(), title: beam.title.into(), blocks })
}

fn column(metric: &Metric) -> Column {
    Column::new(metric.name, metric.unit("mm")).about(metric.about)
}

fn facts(
    beam: &Beam,
    body: &sinew_energy::Body,
    train_samples: usize,
    simulations: &Simulations<'_>,
) -> Vec<(String, String)> {
    let test = &simulations.test;
    let norms = |field: &Vec<f64>| {
        fields::rows(field).into_iter().map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt())
    };
    let (mut sum, mut nodes, mut largest) = (0.0, 0usize, 0.0f64);
    for norm in test.fields.iter().flat_map(norms) {
        (sum, nodes, largest) = (sum + norm, nodes + 1, largest.max(norm));
    }
    let [mean, most] = [sum / nodes as f64, largest].map(|mm| trimmed(mm, 3));
    let theta = |p: &sinew_energy::Parameter| {
        format!("{} ∈ [{}, {}] {}", p.name, p.range[0], p.range[1], p.unit)
    };
    let theta: Vec<_> = beam.scene.parameters.iter().map(theta).collect();
    let [thesis_mean, thesis_most] = beam.thesis.displacement_mm;
    let mesh = [
        (body.nodes, "nodes"),
        (body.cell_count(), "elements"),
        (body.free_degrees_of_freedom().len(), "unknowns"),
    ]
    .map(|(number, what)| format!("{} {what}", count(number as u64)));
    let samples = format!("{} training, {} test", train_samples, test.thetas.len());
    let size =
        format!("mean {mean} mm, largest {most} mm (thesis: {thesis_mean} and {thesis_most} mm)");
    let units = format!("{}, {}", beam.scene.units.length, beam.scene.units.stress);
    [
        ("mesh", mesh.join(", ")),
        ("parameters", theta.join(", ")),
        ("displacement", size),
        ("samples", samples),
        ("units", units),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .to_vec()
}

/// Errors over training time; methods without steps as one point, the thesis' medians as levels.
fn curves(trained: &[&Outcome], table: &Table, beam: &Beam) -> Block {
    let chart = |(number, metric): (usize, &Metric)| {
        let title = format!("Error in {}", metric.quantity);
        let name = format!("median {}", column(metric).head());
        let mut chart = Chart::new(title, ["training time [s]", &name], [true; 2]);
        for outcome in trained {
            let (method, history) = (outcome.method, &outcome.history);
            let label = method.label();
            let median = |p: &CurvePoint| p.medians.map_or(f64::NAN, |medians| medians[number]);
            let points = history.iter().map(|p| [p.train_s, median(p)]);
            chart.series.push(Series::new(label, Style::Line, points));
            let thesis = beam.thesis.median(method, number);
            let level =
                |value| Level { name: label.into(), value, upright: false, published: true };
            chart.levels.extend(thesis.map(level));
        }
        let has_curve =
            |row: &&Row| trained.iter().any(|outcome| outcome.method.label() == row.method);
        for row in table.ranked().filter(|row| !has_curve(row)) {
            let numbers = row.times[1].value.median().zip(row.errors[number].value.median());
            let points = numbers.map(|(time, error)| [time, error]);
            chart.series.push(Series::new(&row.method, Style::Points, points));
        }
        chart
    };
    Block::charts(
        "Error over training time",
        "Medians over the validation cases. Time is that of training; preparation comes on top, evaluations are not \
         counted. Dotted lines are the thesis’ medians. A single marker is a method without training steps.",
        METRICS.iter().enumerate().map(chart),
    )
}

fn energies(trained: &[&Outcome]) -> Block {
    let axes = ["training time [s]", "mean energy above FEM [%]"];
    let mut chart = Chart::new("Energy above the minimum", axes, [true; 2]);
    for outcome in trained {
        let point = |p: &CurvePoint| [p.train_s, p.energy_excess_pct.unwrap_or(f64::NAN)];
        let points = outcome.history.iter().map(point);
        chart.series.push(Series::new(outcome.method.label(), Style::Line, points));
    }
    Block::charts(
        "Energy during training",
        "Mean of (Π(û) − Π(u)) / |Π(u)| over the validation cases, u from the finite-element solver. The solution is a \
         minimum, so the excess tends to zero from above.",
        [chart],
    )
}

fn surfaces(beam: &Beam, simulations: &Simulations<'_>, outcomes: &[Outcome]) -> Result<Surfaces> {
    let mesh = &beam.scene.mesh;
    let facets = sinew_mesh::boundary_facets(mesh);
    let triangles: Vec<[usize; 3]> = facets.iter().map(|&facet| mesh.facet_nodes(facet)).collect();
    let mut surfaces = Surfaces::new(&triangles, &mesh.points)?;
    surfaces.quantity = "Where the errors are: ‖u − û‖₂ at the nodes".into();
    (surfaces.unit, surfaces.length) = ("mm".into(), beam.scene.units.length.to_string());
    for outcome in outcomes.iter().filter(|outcome| !outcome.method.is_solver()) {
        for (kind, case) in ["median", "worst"].into_iter().zip(outcome.median_and_worst) {
            let (truth, guess) = (&simulations.test.fields[case], &outcome.predictions[case]);
            let deformed: Vec<[f64; 3]> = fields::rows(guess)
                .iter()
                .zip(&mesh.points)
                .map(|(u, x)| std::array::from_fn(|i| u[i] + x[i]))
                .collect();
            let theta = &simulations.test.thetas[case];
            let title = format!("{kind} case, μ = {:.0} kPa, λ = {:.0} kPa", theta[0], theta[1]);
            let error = sinew_energy::metrics::displacement_error(truth, guess);
            surfaces.push(outcome.method.label(), title, &deformed, &error)?;
        }
    }
    Ok(surfaces)
}

//! What a scene's outcomes become: fields for ParaView and the scene's part of the report.

use crate::fields::{self, FieldCase};
use crate::report::{self, DisplacementScale, MeshCounts, SceneReport, SurfaceCases, ThetaRange};
use crate::run::Outcome;
use crate::scenes::Beam;
use crate::simulate::Simulations;
use anyhow::Result;
use std::path::Path;

/// Writes the fields of the median and the worst case of every method.
///
/// # Errors
/// A folder or file that cannot be written.
pub(crate) fn write_fields(
    folder: &Path,
    beam: &Beam,
    simulations: &Simulations,
    outcomes: &[Outcome],
) -> Result<()> {
    let emulators: Vec<&Outcome> = outcomes.iter().filter(|outcome| on_test_set(outcome)).collect();
    let mut cases = Vec::new();
    for outcome in &emulators {
        for (kind, case) in ["median", "worst"].into_iter().zip(outcome.median_and_worst) {
            cases.push(FieldCase {
                name: format!("{}_{kind}", outcome.row.method().key()),
                truth: &simulations.test.fields[case],
                predictions: emulators
                    .iter()
                    .map(|other| (other.row.method().key(), &other.predictions[case][..]))
                    .collect(),
            });
        }
    }
    fields::write(folder, &beam.scene.mesh, &cases)
}

fn on_test_set(outcome: &Outcome) -> bool {
    !matches!(outcome.row.method(), report::Method::FemCold | report::Method::FemWarm)
}

/// The scene's part of the report.
///
/// # Errors
/// Numbers that a report refuses.
pub(crate) fn scene_report(
    beam: &Beam,
    potential: &sinew_energy::Body,
    simulations: &Simulations,
    outcomes: &[Outcome],
) -> Result<SceneReport> {
    let test = &simulations.test;
    let norms = |field: &Vec<f64>| {
        fields::rows(field).into_iter().map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt())
    };
    let (mut sum, mut count, mut largest) = (0.0, 0usize, 0.0f64);
    for norm in test.fields.iter().flat_map(norms) {
        (sum, count, largest) = (sum + norm, count + 1, largest.max(norm));
    }
    let theta = |p: &sinew_energy::Parameter| ThetaRange {
        name: p.name.clone(),
        unit: p.unit.clone(),
        low: p.range[0],
        high: p.range[1],
    };
    Ok(SceneReport {
        name: beam.name.to_string(),
        title: beam.title.to_string(),
        description: beam.description.to_string(),
        units: format!("{}, {}", beam.scene.units.length, beam.scene.units.stress),
        mesh: MeshCounts {
            nodes: potential.nodes,
            elements: potential.cells.len(),
            unknowns: potential.free_degrees_of_freedom().len(),
        },
        theta: beam.scene.parameters.iter().map(theta).collect(),
        train_samples: simulations.training.thetas.len(),
        test_samples: test.thetas.len(),
        displacement: DisplacementScale { mean_mm: sum / count as f64, max_mm: largest },
        thesis: Some(beam.thesis),
        methods: outcomes.iter().map(|outcome| outcome.row.clone()).collect(),
        training: outcomes.iter().filter_map(|outcome| outcome.history.clone()).collect(),
        surfaces: Some(surfaces(beam, simulations, outcomes)?),
    })
}

fn surfaces(beam: &Beam, simulations: &Simulations, outcomes: &[Outcome]) -> Result<SurfaceCases> {
    let mesh = &beam.scene.mesh;
    let facets = sinew_mesh::boundary_facets(mesh);
    let triangles: Vec<[usize; 3]> = facets.iter().map(|&facet| mesh.facet_nodes(facet)).collect();
    let mut surfaces = SurfaceCases::new(&triangles, &mesh.points)?;
    for outcome in outcomes.iter().filter(|outcome| on_test_set(outcome)) {
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
            surfaces.push(outcome.row.method(), title, &deformed, &error)?;
        }
    }
    Ok(surfaces)
}

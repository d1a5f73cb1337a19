//! Trains an emulator of one's own body: mesh, loads, parameter ranges and network come from a case file.
//!
//! ```sh
//! cargo run -p sinew-examples --example train_emulator -- examples/cases/hanging_bar.toml
//! ```
//!
//! Writes the emulator and a VTU file of one prediction into the case's output folder.

use anyhow::Result;
use sinew_energy::Barriers;
use sinew_examples::{Case, Method};
use sinew_fem::{Options, Solver, sweep};
use sinew_gnn::{
    Backend, Budget, DataFit, DataSet, MinimumPotential, Objective, Observer, OutputScale,
    Progress, Sample, Scales, Surrogate, Trainer, TrainingConfig,
};
use sinew_mesh::{Field, write_vtu};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

/// One line on the terminal: how far, how long still.
struct Line;

impl Observer for Line {
    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        if progress.step.is_multiple_of(20) || progress.step == progress.steps {
            let (step, steps, left) = (progress.step, progress.steps, progress.remaining_seconds);
            eprint!("\rstep {step}/{steps}  loss {:.4e}  {left:.0} s left   ", progress.loss);
            std::io::stderr().flush().unwrap_or_default();
        }
        ControlFlow::Continue(())
    }
}

const HELP: &str = concat!(
    "usage: train_emulator [CASE.toml]\n\n",
    "Without a case file it trains the one that comes with the examples, which explains every key:\n\n",
    include_str!("../cases/hanging_bar.toml"),
);

fn main() -> Result<()> {
    match std::env::args_os().nth(1) {
        Some(option) if option == "--help" || option == "-h" => print!("{HELP}"),
        Some(path) => train(&Case::read(Path::new(&path))?)?,
        None => train(&Case::bundled()?)?,
    }
    Ok(())
}

fn train(case: &Case) -> Result<()> {
    let body = case.prepare()?;
    let (thetas, centre) = (case.thetas(0..case.training.samples), case.centre());

    // One solve gives the size of displacements and energies; training on data needs one for each sample.
    let solution = Solver::new(&body.potential)?.solve(&centre, &Options::default())?;
    let simulated = match case.method {
        Method::Pi => None,
        Method::Dd => Some(sweep(&body.potential, &thetas, &Options::default(), || ())?),
    };
    let fields = match &simulated {
        None => vec![Vec::new(); thetas.len()],
        Some(swept) => swept.solutions()?.into_iter().map(|s| s.displacement.clone()).collect(),
    };
    let (output, objective): (_, Box<dyn Objective>) = match case.method {
        Method::Pi => {
            let potential = Arc::new(body.potential.clone().with_barriers(Barriers::default()));
            let output = OutputScale::root_mean_square(3, [&solution.displacement[..]])?;
            (output, Box::new(MinimumPotential::new(vec![potential], solution.energy.abs())?))
        }
        Method::Dd => {
            let output = OutputScale::standardising_every_node(fields.iter().map(Vec::as_slice))?;
            let length = output.length();
            (output, Box::new(DataFit::new(length)?))
        }
    };

    let sample = |(theta, displacement)| Sample { geometry: 0, theta, displacement };
    let data = DataSet {
        topology: body.topology,
        geometries: vec![body.geometry.clone()],
        training: thetas.into_iter().zip(fields).map(sample).collect(),
        validation: Vec::new(),
    };
    let device = Backend::Flex.device()?;
    let scales = Scales::over(&data.geometries, body.scaling, output)?;
    let surrogate = Surrogate::new(&body.network, &data, scales, case.training.seed, &device)?;
    let config = TrainingConfig {
        learning_rate: case.training.learning_rate,
        budget: Budget::Steps(case.training.steps),
        batch: case.training.batch,
        seed: case.training.seed,
        evaluations: 1,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate, data, objective, config)?;
    let report = trainer.run(&mut Line)?;
    eprintln!("\n{} steps in {:.1} s", report.steps, report.seconds);

    let surrogate = trainer.into_surrogate();
    let folder = case.output.join("emulator");
    std::fs::create_dir_all(&case.output)?;
    surrogate.save(&folder)?;
    let prediction = surrogate.predict(&body.geometry, &[centre])?.displacement;
    let mut mesh = body.mesh;
    let rows = |u: &[f64]| u.as_chunks::<3>().0.to_vec();
    mesh.point_fields.insert("u_emulator".into(), Field::vectors(&rows(&prediction)));
    mesh.point_fields.insert("u_fem".into(), Field::vectors(&rows(&solution.displacement)));
    write_vtu(case.output.join("prediction.vtu"), &mesh)?;
    let errors = sinew_energy::metrics::displacement_error(&solution.displacement, &prediction);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    println!(
        "mean nodal error at the centre of the ranges: {mean:.3} mm after {:.1} s of training",
        report.seconds
    );
    println!("emulator: {}", folder.display());
    Ok(())
}

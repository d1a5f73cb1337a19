//! Tries recipes of training on a beam and prints the errors on the way: what `docs/design.md` compares.

mod averaged;
mod load_ramp;

use anyhow::{Context, Result, bail};
use averaged::Averaged;
use clap::{Parser, ValueEnum};
use load_ramp::LoadRamp;
use sinew_energy::Barriers;
use sinew_fem::{Options, Solver, sweep};
use sinew_gnn::{
    Backend, Budget, Concern, DataFit, DataSet, Decoding, EmulatorConfig, EnergyNormFit, Geometry,
    HistoryPoint, MinimumPotential, Motions, Objective, Observer, OutputBasis, OutputScale,
    ParameterScaling, Sample, Scales, Surrogate, Trainer, TrainingConfig, WeightedSum,
};
use sinew_graph::AugmentationConfig;
use sinew_study::evaluate::TestSet;
use sinew_study::train::Body;
use sinew_study::{basis, graph, sampling, scenes};
use std::sync::Arc;
use std::time::Instant;

/// Trains one emulator after another on a beam; the errors are over 100 test cases.
#[derive(Parser)]
struct Arguments {
    /// `once` or `twice`
    scene: String,
    /// Coordinates of the outputs and objective, as `simulations:fit`, one per training. `prediction` is the
    /// stiffness about what the training before it predicts for the centre of the range
    #[arg(required = true, value_parser = parse_recipe)]
    recipes: Vec<(Coordinates, Goal)>,
    /// Parameter sets per step
    #[arg(long, value_delimiter = ',', default_value = "8")]
    batch: Vec<usize>,
    /// Steps of each training
    #[arg(long, value_delimiter = ',', default_value = "1000")]
    steps: Vec<usize>,
    /// Share of the steps that train the node embeddings
    #[arg(long, value_delimiter = ',', default_value = "0.1")]
    share: Vec<f64>,
    /// Peak of the learning rate
    #[arg(long, value_delimiter = ',', default_value = "4e-3")]
    learning_rate: Vec<f64>,
    /// Simulations that the coordinates are taken from
    #[arg(long, default_value_t = 200)]
    simulations: usize,
    /// Power of the deviations in the coordinates of simulations
    #[arg(long, default_value_t = 0.7)]
    power: f64,
    /// Keep this share of an exponential average of the weights at every step, and end with the average
    #[arg(long)]
    average: Option<f32>,
    /// Each layer of virtual nodes is so much smaller than the one below, down to one; 0 is the graph of the thesis
    #[arg(long, default_value_t = 4)]
    ratio: usize,
    /// Factor of the outputs' size
    #[arg(long, value_delimiter = ',', default_value = "1")]
    size: Vec<f64>,
    /// Width M of the embeddings
    #[arg(long, default_value_t = 40)]
    latent: usize,
    /// Message-passing steps
    #[arg(long, default_value_t = 5)]
    passes: usize,
    /// Width of the hidden layers
    #[arg(long, default_value_t = 128)]
    width: usize,
    /// Cells of the mesh
    #[arg(long, num_args = 3)]
    cells: Vec<usize>,
    /// Number of test cases and of simulations trained on
    #[arg(long, default_value_t = 100)]
    tests: usize,
    /// Seed of data, weights and batches
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many seeds, from that one on; several are summed up at the end
    #[arg(long, default_value_t = 1)]
    seeds: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Coordinates {
    Components,
    Nodes,
    Simulations,
    Rest,
    Simulation,
    Prediction,
    MotionsRest,
    MotionsSimulation,
    MotionsPrediction,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Goal {
    Fit,
    Norm,
    Energy,
    EnergyFit,
    EnergyNorm,
    LoadRamp,
}

fn parse_recipe(text: &str) -> Result<(Coordinates, Goal), String> {
    let (coordinates, goal) = text.split_once(':').ok_or("write COORDINATES:OBJECTIVE")?;
    Ok((Coordinates::from_str(coordinates, true)?, Goal::from_str(goal, true)?))
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut finals: Vec<Vec<f64>> = vec![Vec::new(); arguments.recipes.len()];
    let mut troubles = Vec::new();
    for seed in arguments.seed..arguments.seed + arguments.seeds {
        let (body, fields, test) = simulate(&arguments, seed)?;
        let mut before = None;
        for (index, &recipe) in arguments.recipes.iter().enumerate() {
            println!("seed {seed}: {recipe:?}");
            let trained =
                train(&arguments, seed, (index, recipe), &body, &fields, &test, before.take());
            match trained {
                Ok(Trained { surrogate, geometry, err_u_mm, concerns }) => {
                    finals[index].push(err_u_mm);
                    troubles
                        .extend(concerns.iter().map(|c| format!("seed {seed}: {recipe:?}: {c}")));
                    before = Some((surrogate, geometry));
                }
                Err(error) => {
                    troubles.push(format!("seed {seed}: {recipe:?}: {error:#}"));
                    break;
                }
            }
        }
    }
    for (recipe, errors) in arguments.recipes.iter().zip(&finals) {
        let [least, largest] = [f64::min as fn(f64, f64) -> f64, f64::max]
            .map(|pick| errors.iter().copied().reduce(pick).unwrap_or(f64::NAN));
        let (trained, seeds) = (errors.len(), arguments.seeds);
        println!(
            "{recipe:?}: {trained} of {seeds} seeds trained, median err_u {least:.1e} to {largest:.1e} mm"
        );
    }
    troubles.iter().for_each(|trouble| println!("{trouble}"));
    Ok(())
}

/// The value of a training among those given for all; the last one goes on.
fn nth<T: Copy>(values: &[T], index: usize) -> T {
    values[index.min(values.len() - 1)]
}

/// The end of a training.
struct Trained {
    surrogate: Surrogate,
    geometry: Geometry,
    err_u_mm: f64,
    concerns: Vec<Concern>,
}

fn simulate(arguments: &Arguments, seed: u64) -> Result<(Body, Vec<Vec<f64>>, TestSet)> {
    let beam = match &arguments.scene[..] {
        "once" => scenes::once_clamped(),
        "twice" => scenes::twice_clamped(),
        other => bail!("there is no beam `{other}`; write once or twice"),
    };
    let mut beam = beam;
    if let [x, y, z] = arguments.cells[..] {
        let extent =
            if arguments.scene == "once" { [100.0, 10.0, 10.0] } else { [150.0, 10.0, 2.0] };
        beam.scene.mesh = sinew_mesh::box_tetrahedra(extent, [x, y, z]);
    }
    let exact = beam.scene.lower()?;
    let potential = exact.clone().with_barriers(Barriers::default());
    let ranges: Vec<[f64; 2]> = beam.scene.parameters.iter().map(|p| p.range).collect();
    let centre: Vec<f64> = ranges.iter().map(|[low, high]| (low * high).sqrt()).collect();
    let (lower, upper): (Vec<f64>, Vec<f64>) = ranges.iter().map(|[a, b]| (*a, *b)).unzip();
    let solve = |thetas: &[Vec<f64>]| -> Result<Vec<Vec<f64>>> {
        let swept = sweep(&exact, thetas, &Options::default(), || ())?;
        let solutions = swept.solutions().context("simulations")?;
        Ok(solutions.iter().map(|solution| solution.displacement.clone()).collect())
    };
    let thetas = sampling::log_latin_hypercube(200, &ranges, seed);
    let needed = arguments.recipes.iter().any(|(c, g)| {
        !matches!(c, Coordinates::MotionsRest | Coordinates::MotionsPrediction)
            || !matches!(g, Goal::Energy)
    });
    let fields = if needed { solve(&thetas)? } else { vec![Vec::new(); 200] };
    let tests = sampling::uniform(arguments.tests, &ranges, !seed);
    let displacements = solve(&tests)?;
    let test = TestSet { potential: potential.clone(), displacements, thetas: tests };

    let (topology, geometry) = {
        let nodes = beam.scene.mesh.points.len();
        let config = match arguments.ratio {
            0 => AugmentationConfig::for_nodes(nodes),
            ratio => AugmentationConfig::to_one_root(nodes, ratio),
        };
        graph::geometry(&beam.scene.mesh, &exact, AugmentationConfig { seed, ..config })?
    };
    let mut nearly_unloaded = exact.clone();
    nearly_unloaded.nodal_force.iter_mut().for_each(|force| *force *= 1e-6);
    let linear = Solver::new(&nearly_unloaded)?.solve(&centre, &Options::default())?;
    let body = Body {
        potential,
        topology,
        geometry,
        parameters: ParameterScaling::logarithmic(&lower, &upper)?,
        thetas,
        linear_response: linear.displacement.iter().map(|u| u * 1e6).collect(),
        centre,
        exact,
    };
    Ok((body, fields, test))
}

fn train(
    arguments: &Arguments,
    seed: u64,
    (index, (coordinates, goal)): (usize, (Coordinates, Goal)),
    body: &Body,
    fields: &[Vec<f64>],
    test: &TestSet,
    before: Option<(Surrogate, Geometry)>,
) -> Result<Trained> {
    let start = Instant::now();
    let steps = nth(&arguments.steps, index);
    let anchor = match (coordinates, before) {
        (Coordinates::Prediction | Coordinates::MotionsPrediction, Some((surrogate, geometry))) => {
            surrogate.predict(&geometry, std::slice::from_ref(&body.centre))?.displacement
        }
        (Coordinates::Prediction | Coordinates::MotionsPrediction, None) => {
            bail!("no training before this one")
        }
        (Coordinates::MotionsRest, _) => vec![0.0; body.linear_response.len()],
        _ => basis::nearest_to_centre(body, fields).context("no simulation")?.to_vec(),
    };
    let mut geometry = body.geometry.clone();
    geometry.coordinates = match coordinates {
        Coordinates::Components | Coordinates::Nodes => sinew_gnn::Coordinates::Components,
        Coordinates::Rest => sinew_gnn::Coordinates::Basis(basis::at_rest(body)?),
        Coordinates::Simulation | Coordinates::Prediction => {
            sinew_gnn::Coordinates::Basis(basis::at_anchor(body, &anchor)?.basis)
        }
        Coordinates::MotionsRest
        | Coordinates::MotionsSimulation
        | Coordinates::MotionsPrediction => motions(nth(&arguments.size, index), body, &anchor)?,
        Coordinates::Simulations => {
            let some = fields.iter().take(arguments.simulations).map(Vec::as_slice);
            sinew_gnn::Coordinates::Basis(OutputBasis::principal(some, arguments.power)?)
        }
    };
    let output = match coordinates {
        Coordinates::Nodes => {
            OutputScale::standardising_every_node(fields.iter().map(Vec::as_slice))?
        }
        _ => OutputScale::root_mean_square(3, [&body.linear_response[..]])?,
    };
    let samples = body.thetas.iter().zip(fields).map(|(theta, field)| Sample {
        geometry: 0,
        theta: theta.clone(),
        displacement: field.clone(),
    });
    let data = DataSet {
        topology: body.topology.clone(),
        geometries: vec![geometry.clone()],
        training: samples.collect(),
        validation: Vec::new(),
    };
    let objective = objective(goal, body, &anchor, &output, &data, steps)?;
    let config = TrainingConfig {
        batch: nth(&arguments.batch, index),
        budget: Budget::Steps(steps),
        learning_rate: nth(&arguments.learning_rate, index),
        embedding_share: nth(&arguments.share, index),
        seed,
        evaluations: 4,
        ..TrainingConfig::default()
    };
    let columns = (geometry.features.nodes.columns, geometry.features.edges.columns);
    let layers = data.topology.roots_per_layer.len();
    let motions = matches!(geometry.coordinates, sinew_gnn::Coordinates::Motions(_));
    let network = EmulatorConfig {
        latent: arguments.latent,
        steps: arguments.passes,
        width: arguments.width,
        decoding: if motions { Decoding::Motions { layers } } else { Decoding::Components },
        ..EmulatorConfig::new(3, columns.0, columns.1, body.centre.len())
    };
    let scales = Scales::over(&data.geometries, body.parameters.clone(), output)?;
    let device = Backend::Flex.device()?;
    let surrogate = Surrogate::new(&network, &data, scales, seed, &device)?;
    let averaged = arguments.average.map(|decay| Averaged::new(&config.optimiser, decay, steps));
    let mut trainer = Trainer::new(surrogate, data, objective, config)?;
    if let Some(averaged) = averaged {
        trainer = trainer.with_optimiser(Box::new(averaged));
    }
    println!("prepared in {:.2} s", start.elapsed().as_secs_f64());
    let mut printer = Printer { test, geometry: &geometry, err_u_mm: f64::NAN };
    let concerns = trainer.run(&mut printer)?.concerns;
    let err_u_mm = printer.err_u_mm;
    Ok(Trained { surrogate: trainer.into_surrogate(), geometry, err_u_mm, concerns })
}

fn objective(
    goal: Goal,
    body: &Body,
    anchor: &[f64],
    output: &OutputScale,
    data: &DataSet,
    steps: usize,
) -> Result<Box<dyn Objective>> {
    let fit = || -> Result<Box<dyn Objective>> { Ok(Box::new(DataFit::new(output.length())?)) };
    let norm = || -> Result<Box<dyn Objective>> {
        let stiffness = body.exact.stiffness(anchor, &body.centre).context("inverted")?;
        Ok(Box::new(EnergyNormFit::new(vec![stiffness], data)?))
    };
    let (potential, linear) = (&body.potential, &body.linear_response);
    let unit = || MinimumPotential::energy_of_linear_response(potential, linear, &body.centre);
    let energy = || -> Result<Box<dyn Objective>> {
        Ok(Box::new(MinimumPotential::new(vec![Arc::new(potential.clone())], unit()?)?))
    };
    Ok(match goal {
        Goal::Fit => fit()?,
        Goal::Norm => norm()?,
        Goal::Energy => energy()?,
        Goal::LoadRamp => Box::new(LoadRamp::new(body, unit()?, steps)?),
        Goal::EnergyFit => Box::new(WeightedSum::new(vec![(1.0, energy()?), (1.0, fit()?)])?),
        Goal::EnergyNorm => Box::new(WeightedSum::new(vec![(1.0, energy()?), (1.0, norm()?)])?),
    })
}

/// Prints medians over the test cases.
struct Printer<'a> {
    test: &'a TestSet,
    geometry: &'a Geometry,
    /// The latest.
    err_u_mm: f64,
}

impl Observer for Printer<'_> {
    fn evaluate(&mut self, surrogate: &Surrogate, point: &HistoryPoint) {
        let medians = surrogate
            .predict(self.geometry, &self.test.thetas)
            .map_err(anyhow::Error::from)
            .and_then(|prediction| {
                let cases = 0..self.test.thetas.len();
                let fields: Vec<_> = cases.map(|case| prediction.field(case).to_vec()).collect();
                self.test.evaluate(&fields)?.medians()
            });
        match medians {
            Ok(m) => {
                self.err_u_mm = m.err_u_mm;
                println!(
                    "{:6} steps {:6.1} s: err_u {:.1e} mm, err_F {:.1e} %, err_I1 {:.1e} %, err_Pi {:.1e} %",
                    point.step, point.seconds, m.err_u_mm, m.err_f_pct, m.err_i1_pct, m.err_pi_pct
                );
            }
            Err(error) => println!("{:6} steps {:6.1} s: {error:#}", point.step, point.seconds),
        }
    }
}

/// Motions about an anchor; outputs of one cost so much of what a linear response would.
fn motions(size: f64, body: &Body, anchor: &[f64]) -> Result<sinew_gnn::Coordinates> {
    let motions = Motions::about(anchor, &body.topology, &body.exact, &body.centre)?;
    let response = motions.linear_response(&body.exact, &body.centre)?;
    let energy = -0.5 * body.exact.load_value(&response, &body.centre);
    Ok(sinew_gnn::Coordinates::Motions(motions.of_energy(size * size * energy)?))
}

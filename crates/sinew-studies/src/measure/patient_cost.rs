//! Processor time of one patient, stage by stage: an ideal left ventricle with made data, calibrated with the default options.

#[path = "../../../sinew-calibrate/tests/calibrate/support/heart.rs"]
mod heart;

use crate::program::cpu_seconds;
use anyhow::Result;
use heart::{MMHG, NAMES, ObserveStrains, passive, segments, wall};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_calibrate::{
    CalibrateOptions, Datum, Direction, Forward, Observable, Patient, PatientBuilder, Prior,
    Problem, Solves, Unknown, calibrate,
};
use sinew_mesh::TruncatedEllipsoid;
use sinew_sample::standard_normals;

/// Bounds of θ, and the θ that the data are made with.
const RANGES: [[f64; 2]; 4] = [[0.1, 0.4], [1.0, 4.0], [1.5, 5.0], [1.0, 4.5]];
const TRUTH: [f64; 4] = [0.2, 2.0, 2.8, 2.1];

/// Mesh, data and image.
#[derive(clap::Args)]
pub struct Arguments {
    /// Cells through the wall, around and along
    #[arg(default_values_t = [2, 16, 10], num_args = 3)]
    cells: Vec<usize>,
    /// The image is the body at rest
    #[arg(long)]
    rest: bool,
    /// Seed of errors and draws
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Prints the stages and the posterior.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let &Arguments { ref cells, rest, seed } = arguments;
    let [layers, around, along] = cells[..] else { anyhow::bail!("cells are three numbers") };
    let mesh = TruncatedEllipsoid { short: [20.0, 30.0], long: [52.0, 62.0], base: 15.0 };
    let mesh = mesh.wall([layers, around, along]).tetrahedra();
    let body = passive(mesh.clone(), 25.0).lower()?;
    let wall = wall(&mesh);
    let segments = segments(&wall);
    let mut patient = Patient::of(&body).parameters(NAMES).image([("pressure", 8.0 * MMHG)]);
    if rest {
        patient = PatientBuilder { fibres: None, ..patient.image([("pressure", 0.0)]) };
    }
    let patient = PatientBuilder {
        wall: Some(&wall),
        segments: Some(&segments),
        accuracy: 1e-6,
        start: Some(RANGES.map(|[low, high]| (low * high).sqrt()).to_vec()),
        ..patient
    };
    let patient = patient
        .phase("low", [("pressure", 3.0 * MMHG)])
        .phase("high", [("pressure", 14.0 * MMHG)])
        .observe(Observable::volume("endo", "low"))
        .observe(Observable::volume("endo", "high"))
        .observe_strains(&segments, Direction::Circumferential, "low", "high")
        .observe_strains(&segments, Direction::Longitudinal, "low", "high")
        .build()?;
    let unknown = |(name, range): (&&str, &[f64; 2])| {
        Unknown::new(*name, "1", Prior::LogUniform { range: *range })
    };
    let unknowns = NAMES.iter().zip(&RANGES).map(unknown).collect();
    let exact = patient.observe(&TRUTH, false)?.values;
    let noise = standard_normals(exact.len(), &mut ChaCha8Rng::seed_from_u64(seed));
    let datum = |(at, (exact, z)): (usize, (&f64, f64))| {
        let (kind, deviation) = if at < 2 { ("volume", 0.03 * exact) } else { ("strain", 0.02) };
        Datum::new(format!("{kind} {at}"), kind, at, exact + z * deviation, deviation)
    };
    let data = exact.iter().zip(noise).enumerate().map(datum).collect();
    let problem = Problem::new(unknowns, data, Vec::new())?;
    println!("{} nodes", body.nodes);
    let began = cpu_seconds();
    let mut last = (String::new(), 0, began);
    let told = move |stage: &str, done: usize, of: usize| {
        if stage != last.0 {
            last = (stage.into(), done, cpu_seconds());
        }
        if done == of && done > last.1 {
            println!(
                "{stage}: {} solves, {:.2} s of processor time",
                done - last.1,
                cpu_seconds() - last.2
            );
            last.1 = done;
        }
    };
    let mut solves = Solves::new(&patient, Box::new(told));
    let posterior =
        calibrate(&problem, &mut solves, &CalibrateOptions { seed, ..Default::default() })?;
    let (c, [r_hat, bulk, tail]) = (&posterior.correction, posterior.coordinates.mixing());
    println!(
        "{} solves, {:.1} s of processor time, {:.1} s on {} threads; {} rounds, k̂ {:.2}, share {:.2}, accepted {:.3}, R̂ {r_hat:.3}, \
         {bulk:.0} effective draws in the bulk and {tail:.0} in the tails",
        c.solves,
        cpu_seconds() - began,
        c.seconds,
        rayon::current_num_threads(),
        c.rounds,
        c.k_hat,
        c.share,
        c.acceptance
    );
    for (at, name) in NAMES.iter().enumerate() {
        let summary = posterior.summary(at);
        println!("{name}: mean {:.4}, standard deviation {:.4}", summary.mean, summary.deviation);
    }
    Ok(())
}

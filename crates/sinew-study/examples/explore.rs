//! Scratch: recipes of training, stage by stage.
use anyhow::{Context, Result};
use sinew_energy::Barriers;
use sinew_fem::{Options, Solver, sweep};
use sinew_gnn::*;
use sinew_study::evaluate::TestSet;
use sinew_study::train::Body;
use sinew_study::{basis, graph, sampling, scenes};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

struct Watch<'a> {
    test: &'a TestSet,
    geometry: Geometry,
    before: f64,
}
impl Observer for Watch<'_> {
    fn progress(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
    fn evaluate(&mut self, surrogate: &Surrogate, point: &HistoryPoint) {
        let p = surrogate.predict(&self.geometry, &self.test.thetas).unwrap();
        let fields: Vec<_> = (0..self.test.thetas.len()).map(|c| p.field(c).to_vec()).collect();
        let m = self.test.evaluate(&fields).unwrap().medians().unwrap();
        println!(
            "  {:6} steps {:7.1} s  loss {:.3e}  u {:.2e}  F {:.2e}  I1 {:.2e}  Pi {:.2e}",
            point.step,
            self.before + point.seconds,
            point.loss,
            m.err_u_mm,
            m.err_f_pct,
            m.err_i1_pct,
            m.err_pi_pct
        );
    }
}

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let beam = if args[0] == "once" { scenes::once_clamped() } else { scenes::twice_clamped() };
    let seed: u64 = args[1].parse()?;
    let potential = beam.scene.lower()?;
    let ranges: Vec<[f64; 2]> = beam.scene.parameters.iter().map(|p| p.range).collect();
    let (lower, upper): (Vec<f64>, Vec<f64>) = ranges.iter().map(|[a, b]| (*a, *b)).unzip();
    let training = sampling::log_latin_hypercube(200, &ranges, seed);
    let tests = sampling::uniform(100, &ranges, 999);
    let t0 = Instant::now();
    let solve = |t: &[Vec<f64>]| -> Result<Vec<Vec<f64>>> {
        Ok(sweep(&potential, t, &Options::default(), || ())?
            .solutions()
            .context("s")?
            .iter()
            .map(|s| s.displacement.clone())
            .collect())
    };
    let fields = solve(&training)?;
    println!("{} simulations {:.2} s", fields.len(), t0.elapsed().as_secs_f64());
    let guarded = potential.clone().with_guard(Barriers::default());
    let test = TestSet { potential: guarded.clone(), displacements: solve(&tests)?, thetas: tests };
    let (topology, geometry) = graph::geometry(&beam.scene.mesh, &potential, seed)?;
    let centre: Vec<f64> = ranges.iter().map(|[low, high]| (low * high).sqrt()).collect();
    let mut nearly = potential.clone();
    nearly.nodal_force.iter_mut().for_each(|f| *f *= 1e-6);
    let linear: Vec<f64> = Solver::new(&nearly)?
        .solve(&centre, &Options::default())?
        .displacement
        .iter()
        .map(|u| u * 1e6)
        .collect();
    let body = Body {
        exact: potential.clone(),
        potential: guarded.clone(),
        topology,
        geometry,
        parameters: ParameterScaling::logarithmic(&lower, &upper)?,
        thetas: training.clone(),
        linear_response: linear,
        centre: centre.clone(),
    };
    let device = Backend::Flex.device()?;
    let mut previous: Option<(Surrogate, Geometry)> = None;
    let mut spent = 0.0;
    for stage in &args[2..] {
        println!("stage {stage}");
        let map: BTreeMap<&str, &str> =
            stage.split(';').filter_map(|p| p.split_once('=')).collect();
        let get = |k: &str, d: f64| map.get(k).map_or(d, |v| v.parse().unwrap());
        let data = get("n", 200.0) as usize;
        let kind = map.get("loss").copied().unwrap_or("pi");
        let t = Instant::now();
        let mut geometry = body.geometry.clone();
        let mut anchor_of = vec![];
        let at = |a: &[f64], power: f64, share: f64| -> Result<OutputBasis> {
            let mut solver = Solver::new(&body.exact)?;
            let m = solver.inverse_stiffness_power(a, &body.centre, power)?;
            let e = body.exact.value(a, &body.centre).abs();
            let c = (2.0 * share * e / solver.unknowns() as f64).sqrt();
            Ok(OutputBasis::new(a.to_vec(), &m.iter().map(|x| x * c).collect::<Vec<_>>())?)
        };
        match map.get("basis").copied().unwrap_or("comp") {
            "rest" => geometry.basis = Some(basis::at_rest(&body)?),
            "anchor" => {
                let (s, g) = previous.as_ref().unwrap();
                let a = s.predict(g, &[centre.clone()])?.displacement;
                geometry.basis = Some(basis::at_anchor(&body, &a)?);
                anchor_of = a;
            }
            "pod" => {
                let n = fields[0].len();
                let m = get("m", 200.0) as usize;
                let mean: Vec<f64> = (0..n)
                    .map(|i| fields[..m].iter().map(|f| f[i]).sum::<f64>() / m as f64)
                    .collect();
                let x = nalgebra::DMatrix::from_fn(n, m, |i, j| {
                    (fields[j][i] - mean[i]) / (m as f64).sqrt()
                });
                let svd = x.svd(true, false);
                let u = svd.u.unwrap();
                let s = svd.singular_values;
                let rank = (get("rank", 20.0) as usize).min(s.len());
                println!(
                    "  singular values {:?}",
                    s.iter().take(16).map(|x| format!("{x:.1e}")).collect::<Vec<_>>()
                );
                let power = get("power", 1.0);
                // rows of u have norm sqrt(rank/n) or so: outputs of size one give displacements of the scale of the data
                let c = s[0] / s[0].powf(power);
                let scaled =
                    nalgebra::DMatrix::from_fn(n, rank, |i, j| u[(i, j)] * s[j].powf(power) * c);
                let w = &scaled * u.columns(0, rank).transpose();
                let flat: Vec<f64> = (0..n * n).map(|k| w[(k / n, k % n)]).collect();
                geometry.basis = Some(OutputBasis::new(mean, &flat)?);
            }
            "fem" => {
                let a = Solver::new(&potential)?.solve(&centre, &Options::default())?.displacement;
                geometry.basis = Some(at(&a, 0.5, get("es", 0.05))?);
                anchor_of = a;
            }
            _ => {}
        }
        let output = if map.get("basis") == Some(&"node") {
            OutputScale::standardising_every_node(fields.iter().map(Vec::as_slice))?
        } else {
            OutputScale::root_mean_square(3, [&body.linear_response[..]])?
        };
        let sample = |(i, theta): (usize, &Vec<f64>)| Sample {
            geometry: 0,
            theta: theta.clone(),
            displacement: fields[i].clone(),
        };
        let set = DataSet {
            topology: body.topology.clone(),
            geometries: vec![geometry.clone()],
            training: training.iter().enumerate().take(data).map(sample).collect(),
            validation: vec![],
        };
        let energy = MinimumPotential::energy_of_linear_response(
            &body.potential,
            &body.linear_response,
            &centre,
        )?;
        let pi = || -> Result<Box<dyn Objective>> {
            Ok(Box::new(MinimumPotential::new(vec![Arc::new(body.potential.clone())], energy)?))
        };
        let dd = || -> Result<Box<dyn Objective>> { Ok(Box::new(DataFit::new(output.length())?)) };
        let norm = |squared: bool| -> Result<Box<dyn Objective>> {
            let a = if anchor_of.is_empty() {
                Solver::new(&potential)?.solve(&centre, &Options::default())?.displacement
            } else {
                anchor_of.clone()
            };
            let mut solver = Solver::new(&potential)?;
            let r = solver.inverse_stiffness_power(&a, &centre, -get("np", 0.5))?;
            let n = a.len();
            // scale: rms of root·(u - mean) is one
            let mean: Vec<f64> = (0..n)
                .map(|i| fields.iter().map(|f| f[i]).sum::<f64>() / fields.len() as f64)
                .collect();
            let mut sum = 0.0;
            for f in fields.iter().take(20) {
                for row in r.chunks_exact(n) {
                    sum += row
                        .iter()
                        .zip(f.iter().zip(&mean))
                        .map(|(x, (u, m))| x * (u - m))
                        .sum::<f64>()
                        .powi(2);
                }
            }
            let c = (sum / (20 * n / 3) as f64).sqrt();
            Ok(Box::new(EnergyNorm::new(&r.iter().map(|x| x / c).collect::<Vec<_>>(), n, squared)?))
        };
        let w = get("w", 1.0);
        let objective: Box<dyn Objective> = match kind {
            "pi" => pi()?,
            "dd" => dd()?,
            "ddz" => norm(false)?,
            "ddz2" => norm(true)?,
            "hyb" => Box::new(WeightedSum::new(vec![(1.0, pi()?), (w, dd()?)])?),
            "hybz" => Box::new(WeightedSum::new(vec![(1.0, pi()?), (w, norm(false)?)])?),
            "both" => Box::new(WeightedSum::new(vec![(1.0, norm(false)?), (w, dd()?)])?),
            other => anyhow::bail!("loss {other}"),
        };
        let config = TrainingConfig {
            batch: get("batch", 4.0) as usize,
            budget: Budget::Steps(get("steps", 100.0) as usize),
            learning_rate: get("lr", 4e-3),
            embedding_share: get("share", 1.0),
            seed,
            evaluations: get("evals", 4.0) as usize,
            ..TrainingConfig::default()
        };
        let features = &geometry.features;
        let mut network = EmulatorConfig::new(3, features.nodes.columns, features.edges.columns, 2);
        if let Some(w) = map.get("width") {
            network.width = w.parse()?;
        }
        let scales = Scales::over(&set.geometries, body.parameters.clone(), output)?;
        let mut surrogate = Surrogate::new(&network, &set, scales, seed, &device)?;
        if get("transfer", 0.0) > 0.0 {
            surrogate = surrogate.with_embeddings_of(&previous.as_ref().unwrap().0)?;
        }
        let mut trainer = Trainer::new(surrogate, set, objective, config)?;
        println!("  prepared in {:.2} s", t.elapsed().as_secs_f64());
        spent += t.elapsed().as_secs_f64();
        let report =
            trainer.run(&mut Watch { test: &test, geometry: geometry.clone(), before: spent })?;
        spent += report.seconds;
        println!("  {:.1} ms per step", 1e3 * report.seconds / report.steps as f64);
        previous = Some((trainer.into_surrogate(), geometry));
    }
    Ok(())
}

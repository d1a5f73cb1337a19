//! Calls of `docs/coming-from.md`, compiled and run; the page quotes this file.

use sinew::laws::{NeoHookean, NeoHookeanShape};
use sinew::output::Results;
use sinew::recipe::{DataDriven, PhysicsInformed, Regression};
use sinew::{
    Body, Design, Load, Options, Parameter, Recipe, Scene, Simulations, Solver, Support, TestSet,
    Train, TrainingOptions, simulate, sweep,
};
use sinew_emulate::Budget;
use sinew_energy::{Guard, Law, Magnitude, Mat3, Scalar};
use sinew_fem::{Line, cell_stresses, held_sets, reactions};
use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, Model, Noise, NutsOptions, Prior, Problem, Side,
    Smoothness, constant, laplace, matern, nuts, squared_exponential,
};
use sinew_graph::{AugmentationConfig, augment};
use sinew_mesh::{box_hexahedra, box_tetrahedra, edges, read_mesh, write_vtu};
use std::error::Error;
use std::path::{Path, PathBuf};

type Result = std::result::Result<(), Box<dyn Error>>;

/// Empty folder of a test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("coming-from").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("Cargo's folder for tests is writable");
    folder
}

#[test]
fn fenics() -> Result {
    let folder = folder("fenics");
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]);
    let path = folder.join("beam.vtu");
    write_vtu(&path, &mesh)?;
    let (mut mesh, _) = read_mesh::<4>(&path)?;
    mesh.name_facets("top", |x| x[2] == 10.0);
    mesh.name_nodes("x_min", |x| x[0] == 0.0);
    let fine = mesh.quadratic();
    assert!(fine.points.len() > 4 * mesh.points.len(), "nodes in the middle of edges");
    let scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"));
    let body = scene.lower()?;
    let theta = [75.0, 75.0];
    let mut solver = Solver::new(&body)?;
    let solution = solver.solve(&theta, &Options::default())?;
    let energy = body.value(&solution.displacement, &theta);
    assert!((energy + 766.970_681).abs() < 1e-6, "{energy}: FEniCS on the same mesh [kPa mm³]");

    let thetas = [vec![60.0, 60.0], vec![90.0, 90.0]];
    let solutions = sweep(&body, &thetas, &Options::default(), || ())?;
    let fields = solutions.into_iter().map(|s| s.map(|s| s.displacement));
    let fields = fields.collect::<std::result::Result<Vec<_>, _>>()?;
    let simulations = Simulations { thetas: thetas.to_vec(), fields, ..Simulations::default() };
    Results::of(&body, &thetas, &simulations).write(&folder, 2, true)?;
    assert!(folder.join("cases.pvd").exists(), "for ParaView");
    Ok(())
}

/// Compressible neo-Hookean law, `Ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)²`, as its energy alone.
#[derive(Clone, Copy, Debug)]
struct MyLaw;

impl Law<0> for MyLaw {
    const NAME: &'static str = "my law";
    const PARAMETERS: &'static [&'static str] = &["mu", "lambda"];

    fn density<S: Scalar, G: Guard>(
        &self,
        theta: &[S],
        h: &Mat3<S>,
        _: &[[S; 3]; 0],
        guard: &G,
    ) -> S {
        let [mu, lambda] = [0, 1].map(|entry| theta[entry].clone());
        let i1_minus_3 = guard.first_invariant(h.first_invariant_minus_three());
        let ln_j = guard.volume_change(h.volume_change()).ln_1p();
        mu.clone() * i1_minus_3 * 0.5 - mu * ln_j.clone() + lambda * ln_j.squared() * 0.5
    }
}

/// Moduli of both parameters of a compressible neo-Hookean body.
fn moduli(scene: Scene) -> Scene {
    scene.parameter(Parameter::log("mu", "kPa", 50.0..=100.0)).parameter(Parameter::log(
        "lambda",
        "kPa",
        50.0..=100.0,
    ))
}

#[test]
fn felupe() -> Result {
    // Uniaxial tension of a cube.
    let mesh = box_hexahedra([1.0, 1.0, 1.0], [3, 3, 3]);
    let scene = moduli(Scene::new(mesh, MyLaw))
        .support(Support::roller_on_plane("y_min", [0.0, 1.0, 0.0]))
        .support(Support::roller_on_plane("z_min", [0.0, 0.0, 1.0]))
        .support(Support::roller_on_plane("x_min", [1.0, 0.0, 0.0]))
        .support(Support::uniform("x_max", [Some(0.2), None, None]));
    let body = scene.lower()?;
    let theta = [75.0, 75.0];
    let mut solver = Solver::new(&body)?;
    let solution = solver.solve(&theta, &Options::default())?;
    let stresses = cell_stresses(&body, &solution.displacement, &theta)?;
    let [force, _, _] = reactions(&body, &solution.displacement, &[], &theta)?[0];
    assert_eq!(held_sets(&body).next().unwrap().0, "x_max");
    // Force is Cauchy stress times current area, J / λ₁ of the unit square.
    let area = stresses[0].volume_ratio / 1.2;
    assert!((force - stresses[0].cauchy[0][0] * area).abs() < 1e-9 * force);

    let mut loads = 0;
    for point in solver.follow(&Line::of_loads(&theta), &Options::default())? {
        point?;
        loads += 1;
    }
    assert!(loads > 2, "equilibria on the way");

    // A plate with clamped sides under pressure, nearly incompressible.
    let mesh = box_hexahedra([4.0, 4.0, 1.0], [4, 4, 2]);
    let scene = Scene::new(mesh, NeoHookeanShape.nearly_incompressible(5000.0))
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::linear("p", "kPa", 0.0..=0.5))
        .load(Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Theta(1) });
    let sides = ["x_min", "x_max", "y_min", "y_max"];
    let scene = sides.into_iter().fold(scene, |scene, side| scene.support(Support::clamped(side)));
    let locked = scene.lower()?;
    let body = scene.averaged().lower()?;
    let theta = [1.0, 0.1];
    let plate = Solver::new(&body)?.solve(&theta, &Options::default())?;
    let locked = Solver::new(&locked)?.solve(&theta, &Options::default())?;
    let [free, locked] =
        [&plate, &locked].map(|s| s.displacement.iter().fold(0.0, |m, u| u.max(m)));
    assert!(free > 1.5 * locked, "{free} mm, {locked} mm with volumetric locking");
    let cells = cell_stresses(&body, &plate.displacement, &theta)?;
    let mean = cells.iter().map(|cell| cell.volume_ratio).sum::<f64>() / cells.len() as f64;
    assert!((mean - 1.0).abs() < 1e-2, "mean volume ratio {mean}");
    Ok(())
}

#[test]
fn jax_fem() -> Result {
    let mesh = box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]);
    let scene = moduli(Scene::new(mesh, NeoHookean))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .load(Load::Traction { facets: "z_max".into(), value: [0.0, 0.0, -1e-2] })
        .load(Load::Foundation { facets: "z_min".into(), normal: 1e-3, tangential: 0.0 })
        .support(Support::clamped("x_min"));
    let body = scene.lower()?;
    let mut solver = Solver::new(&body)?;
    let theta = [60.0, 80.0];
    let solution = solver.solve(&theta, &Options::default())?;
    let near = solver.solve_from(&solution.displacement, &[60.6, 80.0], &Options::default())?;

    // Derivatives of the deflection of the tip by both moduli.
    let tip = 3 * scene.mesh.node_sets()["x_max"][0] + 2;
    let columns = solver.sensitivity(&solution)?;
    let mut slope = vec![0.0; 3 * body.nodes];
    slope[tip] = 1.0;
    let gradient = solver.adjoint_sensitivity(&solution, &slope)?;
    assert!((gradient[0] - columns[0][tip]).abs() < 1e-9 * gradient[0].abs());
    let difference = (near.displacement[tip] - solution.displacement[tip]) / 0.6;
    assert!((gradient[0] / difference - 1.0).abs() < 0.02, "a difference over 1 % of mu");

    // Over a path of loads, through limit points where there are any.
    let line = Line::of_theta([&[60.0, 80.0], &[50.0, 80.0]]);
    let curve =
        solver.follow(&line, &Options::default())?.collect::<std::result::Result<Vec<_>, _>>()?;
    let softest = curve.last().ok_or("a curve has an end")?;
    assert_eq!(softest.solution.theta, [50.0, 80.0]);
    Ok(())
}

/// Soft bar under its weight, with two parameters.
fn bar() -> std::result::Result<Body, Box<dyn Error>> {
    let scene = Scene::new(box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"));
    Ok(scene.lower()?)
}

#[test]
fn physicsnemo() -> Result {
    let mesh = box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]);
    let config = AugmentationConfig::for_nodes(mesh.points.len());
    let graph = augment(&mesh.points, &edges(&mesh), &config)?;
    assert!(!graph.roots_per_layer.is_empty(), "virtual nodes");

    let body = bar()?;
    let thetas = Design::LatinHypercube.sample(&body.parameters, 4, 99)?;
    let test = TestSet::new(&body, simulate(&body, &thetas, "test", None, &mut ())?);

    let run = folder("physicsnemo");
    let budget = Budget::Steps(20);
    let options = TrainingOptions { budget, held_out: 2, ..TrainingOptions::default() };
    let options = TrainingOptions { folder: Some(run.clone()), ..options };
    let mut recipe = DataDriven { simulations: 6, ..DataDriven::default() };
    recipe.network.message_passing_steps = 2;
    recipe.training.learning_rate = 4e-3;
    let recipe = Recipe::DataDriven(recipe);
    let emulator = recipe.train(&body, &options, &mut ())?;
    let found = emulator.evaluate(&test, 1)?;
    assert!(found.corrected[0].errors.err_u.q50 < found.raw.err_u.q50);

    let emulator = sinew::load(&run.join("emulator"), &body)?;
    let prediction = emulator.predict(&[vec![10.0, 12.0]])?;
    let estimate = emulator.estimate(&prediction, 0)?;
    let corrected = emulator.correct(&[10.0, 12.0], 1)?;
    assert!(corrected.estimate.residual < estimate.residual);

    let options = TrainingOptions { start: Some(run), folder: None, ..options };
    let fine_tuned = recipe.train(&body, &options, &mut ())?;
    let options = TrainingOptions { start: None, ..options };
    let informed = Recipe::PhysicsInformed(PhysicsInformed::default());
    let informed = informed.train(&body, &options, &mut ())?;
    let rival = Regression::default().train(&body, &TrainingOptions::default(), &mut ())?;
    let first = found.raw.err_u.q50;
    let tuned = fine_tuned.evaluate(&test, 0)?.raw.err_u.q50;
    let rival = rival.evaluate(&test, 0)?.raw.err_u.q50;
    let informed = informed.evaluate(&test, 3)?;
    let [raw, corrected] = [&informed.raw, &informed.corrected[2].errors].map(|e| e.err_u.q50);
    println!("mm: {first:.1e}, fine-tuned {tuned:.1e}, regression {rival:.1e}");
    println!("on energy {raw:.1e}, after three Newton steps {corrected:.1e}");
    assert!(tuned < 1.5 * first, "fine-tuning begins with the first network");
    assert!(rival < 1e-2 * first, "regression on few simulations");
    assert!(corrected < 1e-2 * raw, "Newton steps correct 20 steps of training");
    Ok(())
}

#[test]
fn gpytorch() -> Result {
    // A string under a load, u″ = −2 with both ends held, and rough deflections.
    let string = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = string.derivatives();
    let tension = sinew_gp::Parameter::new("tension", [0.1, 10.0])?;
    let held = || Condition::Dirichlet(constant(0.0));
    let problem = Problem::new(string.clone(), -(&tension * dx * dx))?
        .condition("x", Side::Lower, held())?
        .condition("x", Side::Upper, held())?;
    let x = string.sample(20, 1)?;
    let y: Vec<f64> =
        x.iter().enumerate().map(|(k, [x])| x * (1.0 - x) + 2e-3 * (k as f64).sin()).collect();
    let data = Data::new().values(&x, &y, Noise::Learned);
    let data = data.equation(&string.sample(10, 2)?, &[2.0; 10], Noise::Exact);

    let kernel = squared_exponential();
    let rough = matern(Smoothness::Twice);
    let both = squared_exponential().scaled() + rough.scaled();
    let prior = Prior::constrained(&problem, &kernel)?;
    let model = Model::new(prior, data.averaged(15), Evidence::Auto)?;
    let fit = model.fit(&FitOptions::default())?;
    let band = fit.predict(&[[0.5]])?;
    assert!((band.mean[0] - 0.25).abs() < 2e-3 && band.standard_deviation[0] < 2e-3);
    let slope = fit.ensemble()?.predict_operator(&dx.into(), &[[0.0]])?;
    assert!((slope.mean[0] - 1.0).abs() < 0.02);

    let ensemble = nuts(&fit, &NutsOptions::default())?;
    let [lower, upper] = ensemble.interval("tension", 0.95)?;
    assert!(lower < 1.0 && 1.0 < upper);
    let [lower, upper] = laplace(&fit, 300, 1)?.interval("tension", 0.95)?;
    assert!(lower < 1.0 && 1.0 < upper);

    let known = Data::new().values(&x, &y, Noise::Known(1.5e-3));
    let plain = Model::new(Prior::unconstrained(&problem, &both)?, known, Evidence::Auto)?;
    let plain = plain.fit(&FitOptions::default())?.conditional()?.mean(&[[0.5]])?;
    assert!((plain[0] - 0.25).abs() < 5e-3, "without the equation");
    Ok(())
}

/// Headings and rows of the page's tables: their call and ours.
fn rows(page: &str) -> Vec<(String, Vec<[String; 2]>)> {
    let mut found: Vec<(String, Vec<[String; 2]>)> = Vec::new();
    for line in page.lines() {
        if let Some(name) = line.strip_prefix("## ") {
            found.push((name.into(), Vec::new()));
        }
        let is_row = line.starts_with("| ") && line.contains("` | `");
        if let (true, Some((_, rows))) = (is_row, found.last_mut()) {
            let calls: Vec<&str> = line.split('`').skip(1).step_by(2).collect();
            let ours = calls.last().expect("a row has calls").replace("\\|", "|");
            rows.push([calls[0].into(), ours]);
        }
    }
    found
}

/// Code without what `rustfmt` decides.
fn bare(code: &str) -> String {
    let code: String = code.split_whitespace().collect();
    [")", "]", "}"].into_iter().fold(code, |code, end| code.replace(&format!(",{end}"), end))
}

#[test]
fn the_page_quotes_this_file() {
    let page = include_str!("../../docs/coming-from.md");
    let source = bare(include_str!("coming_from.rs"));
    let programs = rows(page);
    let names: Vec<&str> = programs.iter().map(|(name, _)| &**name).collect();
    assert_eq!(names, ["FEniCS", "FElupe", "JAX-FEM", "PhysicsNeMo", "GPyTorch"]);
    for (name, rows) in &programs {
        assert!(rows.len() >= 10, "{name} has {} rows", rows.len());
        for [theirs, ours] in rows {
            assert!(source.contains(&bare(ours)), "{name}, {theirs}: not in this file: {ours}");
        }
    }
}

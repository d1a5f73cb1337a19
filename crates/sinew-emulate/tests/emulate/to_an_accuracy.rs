//! Answers to an accuracy against solves.

use crate::ventricle_shape::VentricleShape;
use sinew_emulate::{
    Answer, Answers, Body, CaseErrors, Design, Emulator, Error, Errors, Method, Plan, Predictor,
    Record, Train, TrainingOptions, recipe::Taylor,
};
use sinew_energy::laws::{HolzapfelOgden, NeoHookean};
use sinew_energy::metrics::displacement_error;
use sinew_energy::{Law, Load, Magnitude, Parameter, Scene, Support};
use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
use sinew_fem::{FrozenStiffness, Options, Solver, sweep};
use sinew_mesh::{TruncatedEllipsoid, box_tetrahedra};
use std::path::Path;

/// A bar that bends far, over a decade of stiffness: the expansion alone is 30 % off at the soft end.
pub(crate) fn bar() -> Body {
    let stiffness = |name: &str| Parameter::log(name, "kPa", 10.0..=100.0);
    let scene = Scene::new(box_tetrahedra([60.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
        .parameter(stiffness("mu"))
        .parameter(stiffness("lambda"))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"));
    scene.lower().unwrap()
}

/// A left ventricle of a population, by as many of its 32 numbers as are not zero, under the pressure of its cavity.
fn ventricle(numbers: &[f64]) -> Body {
    let mesh = VentricleShape::new(numbers).unwrap().tetrahedra([1, 16, 6]).unwrap();
    let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
    let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY).unwrap();
    let pressure = Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(4) };
    let law = HolzapfelOgden.nearly_incompressible(25.0); // K [kPa]
    let fibres = frames.iter().map(|&[fibre, _, _]| [fibre]).collect();
    let scene = Scene::new(mesh, law.along(fibres))
        .parameter(Parameter::log("a", "kPa", 0.1..=0.26))
        .parameter(Parameter::log("b", "1", 1.0..=4.2))
        .parameter(Parameter::log("a_f", "kPa", 1.5..=5.18))
        .parameter(Parameter::log("b_f", "1", 1.0..=4.46))
        .parameter(Parameter::linear("p", "kPa", 0.53..=1.33)) // 4 to 10 mmHg
        .load(pressure)
        .support(Support::clamped("base"));
    scene.lower().unwrap()
}

/// Shapes of an unseen ventricle: larger and thinner than the mean, and the other way round.
const UNSEEN: [[f64; 7]; 2] =
    [[1.2, -0.4, -0.8, 0.5, -0.7, 0.9, 0.3], [-1.0, 0.8, 0.6, -0.9, 0.4, -0.5, 0.7]];

fn equilibrium(body: &Body, theta: &[f64]) -> Vec<f64> {
    Solver::new(body).unwrap().solve(theta, &Options::default()).unwrap().displacement
}

/// Mean nodal distance from the equilibrium, relative to the mean nodal displacement.
fn error(truth: &[f64], displacement: &[f64]) -> f64 {
    let sum = |other: &[f64]| displacement_error(truth, other).iter().sum::<f64>();
    sum(displacement) / sum(&vec![0.0; truth.len()])
}

/// [`error`] beside a solve.
pub(crate) fn true_error(body: &Body, theta: &[f64], displacement: &[f64]) -> f64 {
    error(&equilibrium(body, theta), displacement)
}

/// A ventricle that springs hold, base and all, under a pressure on its wall and on the lid over its base.
fn lidded() -> Body {
    let shape = TruncatedEllipsoid { short: [20.0, 30.0], long: [52.0, 62.0], base: 15.0 };
    let spring =
        |facets: &str| Load::Foundation { facets: facets.into(), normal: 0.2, tangential: 0.1 };
    let scene = Scene::new(shape.wall([1, 8, 4]).tetrahedra(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 10.0..=30.0))
        .parameter(Parameter::log("lambda", "kPa", 30.0..=90.0))
        .parameter(Parameter::linear("p", "kPa", 0.5..=2.0))
        .load(Load::CavityPressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
        .load(spring("epi"))
        .load(spring("base"));
    scene.lower().unwrap()
}

#[test]
fn every_answer_is_truly_within_its_tolerance() {
    within_tolerance(&bar(), 60, 10);
}

#[test]
fn answers_of_a_cavity_whose_lid_moves_are_within_their_tolerance() {
    within_tolerance(&lidded(), 20, 0);
}

/// Answers at `count` parameter sets, of which at least `least` need steps at a tolerance of 1 %.
fn within_tolerance(body: &Body, count: usize, least: usize) {
    let thetas = Design::LatinHypercube.sample(&body.parameters, count, 3).unwrap();
    let expansion = Emulator::taylor(body, 1).unwrap();
    let truths: Vec<_> = thetas.iter().map(|theta| equilibrium(body, theta)).collect();
    let raw = expansion.predict(&thetas).unwrap();
    let raw = truths.iter().enumerate().map(|(case, truth)| error(truth, raw.field(case)));
    let far = raw.filter(|error| *error > 1e-2).count();
    assert!(far >= least, "only {far} of {count} predictions need steps");
    for accuracy in [1e-2, 1e-4, 1e-8] {
        let found = Answers::to(body, &thetas, accuracy, Some(&expansion), &mut ()).unwrap();
        assert_eq!(found.answers.len(), thetas.len());
        for ((theta, truth), answer) in thetas.iter().zip(&truths).zip(&found.answers) {
            let answer = answer.as_ref().unwrap();
            let error = error(truth, &answer.displacement);
            // Two solves of one equilibrium differ by rounding errors.
            assert!(
                answer.is_within(accuracy) && error <= accuracy + 1e-10,
                "{theta:?}: {error:e}"
            );
        }
    }
}

/// Plan of so many parameter sets to a thousandth, by the first of them.
fn plan(body: &Body, thetas: &[Vec<f64>], emulator: Option<&Emulator<'_>>) -> Plan {
    let counts = [thetas.len()];
    let plans = Plan::for_counts(body, &thetas[0], &counts, 1e-3, emulator, &mut ());
    plans.unwrap().remove(0)
}

#[test]
fn a_plan_weighs_what_there_is() {
    let body = bar();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 1000, 1).unwrap();
    assert_eq!(plan(&body, &thetas[..1], None).method(), Method::Solver);
    let many = plan(&body, &thetas, None);
    assert_eq!((many.sets, many.costs.len()), (1000, 2));
    assert!(
        many.costs.windows(2).all(|pair| pair[0].newton_steps(1000) <= pair[1].newton_steps(1000))
    );
    let options = TrainingOptions { held_out: 4, ..TrainingOptions::default() };
    let trained = Taylor.train(&body, &options, &mut ()).unwrap();
    assert_eq!(plan(&body, &thetas[..1], Some(&trained)).method(), Method::Emulator);
}

#[test]
fn sets_without_an_equilibrium_are_told_and_the_others_answered() {
    let body = bar();
    let mut thetas = Design::LatinHypercube.sample(&body.parameters, 8, 1).unwrap();
    thetas[3] = vec![1e-9, 1e-9];
    let found = Answers::to(&body, &thetas, 1e-3, None, &mut ()).unwrap();
    assert!(found.answers[3].is_err(), "{:?}", found.answers[3]);
    let within = found.answers.iter().flatten().filter(|answer| answer.is_within(1e-3)).count();
    assert_eq!(within, 7);
}

#[test]
fn a_set_without_a_prediction_is_solved_and_spoils_no_other() {
    // A pressure over whose logarithm samples are taken may be zero, or pull.
    let scene = Scene::new(TruncatedEllipsoid::LAND.wall([1, 8, 4]).tetrahedra(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 5.0..=10.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=15.0))
        .parameter(Parameter::log("p", "kPa", 0.05..=0.5))
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
        .support(Support::clamped("base"));
    let body = scene.lower().unwrap();
    let mut thetas = Design::LatinHypercube.sample(&body.parameters, 9, 1).unwrap();
    (thetas[2][2], thetas[6][2]) = (-0.2, 0.0);
    let found = Answers::to(&body, &thetas, 1e-3, None, &mut ()).unwrap();
    assert_eq!(found.plan.method(), Method::Expansion);
    for (case, (theta, answer)) in thetas.iter().zip(&found.answers).enumerate() {
        let answer = answer.as_ref().unwrap();
        if case == 6 {
            assert!(answer.displacement.iter().all(|u| u.abs() < 1e-9));
        } else {
            assert!(true_error(&body, theta, &answer.displacement) <= 1e-3, "{case}");
        }
    }
}

#[test]
fn answers_on_another_branch_than_that_of_a_rising_load_are_marked() {
    // A column beyond the load at which it buckles, to the side on which the lid presses.
    let column = Scene::new(box_tetrahedra([20.0, 4.0, 4.0], [8, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 2.0..=50.0))
        .parameter(Parameter::log("lambda", "kPa", 10.0..=50.0))
        .parameter(Parameter::linear("q", "kPa", -0.02..=0.05))
        .load(Load::Traction { facets: "x_max".into(), value: [-0.9, 0.0, 0.0] })
        .load(Load::CavityPressure { facets: "z_min".into(), magnitude: Magnitude::Theta(2) })
        .support(Support::clamped("x_min"));
    let body = column.lower().unwrap();
    let sides = [-0.02, -0.01, 0.01, 0.02];
    let thetas: Vec<Vec<f64>> =
        [3.0, 6.0, 12.0].iter().flat_map(|&mu| sides.map(|q| vec![mu, 20.0, q])).collect();
    let found = Answers::to(&body, &thetas, 1e-3, None, &mut ()).unwrap();
    let (mut solver, options) = (Solver::new(&body).unwrap(), Options::default());
    let mut elsewhere = 0;
    for (theta, answer) in thetas.iter().zip(&found.answers) {
        let answer = answer.as_ref().unwrap();
        let there = solver.solve_from(&answer.displacement, theta, &options).unwrap();
        if solver.under_rising_load(&there, &options, &mut |_| ()).unwrap().is_some() {
            elsewhere += 1;
            assert!(answer.has_jumped(), "{theta:?}");
        }
    }
    assert!(elsewhere > 0, "no answer is on another branch");
}

#[test]
fn a_tolerance_that_makes_no_sense_is_refused() {
    let body = bar();
    for accuracy in [0.0, -1.0, f64::NAN, 1e-12, 0.9] {
        let refused = Answers::to(&body, &[vec![20.0, 20.0]], accuracy, None, &mut ());
        assert!(matches!(refused, Err(Error::Setting { .. })), "{accuracy}");
    }
}

#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let body = bar();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 30, 5).unwrap();
    let emulator = Emulator::taylor(&body, 1).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| Answers::to(&body, &thetas, 1e-4, Some(&emulator), &mut ()));
        let answers = found.unwrap().answers;
        answers.into_iter().map(|answer| answer.unwrap().displacement).collect::<Vec<_>>()
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn an_unseen_ventricle_is_answered_from_the_stiffness_of_another() {
    let mean = ventricle(&[]);
    let known = FrozenStiffness::new(&mean).unwrap();
    for numbers in UNSEEN {
        let body = ventricle(&numbers);
        let emulator = Emulator::frozen_stiffness(&body, &known).unwrap();
        let thetas = Design::LatinHypercube.sample(&body.parameters, 100, 7).unwrap();
        let solved = sweep(&body, &thetas, &Options::default(), || ()).unwrap();
        let truths: Vec<_> = solved.into_iter().map(Result::unwrap).collect();
        let solver: usize = truths.iter().map(|truth| truth.iterations()).sum();
        for accuracy in [1e-2, 1e-3, 1e-4] {
            let found = Answers::to(&body, &thetas, accuracy, Some(&emulator), &mut ()).unwrap();
            let answers: Vec<Answer> = found.answers.into_iter().map(Result::unwrap).collect();
            let errors = answers.iter().zip(&truths);
            let errors = errors.map(|(a, truth)| error(&truth.displacement, &a.displacement));
            let largest = errors.fold(0.0, f64::max);
            assert!(answers.iter().all(|answer| answer.is_within(accuracy)));
            assert!(largest <= accuracy, "{largest:e} for {accuracy:e}");
            let steps: usize = answers.iter().map(|answer| answer.steps).sum();
            println!(
                "{accuracy:e}: {largest:.1e}, {steps} Newton steps for {solver}, {:?}",
                found.plan
            );
            assert!(steps as f64 <= 0.65 * solver as f64, "{steps} Newton steps for {solver}");
        }
        // The solve at its centre begins nearer than rest.
        let own = plan(&body, &thetas, None);
        let from = plan(&body, &thetas, Some(&emulator));
        let prepare = |plan: &Plan| {
            plan.costs.iter().find(|cost| cost.method == Method::Expansion).unwrap().prepare
        };
        assert!(prepare(&from) <= prepare(&own), "{} {}", prepare(&from), prepare(&own));
    }
}

#[test]
fn another_body_that_does_not_fit_is_refused() {
    let (mean, bar) = (ventricle(&[]), bar());
    let known = FrozenStiffness::new(&mean).unwrap();
    let refused = Emulator::frozen_stiffness(&bar, &known).err().unwrap();
    assert!(matches!(refused, Error::Solve(sinew_fem::SolveError::OtherBody { .. })), "{refused}");
    let folder = Path::new("never written");
    let own = Emulator::frozen_stiffness(&mean, &known).unwrap();
    assert!(own.save(folder).unwrap_err().to_string().contains("is not stored"));
}

/// The wall between two ellipsoids; the shorter diagonals of its surface, along which its cells are cut, change with the axes.
fn chamber([short, long, thickness]: [f64; 3]) -> Body {
    let [short, long] = [short, long].map(|inner| [inner, inner + thickness]);
    let mesh = TruncatedEllipsoid { short, long, base: 0.0 }.wall([1, 16, 8]).tetrahedra();
    Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=20.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=20.0))
        .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(0.8) })
        .support(Support::clamped("base"))
        .lower()
        .unwrap()
}

#[test]
fn an_ellipsoid_is_answered_from_one_whose_cells_are_cut_along_other_diagonals() {
    let known = chamber([22.0, 50.0, 10.0]);
    let frozen = FrozenStiffness::new(&known).unwrap();
    let mut other_cells = 0;
    for axes in [[22.0, 40.0, 10.0], [24.0, 60.0, 9.0], [18.0, 70.0, 12.0], [30.0, 45.0, 10.0]] {
        let body = chamber(axes);
        other_cells += usize::from(body.cells != known.cells);
        let emulator = Emulator::frozen_stiffness(&body, &frozen).unwrap();
        for theta in Design::LatinHypercube.sample(&body.parameters, 5, 3).unwrap() {
            let answer = emulator.answer(&theta, 1e-3).unwrap();
            let error = true_error(&body, &theta, &answer.displacement);
            assert!(answer.is_within(1e-3) && error <= 1e-3, "{axes:?}: {error:e}");
        }
    }
    assert!(other_cells > 0);
    let renumbered = |mut mesh: sinew_mesh::TetMesh| {
        let (count, points) = (mesh.points.len(), mesh.points.clone());
        let other = |node: usize| 7 * node % count; // 60 nodes
        mesh.cells.iter_mut().flatten().for_each(|node| *node = other(*node));
        (0..count).for_each(|node| mesh.points[other(node)] = points[node]);
        mesh.facet_sets.clear();
        mesh
    };
    let scene = |mesh| {
        Scene::new(mesh, NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 10.0..=100.0))
            .parameter(Parameter::log("lambda", "kPa", 10.0..=100.0))
            .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
            .support(Support::clamped("held"))
    };
    let bar = |turn: bool| {
        let mesh = box_tetrahedra([30.0, 20.0, 10.0], [4, 3, 2]);
        let mut mesh = if turn { renumbered(mesh) } else { mesh };
        let held = (0..mesh.points.len()).filter(|&node| mesh.points[node][0] == 0.0).collect();
        mesh.node_sets.insert("held".into(), held);
        scene(mesh).lower().unwrap()
    };
    // Other numbers of the nodes are another mesh.
    let (plain, turned) = (bar(false), bar(true));
    let plain = FrozenStiffness::new(&plain).unwrap();
    assert!(Emulator::frozen_stiffness(&turned, &plain).is_err());
}

/// A predictor that is wrong: the solution of other parameters, times a factor.
#[derive(Debug)]
pub(crate) struct Wrong(pub(crate) Vec<f64>, pub(crate) f64);

impl Predictor for Wrong {
    fn kind(&self) -> &'static str {
        "wrong"
    }
    fn predict(&self, _: &Body, thetas: &[Vec<f64>]) -> Result<Vec<f64>, Error> {
        Ok(thetas.iter().flat_map(|_| self.0.iter().map(|u| u * self.1)).collect())
    }
    fn save(&self, _: &Path) -> Result<(), Error> {
        Ok(())
    }
}

/// A few parameter sets with the Newton steps of their solves from rest.
fn solved_from_rest(body: &Body) -> Vec<(Vec<f64>, f64)> {
    let thetas = Design::LatinHypercube.sample(&body.parameters, 8, 11).unwrap();
    let mut solver = Solver::new(body).unwrap();
    let mut steps =
        |theta: &[f64]| solver.solve(theta, &Options::default()).unwrap().iterations() as f64;
    thetas.into_iter().map(|theta| (theta.clone(), steps(&theta))).collect()
}

/// Newton steps of single answers by an emulator, each beside those of a solve from rest.
fn single<'b>(
    (body, solves): (&'b Body, &[(Vec<f64>, f64)]),
    emulator: Option<&Emulator<'b>>,
    own: f64,
    told: &str,
) -> [f64; 2] {
    let (mut sums, mut over) = ([0.0; 2], 0);
    for (theta, solved) in solves {
        for accuracy in [1e-2, 1e-4, 1e-6] {
            let one = std::slice::from_ref(theta);
            let found = Answers::to(body, one, accuracy, emulator, &mut ()).unwrap();
            let answer = found.answers.into_iter().next().unwrap().unwrap();
            assert!(answer.is_within(accuracy));
            let steps = own + answer.steps as f64;
            // A whole step more where 20 % of a solve are less than one.
            if steps > (1.2 * *solved).ceil() {
                println!("{told}, {accuracy:e}: {steps} Newton steps for {solved}");
                over += 1;
            }
            sums = [sums[0] + steps, sums[1] + solved];
        }
    }
    assert_eq!(over, 0, "{told}");
    sums
}

#[test]
fn one_set_takes_no_more_newton_steps_than_a_solve() {
    let (bar, unseen, mean) = (bar(), ventricle(&UNSEEN[0]), ventricle(&[]));
    let known = FrozenStiffness::new(&mean).unwrap();
    // 16 quasi-Newton steps, a gradient and a back-substitution each, cost as much as 2.4 Newton steps.
    let emulator = Emulator::frozen_stiffness(&unseen, &known).unwrap();
    let [of_bar, of_unseen] = [&bar, &unseen].map(solved_from_rest);
    let frozen = single((&unseen, &of_unseen), Some(&emulator), 2.4, "frozen stiffness");
    println!("frozen stiffness: {frozen:?}");
    assert!(frozen[0] <= frozen[1]);
    for (body, solves) in [(&bar, of_bar), (&unseen, of_unseen)] {
        let single =
            |emulator: Option<&_>, told: &str| single((body, &solves), emulator, 0.0, told);
        let none = single(None, "no emulator");
        assert_eq!(none[0], none[1]);
        let taylor = Emulator::taylor(body, 1).unwrap();
        let [steps, solved] = single(Some(&taylor), "expansion");
        println!("expansion: {steps} for {solved}");
        assert!(steps <= 0.6 * solved, "{steps} for {solved}");
        let centre = taylor.predict(&[body.centre()]).unwrap().displacement;
        for factor in [-1.0, 0.0, 0.3, 0.8, 1.3, 2.0, 10.0] {
            let wrong = Box::new(Wrong(centre.clone(), factor));
            let emulator = Emulator::new(body, wrong, Record::new("wrong"));
            let [steps, solved] = single(Some(&emulator), &format!("{factor} x centre"));
            println!("{factor} x centre: {steps} for {solved}");
            assert!(steps <= 1.2 * solved, "{factor}: {steps} Newton steps for {solved}");
        }
    }
}

#[test]
fn many_sets_grow_a_regression_whose_answers_are_truly_within_their_tolerance() {
    let body = ventricle(&[]);
    let thetas = Design::LatinHypercube.sample(&body.parameters, 3300, 13).unwrap();
    // Every tenth is solved: they are spread as all are.
    let places: Vec<usize> = (0..thetas.len()).step_by(10).collect();
    let some: Vec<_> = places.iter().map(|&place| thetas[place].clone()).collect();
    let truths = sweep(&body, &some, &Options::default(), || ()).unwrap();
    for accuracy in [1e-2, 1e-4] {
        let found = Answers::to(&body, &thetas, accuracy, None, &mut ()).unwrap();
        let answers: Vec<Answer> = found.answers.into_iter().map(Result::unwrap).collect();
        assert!(answers.iter().all(|answer| answer.is_within(accuracy)));
        let error = |(&place, truth): (&usize, &Result<sinew_fem::Solution, _>)| {
            error(&truth.as_ref().unwrap().displacement, &answers[place].displacement)
        };
        let largest = places.iter().zip(&truths).map(error).fold(0.0, f64::max);
        assert!(largest <= accuracy, "{largest:e} for {accuracy:e}");
        let count = |method| answers.iter().filter(|answer| answer.method == method).count();
        let (learned, solved) = (count(Method::Regression), count(Method::Solver));
        let steps: usize = answers.iter().map(|answer| answer.steps).sum();
        println!(
            "{accuracy:e}: {largest:.1e}, {learned} by regression, {solved} solved, {steps} Newton steps"
        );
        // The first hundred come from the expansion.
        assert!(learned >= 3000 && solved <= 10, "{learned} {solved}");
    }
}

#[test]
fn a_record_of_errors_beyond_all_numbers_is_read_again() {
    // Predictions that invert cells: each energy is as far off as numbers go, and their sum farther.
    let case = CaseErrors {
        err_u: vec![f64::NAN],
        err_f: vec![f64::INFINITY],
        err_i1: vec![1.0],
        err_pi: f64::MAX,
        err_volume: Vec::new(),
        relative: f64::MAX,
        inverted: true,
        energy_excess: f64::MAX,
    };
    let mut record = Record::new("taylor");
    record.held_out = Some(Errors::of(&[case.clone(), case]));
    let text = serde_json::to_string(&record).unwrap();
    assert_eq!(serde_json::from_str::<Record>(&text).unwrap(), record);
}

//! Scenes: what lowers, what is refused, and what the metrics say.

use sinew_energy::laws::{Guccione, HolzapfelOgden, NeoHookean, Penalty};
use sinew_energy::{
    Barriers, Body, Fibres, Guard, Invariants, Law, Load, Magnitude, Parameter, Prescribed,
    Sampling, Scene, SceneError, ShapeEnergy, Solid, Support, ThetaError, metrics,
};
use sinew_mesh::{TetMesh, box_tetrahedra};
use sinew_num::Scalar;

fn parameter(name: &str) -> Parameter {
    Parameter { name: name.into(), unit: "kPa".into(), range: [1.0, 2.0], sampling: Sampling::Log }
}

fn block() -> Scene {
    block_of(box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]))
}

fn block_of(mesh: TetMesh) -> Scene {
    Scene {
        name: "block".into(),
        parameters: vec![parameter("mu"), parameter("lambda")],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, NeoHookean)
    }
}

/// The block on a mesh that is changed first.
fn block_on(change: impl FnOnce(&mut TetMesh)) -> Scene {
    let mut mesh = box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]);
    change(&mut mesh);
    block_of(mesh)
}

fn refused_on(change: impl FnOnce(&mut TetMesh)) -> SceneError {
    block_on(change).lower().expect_err("the mesh is wrong")
}

fn refused(change: impl FnOnce(&mut Scene)) -> SceneError {
    let mut scene = block();
    change(&mut scene);
    scene.lower().expect_err("the scene is wrong")
}

#[test]
fn dead_loads_add_up() {
    let mut scene = block();
    let traction = Load::Traction { facets: "x_max".into(), value: [0.0, 3.0, 0.0] };
    scene.loads = vec![Load::BodyForce([0.0, 0.0, -0.5]), traction];
    let potential = scene.lower().unwrap();
    let total = |axis: usize| potential.nodal_force.iter().skip(axis).step_by(3).sum::<f64>();
    assert!((total(0)).abs() < 1e-14);
    assert!((total(1) - 3.0 * 2.0).abs() < 1e-13);
    assert!((total(2) + 0.5 * 6.0).abs() < 1e-13);
    // A uniform displacement does the work force · displacement and strains nothing.
    let lifted: Vec<f64> = (0..potential.nodes).flat_map(|_| [0.0, 0.0, 0.1]).collect();
    let energy = potential.value(&lifted, &[1.0, 1.0]);
    assert!((energy - 0.1 * 3.0).abs() < 1e-13);
}

#[test]
fn forces_on_nodes_add_to_the_others_and_stay_when_the_body_is_moved() {
    let mut scene = block();
    let mut forces = vec![[0.0; 3]; 36];
    forces[35] = [0.0, 2.0, -1.0];
    scene.loads = vec![Load::BodyForce([0.0, 0.0, -0.5]), Load::NodalForces(forces.clone())];
    scene.loads.push(Load::NodalForces(forces));
    let body = scene.lower().unwrap();
    let total = |body: &Body, axis| body.nodal_force.iter().skip(axis).step_by(3).sum::<f64>();
    assert!((total(&body, 1) - 4.0).abs() < 1e-13);
    assert!((total(&body, 2) + 2.0 + 0.5 * 6.0).abs() < 1e-13);
    let twice_as_long: Vec<f64> = body.positions.iter().flat_map(|x| [x[0], 0.0, 0.0]).collect();
    let longer = body.moved(&twice_as_long, Fibres::Carried).unwrap();
    assert!((total(&longer, 1) - 4.0).abs() < 1e-13);
    assert!((total(&longer, 2) + 2.0 + 0.5 * 12.0).abs() < 1e-13);

    let few = refused(|s| s.loads = vec![Load::NodalForces(vec![[0.0; 3]; 35])]);
    assert_eq!(
        few,
        SceneError::Body(
            "the load lists forces on 35 nodes, but the mesh has 36; give one per node".into()
        )
    );
    let odd = refused(|s| s.loads = vec![Load::NodalForces(vec![[f64::NAN; 3]; 36])]);
    assert!(matches!(odd, SceneError::NotFinite { .. }));
}

#[test]
fn followers_read_the_pressure_and_a_balance_a_compliance_that_makes_sense() {
    let magnitude = Magnitude::Theta(2);
    let mut scene = block();
    scene.loads = vec![Load::Pressure { facets: "z_max".into(), magnitude }];
    scene.parameters.push(parameter("p"));
    let follower = scene.loose_rims().lower().unwrap();
    assert!(!follower.has_potential() && follower.theta_len() == 3);
    // Followers read the pressure wherever θ lists it.
    let magnitude = |body: Body| body.followers[0].magnitude;
    let known = |name: &str| magnitude(follower.clone().with_known(&[(name, 1.0)]).unwrap());
    assert_eq!((known("mu"), known("p")), (Magnitude::Theta(1), Magnitude::Fixed(1.0)));

    let mixed = Scene::new(box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]).quadratic(), NeoHookean)
        .parameter(parameter("mu"))
        .parameter(parameter("lambda"))
        .support(Support::clamped("x_min"));
    for (compliance, accepted) in [(0.0, true), (0.1, true), (-1.0, false), (f64::NAN, false)] {
        let found = mixed.clone().mixed().lower().unwrap().with_compliance(compliance);
        assert_eq!(found.is_ok(), accepted, "{compliance}");
    }
}

#[test]
fn gradient_is_the_derivative_of_the_value() {
    let mut scene = block();
    scene.loads = vec![Load::BodyForce([0.1, 0.0, -0.5])];
    let potential = scene.lower().unwrap();
    let theta = [1.5, 2.5];
    let u: Vec<f64> = (0..3 * potential.nodes).map(|i| 0.05 * (i as f64 * 1.7).sin()).collect();
    let mut gradient = vec![f64::NAN; u.len()];
    let value = potential.value_and_gradient(&u, &theta, &mut gradient);
    assert!((value - potential.value(&u, &theta)).abs() < 1e-13 * value.abs());
    // A central difference with a step that balances rounding and truncation.
    let step = 1e-5;
    for entry in (0..u.len()).step_by(7) {
        let at = |sign: f64| {
            let mut shifted = u.clone();
            shifted[entry] += sign * step;
            potential.value(&shifted, &theta)
        };
        let slope = (at(1.0) - at(-1.0)) / (2.0 * step);
        assert!((slope - gradient[entry]).abs() < 1e-8, "{entry}");
    }
}

#[test]
fn uniform_strain_is_exact_on_any_mesh() {
    // Distort the inside: the displacement gradient of a linear field must not notice.
    let scene = block_on(|mesh| {
        for (node, point) in mesh.points.iter_mut().enumerate() {
            point[1] += 0.05 * (node as f64).sin();
        }
    });
    let potential = scene.lower().unwrap();
    let h = [[0.1, -0.2, 0.05], [0.3, 0.2, -0.1], [0.02, 0.4, -0.15]];
    let row = |x: &[f64; 3], i: usize| (0..3).map(|j| h[i][j] * x[j]).sum::<f64>();
    let linear = |x: &[f64; 3]| [row(x, 0), row(x, 1), row(x, 2)];
    let u: Vec<f64> = scene.mesh.points().iter().flat_map(linear).collect();
    for cell in 0..potential.cell_count() {
        let found = potential.displacement_gradient(cell, &u);
        for (found, expected) in found.0.as_flattened().iter().zip(h.as_flattened()) {
            assert!((found - expected).abs() < 1e-13);
        }
    }
    // One density everywhere, and no force on inner nodes: the patch test.
    let mut gradient = vec![0.0; u.len()];
    potential.value_and_gradient(&u, &[1.5, 2.5], &mut gradient);
    let mesh = &scene.mesh;
    let outside: Vec<usize> = mesh.node_sets().values().flatten().copied().collect();
    let inner: Vec<usize> = (0..potential.nodes).filter(|node| !outside.contains(node)).collect();
    assert!(!inner.is_empty());
    for node in inner {
        assert!(gradient[3 * node..][..3].iter().all(|g| g.abs() < 1e-12));
    }
}

#[test]
fn supports_prescribe_what_they_say() {
    let mut scene = block();
    let mesh = box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]);
    let pushed = Support::moved("x_max", &mesh, |[_, y, _]| [0.1, -0.01 * y, 0.0]);
    let roller = Support::uniform("z_min", [None, None, Some(0.0)]);
    scene.supports.extend([pushed, roller]);
    let potential = scene.lower().unwrap();
    let free = potential.free_degrees_of_freedom();
    // Both ends of nine nodes each, and the height of the six nodes between them at the bottom.
    assert_eq!(free.len(), 3 * 36 - 2 * 27 - 6);
    assert!(free.is_sorted());
    for &node in &mesh.node_sets["x_max"] {
        assert_eq!(potential.prescribed[3 * node], Some(0.1));
        assert_eq!(potential.prescribed[3 * node + 1], Some(-0.01 * mesh.points[node][1]));
    }
}

#[test]
fn wrong_scenes_are_refused_with_advice() {
    assert_eq!(
        refused_on(|mesh| *mesh = TetMesh::default()),
        SceneError::Body("the mesh has no cells; read or generate one that has".into())
    );
    assert!(matches!(refused_on(|mesh| mesh.cells[2][1] = 999), SceneError::Mesh(_)));
    let inverted = refused_on(|mesh| mesh.cells[2].swap(0, 1));
    assert!(inverted.to_string().starts_with("cell 2 has the volume -"), "{inverted}");

    let unknown = refused(|s| s.supports = vec![Support::clamped("left")]);
    assert!(unknown.to_string().contains("x_min"), "{unknown}");
    let load = |name: &str| Load::Traction { facets: name.into(), value: [1.0; 3] };
    let unknown = refused(|s| s.loads = vec![load("bottom")]);
    assert!(unknown.to_string().contains("z_min"), "{unknown}");
    let empty = refused(|s| {
        s.mesh.facet_sets_mut().insert("none".into(), vec![]);
        s.loads = vec![load("none")];
    });
    assert_eq!(empty, SceneError::Loads("facet set `none` is empty, so its load acts on nothing; remove the load or name the facets".into()));
    let infinite = refused(|s| s.loads = vec![Load::BodyForce([0.0, f64::NAN, 0.0])]);
    assert!(matches!(infinite, SceneError::NotFinite { .. }));

    let free = refused(|s| s.supports.clear());
    assert_eq!(free, SceneError::Supports("no support holds the body along x, y, z: it is free to move there and has no unique equilibrium; add a support that holds it there".into()));
    let slides = Support::uniform("x_min", [Some(0.0), None, Some(0.0)]);
    let free = refused(|s| s.supports = vec![slides]);
    assert_eq!(free, SceneError::Supports("no support holds the body along y: it is free to move there and has no unique equilibrium; add a support that holds it there".into()));
    let twice = refused(|s| s.supports.push(Support::uniform("z_min", [Some(1.0), None, None])));
    let both =
        "prescribes 1 along (1, 0, 0) for node 0, but it is held at 0 there by those of x_min";
    assert!(twice.to_string().contains(both), "{twice}");
    let short = Support { nodes: "x_max".into(), displacement: Prescribed::PerNode(vec![]) };
    let short = refused(|s| s.supports.push(short));
    assert!(short.to_string().contains("lists 0 displacements for 9 nodes"), "{short}");
    let loose = refused_on(|mesh| mesh.points.push([9.0; 3]));
    assert_eq!(loose, SceneError::Supports("1 nodes belong to no cell (first: node 36) and are not held; remove them from the mesh".into()));

    let count = refused(|s| s.parameters.truncate(1));
    assert!(
        count
            .to_string()
            .contains("lists 1 parameters, but the law reads mu, lambda and the loads 0 more"),
        "{count}"
    );
    let pressure =
        |index| Load::ThesisPressure { facets: "x_max".into(), magnitude: Magnitude::Theta(index) };
    let taken = refused(|s| s.loads = vec![pressure(1)]);
    assert_eq!(
        taken,
        SceneError::Parameters(
            "a load reads entry 1 of theta, but all 2 parameters belong to the law; list one for the load after them, which becomes entry 2"
                .into()
        )
    );
    let unused = refused(|s| s.parameters.push(parameter("p")));
    assert!(
        unused
            .to_string()
            .contains("lists 3 parameters, but the law reads mu, lambda and the loads 0 more"),
        "{unused}"
    );
    let linear = block().mixed().lower().unwrap_err();
    assert_eq!(linear, SceneError::Body("mixed elements have quadratic tetrahedra or triangles, but the mesh is made of tetrahedra; make it quadratic".into()));
    let log_of_zero = refused(|s| s.parameters[0].range = [0.0, 1.0]);
    assert!(matches!(log_of_zero, SceneError::Range { .. }));
}

#[test]
fn parameters_stand_in_the_order_of_the_law_and_by_its_names() {
    let listed = |names: &[&str]| {
        refused(|scene| scene.parameters = names.iter().map(|name| parameter(name)).collect())
    };
    let swapped = listed(&["lambda", "mu"]);
    assert_eq!(
        swapped,
        SceneError::Body(
            "the law reads mu, lambda in this order, but the scene lists lambda, mu; list the law's parameters first, in its order and by its names"
                .into()
        )
    );
    assert!(listed(&["mu", "stiffness"]).to_string().contains("the scene lists mu, stiffness"));
    assert_eq!(listed(&["mu", "mu"]), SceneError::Loads("the scene lists two parameters `mu`; law and loads read entries of theta of their own: rename one".into()));
    let taken = refused(|scene| {
        scene.parameters.push(parameter("mu"));
        let facets = "x_max".into();
        scene.loads = vec![Load::Pressure { facets, magnitude: Magnitude::Theta(2) }];
    });
    assert_eq!(taken, SceneError::Loads("the scene lists two parameters `mu`; law and loads read entries of theta of their own: rename one".into()));
}

#[test]
fn directions_must_be_unit_vectors() {
    let Scene { name, units, mesh, supports, .. } = block();
    let law = HolzapfelOgden.nearly_incompressible(10.0);
    let mut fibres = vec![[[1.0, 0.0, 0.0]]; mesh.cell_count()];
    let mut scene = Scene {
        name,
        units,
        parameters: ["a", "b", "a_f", "b_f"].map(parameter).into(),
        supports,
        ..Scene::new(mesh, law.along(fibres.clone()))
    };
    assert!(scene.lower().is_ok());
    for wrong in [[0.0; 3], [2.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0]] {
        fibres[5] = [wrong];
        scene.material = law.along(fibres.clone());
        let error = scene.lower().expect_err("not a unit vector");
        assert!(error.to_string().starts_with("direction 0 of cell 5 has length"), "{error}");
    }
    fibres.pop();
    scene.material = law.along(fibres);
    let few = scene.lower().unwrap_err().to_string();
    assert!(few.starts_with("the law reads 1 directions"), "{few}");
}

#[test]
fn nodal_directions_are_independent_of_the_numbering_of_nodes() {
    let names = ["a", "b", "a_f", "b_f"].map(parameter);
    // The cells of a cube have a node with none, one, two and three coordinates 1.
    let lowered = |directions: [[f64; 3]; 4], order: [usize; 4]| {
        let mut mesh = box_tetrahedra([1.0; 3], [1; 3]);
        mesh.cells.iter_mut().for_each(|cell| *cell = order.map(|node| cell[node]));
        let of = |x: &[f64; 3]| [directions[x.iter().sum::<f64>() as usize]];
        let law = HolzapfelOgden.nearly_incompressible(25.0);
        let material = law.along(mesh.points.iter().map(of).collect());
        let scene = Scene::new(mesh, material).support(Support::clamped("x_min"));
        names.iter().cloned().fold(scene, Scene::parameter).lower()
    };
    let energy = |directions, order| {
        let body = lowered(directions, order).unwrap();
        let moved =
            body.positions.iter().flat_map(|x| [0.3 * x[0] * x[1], -0.1 * x[1], 0.2 * x[0]]);
        body.value(&moved.collect::<Vec<_>>(), &[1.0, 1.0, 4.0, 2.0])
    };
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let own = [0, 1, 2, 3];
    for directions in
        [[y, x, x, x.map(|x| -x)], [x, y, z, x], [x, [-0.6, 0.8, 0.0], y, [0.0, 0.8, -0.6]]]
    {
        let expected = energy(directions, own);
        for order in [[1, 2, 0, 3], [3, 2, 1, 0], [2, 3, 0, 1]] {
            let found = energy(directions, order);
            assert!((found / expected - 1.0).abs() < 1e-14, "{order:?}: {found} and {expected}");
        }
    }
    let alike = energy([x; 4], own);
    assert_eq!(energy([x, x, y, x], own), alike, "right angles count nothing in either sense");
    let error = lowered([x, y, y, x], own).unwrap_err().to_string();
    assert!(error.starts_with("nothing determines direction 0 of cell 0"), "{error}");
}

/// Resists strain along its second direction only.
#[derive(Clone, Debug)]
struct AlongSheets;

impl ShapeEnergy<3> for AlongSheets {
    const NAME: &'static str = "along sheets";
    const PARAMETERS: &'static [&'static str] = &["C"];

    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, 3>, _: &G) -> S {
        theta[0].clone() * i.strain[1][1].clone().squared()
    }
}

#[test]
fn sheets_that_nothing_determines_are_refused_where_the_law_reads_them() {
    fn lowered<L: Law<3>>(law: L, names: &[&str]) -> Result<Body, SceneError> {
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = box_tetrahedra([1.0; 3], [1; 3]);
        let of = |at: &[f64; 3]| if at.iter().sum::<f64>() < 1.5 { [x, y, z] } else { [x, z, y] };
        let material = law.along(mesh.points.iter().map(of).collect());
        let scene = Scene::new(mesh, material).support(Support::clamped("x_min"));
        names.iter().map(|name| parameter(name)).fold(scene, Scene::parameter).lower()
    }
    let error = lowered(Solid::new(AlongSheets, Penalty { bulk_modulus: 25.0 }), &["C"])
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("nothing determines direction 1 of cell 0"), "{error}");
    let guccione = ["C", "b_f", "b_t", "b_fs"];
    assert!(lowered(Guccione.nearly_incompressible(25.0), &guccione).is_ok());
}

#[test]
fn theta_is_checked() {
    let potential = block().lower().unwrap();
    assert_eq!(potential.check_theta(&[1.0, 0.0]), Ok(()));
    let length = potential.check_theta(&[1.0]).unwrap_err();
    assert!(matches!(length, ThetaError::Length { given: 1, needed: 2, .. }));
    for wrong in [[-1.0, 1.0], [f64::NAN, 1.0], [0.0, 1.0], [f64::INFINITY, 1.0]] {
        let error = potential.check_theta(&wrong).unwrap_err();
        assert!(matches!(error, ThetaError::OutOfBounds { index: 0, name: "mu", .. }));
    }
}

#[test]
fn guards_keep_a_tangled_body_finite() {
    let potential = block().lower().unwrap();
    let theta = [1.0, 1.0];
    let wild: Vec<f64> = (0..3 * potential.nodes).map(|i| 5.0 * (i as f64).sin()).collect();
    let mut gradient = vec![0.0; wild.len()];
    assert_eq!(potential.value(&wild, &theta), f64::INFINITY);
    assert_eq!(potential.value_and_gradient(&wild, &theta, &mut gradient), f64::INFINITY);
    assert!(gradient.iter().all(|g| !g.is_nan()));
    let guarded = potential.with_barriers(Barriers::default());
    assert!(guarded.value_and_gradient(&wild, &theta, &mut gradient).is_finite());
    assert!(gradient.iter().all(|g| g.is_finite()));
}

#[test]
fn a_state_that_only_guards_bound_is_not_within_them() {
    let tissue = HolzapfelOgden.nearly_incompressible(25.0).along(vec![[[1.0, 0.0, 0.0]]; 6]);
    let scene = Scene::new(box_tetrahedra([1.0; 3], [1; 3]), tissue);
    let scene = scene.support(Support::clamped("x_min"));
    let names = ["a", "b", "a_f", "b_f"].map(parameter);
    let scene = names.into_iter().fold(scene, Scene::parameter);
    let body = scene.lower().unwrap();
    let guarded = body.clone().with_barriers(Barriers::default());
    let stretched = |by: f64| -> Vec<f64> {
        body.positions.iter().flat_map(|x| [by * x[0], 0.0, 0.0]).collect()
    };
    let theta = [1.0; 4];
    assert!(guarded.is_within_barriers(&stretched(0.2), &theta));
    // A saturated invariant, and an exponential that overflows without guards.
    for by in [3.0, 1e3] {
        assert!(body.admits(&stretched(by)), "{by}");
        assert!(!guarded.is_within_barriers(&stretched(by), &theta), "{by}");
    }
    assert_eq!(body.value(&stretched(1e3), &theta), f64::INFINITY);
    // The same where volume ratios are averaged.
    let averaged = scene.averaged().lower().unwrap().with_barriers(Barriers::default());
    assert!(averaged.is_within_barriers(&stretched(0.2), &theta));
    for by in [3.0, 1e3] {
        assert!(!averaged.is_within_barriers(&stretched(by), &theta), "{by}");
    }
}

#[test]
fn metrics_of_known_differences() {
    let scene = block();
    let potential = scene.lower().unwrap();
    let stretched = |stretch: f64| -> Vec<f64> {
        scene.mesh.points().iter().flat_map(|x| x.map(|x| (stretch - 1.0) * x)).collect()
    };
    let (truth, estimate) = (stretched(1.1), stretched(1.2));
    let distances = metrics::displacement_error(&truth, &estimate);
    let corner = distances.last().unwrap();
    assert!((corner - 0.1 * 14f64.sqrt()).abs() < 1e-14);
    for error in metrics::deformation_gradient_error(&potential, &truth, &estimate) {
        assert!((error - 100.0 * 0.1 / 1.1).abs() < 1e-11);
    }
    for error in metrics::first_invariant_error(&potential, &truth, &estimate) {
        assert!((error - 100.0 * (1.44 - 1.21) / 1.21).abs() < 1e-10);
    }
}

//! Prescribed motions: where they take nodes, what cells pass on the way, and energies where they leave nothing to find.

use crate::support::lower;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Support};
use sinew_fem::{Options, Solver, Stop, held_sets, reactions};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// A body all of whose nodes are prescribed.
fn moved(mut mesh: TetMesh, loads: Vec<Load>, motion: impl Fn([f64; 3]) -> [f64; 3]) -> Body {
    mesh.node_sets.insert("all".into(), (0..mesh.points.len()).collect());
    let supports = vec![Support::moved("all", &mesh, motion)];
    lower(NeoHookean, mesh, loads, supports)
}

#[test]
fn held_nodes_are_placed_along_their_own_directions_only() {
    let mesh = box_tetrahedra([1.0; 3], [1; 3]);
    let (held, clamped) = (mesh.node_sets["x_max"].clone(), mesh.node_sets["x_min"].clone());
    let supports = vec![Support::clamped("x_min"), Support::along("x_max", [3.0, 0.0, 4.0], 1.0)];
    let body = lower(NeoHookean, mesh, vec![], supports);
    let theta = [1.5, 1.5];
    let solver = Solver::new(&body).unwrap();
    // No step, so that supports alone move the nodes.
    let placed = |from: &[f64]| solver.refine(from, &theta, Stop::after(0)).unwrap().displacement;
    let u = placed(&vec![0.5; body.prescribed.len()]);
    let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-14);
    for &node in &held {
        // 1 − 0.7 are missing along the direction.
        assert!(close([0, 1, 2].map(|i| u[3 * node + i]), [0.68, 0.5, 0.74]));
    }
    assert!(clamped.iter().all(|&node| u[3 * node..3 * node + 3] == [0.0; 3]));
    assert_eq!(placed(&u), u);

    // The support bears forces along its direction alone, the clamp all of them.
    let mut forces = vec![0.0; u.len()];
    body.value_and_gradient(&u, &theta, &mut forces);
    let sum =
        |nodes: &[usize]| [0, 1, 2].map(|i| nodes.iter().map(|n| forces[3 * n + i]).sum::<f64>());
    let of_sets = reactions(&body, &u, &[], &theta).unwrap();
    let reaction = |nodes: &[usize]| {
        let at = held_sets(&body).position(|(_, set)| set == nodes).unwrap();
        of_sets[at]
    };
    let [x, _, z] = sum(&held);
    let along = 0.6 * x + 0.8 * z;
    assert!(along.abs() > 0.1 && close(reaction(&held), [0.6 * along, 0.0, 0.8 * along]));
    assert!(close(reaction(&clamped), sum(&clamped)));
}

/// A prescribed motion goes along straight lines, on which no cell may lose all but a thousandth of its volume.
#[test]
fn the_least_volume_ratio_is_found_on_the_way() {
    let at_once = Options { least_load_step: 1.0, ..Options::default() };
    let solved = |slope: [[f64; 3]; 3]| {
        let motion = |x: [f64; 3]| slope.map(|row| (0..3).map(|j| row[j] * x[j]).sum::<f64>());
        let body = moved(box_tetrahedra([1.0; 3], [1; 3]), vec![], motion);
        Solver::new(&body).unwrap().solve(&[1.0, 1.0], &at_once).is_ok()
    };
    // J = (1 − 2t)² + (b t)² is least at b²/(4 + b²), and near 1 at the end, which is turned.
    let turned = |b: f64| solved([[0.0; 3], [0.0, -2.0, -b], [0.0, b, -2.0]]);
    assert!(!turned(0.0) && !turned(0.06) && turned(0.066));
    // J = (1 + t)(1 − t/2) is least at an end.
    let diagonal = |d: [f64; 3]| [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]];
    assert!(solved(diagonal([1.0, -0.5, 0.0])) && !solved(diagonal([2.0, -1.0, 0.0])));
    assert!(solved(diagonal([0.3, 0.0, -0.3])) && !solved(diagonal([0.0, 0.0, -1.0])));
    // Sampled; the end has a volume in either case.
    let (mut passed, mut refused) = (0, 0);
    for seed in 1..=10 {
        let scattered =
            |i: usize, j: usize| ((seed * (7 * i + 3 * j + 5)) % 11) as f64 / 9.0 - 0.55;
        let mut slope = diagonal([0.2, -1.8, -1.7]);
        (0..9).for_each(|at| slope[at / 3][at % 3] += 0.5 * scattered(at / 3, at % 3));
        let ratio = |t: f64| {
            let f = |i: usize, j: usize| f64::from(u8::from(i == j)) + t * slope[i][j];
            let minor = |i: usize, j: usize| f(1, i) * f(2, j) - f(1, j) * f(2, i);
            f(0, 0) * minor(1, 2) + f(0, 1) * minor(2, 0) + f(0, 2) * minor(0, 1)
        };
        let least = (0..=2000).map(|k| ratio(k as f64 / 2000.0)).fold(f64::INFINITY, f64::min);
        assert!(ratio(1.0) > 0.3);
        assert_eq!(solved(slope), least > 1e-3, "{seed}: {least}");
        if least > 1e-3 {
            passed += 1;
        } else {
            refused += 1;
        }
    }
    assert!(passed > 2 && refused > 2, "{passed} {refused}");
}

/// The line search compares energies that are summed in two orders: a difference above the noise ends it.
#[test]
fn sums_of_many_cells_differ_by_less_than_their_noise() {
    /// Number of roundings in a term of the energy.
    const ROUNDINGS: f64 = 16.0;
    let weight = Load::BodyForce([100.0, 0.0, 0.0]); // kPa/mm
    let motion = |[x, y, _]: [f64; 3]| [x * (1.0 + 0.3 * y.sin()), 0.0, 0.0];
    let body = moved(box_tetrahedra([3.0, 1.0, 1.0], [60, 20, 20]), vec![weight], motion);
    let theta = [1.5, 1.3];
    let solution = Solver::new(&body).unwrap().solve(&theta, &Options::default()).unwrap();
    let u = &solution.displacement;
    let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let loads = body.load_value(u, &theta);
    let (mut noise, mut summed) = (loads.abs(), loads);
    for (cell, volume) in body.volumes.iter().enumerate() {
        let h = body.displacement_gradient(cell, u);
        let response = body.material.response(cell, &theta, &h);
        let (strain, tangent) = (largest(h.0.as_flattened()), response.tangent);
        let stiffness = (0..9).map(|i| tangent[i][i].abs()).fold(0.0, f64::max);
        noise += volume * stiffness * strain * (1.0 + strain);
        // One after the other, from the work of the loads on.
        summed += volume * body.material.energy(cell, &theta, &h, None);
    }
    let noise = ROUNDINGS * f64::EPSILON * noise;
    let energy = body.value(u, &theta);
    let apart = |other: f64| (other - energy).abs() / noise;
    println!("{} and {}", apart(solution.energy), apart(summed));
    assert!(apart(solution.energy) <= 0.1, "{}", apart(solution.energy));
    // The roundings of so many cells exceed the noise.
    assert!(apart(summed) > 1.0, "{}", apart(summed));
}

//! Patch tests: a homogeneous deformation of the boundary is followed by the interior of any mesh.

use crate::support::lower;
use sinew_energy::Support;
use sinew_energy::laws::NeoHookean;
use sinew_fem::{Options, Solver};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// Relative to the size of the cube.
const TOLERANCE: f64 = 1e-10;

/// A cube whose interior nodes are moved about, deterministically.
fn distorted_cube() -> TetMesh {
    let mut mesh = box_tetrahedra([1.0, 1.0, 1.0], [4, 4, 4]);
    let boundary: Vec<_> = mesh.node_sets.values().flatten().copied().collect();
    for node in (0..mesh.points.len()).filter(|node| !boundary.contains(node)) {
        for (i, x) in mesh.points[node].iter_mut().enumerate() {
            *x += 0.05 * (((node * 37 + i * 101) % 17) as f64 / 8.5 - 1.0);
        }
    }
    mesh.node_sets.insert("boundary".into(), boundary);
    mesh
}

/// Displacement (F − I)X at each node.
fn homogeneous(mesh: &TetMesh, f: [[f64; 3]; 3]) -> Vec<f64> {
    let u = |x: &[f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| f[i][j] * x[j]).sum::<f64>() - x[i])
    };
    mesh.points.iter().flat_map(u).collect()
}

#[test]
fn the_interior_follows_simple_shear_stretch_and_rotation() {
    let (sine, cosine) = 0.7_f64.sin_cos();
    let deformations = [
        [[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[1.5, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.8]],
        [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]],
    ];
    let mesh = distorted_cube();
    for f in deformations {
        let exact = homogeneous(&mesh, f);
        let motion = |x: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| (0..3).map(|j| f[i][j] * x[j]).sum::<f64>() - x[i])
        };
        let supports = vec![Support::moved("boundary", &mesh, motion)];
        let cube = lower(NeoHookean, mesh.clone(), vec![], supports);
        for theta in [[1.0, 1.0], [1.0, 1e3]] {
            let solution = Solver::new(&cube).unwrap().solve(&theta, &Options::default()).unwrap();
            let error = solution.displacement.iter().zip(&exact).map(|(a, b)| (a - b).abs());
            let error = error.fold(0.0, f64::max);
            assert!(error < TOLERANCE, "{f:?} {theta:?}: {error:e}");
            assert!(solution.is_stable());
        }
    }
}

#[test]
fn a_stretched_bar_contracts_as_the_closed_form_says() {
    // λ = μ = 1, stretch s: lateral stretch t of BENCHMARKS.md A2 (closed form, own calculation).
    let cases: [(f64, f64, f64); 4] = [
        (0.5, 1.172528263277, 0.444891020184),
        (1.2, 0.954435935785, f64::NAN),
        (1.5, 0.898820614885, 0.259212331299),
        (2.0, 0.827693749013, 0.919742150491),
    ];
    for (stretch, lateral, density) in cases {
        let mesh = distorted_cube();
        let far = mesh.points.iter().position(|&p| p == [1.0, 1.0, 1.0]).unwrap();
        let roller = |axis: usize| std::array::from_fn(|i| (i == axis).then_some(0.0));
        let supports = vec![
            Support::uniform("x_min", roller(0)),
            Support::uniform("y_min", roller(1)),
            Support::uniform("z_min", roller(2)),
            Support::uniform("x_max", [Some(stretch - 1.0), None, None]),
        ];
        let bar = lower(NeoHookean, mesh, vec![], supports);
        let solution = Solver::new(&bar).unwrap().solve(&[1.0, 1.0], &Options::default()).unwrap();
        for i in 1..3 {
            assert!((solution.displacement[3 * far + i] - (lateral - 1.0)).abs() < 1e-11);
        }
        assert!(density.is_nan() || (solution.energy - density).abs() < 1e-11);
    }
}

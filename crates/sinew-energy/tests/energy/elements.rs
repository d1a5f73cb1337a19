//! Shape functions, quadrature, and the stiffness made of them.

mod shapes {
    use sinew_mesh::{Mesh, QuadraturePoint};

    /// Shape functions are 1 at their node, their derivatives agree with differences, and both rules
    /// integrate the polynomial of the stated degree.
    fn check<const N: usize>(nodes: [[f64; 3]; N]) {
        for (a, &at) in nodes.iter().enumerate() {
            let shape = Mesh::<N>::shape(at);
            for b in 0..N {
                assert!((shape[b] - f64::from(u8::from(a == b))).abs() < 1e-14, "{N} {a} {b}");
            }
        }
        const STEP: f64 = 1e-6;
        for point in Mesh::<N>::QUADRATURE.iter().chain(Mesh::<N>::FINE_QUADRATURE) {
            let exact = Mesh::<N>::shape_derivatives(point.at);
            for i in 0..Mesh::<N>::ELEMENT.dimension {
                let moved = |by: f64| {
                    let mut at = point.at;
                    at[i] += by;
                    Mesh::<N>::shape(at)
                };
                let (up, down) = (moved(STEP), moved(-STEP));
                for a in 0..N {
                    assert!(((up[a] - down[a]) / (2.0 * STEP) - exact[a][i]).abs() < 1e-8);
                }
            }
        }
    }

    #[test]
    fn shape_functions_are_nodal_and_their_derivatives_right() {
        let mid = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        let t = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        check::<4>(t);
        check::<3>([t[0], t[1], t[2]]);
        let triangle = [mid(t[0], t[1]), mid(t[1], t[2]), mid(t[2], t[0])];
        check::<6>([t[0], t[1], t[2], triangle[0], triangle[1], triangle[2]]);
        let rest = [mid(t[0], t[3]), mid(t[1], t[3]), mid(t[2], t[3])];
        let [a, b, c] = triangle;
        let [d, e, f] = rest;
        check::<10>([t[0], t[1], t[2], t[3], a, b, c, d, e, f]);
        check::<8>(std::array::from_fn(|a| {
            let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][a % 4];
            [corner[0], corner[1], (a / 4) as f64]
        }));
    }

    #[test]
    fn rules_integrate_monomials_of_their_degree() {
        let integrate = |rule: &[QuadraturePoint], powers: [i32; 3]| -> f64 {
            let value = |p: &QuadraturePoint| {
                p.weight * (0..3).map(|i| p.at[i].powi(powers[i])).product::<f64>()
            };
            rule.iter().map(value).sum()
        };
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let simplex = |powers: [i32; 3], dimension: i32| {
            powers.iter().map(|&p| factorial(p)).product::<f64>()
                / factorial(powers.iter().sum::<i32>() + dimension)
        };
        for (rule, degree) in [(Mesh::<10>::QUADRATURE, 2), (Mesh::<10>::FINE_QUADRATURE, 5)] {
            for powers in [[degree, 0, 0], [degree - 1, 1, 0], [degree - 2, 1, 1]] {
                assert!((integrate(rule, powers) - simplex(powers, 3)).abs() < 1e-14, "{powers:?}");
            }
        }
        for (rule, degree) in [(Mesh::<6>::QUADRATURE, 2), (Mesh::<6>::FINE_QUADRATURE, 4)] {
            for powers in [[degree, 0, 0], [degree - 1, 1, 0]] {
                assert!((integrate(rule, powers) - simplex(powers, 2)).abs() < 1e-14, "{powers:?}");
            }
        }
        let even = integrate(Mesh::<8>::QUADRATURE, [2, 2, 2]);
        assert!((even - (1.0f64 / 3.0).powi(3)).abs() < 1e-14);
    }
}

mod factors {
    use sinew_energy::laws::NeoHookean;
    use sinew_energy::{Parameter, Scene, Support};
    use sinew_mesh::box_tetrahedra;

    #[test]
    fn factors_of_cells_are_means_over_their_corners() {
        let linear = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
        let lowered = |mesh: sinew_mesh::AnyMesh| {
            let scene = Scene::new(mesh, NeoHookean)
                .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
                .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0));
            scene.support(Support::clamped("x_min")).lower().unwrap()
        };
        let [linear, quadratic] = [linear.clone().into(), linear.quadratic().into()].map(lowered);
        let mut factors: Vec<f64> = (0..quadratic.nodes).map(|node| 1.0 + node as f64).collect();
        factors[linear.nodes..].fill(99.0);
        let corners = linear.cell_factors(&factors[..linear.nodes]).unwrap();
        assert_eq!(quadratic.cell_factors(&factors).unwrap(), corners);
    }
}

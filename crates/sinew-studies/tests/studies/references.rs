//! References against tabulated values and their own limits.

use sinew_studies::verify::reference::*;

#[test]
fn an_oscillation_keeps_its_phase_and_a_solution_that_blows_up_is_none() {
    let end = 20.0;
    let [y, v] = integrate(|_, &[y, v]| [v, -y], [0.0, end], [1.0, 0.0]).unwrap();
    assert!((y - end.cos()).abs() < 1e-8 && (v + end.sin()).abs() < 1e-8);
    let [back, _] = integrate(|_, &[y, v]| [v, -y], [end, 0.0], [y, v]).unwrap();
    assert!((back - 1.0).abs() < 1e-8);
    // y = 1/(1 − x).
    assert_eq!(integrate(|_, &[y]| [y * y], [0.0, 2.0], [1.0]), None);
}

#[test]
fn roots_are_exact_to_the_last_bits_and_a_bracket_without_one_is_refused() {
    let found = root(|x| x * x - 2.0, [0.0, 10.0]).unwrap();
    assert!((found - 2f64.sqrt()).abs() <= 4.0 * f64::EPSILON, "{found}");
    // Steep on one side, flat on the other.
    let found = root(|x: f64| x.powi(19) - 1e-3, [1.5, 0.0]).unwrap();
    assert!((found - 1e-3f64.powf(1.0 / 19.0)).abs() < 1e-15);
    assert!(root(|x| x * x + 1.0, [-1.0, 1.0]).is_err());
    assert!(root(|_| f64::NAN, [-1.0, 1.0]).is_err());
}

#[test]
fn neo_hookean_blocks_agree_with_the_tabulated_ones() {
    // λ, axes, stretch, lateral stretch, stress.
    let table = [
        (1.0, 1, 0.5, 1.172528263277, -2.249645056367),
        (1.0, 1, 1.2, 0.954435935785, 0.440876703734),
        (1.0, 1, 1.5, 0.898820614885, 0.961414334839),
        (1.0, 1, 2.0, 0.827693749013, 1.657461528923),
        (10.0, 1, 0.5, 1.356111794362, -3.178078397615),
        (10.0, 1, 1.5, 0.829341768748, 1.041461487074),
        (10.0, 1, 2.0, 0.724124868242, 1.737821587597),
        (1.0, 2, 1.3, 0.820462440727, 0.782185679505),
        (10.0, 2, 1.3, 0.628610386962, 0.996037678003),
    ];
    for (lame, axes, stretch, across, stress) in table {
        let found = neo_hookean_block(lame, axes, stretch).unwrap();
        assert!((found[0] - across).abs() < 1e-12, "{found:?}");
        assert!((found[1] - stress).abs() < 1e-11, "{found:?}");
    }
}

mod fung {
    use sinew_studies::verify::reference::*;

    /// The tables have twelve decimals.
    const TABLE: f64 = 2e-12;
    /// Tables of ten decimals (eight for the largest laws).
    const SHORT_TABLE: f64 = 1e-10;
    const HO: Fung = Fung::HolzapfelOgden([0.18, 2.6, 3.34, 2.73]);
    const HO_2009: Fung =
        Fung::HolzapfelOgden2009([0.059, 8.023, 18.472, 16.026, 2.481, 11.120, 0.216, 11.436]);
    const GUCCIONE: Fung = Fung::Guccione([2.0, 8.0, 2.0, 4.0]);

    #[test]
    fn stretched_holzapfel_ogden_blocks_agree_with_the_tabulated_ones() {
        let stress = |load, stretch| HO.incompressible(load, stretch).unwrap().stress;
        let along = [
            (0.85, -0.099422758186),
            (1.1, 1.972833267352),
            (1.2, 7.324166805605),
            (1.3, 28.875292217105),
        ];
        for (stretch, expected) in along {
            assert!((stress(Biaxial::Along(0), stretch)[0] - expected).abs() < TABLE * 30.0);
        }
        let across = [
            (0.85, -0.151323186669),
            (1.1, 0.058281370379),
            (1.2, 0.144100993377),
            (1.3, 0.300188620774),
        ];
        for (stretch, expected) in across {
            assert!((stress(Biaxial::Along(1), stretch)[1] - expected).abs() < TABLE);
        }
        let fibre = HO.incompressible(Biaxial::Along(1), 0.85).unwrap().stretches[0];
        assert!((fibre - 1.006138052908).abs() < TABLE);
        for (stretch, ff, ss) in
            [(1.1, 2.038543218079, 0.123991321105), (1.2, 7.622213144560, 0.442147332331)]
        {
            let found = stress(Biaxial::InPlane, stretch);
            assert!((found[0] - ff).abs() < 5.0 * TABLE && (found[1] - ss).abs() < TABLE);
        }
    }

    #[test]
    fn stretched_guccione_blocks_agree_with_the_tabulated_ones() {
        let block = |load, stretch| GUCCIONE.incompressible(load, stretch).unwrap();
        let along = [
            (0.9, -1.608516532484),
            (1.1, 2.420690731985),
            (1.2, 8.096521024812),
            (1.3, 26.467349507659),
        ];
        for (stretch, expected) in along {
            let found = block(Biaxial::Along(0), stretch).stress[0];
            assert!((found - expected).abs() < 30.0 * TABLE);
        }
        for (stretch, expected, fibre) in
            [(1.1, 0.784449588832, 0.983759939970), (1.2, 1.904770497323, 0.973816575207)]
        {
            let found = block(Biaxial::Along(1), stretch);
            assert!((found.stress[1] - expected).abs() < TABLE, "{found:?}");
            assert!((found.stretches[0] - fibre).abs() < TABLE, "{found:?}");
        }
        for (stretch, ff, ss) in
            [(1.1, 2.895076283352, 1.105064298440), (1.2, 10.330466112587, 3.277466777113)]
        {
            let found = block(Biaxial::InPlane, stretch).stress;
            assert!((found[0] - ff).abs() < 10.0 * TABLE && (found[1] - ss).abs() < 5.0 * TABLE);
        }
    }

    #[test]
    fn shear_stresses_agree_with_the_tabulated_ones() {
        let check = |law: Fung, normal, along, table: [f64; 5], tolerance: f64| {
            for (step, expected) in table.into_iter().enumerate() {
                let found = law.shear_stress(normal, along, 0.1 * (step + 1) as f64);
                assert!((found - expected).abs() < tolerance, "{normal}{along} {found} {expected}");
            }
        };
        let fs = [0.0251559610, 0.0936195528, 0.2526295267, 0.5676111290, 1.1627469998];
        let rest = [0.0184741371, 0.0399456164, 0.0682368026, 0.1091437826, 0.1723986746];
        for (normal, along) in [(0, 1), (0, 2)] {
            check(HO, normal, along, fs, SHORT_TABLE);
        }
        for (normal, along) in [(1, 0), (1, 2), (2, 0), (2, 1)] {
            check(HO, normal, along, rest, SHORT_TABLE);
        }
        let table = [
            (0, 1, [0.06761308, 0.38775052, 1.35356250, 4.18736266, 14.67663487]),
            (0, 2, [0.04339612, 0.31949349, 1.17219133, 3.64888410, 12.79267487]),
            (1, 0, [0.03557735, 0.12493069, 0.36441145, 1.04582357, 3.34599469]),
            (1, 2, [0.01136038, 0.05667366, 0.18304028, 0.50734501, 1.46203469]),
            (2, 0, [0.00639286, 0.01626506, 0.03643882, 0.08519363, 0.21923413]),
            (2, 1, [0.00639286, 0.01626506, 0.03643882, 0.08519363, 0.21923413]),
        ];
        for (normal, along, values) in table {
            check(HO_2009, normal, along, values, 100.0 * SHORT_TABLE);
        }
        let fs = [0.4163254035, 0.9389598958, 1.7229466528, 3.0612868471, 5.6047378723];
        let sf = [0.4101414453, 0.8846697000, 1.5074032104, 2.4103324171, 3.8273789292];
        let sn = [0.2040403355, 0.4333238025, 0.7184939976, 1.1030471140, 1.6559809484];
        check(GUCCIONE, 0, 1, fs, SHORT_TABLE);
        check(GUCCIONE, 1, 0, sf, SHORT_TABLE);
        check(GUCCIONE, 1, 2, sn, SHORT_TABLE);
    }

    #[test]
    fn a_stiff_bulk_is_almost_incompressible() {
        for law in [HO, GUCCIONE] {
            for load in [Biaxial::Along(0), Biaxial::Along(1), Biaxial::InPlane] {
                let limit = law.incompressible(load, 1.2).unwrap();
                let found = law.nearly_incompressible(1e7, load, 1.2).unwrap();
                for i in 0..3 {
                    assert!((found.stretches[i] - limit.stretches[i]).abs() < 1e-5, "{found:?}");
                    assert!((found.stress[i] - limit.stress[i]).abs() < 1e-3, "{found:?}");
                }
            }
        }
    }
}

#[test]
fn tips_of_the_elastica_agree_with_the_tabulated_ones() {
    let table = [
        (Elastica::TipLoad(1.0), [0.943566764, 0.301720774]),
        (Elastica::TipLoad(2.0), [0.839358279, 0.493457480]),
        (Elastica::TipLoad(5.0), [0.612371639, 0.713791524]),
        (Elastica::TipLoad(10.0), [0.445004402, 0.810609025]),
        (Elastica::UniformLoad(1.0), [0.991246395, 0.123471402]),
        (Elastica::UniformLoad(4.0), [0.890110747, 0.425159284]),
        (Elastica::UniformLoad(10.0), [0.656353761, 0.700199716]),
    ];
    for (load, expected) in table {
        let tip = load.tip().unwrap();
        assert!((0..2).all(|i| (tip[i] - expected[i]).abs() < 1e-9), "{load:?} {tip:?}");
    }
}

#[test]
fn pressures_of_incompressible_walls_agree_with_the_tabulated_ones() {
    // Inner radius, pressures of a sphere and of a tube.
    let table = [
        (1.05, 0.158081433746, 0.070131950816),
        (1.1, 0.287154845934, 0.131562278444),
        (1.2, 0.480159779291, 0.233369777360),
        (1.3, 0.610816872211, 0.313376398042),
        (1.5, 0.755433118712, 0.428228409097),
        (2.0, 0.806926603107, 0.574053572307),
    ];
    for (a, sphere, tube) in table {
        assert!((sphere_pressure(a) - sphere).abs() < 1e-12, "{a}");
        assert!((tube_pressure(a) - tube).abs() < 1e-12, "{a}");
    }
    let [stretch, pressure] = sphere_limit_point().unwrap();
    assert!((stretch - 1.82814731).abs() < 1e-8, "{stretch}");
    assert!((pressure - 0.816423647955).abs() < 1e-12, "{pressure}");
}

#[test]
fn inflations_agree_with_the_tabulated_ones_and_with_the_incompressible_limit() {
    let table = [
        (1.0, 0.2, [0.0727532867, 0.0307364679]),
        (1.0, 0.4, [0.1760833129, 0.0777611167]),
        (49.0, 0.4, [0.1543684080, 0.0447427251]),
        (4999.0, 0.4, [0.1536586862, 0.0436682289]),
    ];
    for (lame, pressure, expected) in table {
        let found = inflated_sphere(lame, pressure).unwrap();
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 2e-10), "{lame} {found:?}");
    }
    let [found, _] = inflated_sphere(1e7, 0.4).unwrap();
    let inner = root(|a| sphere_pressure(a) - 0.4, [1.0, 1.5]).unwrap();
    assert!((found - (inner - 1.0)).abs() < 1e-7, "{found} {inner}");
    assert!((inner - 1.1536515769).abs() < 1e-10);
    assert!((outer_radius(3, inner) - 2.0436574687).abs() < 1e-10);
}

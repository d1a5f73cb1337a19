//! Homogeneous deformations against reference values from independent closed-form calculations
//! (8 to 12 printed digits). Nearly incompressible laws are compared at J = 1, where their
//! volumetric stress vanishes and the lateral stress fixes the pressure.

use sinew_energy::laws::{Guccione, HolzapfelOgden, HolzapfelOgden2009, NeoHookean};
use sinew_energy::{Exact, Law, Response};
use sinew_num::Mat3;

const FIBRE: [[f64; 3]; 1] = [[1.0, 0.0, 0.0]];
const FRAME: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn diagonal(stretches: [f64; 3]) -> Mat3<f64> {
    Mat3::from_fn(|i, j| if i == j { stretches[i] - 1.0 } else { 0.0 })
}

/// `F = I + γ e_j ⊗ e_i`: the plane with normal i is displaced along j.
fn shear(normal: usize, along: usize, amount: f64) -> Mat3<f64> {
    let mut h = Mat3::ZERO;
    h.0[along][normal] = amount;
    h
}

/// Cauchy stress `P Fᵀ / J`.
fn cauchy<L: Law<D>, const D: usize>(
    law: &L,
    theta: &[f64],
    h: &Mat3<f64>,
    directions: &[[f64; 3]; D],
) -> Mat3<f64> {
    let (_, stress) = law.stress(theta, h, directions, &Exact);
    let f = Mat3::from_fn(|i, j| h[i][j] + if i == j { 1.0 } else { 0.0 });
    let j = f.determinant();
    Mat3::from_fn(|i, k| (0..3).map(|m| stress[i][m] * f[k][m]).sum::<f64>() / j)
}

/// Root by the secant method.
fn root(f: impl Fn(f64) -> f64, guess: f64) -> f64 {
    let (mut x, mut next) = (guess, guess * 1.001);
    for _ in 0..60 {
        let (fx, fnext) = (f(x), f(next));
        if fx == fnext {
            break;
        }
        (x, next) = (next, next - fnext * (next - x) / (fnext - fx));
    }
    next
}

/// `digits` counts the decimal places that the reference prints.
#[track_caller]
fn close(found: f64, expected: f64, digits: i32) {
    let tolerance = 0.6 * 10f64.powi(-digits);
    assert!((found - expected).abs() <= tolerance, "found {found:.14}, expected {expected:.14}");
}

#[test]
fn neo_hookean_simple_shear_is_exact() {
    for lame in [1.0, 10.0, 1e4] {
        let (shear_modulus, amount) = (0.7, 0.4);
        let stress = cauchy(&NeoHookean, &[shear_modulus, lame], &shear(1, 0, amount), &[]);
        close(stress[0][1], shear_modulus * amount, 14);
        close(stress[0][0], shear_modulus * amount * amount, 14);
        assert_eq!((stress[1][1], stress[2][2]), (0.0, 0.0));
    }
}

#[test]
fn neo_hookean_uniaxial_with_free_sides() {
    // λ, stretch, lateral stretch, P₁₁, Ψ where printed; μ = 1.
    let cases = [
        (1.0, 0.5, 1.172528263277, -2.249645056367, Some(0.444891020184)),
        (1.0, 1.2, 0.954435935785, 0.440876703734, None),
        (1.0, 1.5, 0.898820614885, 0.961414334839, Some(0.259212331299)),
        (1.0, 2.0, 0.827693749013, 1.657461528923, Some(0.919742150491)),
        (10.0, 0.5, 1.356111794362, -3.178078397615, None),
        (10.0, 1.5, 0.829341768748, 1.041461487074, None),
        (10.0, 2.0, 0.724124868242, 1.737821587597, None),
    ];
    for (lame, stretch, lateral, stress, energy) in cases {
        let response = |t| NeoHookean.response(&[1.0, lame], &diagonal([stretch, t, t]), &[]);
        let t = root(|t| response(t).stress[1][1], stretch.powf(-0.4));
        let found: Response = response(t);
        close(t, lateral, 12);
        close(found.stress[0][0], stress, 12);
        if let Some(energy) = energy {
            close(found.energy, energy, 12);
        }
    }
}

#[test]
fn neo_hookean_equibiaxial_with_a_free_face() {
    for (lame, lateral, stress) in
        [(1.0, 0.820462440727, 0.782185679505), (10.0, 0.628610386962, 0.996037678003)]
    {
        let response = |t| NeoHookean.response(&[1.0, lame], &diagonal([1.3, 1.3, t]), &[]);
        let t = root(|t| response(t).stress[2][2], 0.8);
        close(t, lateral, 12);
        close(response(t).stress[0][0], stress, 12);
    }
}

/// Uniaxial stretch across the fibre with both other faces free: stress and stretch of the fibre.
fn across<L: Law<D>, const D: usize>(
    law: &L,
    theta: &[f64],
    directions: &[[f64; 3]; D],
    stretch: f64,
) -> (f64, f64) {
    let stress = |fibre: f64| {
        cauchy(law, theta, &diagonal([fibre, stretch, 1.0 / (fibre * stretch)]), directions)
    };
    let fibre = root(|l| stress(l)[0][0] - stress(l)[2][2], 1.0 - 0.05 * (stretch - 1.0));
    let stress = stress(fibre);
    (stress[1][1] - stress[2][2], fibre)
}

const HOLZAPFEL_OGDEN: sinew_energy::NearlyIncompressible<HolzapfelOgden> =
    HolzapfelOgden.nearly_incompressible(50.0);
const THETA_HO: [f64; 4] = [0.18, 2.6, 3.34, 2.73];

#[test]
fn holzapfel_ogden_uniaxial_and_equibiaxial() {
    let stress = |h: Mat3<f64>| cauchy(&HOLZAPFEL_OGDEN, &THETA_HO, &h, &FIBRE);
    for (stretch, expected) in [
        (0.85, -0.099422758186),
        (1.1, 1.972833267352),
        (1.2, 7.324166805605),
        (1.3, 28.875292217105),
    ] {
        let lateral = 1.0 / f64::sqrt(stretch);
        let stress = stress(diagonal([stretch, lateral, lateral]));
        close(stress[0][0] - stress[2][2], expected, 12);
    }
    for (stretch, expected) in [
        (0.85, -0.151323186669),
        (1.1, 0.058281370379),
        (1.2, 0.144100993377),
        (1.3, 0.300188620774),
    ] {
        let (stress, fibre) = across(&HOLZAPFEL_OGDEN, &THETA_HO, &FIBRE, stretch);
        close(stress, expected, 12);
        if stretch < 1.0 {
            close(fibre, 1.006138052908, 12);
        }
    }
    for (stretch, fibre, sheet) in
        [(1.1, 2.038543218079, 0.123991321105), (1.2, 7.622213144560, 0.442147332331)]
    {
        let stress = stress(diagonal([stretch, stretch, 1.0 / (stretch * stretch)]));
        close(stress[0][0] - stress[2][2], fibre, 12);
        close(stress[1][1] - stress[2][2], sheet, 12);
    }
}

#[test]
fn holzapfel_ogden_simple_shear() {
    let fibre = [0.0251559610, 0.0936195528, 0.2526295267, 0.5676111290, 1.1627469998];
    let others = [0.0184741371, 0.0399456164, 0.0682368026, 0.1091437826, 0.1723986746];
    for (step, (fibre, other)) in fibre.into_iter().zip(others).enumerate() {
        let amount = 0.1 * (step + 1) as f64;
        for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            let stress = cauchy(&HOLZAPFEL_OGDEN, &THETA_HO, &shear(i, j, amount), &FIBRE);
            close(stress[i][j], if i == 0 { fibre } else { other }, 10);
        }
    }
}

#[test]
fn fibres_switch_smoothly_where_compression_begins() {
    let at = |stretch: f64| {
        let lateral = 1.0 / stretch.sqrt();
        HOLZAPFEL_OGDEN.response(&THETA_HO, &diagonal([stretch, lateral, lateral]), &FIBRE)
    };
    let (below, above) = (at(1.0 - 1e-9), at(1.0 + 1e-9));
    assert!((above.energy - below.energy).abs() < 1e-15);
    assert!((above.stress[0][0] - below.stress[0][0]).abs() < 1e-7);
    // Only in tension the fibres add a_f/(2b_f)·b_f·2(∂Ī₄)² with ∂Ī₄/∂F₁₁ = 2 − 2/3 at rest.
    let jump = above.tangent[0][0] - below.tangent[0][0];
    assert!((jump - THETA_HO[2] * (4.0f64 / 3.0).powi(2)).abs() < 1e-6);
}

#[test]
fn orthotropic_holzapfel_ogden_simple_shear() {
    let law = HolzapfelOgden2009.nearly_incompressible(50.0);
    let theta = [0.059, 8.023, 18.472, 16.026, 2.481, 11.12, 0.216, 11.436];
    let (f, s, n) = (0, 1, 2);
    let modes = [
        ((f, s), [0.06761308, 0.38775052, 1.35356250, 4.18736266, 14.67663487]),
        ((f, n), [0.04339612, 0.31949349, 1.17219133, 3.64888410, 12.79267487]),
        ((s, f), [0.03557735, 0.12493069, 0.36441145, 1.04582357, 3.34599469]),
        ((s, n), [0.01136038, 0.05667366, 0.18304028, 0.50734501, 1.46203469]),
        ((n, f), [0.00639286, 0.01626506, 0.03643882, 0.08519363, 0.21923413]),
        ((n, s), [0.00639286, 0.01626506, 0.03643882, 0.08519363, 0.21923413]),
    ];
    for ((i, j), expected) in modes {
        for (step, expected) in expected.into_iter().enumerate() {
            let h = shear(i, j, 0.1 * (step + 1) as f64);
            close(cauchy(&law, &theta, &h, &[FRAME[0], FRAME[1]])[i][j], expected, 8);
        }
    }
}

#[test]
fn guccione_uniaxial_equibiaxial_and_shear() {
    let law = Guccione.nearly_incompressible(50.0);
    let theta = [2.0, 8.0, 2.0, 4.0];
    let stress = |h: Mat3<f64>| cauchy(&law, &theta, &h, &FRAME);
    for (stretch, expected) in [
        (0.9, -1.608516532484),
        (1.1, 2.420690731985),
        (1.2, 8.096521024812),
        (1.3, 26.467349507659),
    ] {
        let lateral = 1.0 / f64::sqrt(stretch);
        let stress = stress(diagonal([stretch, lateral, lateral]));
        close(stress[0][0] - stress[2][2], expected, 12);
    }
    for (stretch, expected, fibre) in
        [(1.1, 0.784449588832, 0.983759939970), (1.2, 1.904770497323, 0.973816575207)]
    {
        let found = across(&law, &theta, &FRAME, stretch);
        close(found.0, expected, 12);
        close(found.1, fibre, 12);
    }
    for (stretch, fibre, cross) in
        [(1.1, 2.895076283352, 1.105064298440), (1.2, 10.330466112587, 3.277466777113)]
    {
        let stress = stress(diagonal([stretch, stretch, 1.0 / (stretch * stretch)]));
        close(stress[0][0] - stress[2][2], fibre, 12);
        close(stress[1][1] - stress[2][2], cross, 12);
    }
    let modes = [
        ((0, 1), [0.4163254035, 0.9389598958, 1.7229466528, 3.0612868471, 5.6047378723]),
        ((1, 0), [0.4101414453, 0.8846697000, 1.5074032104, 2.4103324171, 3.8273789292]),
        ((1, 2), [0.2040403355, 0.4333238025, 0.7184939976, 1.1030471140, 1.6559809484]),
    ];
    for ((i, j), expected) in modes {
        for (step, expected) in expected.into_iter().enumerate() {
            close(stress(shear(i, j, 0.1 * (step + 1) as f64))[i][j], expected, 10);
        }
    }
}

#[test]
fn a_frame_from_the_fibre_is_orthonormal_and_any_one_will_do() {
    let law = Guccione.nearly_incompressible(5.0);
    let theta = [2.0, 8.0, 2.0, 4.0];
    let h = Mat3([[0.1, -0.05, 0.02], [0.08, 0.05, -0.1], [0.0, 0.03, -0.04]]);
    for fibre in [[2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0], [0.0, 0.0, -1.0], [0.6, 0.0, -0.8]] {
        let [f, s, n] = Guccione::frame(fibre);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for (a, b, expected) in [(f, s, 0.0), (f, n, 0.0), (s, n, 0.0), (s, s, 1.0), (n, n, 1.0)] {
            assert!((dot(a, b) - expected).abs() < 1e-15);
        }
        // Turned about the fibre by an angle with cosine 0.8.
        let turned: [[f64; 3]; 2] = [
            std::array::from_fn(|i| 0.8 * s[i] + 0.6 * n[i]),
            std::array::from_fn(|i| 0.8 * n[i] - 0.6 * s[i]),
        ];
        let energy = |frame| law.energy(&theta, &h, &frame, &Exact);
        let [one, other] = [energy([f, s, n]), energy([f, turned[0], turned[1]])];
        assert!((one - other).abs() < 1e-14 * one.abs());
    }
}

//! A left ventricle like the thesis' (§3.3.4) under a true follower pressure, and points of its parameter box.
#![allow(dead_code, reason = "each program uses a part")]

use sinew_energy::laws::HolzapfelOgden;
use sinew_energy::{Law, Load, Magnitude, Parameter, Sampling, Scene, Support};
use sinew_mesh::TetMesh;

/// One millimetre of mercury \[kPa\].
pub(crate) const MMHG: f64 = 0.133_322;
/// Bulk modulus of the thesis \[kPa\].
pub(crate) const BULK_MODULUS: f64 = 25.0;
/// Names and ranges of θ; the first corner is the softest body. a and a_f in kPa.
///
/// The thesis prints 2.6 for the largest a, but its displacements belong to 0.26.
pub(crate) const BOX: [(&str, [f64; 2]); 4] =
    [("a", [0.1, 0.26]), ("b", [1.0, 4.2]), ("a_f", [1.5, 5.18]), ("b_f", [1.0, 4.46])];

/// The scene; θ = (a, b, a_f, b_f, pressure \[kPa\]).
pub(crate) fn scene(mesh: TetMesh, bulk_modulus: f64) -> Scene {
    let fibres = mesh.cell_fields["fibre"].to_vectors::<3>().expect("three components");
    let fibres = fibres.into_iter().map(|fibre| [fibre]).collect();
    let parameter = |name: &str, range| Parameter {
        name: name.into(),
        unit: if name.starts_with('b') { "1" } else { "kPa" }.into(),
        range,
        sampling: Sampling::Log,
    };
    let mut parameters: Vec<_> = BOX.iter().map(|&(name, range)| parameter(name, range)).collect();
    parameters.push(parameter("pressure", [4.0 * MMHG, 10.0 * MMHG]));
    Scene {
        name: "LeftVentricle".into(),
        parameters,
        loads: vec![Load::Pressure { facets: "region:1".into(), magnitude: Magnitude::Theta(4) }],
        supports: vec![Support::clamped("base")],
        ..Scene::new(mesh, HolzapfelOgden.nearly_incompressible(bulk_modulus).along(fibres))
    }
}

/// The softest corner of the box, then Sobol points, spread evenly in the logarithm, all at one pressure \[kPa\].
pub(crate) fn thetas(points: usize, pressure: f64) -> Vec<[f64; 5]> {
    let place = |unit: [f64; 4]| {
        let [a, b, a_f, b_f] = std::array::from_fn(|i| {
            let [least, most] = BOX[i].1;
            least * f64::powf(most / least, unit[i])
        });
        [a, b, a_f, b_f, pressure]
    };
    // The first point of the sequence is the origin: the softest corner itself.
    (0..=points).map(|index| place(sobol(index as u32))).collect()
}

/// A point of the Sobol sequence in four dimensions (primitive polynomials and initial numbers of
/// S. Joe & F. Y. Kuo, SIAM J. Sci. Comput. 30, 2008).
fn sobol(index: u32) -> [f64; 4] {
    // Inner coefficients of the polynomial, and the initial direction numbers.
    const TABLE: [(u32, &[u32]); 3] = [(0, &[1]), (1, &[1, 3]), (1, &[1, 3, 1])];
    let gray = index ^ (index >> 1);
    let coordinate = |directions: [u32; 32]| {
        let chosen = directions.iter().enumerate().filter(|(bit, _)| gray >> bit & 1 == 1);
        chosen.fold(0, |sum, (_, direction)| sum ^ direction) as f64 / 2.0_f64.powi(32)
    };
    std::array::from_fn(|dimension| {
        let mut directions: [u32; 32] = std::array::from_fn(|bit| 1 << (31 - bit));
        if let Some((inner, initial)) = dimension.checked_sub(1).map(|d| TABLE[d]) {
            let degree = initial.len();
            for bit in 0..32 {
                directions[bit] = if bit < degree {
                    initial[bit] << (31 - bit)
                } else {
                    let past = directions[bit - degree];
                    (1..degree).fold(past ^ (past >> degree), |value, k| {
                        let present = inner >> (degree - 1 - k) & 1;
                        value ^ (present * directions[bit - k])
                    })
                };
            }
        }
        coordinate(directions)
    })
}

//! Every law over Burn tensors: the same numbers as over `f64`, and the same slopes as over Taylor numbers, in the
//! displacement gradient and in the parameters.

use crate::lanes::Lanes;
use burn::tensor::{DType, Device, Tensor, TensorData};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_energy::laws::{
    ActiveTension, ByYoungPoisson, Compressible, Guccione, HolzapfelOgden, HolzapfelOgden2009,
    HolzapfelOgdenCompressible, LinearElastic, NeoHookean, NeoHookeanShape,
};
use sinew_energy::{Barriers, Exact, Guard, Law, Solid, Strain};
use sinew_num::{Mat3, Slope};

/// Rounding in f64 after some hundred operations.
const ROUNDING: f64 = 1e-13;
const STATES: usize = 40;
const BULK: f64 = 5.0;
/// An orthonormal frame off the axes.
const FRAME: [[f64; 3]; 3] = [
    [2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0],
    [-2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0],
    [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0],
];

#[test]
fn every_law_is_the_same_formula_over_tensors() {
    agrees(NeoHookean, &[1.5, 2.5]);
    agrees(ByYoungPoisson(NeoHookean), &[10.0, 0.3]);
    agrees(NeoHookeanShape.nearly_incompressible(BULK), &[1.5]);
    agrees(Solid::new(NeoHookeanShape, Compressible { kappa: BULK }), &[1.5]);
    agrees(LinearElastic, &[1.5, 2.5]);
    let muscle = HolzapfelOgden.nearly_incompressible(BULK);
    agrees(muscle, &[0.18, 2.6, 3.34, 2.73]);
    agrees(muscle.with_active(ActiveTension), &[0.18, 2.6, 3.34, 2.73, 4.0]);
    let compressible = Solid::new(HolzapfelOgdenCompressible, Compressible { kappa: 25.0 });
    agrees(compressible, &[0.18, 2.6, 3.34, 2.73]);
    let orthotropic = [0.059, 8.023, 18.472, 16.026, 2.481, 11.12, 0.216, 11.436];
    agrees(HolzapfelOgden2009.nearly_incompressible(BULK), &orthotropic);
    agrees(Guccione.nearly_incompressible(BULK), &[2.0, 8.0, 2.0, 4.0]);
    let whole = Solid { strain: Strain::Whole, ..Guccione.nearly_incompressible(BULK) };
    agrees(whole, &[2.0, 8.0, 2.0, 4.0]);
}

fn agrees<L: Law<D>, const D: usize>(law: L, parameters: &[f64]) {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut states = |size: f64, admissible: bool| -> Vec<Mat3<f64>> {
        let state = || Mat3::from_fn(|_, _| size * random.random_range(-1.0..1.0));
        let states = std::iter::repeat_with(state);
        states.filter(|h| !admissible || h.volume_change() > -0.9).take(STATES).collect()
    };
    let (small, large, turned) = (states(1e-6, true), states(0.3, true), states(2.0, false));
    assert!(turned.iter().any(|h| h.volume_change() < -1.0), "some cells turned inside out");
    compare(&law, parameters, &Exact, &[small, large.clone()].concat());
    // Barriers take the other branch of every `select` where a state is out of bounds.
    compare(&law, parameters, &Barriers::default(), &[large, turned].concat());
}

/// All states at once as lanes of tensors, against one after the other.
fn compare<L: Law<D>, G: Guard, const D: usize>(
    law: &L,
    parameters: &[f64],
    guard: &G,
    states: &[Mat3<f64>],
) {
    let device = Device::flex().autodiff();
    let tensor = |values: Vec<f64>| {
        let shape = [values.len()];
        Tensor::<1>::from_data(TensorData::new(values, shape), (&device, DType::F64)).require_grad()
    };
    let entries: [_; 9] =
        std::array::from_fn(|k| tensor(states.iter().map(|h| h[k / 3][k % 3]).collect()));
    // A parameter per lane, as in a batch of θ.
    let lanes: Vec<_> = parameters.iter().map(|&p| tensor(vec![p; states.len()])).collect();
    let directions: [[Lanes<1>; 3]; D] =
        std::array::from_fn(|d| FRAME[d].map(|x| Lanes(tensor(vec![x; states.len()]).detach())));
    let h = Mat3::from_fn(|i, j| Lanes(entries[3 * i + j].clone()));
    let theta: Vec<_> = lanes.iter().cloned().map(Lanes).collect();
    let energies = law.density(&theta, &h, &directions, guard).0;
    let gradients = energies.clone().sum().backward();
    let numbers = |tensor: Tensor<1>| tensor.into_data().try_to_vec::<f64>().unwrap();
    // A tensor that the energy does not read has no gradient.
    let slope = |of: &Tensor<1>| of.grad(&gradients).map_or(vec![0.0; states.len()], numbers);
    let slopes: Vec<_> = entries.iter().chain(&lanes).map(slope).collect();
    let energies = numbers(energies);
    let rest = law.response(parameters, &Mat3::ZERO, &std::array::from_fn(|d| FRAME[d]));
    let stiffness = rest.tangent.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));

    for (lane, h) in states.iter().enumerate() {
        let expected = taylor(law, parameters, guard, h);
        let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let found = std::iter::once(energies[lane]).chain(slopes.iter().map(|s| s[lane]));
        for (k, (found, expected)) in found.zip(&expected).enumerate() {
            // Formulas in ∇u lose digits of stresses like ε, of energies like ε times the strain.
            let strain = if (1..10).contains(&k) { 1.0 } else { h.squared_norm().sqrt().min(1.0) };
            let allowed = ROUNDING * strain * (stiffness + largest);
            // Written so that a NaN fails.
            let same = (found - expected).abs() <= allowed;
            assert!(same, "{} number {k} at {h:?}: {found:e}, not {expected:e}", L::NAME);
        }
    }
}

/// Ψ over `f64`, then its slopes in the nine entries of H and in the parameters.
fn taylor<L: Law<D>, G: Guard, const D: usize>(
    law: &L,
    parameters: &[f64],
    guard: &G,
    h: &Mat3<f64>,
) -> Vec<f64> {
    let directions = std::array::from_fn(|d| FRAME[d]);
    let energy = law.density(parameters, h, &directions, guard);
    let theta: Vec<_> =
        parameters.iter().enumerate().map(|(i, &p)| Slope::<9>::variable(p, i)).collect();
    let fixed = h.seeded(|x, _| Slope::constant(x));
    let in_theta = law.density(&theta, &fixed, &directions.map(|d| d.map(Slope::constant)), guard);
    let constants: Vec<_> = parameters.iter().map(|&p| Slope::<9>::constant(p)).collect();
    let moving = h.seeded(Slope::variable);
    let in_h = law.density(&constants, &moving, &directions.map(|d| d.map(Slope::constant)), guard);
    let slopes = in_h.gradient.into_iter().chain(in_theta.gradient.into_iter().take(theta.len()));
    std::iter::once(energy).chain(slopes).collect()
}

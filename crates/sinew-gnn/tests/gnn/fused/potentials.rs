//! Energies from outside of Burn.

use super::comparison::{Comparison, device, random};
use burn::tensor::Tensor;
use sinew_gnn::fused::fused_potential;

/// `Σ k e^u − k u` with `k = 1 + sample`; infinite where some u exceeds 5.
fn exponential(displacement: &[f64], sample: usize, gradient: &mut [f64]) -> f64 {
    let k = 1.0 + sample as f64;
    for (g, u) in gradient.iter_mut().zip(displacement) {
        *g = k * u.exp_m1();
    }
    match displacement.iter().any(|u| *u > 5.0) {
        true => f64::INFINITY,
        false => displacement.iter().map(|u| k * (u.exp() - u)).sum(),
    }
}

#[test]
fn agrees_with_plain_tensors() {
    let device = device();
    for samples in [1, 4] {
        let stiffness =
            Tensor::<1>::from_floats([1.0, 2.0, 3.0, 4.0], &device).narrow(0, 0, samples);
        Comparison::of([random([samples, 30], 5, &device)]).assert_close(
            |x| fused_potential(x[0].clone().reshape([samples, 10, 3]), exponential).unsqueeze(),
            |x| {
                let per_sample: Tensor<1> =
                    (x[0].clone().exp() - x[0].clone()).sum_dim(1).squeeze_dim(1);
                let stiffness = stiffness.clone().cast(per_sample.dtype());
                (per_sample * stiffness).unsqueeze()
            },
        );
    }
}

#[test]
fn energies_outside_the_domain_stay_visible() {
    let u = Tensor::<3>::from_floats([[[0.0]], [[6.0]]], &device()).require_grad();
    let energy = fused_potential(u.clone(), exponential);
    assert_eq!(energy.to_data().try_to_vec::<f32>().unwrap(), [1.0, f32::INFINITY]);
    let residual =
        u.grad(&energy.sum().backward()).unwrap().into_data().try_to_vec::<f32>().unwrap();
    assert_eq!(residual[0], 0.0);
    assert!(residual[1].is_nan());
}

#[test]
fn no_samples_have_no_energy() {
    let u = Tensor::<3>::zeros([0, 4, 3], &device());
    assert_eq!(fused_potential(u, exponential).dims(), [0]);
}

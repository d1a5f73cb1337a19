//! A potential energy computed outside of Burn as one differentiable operation.

use crate::fused::host::{HostTensor, Pullback, apply};
use burn::tensor::{DType, Tensor};
use rayon::prelude::*;

/// Energies `[samples]` of displacement fields `[samples, nodes, dimensions]`; the backward pass
/// is the nodal residual, computed along with the energy.
///
/// `potential(displacement, sample, gradient)` is the energy of the field `displacement` of a sample, whose gradient (the nodal
/// residual) it writes over `gradient`. Both hold one row per node, and all rows follow one another. Outside its domain (an
/// inverted element) the energy is +∞ and the gradient unspecified.
///
/// Inside everything is double precision; samples are spread over threads. An infinite or
/// undefined energy is returned as such, and its gradient is not a number: check the energies
/// before stepping.
///
/// ```
/// use burn::tensor::{Device, Tensor};
/// use sinew_gnn::fused::fused_potential;
///
/// // Springs of a stiffness per sample between every node and its place of rest.
/// let springs = |displacement: &[f64], sample: usize, gradient: &mut [f64]| {
///     let stiffness = [2.0, 4.0][sample];
///     gradient.iter_mut().zip(displacement).for_each(|(g, u)| *g = stiffness * u);
///     0.5 * stiffness * displacement.iter().map(|u| u * u).sum::<f64>()
/// };
/// let u = Tensor::<3>::ones([2, 1, 3], &Device::flex().autodiff()).require_grad();
/// let energy = fused_potential(u.clone(), springs);
/// assert_eq!(energy.to_data().try_to_vec::<f32>().unwrap(), [3.0, 6.0]);
/// let residual = u.grad(&energy.sum().backward()).unwrap();
/// assert_eq!(residual.into_data().try_to_vec::<f32>().unwrap(), [2.0, 2.0, 2.0, 4.0, 4.0, 4.0]);
/// ```
pub fn fused_potential(
    displacement: Tensor<3>,
    potential: impl Fn(&[f64], usize, &mut [f64]) -> f64 + Send + Sync + 'static,
) -> Tensor<1> {
    let dtype = displacement.dtype();
    let single = displacement.cast(DType::F32);
    let energy: Tensor<1> = apply(vec![single.into_dispatch()], move |inputs, _| {
        let samples = inputs[0].shape()[0];
        let displacement: Vec<f64> = inputs[0].values().iter().map(|u| f64::from(*u)).collect();
        let size = displacement.len() / samples.max(1);
        let energy = |sample: usize| {
            let mut gradient = vec![0.0; size];
            let field = &displacement[sample * size..(sample + 1) * size];
            let energy = potential(field, sample, &mut gradient);
            if !energy.is_finite() {
                gradient.fill(f64::NAN);
            }
            (energy as f32, gradient.iter().map(|g| *g as f32).collect::<Vec<_>>())
        };
        let (energies, gradients): (Vec<_>, Vec<_>) =
            (0..samples).into_par_iter().map(energy).unzip();
        let pullback = Pullback::new(move |cotangent, _| {
            let samples = gradients.iter().zip(cotangent);
            let scaled = samples.flat_map(|(gradient, c)| gradient.iter().map(move |g| g * c));
            vec![Some(scaled.collect())]
        });
        (HostTensor::new(energies, [samples]), pullback)
    });
    energy.cast(dtype)
}

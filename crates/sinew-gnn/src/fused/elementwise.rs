//! Activations of whole tensors.

use crate::fused::activation::{self, Activation};
use crate::fused::host::{HostTensor, Pullback, apply, is_on_host};
use crate::fused::reference;
use burn::tensor::Tensor;
use rayon::prelude::*;

/// Numbers treated by one task.
const NUMBERS_PER_TASK: usize = 1 << 15;

/// `activation` of every number of a tensor as one operation; the derivative comes from the output.
///
/// ```
/// use burn::tensor::{Device, Tensor};
/// use sinew_gnn::fused::{Activation, activate};
///
/// let x = Tensor::<1>::from_floats([-1.0, 0.0, 2.0], &Device::flex());
/// let y = activate(x, Activation::Celu).into_data().try_to_vec::<f32>().unwrap();
/// assert!((y[0] - (-1.0_f32).exp_m1()).abs() < 1e-7);
/// assert_eq!(y[1..], [0.0, 2.0]);
/// ```
pub fn activate<const D: usize>(x: Tensor<D>, activation: Activation) -> Tensor<D> {
    if !is_on_host(&x) {
        return reference::activate(x, activation);
    }
    apply(vec![x.into_dispatch()], move |inputs, _| {
        let mut output = inputs[0].values().to_vec();
        output.par_chunks_mut(NUMBERS_PER_TASK).for_each(|x| activation::activate(activation, x));
        let output = HostTensor::new(output, inputs[0].shape());
        let value = output.clone();
        let pullback = Pullback::new(move |cotangent, _| {
            let mut gradient = vec![0.0; cotangent.len()];
            let values = value.values().par_chunks(NUMBERS_PER_TASK);
            let tasks = gradient.par_chunks_mut(NUMBERS_PER_TASK).zip(values);
            tasks.zip(cotangent.par_chunks(NUMBERS_PER_TASK)).for_each(
                |((gradient, value), cotangent)| {
                    activation::pull_back(activation, value, cotangent, gradient);
                },
            );
            vec![Some(gradient)]
        });
        (output, pullback)
    })
}

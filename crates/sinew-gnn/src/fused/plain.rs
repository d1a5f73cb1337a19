//! Plain operations that Burn's own code leaves slow where it is not optimised: sums of two tensors, concatenated rows, normalised
//! rows, mean distances of rows, activations, and a potential energy computed outside of Burn.

use crate::fused::activation::{self, Activation};
use crate::fused::host::{Cotangents, HostTensor, Pullback, apply, is_on_host};
use crate::fused::normalise::{Normalisation, normalise, pull_back_normalisation};
use crate::fused::{LayerNormalisation, reference};
use burn::tensor::{DType, Tensor, TensorData};
use rayon::prelude::*;

/// Numbers treated by one task.
const NUMBERS_PER_TASK: usize = 1 << 15;

/// `a + b` of tensors of one shape, as one operation.
///
/// ```
/// use burn::tensor::{Device, Tensor};
///
/// let a = Tensor::<2>::from_floats([[1.0, 2.0]], &Device::flex());
/// let sum = sinew_gnn::fused::sum(a.clone(), a).into_data();
/// assert_eq!(sum.iter::<f32>().collect::<Vec<_>>(), [2.0, 4.0]);
/// ```
///
/// # Panics
/// When the shapes differ.
pub fn sum(a: Tensor<2>, b: Tensor<2>) -> Tensor<2> {
    assert_eq!(a.dims(), b.dims(), "tensors of a sum must have one shape");
    if !is_on_host(&a) {
        return a + b;
    }
    apply(vec![a.into_dispatch(), b.into_dispatch()], |inputs, _| {
        let sums = inputs[0].values().iter().zip(inputs[1].values()).map(|(a, b)| a + b);
        let pullback = Pullback::new(|cotangent, needed| {
            needed.iter().map(|needed| needed.then(|| cotangent.to_vec())).collect()
        });
        (HostTensor::new(sums.collect(), inputs[0].shape()), pullback)
    })
}

/// Concatenation of `parts` after each other along the axis `axis`, as one operation.
///
/// ```
/// use burn::tensor::{Device, Tensor};
///
/// let part = |x: f32| Tensor::<2>::from_floats([[x], [x + 1.0]], &Device::flex());
/// let rows = sinew_gnn::fused::concatenated(vec![part(1.0), part(3.0)], 1).into_data();
/// assert_eq!(rows.iter::<f32>().collect::<Vec<_>>(), [1.0, 3.0, 2.0, 4.0]);
/// ```
///
/// # Panics
/// Without parts, or when they differ along another axis.
pub fn concatenated<const R: usize>(parts: Vec<Tensor<R>>, axis: usize) -> Tensor<R> {
    let mut shape = parts[0].dims();
    shape[axis] = parts.iter().map(|part| part.dims()[axis]).sum();
    let others_agree = |part: &Tensor<R>| (0..R).all(|i| i == axis || part.dims()[i] == shape[i]);
    assert!(parts.iter().all(others_agree), "parts that differ along another axis");
    if !(2..=3).contains(&parts.len()) || !parts.iter().all(is_on_host) {
        return Tensor::cat(parts, axis);
    }
    // Each row is that of all parts after each other.
    let rows: usize = shape[..axis].iter().product();
    apply(parts.into_iter().map(Tensor::into_dispatch).collect(), move |parts, _| {
        let parts: Vec<&[f32]> = parts.iter().map(HostTensor::values).collect();
        let widths: Vec<usize> = parts.iter().map(|part| part.len() / rows.max(1)).collect();
        let (mut output, row) = (vec![0.0; shape.iter().product()], widths.iter().sum());
        let mut start = 0;
        for (part, &width) in parts.iter().zip(&widths).filter(|(_, width)| **width > 0) {
            // Rows may be short: no call for each.
            for (to, from) in output.chunks_exact_mut(row).zip(part.chunks_exact(width)) {
                to[start..].iter_mut().zip(from).for_each(|(to, x)| *to = *x);
            }
            start += width;
        }
        let pullback = Pullback::new(move |cotangent, needed| divided(&widths, cotangent, needed));
        (HostTensor::new(output, shape), pullback)
    })
}

/// Parts of these widths of every row.
fn divided(widths: &[usize], rows: &[f32], needed: &[bool]) -> Cotangents {
    let row: usize = widths.iter().sum();
    let mut start = 0;
    let part = |(width, needed): (&usize, &bool)| {
        start += width;
        let columns = start - width..start;
        let rows = rows.chunks_exact(row.max(1));
        needed.then(|| rows.flat_map(|row| &row[columns.clone()]).copied().collect())
    };
    widths.iter().zip(needed).map(part).collect()
}

/// Rows `[rows, m]` of mean zero and variance one, times gain plus offset, as one operation.
///
/// ```
/// use burn::tensor::{Device, Tensor};
/// use sinew_gnn::fused::LayerNormalisation;
///
/// let device = Device::flex();
/// let (gain, offset) = (Tensor::<1>::ones([2], &device), Tensor::<1>::zeros([2], &device));
/// let rows = Tensor::<2>::from_floats([[1.0, 3.0]], &device);
/// let rows = sinew_gnn::fused::normalised(rows, LayerNormalisation { gain, offset });
/// let rows: Vec<f32> = rows.into_data().iter::<f32>().collect();
/// assert!((rows[0] + 1.0).abs() < 1e-6 && (rows[1] - 1.0).abs() < 1e-6);
/// ```
///
/// # Panics
/// When gain or offset have not one number per column.
pub fn normalised(x: Tensor<2>, normalisation: LayerNormalisation) -> Tensor<2> {
    let LayerNormalisation { gain, offset } = normalisation.clone();
    assert_eq!([gain.dims(), offset.dims()], [[x.dims()[1]]; 2], "a gain and an offset per column");
    if !is_on_host(&x) || x.dims()[1] == 0 {
        return reference::normalised(x, normalisation);
    }
    let inputs = vec![x.into_dispatch(), gain.into_dispatch(), offset.into_dispatch()];
    apply(inputs, move |inputs, _| {
        let [x, gain, offset] = inputs else { panic!("rows, gain and offset") };
        let mut output = x.values().to_vec();
        let mut rows = vec![0.0; output.len()];
        let mut inverse = vec![0.0; output.len() / gain.values().len()];
        let normalisation = Normalisation { gain: gain.values(), offset: offset.values() };
        normalise(normalisation, &mut output, &mut rows, &mut inverse);
        let gain = gain.clone();
        let pullback = Pullback::new(move |cotangent, _| {
            let width = gain.values().len();
            let mut all = [rows.len(), width, width].map(|n| vec![0.0; n]);
            let [of_x, of_gain, of_offset] = &mut all;
            let gain = gain.values();
            pull_back_normalisation(gain, &rows, &inverse, cotangent, of_x, of_gain, of_offset);
            all.map(Some).into()
        });
        (HostTensor::new(output, x.shape()), pullback)
    })
}

/// Mean of `√(‖(x − y) / unit‖² + floor)` over the rows of `x`, `[.., .., D]`, and those of `y`, as one operation.
///
/// ```
/// use burn::tensor::{Device, Tensor};
///
/// let x = Tensor::<3>::from_floats([[[3.0, 4.0], [1.0, 1.0]]], &Device::flex());
/// let mean = sinew_gnn::fused::mean_distance(x, vec![0.0, 0.0, 1.0, 0.0], 2.0, 0.0);
/// assert_eq!(mean.into_scalar::<f32>(), 1.5);
/// ```
///
/// # Panics
/// When `y` has not as many numbers as `x`.
pub fn mean_distance(x: Tensor<3>, y: Vec<f32>, unit: f32, floor: f32) -> Tensor<1> {
    let shape = x.dims();
    assert_eq!(y.len(), shape.iter().product::<usize>(), "rows that are compared");
    if !is_on_host(&x) || y.is_empty() {
        let y = Tensor::from_data(TensorData::new(y, shape), (&x.device(), x.dtype()));
        return reference::mean_norm((x - y) / unit, floor);
    }
    let width = shape[2];
    apply(vec![x.into_dispatch()], move |inputs, _| {
        let pairs = inputs[0].values().iter().zip(&y);
        let mut difference: Vec<f32> = pairs.map(|(x, y)| (x - y) / unit).collect();
        let (share, mut sum) = (width as f32 / difference.len() as f32, 0.0);
        for row in difference.chunks_exact_mut(width) {
            let squared: f32 = row.iter().map(|d| d * d).sum();
            let distance = (squared + floor).sqrt();
            sum += f64::from(distance);
            row.iter_mut().for_each(|d| *d *= share / (distance * unit));
        }
        let mean = (sum * f64::from(share)) as f32;
        let gradient = difference;
        let pullback = Pullback::new(move |cotangent, _| {
            vec![Some(gradient.iter().map(|g| g * cotangent[0]).collect())]
        });
        (HostTensor::new(vec![mean], [1]), pullback)
    })
}

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
            activation::pull_back(activation, value.values(), cotangent, &mut gradient);
            vec![Some(gradient)]
        });
        (output, pullback)
    })
}

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
            let mut scaled = Vec::with_capacity(samples * size);
            for (gradient, c) in gradients.iter().zip(cotangent) {
                scaled.extend(gradient.iter().map(|g| g * c));
            }
            vec![Some(scaled)]
        });
        (HostTensor::new(energies, [samples]), pullback)
    });
    energy.cast(dtype)
}

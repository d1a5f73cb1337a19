//! Sums of two tensors, concatenated rows and normalised rows: plain operations that Burn's own code leaves slow where it is not optimised.

use crate::fused::LayerNormalisation;
use crate::fused::host::{Cotangents, HostTensor, Pullback, apply, is_on_host};
use crate::fused::normalise::{Normalisation, normalise, pull_back_normalisation};
use crate::fused::reference;
use burn::tensor::Tensor;

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
        let widths = parts.iter().map(|part| part.values().len() / rows.max(1));
        let widths: Vec<usize> = widths.collect();
        let mut output = Vec::with_capacity(shape.iter().product());
        for row in 0..rows {
            for (part, width) in parts.iter().zip(&widths) {
                output.extend_from_slice(&part.values()[row * width..(row + 1) * width]);
            }
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
/// let rows = sinew_gnn::fused::normalised(rows, LayerNormalisation { gain, offset, epsilon: 1e-9 });
/// let rows: Vec<f32> = rows.into_data().iter::<f32>().collect();
/// assert!((rows[0] + 1.0).abs() < 1e-6 && (rows[1] - 1.0).abs() < 1e-6);
/// ```
///
/// # Panics
/// When gain or offset have not one number per column.
pub fn normalised(x: Tensor<2>, normalisation: LayerNormalisation) -> Tensor<2> {
    let LayerNormalisation { gain, offset, epsilon } = normalisation.clone();
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
        let epsilon = epsilon as f32;
        let normalisation = Normalisation { gain: gain.values(), offset: offset.values(), epsilon };
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

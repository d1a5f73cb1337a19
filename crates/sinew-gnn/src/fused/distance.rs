//! Mean distance of rows.

use crate::fused::host::{HostTensor, Pullback, apply, is_on_host};
use crate::fused::reference;
use burn::tensor::{Tensor, TensorData};

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

//! Mean distance of rows.

use crate::fused::host::{Cotangents, HostOperation, HostTensor, apply, is_on_host};
use crate::fused::reference;
use burn::tensor::{Tensor, TensorData};
use std::sync::Arc;

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
    match is_on_host(&x) && !y.is_empty() {
        true => {
            let operation = MeanDistance { y: y.into(), width: shape[2], unit, floor };
            apply(operation, vec![x.into_dispatch()])
        }
        false => {
            let y = Tensor::from_data(TensorData::new(y, shape), (&x.device(), x.dtype()));
            reference::mean_norm((x - y) / unit, floor)
        }
    }
}

#[derive(Clone, Debug)]
struct MeanDistance {
    y: Arc<[f32]>,
    width: usize,
    unit: f32,
    floor: f32,
}

impl HostOperation for MeanDistance {
    /// Gradient of the mean.
    type Saved = Arc<[f32]>;

    fn forward(&self, inputs: &[HostTensor], tracked: bool) -> (HostTensor, Option<Self::Saved>) {
        let mut difference: Vec<f32> =
            inputs[0].values().iter().zip(&*self.y).map(|(x, y)| (x - y) / self.unit).collect();
        let (share, mut sum) = (self.width as f32 / difference.len() as f32, 0.0);
        for row in difference.chunks_exact_mut(self.width) {
            let squared: f32 = row.iter().map(|d| d * d).sum();
            let distance = (squared + self.floor).sqrt();
            sum += f64::from(distance);
            row.iter_mut().for_each(|d| *d *= share / (distance * self.unit));
        }
        let mean = (sum * f64::from(share)) as f32;
        (HostTensor::new(vec![mean], [1]), tracked.then(|| difference.into()))
    }

    fn backward(&self, gradient: Self::Saved, cotangent: &[f32], _needed: &[bool]) -> Cotangents {
        vec![Some(gradient.iter().map(|g| g * cotangent[0]).collect())]
    }
}

//! Numbers as tensors, and back.

use crate::error::Result;
use burn::tensor::{Device, Tensor, TensorData};
use sinew_emulate::coordinates::ParameterScaling;

/// Standardised parameters `[batch, parameters]`.
pub(crate) fn parameter_tensor<'a>(
    scaling: &ParameterScaling,
    thetas: impl ExactSizeIterator<Item = &'a [f64]>,
    device: &Device,
) -> Result<Tensor<2>> {
    let rows = thetas.len();
    Ok(matrix(&standardised(scaling, thetas)?.concat(), rows, device))
}

/// Standardised parameter sets.
pub(crate) fn standardised<'a>(
    scaling: &ParameterScaling,
    thetas: impl Iterator<Item = &'a [f64]>,
) -> Result<Vec<Vec<f64>>> {
    thetas.map(|theta| Ok(scaling.standardise(theta)?)).collect()
}

/// `[rows, columns]` in single precision.
pub(crate) fn matrix(values: &[f64], rows: usize, device: &Device) -> Tensor<2> {
    let columns = values.len() / rows.max(1);
    let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
    Tensor::from_data(TensorData::new(values, [rows, columns]), device)
}

/// Numbers of a tensor on the host.
pub(crate) fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    let data = tensor.into_data();
    match data.as_slice::<f32>() {
        Ok(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Err(_) => data.iter::<f64>().collect(),
    }
}

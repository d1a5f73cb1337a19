//! Sums of two tensors and normalised rows: plain operations that Burn's own code leaves slow where it is not optimised.

use crate::fused::LayerNormalisation;
use crate::fused::host::{HostOperation, HostTensor, apply, is_on_host};
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
    match is_on_host(&a) {
        true => apply(Sum, vec![a.into_dispatch(), b.into_dispatch()]),
        false => a + b,
    }
}

#[derive(Clone, Debug)]
struct Sum;

impl HostOperation for Sum {
    type Saved = ();

    fn forward(&self, inputs: &[HostTensor], _tracked: bool) -> (HostTensor, Option<()>) {
        let sums = inputs[0].values().iter().zip(inputs[1].values()).map(|(a, b)| a + b);
        (HostTensor::new(sums.collect(), inputs[0].shape()), Some(()))
    }

    fn backward(&self, (): (), cotangent: &[f32], needed: &[bool]) -> Vec<Option<Vec<f32>>> {
        needed.iter().map(|needed| needed.then(|| cotangent.to_vec())).collect()
    }
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
    match is_on_host(&x) && x.dims()[1] > 0 {
        true => apply(
            Normalised { epsilon: epsilon as f32 },
            vec![x.into_dispatch(), gain.into_dispatch(), offset.into_dispatch()],
        ),
        false => reference::normalised(x, normalisation),
    }
}

#[derive(Clone, Debug)]
struct Normalised {
    epsilon: f32,
}

/// Gain, normal rows, and the inverse of each row's deviation.
#[derive(Clone, Debug)]
struct Normal {
    gain: HostTensor,
    rows: Vec<f32>,
    inverse: Vec<f32>,
}

impl HostOperation for Normalised {
    type Saved = Normal;

    fn forward(&self, inputs: &[HostTensor], tracked: bool) -> (HostTensor, Option<Normal>) {
        let [x, gain, offset] = inputs else { panic!("rows, gain and offset") };
        let mut output = x.values().to_vec();
        let mut rows = vec![0.0; output.len()];
        let mut inverse = vec![0.0; output.len() / gain.values().len()];
        let normalisation =
            Normalisation { gain: gain.values(), offset: offset.values(), epsilon: self.epsilon };
        normalise(normalisation, &mut output, &mut rows, &mut inverse);
        let saved = tracked.then(|| Normal { gain: gain.clone(), rows, inverse });
        (HostTensor::new(output, x.shape()), saved)
    }

    fn backward(&self, normal: Normal, cotangent: &[f32], _: &[bool]) -> Vec<Option<Vec<f32>>> {
        let Normal { gain, rows, inverse } = normal;
        let width = gain.values().len();
        let mut gradients = [vec![0.0; rows.len()], vec![0.0; width], vec![0.0; width]];
        let [of_x, of_gain, of_offset] = &mut gradients;
        pull_back_normalisation(
            gain.values(),
            &rows,
            &inverse,
            cotangent,
            of_x,
            of_gain,
            of_offset,
        );
        gradients.map(Some).into()
    }
}

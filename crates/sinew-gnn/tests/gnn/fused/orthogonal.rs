//! The Newton–Schulz iteration of Muon.

use super::comparison::random;
use burn::optim::{MuonConfig, Optimizer};
use burn::tensor::{Device, Tensor, TensorData};
use sinew_gnn::fused::orthogonalise;

const SHAPES: [[usize; 2]; 5] = [[128, 128], [120, 128], [128, 40], [3, 70], [1, 1]];

fn updates() -> Vec<Tensor<2>> {
    SHAPES.iter().zip(1..).map(|(shape, seed)| random(*shape, seed, &Device::flex())).collect()
}

fn numbers(x: Tensor<2>) -> Vec<f32> {
    x.into_data().try_to_vec().unwrap()
}

fn orthogonalised(update: Tensor<2>) -> Tensor<2> {
    let (dims, device) = (update.dims(), update.device());
    let mut values = numbers(update);
    orthogonalise(&mut values, dims[1]);
    Tensor::from_data(TensorData::new(values, dims), &device)
}

#[test]
fn agrees_with_the_optimiser_of_burn() {
    for update in updates() {
        let ours = orthogonalised(update.clone());
        let [rows, columns] = update.dims();
        let start = Tensor::zeros([rows, columns], &update.device());
        let (moved, _) = MuonConfig::new().build().step::<2>(1.0, start, update, None);
        // Burn scales the step by √max(1, rows / columns) and subtracts it.
        let scale = -(rows as f32 / columns as f32).max(1.0).sqrt();
        for (ours, theirs) in numbers(ours).iter().zip(numbers(moved)) {
            assert!(
                (ours * scale - theirs).abs() < 2e-5,
                "{rows}x{columns}: {ours} vs {}",
                theirs / scale
            );
        }
    }
}

#[test]
fn singular_values_are_near_one() {
    // Rows of a wide matrix of random numbers: σ² are the Rayleigh quotients of X Xᵀ, sampled.
    for x in updates().into_iter().map(orthogonalised) {
        let [rows, columns] = x.dims();
        let x = if rows <= columns { x } else { x.transpose() };
        let probe = random([8, x.dims()[0]], 9, &x.device());
        let images = numbers(probe.clone().matmul(x).powi_scalar(2).sum_dim(1));
        for (image, length) in images.iter().zip(numbers(probe.powi_scalar(2).sum_dim(1))) {
            let singular = (image / length).sqrt();
            assert!((0.6..1.3).contains(&singular), "{rows}x{columns}: {singular}");
        }
    }
}

#[test]
fn zero_stays_zero_and_not_a_number_stays_visible() {
    let device = Device::flex();
    let zero = Tensor::<2>::zeros([4, 6], &device);
    assert_eq!(numbers(orthogonalised(zero.clone())), [0.0; 24]);
    let broken = orthogonalised(zero.slice_fill([1..2, 1..2], f32::NAN));
    assert!(numbers(broken).iter().any(|x| x.is_nan()));
}

//! Gradients of a training through the whole network, and through the coordinates of its outputs.

use crate::clustered::Beam;
use crate::common::*;
use sinew_gnn::*;

/// Compares the fall of a loss over a short step along its gradient with the square of the gradient.
fn assert_descends(
    surrogate: &Surrogate,
    data: &DataSet,
    objective: &dyn Fn() -> Box<dyn Objective>,
) {
    /// Fall of the loss, small beside a loss of about one, and large beside its rounding and that of the weights.
    const FALL: f64 = 3e-4;
    /// The curvature of the loss.
    const TOLERANCE: f64 = 0.1;
    let start = descent(surrogate, data, objective(), 1.0).step().unwrap();
    let slope = (start.gradient_norm / TINY).powi(2);
    let mut trainer = descent(surrogate, data, objective(), FALL / slope);
    let [before, after] = [(); 2].map(|()| trainer.step().unwrap().loss / TINY);
    let fall = (before - after) / FALL;
    assert!((fall - 1.0).abs() < TOLERANCE, "{fall}: from {before} to {after}");
}

#[test]
fn short_steps_lower_the_loss_by_the_square_of_the_gradient() {
    let (_, mut data) = plane_data();
    data.geometries.truncate(1);
    data.training.retain(|sample| sample.geometry == 0);
    data.validation.clear();
    let config = small_config(&data, 2);
    for device in devices() {
        for surrogate in
            [untrained(&data, &config, 1, &device), briefly_trained(&data, &config, &device)]
        {
            assert_descends(&surrogate, &data, &|| data_fit(&surrogate));
        }
    }
}

#[test]
fn so_they_do_where_outputs_are_rigid_motions_of_clusters() {
    let beam = Beam::hanging([4, 2, 2]);
    let data = beam.data();
    for device in devices() {
        for surrogate in [beam.surrogate(&data, &device), beam.trained(&data, 5, &device)] {
            assert_descends(&surrogate, &data, &|| beam.objective());
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_numbers() {
    let beam = Beam::hanging([4, 2, 2]);
    let data = beam.data();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let surrogate = beam.trained(&data, 3, &devices()[0]);
            let thetas: Vec<_> = data.training.iter().map(|sample| sample.theta.clone()).collect();
            surrogate.predict(&data.geometries[0], &thetas).unwrap()
        })
    };
    assert_eq!(run(1), run(3));
}

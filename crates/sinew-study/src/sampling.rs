//! Where in the parameter range simulations are run: Latin hypercubes and uniform points.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// `count` points of a Latin hypercube, log-uniform over the box `ranges` (thesis §3.3.1).
///
/// Every parameter's range is cut into `count` slices of equal log-width and each slice holds one
/// point. Same seed, same points.
pub fn log_latin_hypercube(count: usize, ranges: &[[f64; 2]], seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut points = vec![vec![0.0; ranges.len()]; count];
    for (axis, [low, high]) in ranges.iter().enumerate() {
        let mut slices: Vec<usize> = (0..count).collect();
        slices.shuffle(&mut rng);
        for (point, slice) in points.iter_mut().zip(slices) {
            let fraction = (slice as f64 + rng.random::<f64>()) / count as f64;
            point[axis] = low * (high / low).powf(fraction);
        }
    }
    points
}

/// `count` independent points, uniform over the box `ranges`.
pub fn uniform(count: usize, ranges: &[[f64; 2]], seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let point = |rng: &mut ChaCha8Rng| {
        ranges.iter().map(|[low, high]| low + (high - low) * rng.random::<f64>()).collect()
    };
    (0..count).map(|_| point(&mut rng)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGES: [[f64; 2]; 2] = [[50.0, 100.0], [1.0, 25.0]];

    #[test]
    fn every_slice_of_a_latin_hypercube_holds_one_point() {
        let points = log_latin_hypercube(40, &RANGES, 3);
        for (axis, [low, high]) in RANGES.iter().enumerate() {
            let mut slices: Vec<usize> = points
                .iter()
                .map(|p| ((p[axis] / low).ln() / (high / low).ln() * 40.0) as usize)
                .collect();
            slices.sort_unstable();
            assert_eq!(slices, (0..40).collect::<Vec<_>>());
        }
    }

    #[test]
    fn points_repeat_with_the_seed_and_stay_in_the_box() {
        for sample in [log_latin_hypercube, uniform] {
            let points = sample(50, &RANGES, 7);
            assert_eq!(points, sample(50, &RANGES, 7));
            assert_ne!(points, sample(50, &RANGES, 8));
            let inside = |p: &Vec<f64>| p.iter().zip(RANGES).all(|(x, [a, b])| (a..=b).contains(x));
            assert!(points.iter().all(inside));
        }
    }
}

//! Designs of parameter sets, and shards.

use sinew_emulate::{Design, Error, Shard, share_of};
use sinew_energy::{Parameter, Sampling};

fn parameters() -> Vec<Parameter> {
    let parameter =
        |range, sampling| Parameter { name: "k".into(), unit: "kPa".into(), range, sampling };
    vec![parameter([50.0, 100.0], Sampling::Log), parameter([-4.0, 25.0], Sampling::Linear)]
}

#[test]
fn every_slice_of_a_latin_hypercube_holds_one_sample() {
    let points = Design::LatinHypercube.sample(&parameters(), 40, 3).unwrap();
    for (axis, parameter) in parameters().iter().enumerate() {
        let slice = |p: &Vec<f64>| (share_of(parameter, p[axis]) * 40.0) as usize;
        let mut slices: Vec<usize> = points.iter().map(slice).collect();
        slices.sort_unstable();
        assert_eq!(slices, (0..40).collect::<Vec<_>>());
    }
}

#[test]
fn every_half_and_quarter_holds_its_share_of_a_sobol_sequence() {
    let points = Design::Sobol.sample(&parameters(), 64, 5).unwrap();
    for boxes in [2, 4, 8] {
        let mut counts = vec![0; boxes * boxes];
        for point in &points {
            let place = |axis: usize| {
                let share = share_of(&parameters()[axis], point[axis]);
                ((share * boxes as f64) as usize).min(boxes - 1)
            };
            counts[place(0) * boxes + place(1)] += 1;
        }
        assert!(counts.iter().all(|&count| count == 64 / (boxes * boxes)), "{counts:?}");
    }
}

#[test]
fn samples_repeat_with_the_seed_and_stay_in_the_box() {
    for design in [Design::LatinHypercube, Design::Sobol, Design::Uniform] {
        let sample = |seed| design.sample(&parameters(), 50, seed).unwrap();
        assert_eq!(sample(7), sample(7));
        assert_ne!(sample(7), sample(8));
        let inside = |p: &Vec<f64>| {
            p.iter().zip(parameters()).all(|(x, k)| (k.range[0]..=k.range[1]).contains(x))
        };
        assert!(sample(7).iter().all(inside));
    }
}

#[test]
fn shares_of_ranges_are_on_the_scale_of_their_sampling() {
    let parameters = parameters();
    let [log, linear] = &parameters[..] else { panic!() };
    for share in [0.0, 0.3, 1.0, 1.2] {
        assert!((share_of(log, 50.0 * 2f64.powf(share)) - share).abs() < 1e-14);
        assert!((share_of(linear, 29.0 * share - 4.0) - share).abs() < 1e-14);
    }
}

#[test]
fn ranges_that_make_no_sense_are_named() {
    let many = Design::Sobol.sample(&parameters(), 1 << 17, 1).unwrap_err();
    assert!(matches!(many, Error::Samples(_)), "{many}");
    assert!(many.to_string().contains("131072 of 2 are too many"), "{many}");
    let mut parameters = parameters();
    parameters[0].range = [0.0, 1.0];
    let error = Design::Uniform.sample(&parameters, 3, 1).unwrap_err().to_string();
    assert!(error.contains('k') && error.contains('0'), "{error}");
}

#[test]
fn shards_are_named_by_index_and_count() {
    for text in ["1/1", "3/16", "16/16"] {
        assert_eq!(text.parse::<Shard>().map(|shard| shard.to_string()), Ok(text.into()));
    }
    // Outside of an array `$SLURM_ARRAY_TASK_ID/16` is the first of these.
    for text in ["/16", "0/16", "17/16", "3", "3/", "3/16/2"] {
        let error = text.parse::<Shard>().unwrap_err();
        assert!(error.contains(&format!("`{text}`")) && error.contains("INDEX/COUNT"), "{error}");
    }
}

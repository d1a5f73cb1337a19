//! Designs of parameter sets, and shards by the tasks of a job array.

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

/// Shard of a task whose environment is `NAME=value` with spaces between.
fn task(text: &str, environment: &str) -> Result<String, String> {
    let value = |name: &str| {
        let mut pairs = environment.split(' ').filter_map(|pair| pair.split_once('='));
        pairs.find(|(own, _)| *own == name).map(|(_, value)| value.to_string())
    };
    Shard::named(text, value).map(|shard| shard.to_string())
}

#[test]
fn tasks_of_arrays_from_nought_and_from_one_are_shards() {
    let slurm = |id: usize, min: usize, max: usize, step: usize, count: usize| {
        format!(
            "SLURM_ARRAY_TASK_ID={id} SLURM_ARRAY_TASK_MIN={min} SLURM_ARRAY_TASK_MAX={max} SLURM_ARRAY_TASK_STEP={step} \
             SLURM_ARRAY_TASK_COUNT={count}"
        )
    };
    let sge = "SGE_TASK_ID=16 SGE_TASK_FIRST=1 SGE_TASK_LAST=16 SGE_TASK_STEPSIZE=1";
    let told = "SLURM_ARRAY_TASK_ID=undefined SGE_TASK_ID=undefined PBS_ARRAY_INDEX=0";
    for (text, environment, shard) in [
        ("auto", slurm(16, 1, 16, 1, 16), "16/16"),
        ("auto", slurm(0, 0, 15, 1, 16), "1/16"),
        ("auto", slurm(15, 0, 15, 5, 4), "4/4"),
        ("auto:1-16", slurm(3, 3, 3, 1, 1), "3/16"),
        ("auto:0-15", slurm(3, 3, 7, 1, 2), "4/16"),
        ("auto", sge.into(), "16/16"),
        ("auto:0-3", told.into(), "1/4"),
        ("auto:1-16", "PBS_ARRAYID=7".into(), "7/16"),
        ("3/16", String::new(), "3/16"),
    ] {
        assert_eq!(task(text, &environment), Ok(shard.into()), "{text} {environment}");
    }
    for (text, environment, said) in [
        ("auto", String::new(), "none of SLURM_ARRAY_TASK_ID, SGE_TASK_ID, PBS_ARRAY_INDEX"),
        ("auto", "SGE_TASK_ID=undefined".into(), "none of"),
        ("auto", "PBS_ARRAY_INDEX=3".into(), "PBS tells task 3 not how many"),
        ("auto", "SLURM_ARRAY_TASK_ID=3".into(), "Slurm tells task 3 not how many"),
        ("auto", slurm(3, 3, 3, 1, 1), "a part of an array only: 3 to 3"),
        ("auto", slurm(1, 1, 9, 1, 3), "a part of an array only: 1 to 9"),
        ("auto:1-16", "PBS_ARRAY_INDEX=0".into(), "task 0 is not one of an array 1-16"),
        ("auto:0-15", "PBS_ARRAY_INDEX=16".into(), "task 16 is not one of an array 0-15"),
        ("auto:16", "PBS_ARRAY_INDEX=3".into(), "auto:FIRST-LAST"),
        ("automatic", "PBS_ARRAY_INDEX=3".into(), "INDEX/COUNT"),
        ("3", String::new(), "INDEX/COUNT"),
    ] {
        let error = task(text, &environment).unwrap_err();
        assert!(error.contains(said), "{text} {environment}: {error}");
    }
}

//! Directions that data identify, and the verdict of a calibration.

use super::*;

#[test]
fn what_data_identify_is_said_before_anything_is_sampled() {
    let problem = Problem::new(unknowns(), data(3, 1.0), Vec::new()).unwrap();
    let mut solves = Solves::new(&Sphere);
    let (mode, seen) = check_identifiability(&problem, &mut solves).unwrap();
    assert!(solves.count() < 20, "{}", solves.count());
    let posterior = run(data(3, 1.0));
    // Two numbers that are the same for a normal posterior.
    for parameter in 0..2 {
        let [ahead, drawn] = [seen.contraction[parameter], posterior.contraction(parameter)];
        assert!((ahead / drawn).ln().abs() < 0.5, "{ahead} {drawn}");
    }
    assert!(mode.misfits.iter().all(|z| z.abs() < 4.0));
}

fn verdict(data: Vec<Datum>, kinds: Vec<Kind>) -> (Verdict, String) {
    let problem = Problem::new(unknowns(), data, kinds).unwrap();
    let mut solves = Solves::new(&Sphere);
    let (mode, seen) = check_identifiability(&problem, &mut solves).unwrap();
    seen.verdict(&problem, &mode)
}

#[test]
fn the_verdict_names_the_number_that_decides() {
    let says = |data, kinds, expected: Verdict, words: &str| {
        let (verdict, said) = verdict(data, kinds);
        assert!(verdict == expected && said.contains(words), "{verdict:?}: {said}");
    };
    says(data(3, 1.0), Vec::new(), Verdict::Calibrates, "1 of 2 directions");
    says(data(5, 2.0), Vec::new(), Verdict::DoesNot, "(at least 0.01)");
    // A volume at the pressure of the image tells nothing.
    says(vec![volume(2, 121.0, 2.0)], Vec::new(), Verdict::DoesNot, "is left (at most 0.5)");
    let exact = Sphere.observe(&truth(), false).unwrap().values;
    let one = |share: f64| vec![volume(4, exact[4], share * exact[4])];
    says(one(0.03), Vec::new(), Verdict::CannotTell, "degrees of freedom");
    says(one(0.1), Vec::new(), Verdict::CannotTell, "is left (at most 0.5)");
    let inferred = |name: &str| Kind { name: name.into(), inferred: true, bias: 0.0 };
    let kinds = vec![inferred("strain"), inferred("volume")];
    says(data(5, 2.0), kinds, Verdict::CannotTell, "0.00 degrees of freedom");
}

#[test]
fn data_whose_misfits_overflow_are_an_error() {
    let problem = Problem::new(unknowns(), vec![volume(4, 1e3, 1e-170)], Vec::new()).unwrap();
    let mut solves = Solves::new(&Sphere);
    let refused = check_identifiability(&problem, &mut solves);
    assert!(matches!(refused, Err(CalibrateError::NoStart { .. })), "{refused:?}");
}

#[test]
fn one_verdict_in_a_hundred_refuses_the_right_model() {
    let wrong =
        (0..200).filter(|seed| verdict(data(1000 + seed, 1.0), Vec::new()).0 == Verdict::DoesNot);
    // 0.01 of 200, below the 99.9 % quantile of a binomial distribution.
    let wrong = wrong.count();
    println!("{wrong} of 200");
    assert!(wrong <= 7, "{wrong}");
}

#[test]
fn a_parameter_near_the_end_of_its_range_is_identified_as_in_the_middle() {
    let exact = Sphere.observe(&truth(), false).unwrap().values;
    let left = |low, high| {
        let b = Prior::LogUniform { range: [4.99, 5.01] };
        let a = Prior::LogUniform { range: [low, high] };
        let unknowns = vec![Unknown::new("a", "kPa", a), Unknown::new("b", "", b)];
        let data = [1, 3, 4].map(|at| volume(at, exact[at], 0.001 * exact[at]));
        let problem = Problem::new(unknowns, data.to_vec(), Vec::new()).unwrap();
        check_identifiability(&problem, &mut Solves::new(&Sphere)).unwrap().1.contraction[0]
    };
    // The same width of the range; the mode is 0.1 % of it from an end, where its coordinate is 3.
    let [middle, end] = [left(0.08, 0.78), left(0.0256, 0.2506)];
    assert!((end / middle).ln().abs() < 0.2, "{middle} {end}");
}

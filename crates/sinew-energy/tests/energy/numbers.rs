//! Numbers as people write and read them: units, bounds and elastic constants.

use sinew_energy::laws::lame_from_young_poisson;
use sinew_energy::{Unit, requirement};

#[test]
fn values_go_there_and_back_as_they_were_written() {
    let mmhg = Unit::sized("mmHg", 0.133_322_387_415);
    for tenth in 1..2000 {
        let written = f64::from(tenth) / 10.0;
        assert_eq!(mmhg.shown(mmhg.in_scene(written)), written);
    }
    let scene = Unit::from("kPa");
    assert_eq!(scene.shown(0.1 + 0.2), 0.1 + 0.2);
    assert_eq!(scene.head("a"), "a [kPa]");
    assert_eq!(
        [1e120, -0.25, 2e-9].map(|x| scene.format(x)),
        ["1e120 kPa", "-0.25 kPa", "2e-9 kPa"]
    );
    assert!(mmhg.shown(f64::NAN).is_nan());
}

#[test]
fn requirements_are_words() {
    let positive = 1e-100..=1e100;
    assert_eq!(requirement(&positive, -2.0), "positive");
    assert!(requirement(&positive, 1e120).starts_with("between 1e-100 and 1e100"));
    assert_eq!(requirement(&(0.0..=0.5 - f64::EPSILON), 0.5), "at least 0 and less than 0.5");
    assert_eq!(requirement(&(0.0..=1e100), -1.0), "at least 0");
    assert_eq!(requirement(&(-1.0..=2.0), 3.0), "at least -1 and at most 2");
    assert_eq!(requirement(&(f64::MIN..=f64::MAX), f64::NAN), "finite");
}

#[test]
fn lames_parameters_are_those_of_tables() {
    let [shear, lame] = lame_from_young_poisson(10.0, 0.3);
    assert!((shear - 3.8461538461538463).abs() < 1e-14);
    assert!((lame - 5.769230769230769).abs() < 1e-14);
}

//! Numbers with units, names that are misspelt, and the lines at which a case file is wrong.

use crate::keys::{case, refusal};
use sinew::case::stress_in_kpa;
use sinew::mesh::box_tetrahedra;
use sinew::{
    Case, Parameter, Scene, Support, Unit, admissible, laws::NeoHookean, parse_theta, parse_way,
};

/// Millimetre of mercury \[kPa\].
const MMHG: f64 = 0.133_322_387_415;

const BAR: &str = r#"law = "neo-hookean"
parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
mesh = { box = { extent = [30.0, 6.0, 9.0], cells = [6, 2, 2] } }
[[loads]]
facets = "z_max"
traction = [0.0, 0.0, 0.1]
[[loads]]

facets = "z_min"
traction = [0.0, 0.0, 0.2]
[[supports]]
clamped = "x_min"
"#;

#[test]
fn stresses_are_read_into_scenes_of_any_unit() {
    let read = |text: &str, unit: Unit| {
        let parameter = Parameter::log("mu", unit, 1e-3..=1.0);
        parse_theta(text, &[parameter]).unwrap()[0]
    };
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    assert!(near(read("mu=75kPa", Unit::from("MPa")), 0.075));
    assert!(near(read("mu=0.075", Unit::from("MPa")), 0.075));
    assert!(near(read("mu=2 MPa", Unit::from("Pa")), 2e6));
    // In kPa, said in mmHg.
    let mmhg = || Unit::sized("mmHg", MMHG);
    assert!(near(read("mu=8", mmhg()), 8.0 * MMHG));
    assert!(near(read("mu=2 kPa", mmhg()), 2.0));
    // Bounds of a law are in the unit of the scene, which is said where the parameter has another.
    let told = |unit: Unit| {
        let body = Scene::new(box_tetrahedra([3.0, 1.0, 1.0], [2, 1, 1]), NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
            .parameter(Parameter::log("lambda", unit, 8.0..=16.0))
            .support(Support::clamped("x_min"))
            .lower()
            .unwrap();
        admissible(&body, &[9.0, -2.0]).unwrap_err()
    };
    let of_mmhg = told(mmhg());
    assert!(of_mmhg.ends_with("it must be at least 0 (kPa)"), "{of_mmhg}");
    let of_kpa = told(Unit::from("kPa"));
    assert!(of_kpa.ends_with("it must be at least 0"), "{of_kpa}");
}

#[test]
fn letters_may_be_large_or_small_where_one_unit_is_meant() {
    for unit in ["mmhg", "MMHG", "kpa", "KPA", "pa", "MPA", "Mpa", "DYN/CM2"] {
        assert!(stress_in_kpa(unit).is_some(), "{unit}");
    }
    let mu = [Parameter::log("mu", "kPa", 8.0..=16.0)];
    let error = |unit: &str| parse_theta(&format!("mu=9{unit}"), &mu).unwrap_err().to_string();
    assert!(error("mPa").contains("M is mega and m is milli"), "{}", error("mPa"));
    let units = "units of stress: kPa, mmHg, Pa, MPa, dyn/cm2";
    assert!(error("bar").ends_with(units), "{}", error("bar"));
    let scaled = |unit: &str, extent: &str| {
        let mesh = format!("mesh = {{ unit = \"{unit}\", box = {{ extent = {extent}");
        BAR.replace("mesh = { box = { extent = [30.0, 6.0, 9.0]", &mesh)
    };
    let micrometres = ["UM", "µm", "\u{3bc}m"].map(|unit| (unit, "[3e4, 6e3, 9e3]"));
    let lengths = [("CM", "[3.0, 0.6, 0.9]"), ("M", "[0.03, 6e-3, 9e-3]")];
    let lengths = lengths.into_iter().chain(micrometres);
    for (unit, extent) in lengths {
        let body = case(&scaled(unit, extent)).body().unwrap();
        let longest = body.positions.iter().fold(0.0_f64, |most, x| most.max(x[0]));
        assert!((longest - 30.0).abs() < 1e-9, "{unit}: {longest}");
    }
    refusal(&scaled("Mm", "[30.0, 6.0, 9.0]"), &["mesh.unit", "M is mega and m is milli"]);
    refusal(&scaled("nm", "[3e7, 6e6, 9e6]"), &["`nm`", "units of length: mm, cm, m, um"]);
}

#[test]
fn an_error_has_the_line_of_its_key() {
    assert!(case(BAR).body().is_ok());
    let line = |from: &str, to: &str| {
        let text = BAR.replace(from, to);
        let error = Case::parse(&text, "bar.toml").and_then(|case| case.body()).unwrap_err();
        (error.line, error.key)
    };
    // Values in a table, in the entries of an array of tables, and in the line of all of it.
    assert_eq!(line("\"z_max\"", "\"front\""), (Some(5), "loads.0.facets".into()));
    assert_eq!(line("\"z_min\"", "\"back\""), (Some(9), "loads.1.facets".into()));
    assert_eq!(line("\"x_min\"", "\"left\""), (Some(12), "supports.0.clamped".into()));
    assert_eq!(line("mu = [8.0, 16.0]", "mu = [16.0, 8.0]").0, Some(2));
    // The table that lacks a key.
    assert_eq!(line("mu = [8.0, 16.0], ", "").0, Some(2));
}

#[test]
fn a_near_word_is_suggested_and_a_far_one_listed() {
    let advice = |word: &str, names: &[&str]| {
        let known: Vec<Parameter> =
            names.iter().map(|name| Parameter::log(*name, "kPa", 1.0..=2.0)).collect();
        let told = parse_way(&format!("{word}=1..2"), &known).unwrap_err().to_string();
        told.split("is not a parameter").nth(1).unwrap_or(&told).to_string()
    };
    let known = ["mu", "lambda", "endocardium"];
    let listed = "; parameters: mu, lambda, endocardium";
    assert_eq!(advice("lamda", &known), "; did you mean `lambda`?");
    assert_eq!(advice("Endocard", &known), "; did you mean `endocardium`?");
    assert_eq!(advice("p", &known), listed);
    assert_eq!(advice("pressure", &known), listed);
    assert_eq!(advice("18", &["1", "17"]), "; parameters: 1, 17");
}

#[test]
fn half_of_the_way_to_a_turn_is_on_its_chord() {
    let turned = "clamped = \"x_min\"\n[[supports]]\nnodes = \"x_max\"\naxis = [1.0, 0.0, 0.0]\n\
                  point = [0.0, 5.0, 5.0]\nturn = { degrees = 90.0, share = 0.5 }\n";
    let body = case(&BAR.replace("clamped = \"x_min\"\n", turned)).body().unwrap();
    let nodes = &body.mesh.node_sets()["x_max"];
    assert!(nodes.len() >= 9);
    for &node in nodes {
        // An arm (y, z) about x turns to (−z, y).
        let [y, z] = [1, 2].map(|axis| body.positions[node][axis] - 5.0);
        let chord = [0.0, 0.5 * (-z - y), 0.5 * (y - z)];
        for (axis, expected) in chord.into_iter().enumerate() {
            let found = body.prescribed[3 * node + axis].expect("a prescribed displacement");
            // A few roundings of lengths below ten.
            assert!((found - expected).abs() < 4e-15, "{node} {axis}: {found} {expected}");
        }
    }
}

//! Cases that mean something else than they say: units, loads and parameters without effect, cells that lose their volume.

use crate::answers::{PLATE, column, done, plate, sinew};
use sinew::Case;
use sinew::case::negligible_displacement;

/// Message about a plate with another text in it.
fn warnings(from: &str, to: &str) -> Vec<String> {
    assert!(PLATE.contains(from));
    let case = Case::parse(&PLATE.replacen(from, to, 1), "plate.toml").unwrap();
    case.warnings(&case.body().unwrap())
}

#[test]
fn what_no_tissue_has_is_warned_of() {
    assert!(warnings("[mesh]", "[mesh]").is_empty());
    let said = |from: &str, to: &str, words: &[&str]| {
        let found = warnings(from, to);
        let [warning] = &found[..] else { panic!("{to}: {found:?}") };
        assert!(words.iter().all(|word| warning.contains(word)), "{warning}");
    };
    said("[mesh]", "[mesh]\nunit = \"um\"", &["plate.toml, line 6, mesh", "0.03 mm", "unit ="]);
    said(
        "[mesh]",
        "[mesh]\nunit = \"m\"",
        &["mesh", "mm in size", "between 1 and 1000 mm", "are in mm, write \"mm\""],
    );
    said("mu = [8.0, 16.0]", "mu = [8e3, 16e6]", &["line 9, parameters", "kPa", "unit = \"Pa\""]);
    let soft = "mu = { range = [8.0, 16.0], unit = \"Pa\" }";
    said("mu = [8.0, 16.0]", soft, &["line 9, parameters", "0.008 kPa", "0.01 and"]);
    let all = "extent = [30.0, 20.0, 6.0], cells = [1, 1, 1]";
    said("extent = [30.0, 20.0, 6.0], cells = [4, 3, 2]", all, &["supports", "every node"]);
}

#[test]
fn loads_and_parameters_without_effect_are_warned_of() {
    let case = |more: &str| {
        let text = format!(
            "law = \"neo-hookean-young\"\nmesh.box = {{ extent = [30.0, 6.0, 6.0], cells = [4, 1, 1] }}\n\
             supports = [{{ clamped = \"x_min\" }}, {more}"
        );
        let case = Case::parse(&text, "bar.toml").unwrap();
        case.warnings(&case.body().unwrap())
    };
    let ranges = "parameters = { E = [8.0, 16.0], nu = [0.2, 0.4] }";
    let found = case(&format!("]\n{ranges}"));
    assert!(
        found.len() == 1 && found[0].contains("loads") && found[0].contains("zero"),
        "{found:?}"
    );
    let weight = "loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]";
    assert!(case(&format!("]\n{weight}\n{ranges}")).is_empty());
    // A common factor of all stresses changes no displacement that supports prescribe.
    let found = case(&format!("{{ nodes = \"x_max\", x = 1.0 }}]\n{ranges}"));
    assert!(found.len() == 1 && found[0].contains("parameters.E"), "{found:?}");
    assert!(case(&format!("{{ nodes = \"x_max\", x = 1.0 }}]\n{weight}\n{ranges}")).is_empty());
    // Springs beside which all other forces are rounding errors.
    for (springs, loaded) in [(1e30, true), (1e30, false), (1.0, false)] {
        let weight = if loaded { weight } else { "loads = [" }.trim_end_matches(']');
        let comma = if loaded { "," } else { "" };
        let springs = format!(
            "{{ foundation = {{ normal = {springs:e}, tangential = 0.0 }}, facets = \"x_max\" }}]"
        );
        let found = case(&format!("]\n{weight}{comma} {springs}\n{ranges}"));
        let told = found.iter().any(|warning| warning.contains("nothing moves"));
        assert!(told != loaded && found.len() == usize::from(told), "{springs}: {found:?}");
    }
    // A pressure on held nodes.
    let found = case(
        "]\nloads = [{ body_force = [0.0, 0.0, -9.8e-3] }, { pressure = \"p\", facets = \"x_min\" }]\n\
         parameters = { E = [8.0, 16.0], nu = [0.2, 0.4], p = [1.0, 2.0] }",
    );
    assert!(found.len() == 1 && found[0].contains("parameters.p"), "{found:?}");
}

#[test]
fn fibres_and_loads_that_do_nothing_are_warned_of() {
    let case = |more: &str| {
        let text = format!(
            "law = \"neo-hookean-young\"\nmesh.box = {{ extent = [30.0, 6.0, 6.0], cells = [4, 1, 1] }}\n\
             parameters = {{ E = [8.0, 16.0], nu = [0.2, 0.4] }}\nsupports = [{{ clamped = \"x_min\" }}]\n\
             loads = [{{ body_force = [0.0, 0.0, -9.8e-3] }}{more}"
        );
        let case = Case::parse(&text, "bar.toml").unwrap();
        case.warnings(&case.body().unwrap())
    };
    assert!(case("]").is_empty());
    let springs = ", { foundation = { normal = 0.0, tangential = 1.0 }, facets = \"x_max\" }";
    assert!(case(&format!("{springs}]")).is_empty());
    let zero = [
        &springs.replace("1.0", "0.0"),
        ", { body_force = [0.0, 0.0, 0.0] }",
        ", { traction = [0.0, 0.0, 0.0], facets = \"x_max\" }",
    ];
    for load in zero {
        let found = case(&format!("{load}]"));
        assert!(found.len() == 1 && found[0].contains("line 5, loads.1: it is zero"), "{found:?}");
    }
    for fibres in ["direction = [1.0, 0.0, 0.0]", "field = \"fibre\""] {
        let found = case(&format!("]\nfibres.{fibres}"));
        let [told] = &found[..] else { panic!("{found:?}") };
        let words = ["line 6, fibres", "`neo-hookean-young` is isotropic", "remove [fibres]"];
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
    }
}

#[test]
fn a_bulk_modulus_in_megapascals_is_warned_of() {
    let case = |modulus: &str| {
        let text = format!(
            "law = {{ name = \"neo-hookean-isochoric\", bulk_modulus = {modulus} }}\n\
             mesh.box = {{ extent = [30.0, 6.0, 6.0], cells = [1, 1, 1] }}\nparameters.mu = [1.0, 4.0]\n\
             supports = [{{ clamped = \"x_min\" }}]\nloads = [{{ body_force = [0.0, 0.0, -9.8e-3] }}]"
        );
        let case = Case::parse(&text, "bar.toml").unwrap();
        case.warnings(&case.body().unwrap())
    };
    // Poisson's ratio (3 κ − 2 μ)/(6 κ + 2 μ) is negative from κ = ⅔ μ = 2.67 kPa downwards.
    assert!(case("2.7").is_empty());
    let found = case("2.6");
    let words = ["line 1, law.bulk_modulus", "2.6 kPa", "shear modulus 4 kPa", "in kPa"];
    assert!(found.len() == 1 && words.iter().all(|word| found[0].contains(word)), "{found:?}");
}

#[test]
fn no_load_is_told_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let still = "law = \"neo-hookean\"\nsupports = [{ clamped = \"z_min\" }]\nmesh.box = { extent = [8.0, 8.0, 20.0], cells = [1, 1, 3] }\n\
        parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }\ntraining = { samples = 4, held_out = 3 }\n";
    std::fs::write(folder.join("still.toml"), still).unwrap();
    let commands = [
        "solve still.toml",
        "sample still.toml --count 3 --solve",
        "predict still.toml --accuracy 1e-3",
        "train still.toml --recipe regression",
        "evaluate still.toml --cases 3",
        "export still.toml --page",
    ];
    for command in commands {
        let (_, told) = sinew(folder, command);
        assert!(told.contains("nothing moves the body"), "{command}: {told}");
    }
}

#[test]
fn cells_that_lose_their_volume_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let soft = "law = \"neo-hookean\"\nsupports = [{ clamped = \"x_min\" }]\nloads = [{ traction = [-1.0, 0.0, 0.0], facets = \"x_max\" }]\n\
        mesh.box = { extent = [8.0, 8.0, 8.0], cells = [2, 2, 2] }\nparameters = { mu = [0.05, 10.0], lambda = [0.05, 10.0] }\n";
    std::fs::write(folder.join("soft.toml"), soft).unwrap();
    let told = done(folder, "solve soft.toml --theta mu=10,lambda=10");
    assert!(told.contains(", J 0.9") && !told.contains("volume ratio J falls"), "{told}");
    let told = done(folder, "solve soft.toml --theta mu=0.1,lambda=0.1");
    assert!(told.contains("the volume ratio J falls to 0."), "{told}");
    let least = column(&folder.join("out/soft/solve"), "cases.csv", "solved least J");
    let most = column(&folder.join("out/soft/solve"), "cases.csv", "solved largest J");
    let [least, most] = [&least[0], &most[0]].map(|cell| cell.parse::<f64>().unwrap());
    assert!(least < 0.2 && least < most, "{least} {most}");
    // 1 kPa on 64 mm².
    let force =
        column(&folder.join("out/soft/solve"), "cases.csv", "solved reaction x at x_min [kPa mm2]");
    assert!((force[0].parse::<f64>().unwrap() - 64.0).abs() < 1e-8, "{force:?}");
}

#[test]
fn fibre_angles_that_may_be_radians_are_asked_about() {
    let asked = |angles: &str| {
        let text = format!(
            "law = {{ name = \"guccione\", bulk_modulus = 25.0 }}\nsupports = [{{ clamped = \"base\" }}]\nloads = [{{ pressure = \"p\", facets = \"endo\" }}]\n\
             mesh.ellipsoid = {{ short = [22.0, 36.0], long = [58.0, 74.0], base = 0.0, cells = [1, 16, 8] }}\n\
             fibres.rule = {{ endocardium = \"endo\", epicardium = \"epi\", base = \"base\", angles = {angles} }}\n\
             parameters = {{ C = [1.0, 2.0], b_f = [8.0, 9.0], b_t = [2.0, 3.0], b_fs = [4.0, 5.0], p = [0.5, 1.0] }}\n"
        );
        let case = Case::parse(&text, "heart.toml").unwrap();
        let found = case.warnings(&case.body().unwrap());
        found.iter().any(|warning| warning.contains("radians? Then give [60.0, -60.0]"))
    };
    assert!(asked("[1.0472, -1.0472]") && !asked("[60.0, -60.0]") && !asked("[0.0, 0.0]"));
}

#[test]
fn a_load_that_moves_nothing_is_warned_of() {
    let folder = plate();
    let told = done(folder.path(), "solve plate.toml --theta mu=10,p=1e-7");
    assert!(told.contains("less than a millionth of the body's size of 30 mm"), "{told}");
    let body = Case::parse(PLATE, "plate.toml").unwrap().body().unwrap();
    let moved = |largest: f64| negligible_displacement(&body, &vec![largest; 3 * body.nodes]);
    assert!(moved(1e-5).is_some() && moved(1e-4).is_none());
    let told = done(folder.path(), "solve plate.toml --theta mu=10,p=0 --theta mu=10,p=1");
    assert!(!told.contains("less than a millionth"), "{told}");
    let range = "{ range = [-4.0, 4.0], sampling = \"linear\", ";
    let about_zero = PLATE.replace("{ range = [1.0, 4.0], ", range);
    std::fs::write(folder.path().join("zero.toml"), about_zero).unwrap();
    let told = done(folder.path(), "train zero.toml");
    assert!(told.contains("too stiff") && !told.contains("less than a millionth"), "{told}");
}

#[test]
fn a_load_in_a_smaller_unit_moves_the_body_beyond_its_size() {
    // 500 Pa, read as kPa.
    let bar = r#"
law = "neo-hookean"
loads = [{ traction = [0.0, 0.0, -500.0], facets = "x_max" }]
supports = [{ clamped = "x_min" }]
mesh.box = { extent = [20.0, 10.0, 10.0], cells = [4, 2, 2] }
parameters = { mu = [1.0, 20.0], lambda = 15.0 }
"#;
    let folder = tempfile::tempdir().unwrap();
    let told = |text: &str| {
        std::fs::write(folder.path().join("bar.toml"), text).unwrap();
        done(folder.path(), "solve bar.toml --theta mu=10")
    };
    let far = told(bar);
    assert!(far.contains("and the body's size is 20 mm; look at the loads"), "{far}");
    let near = told(&bar.replace("500.0", "0.5"));
    assert!(!near.contains("the body's size"), "{near}");
}

//! Warnings of cells that are too stiff, and the head of the report.

use sinew::Case;
use std::path::Path;
use std::process::Command;

const BAR: &str = r#"
law = "neo-hookean-young"
loads = [{ body_force = [0.0, 0.0, -9.8e-4] }]
supports = [{ clamped = "x_min" }]
mesh.box = { extent = [40.0, 6.0, 6.0], cells = [8, 2, 2] }
parameters = { E = [8.0, 16.0], nu = [0.2, 0.3] }
training = { recipe = "regression", samples = 9, held_out = 3 }
"#;

/// Cube that is not bent: only the volume can make its cells too stiff.
const CUBE: &str = r#"
law = "neo-hookean-young"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh.box = { extent = [10.0, 10.0, 10.0], cells = [3, 3, 3] }
parameters = { E = [8.0, 16.0], nu = [0.2, 0.45] }
training = { recipe = "taylor", held_out = 2 }
"#;

fn folder(name: &str, text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), text).unwrap();
    folder
}

/// Exit code and what was printed, standard error last.
fn sinew(folder: &Path, arguments: &str) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    let output = command.current_dir(folder).args(arguments.split_whitespace()).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code().unwrap(), String::from_utf8(text).unwrap())
}

/// The number between two words.
fn number(text: &str, before: &str, after: &str) -> f64 {
    let from = text.split(before).nth(1).unwrap_or_else(|| panic!("{before} in {text}"));
    from.split(after).next().unwrap().trim().parse().unwrap_or_else(|_| panic!("{text}"))
}

#[test]
fn a_solve_says_what_its_cells_lose_and_measures_it_on_request() {
    let folder = folder("bar.toml", BAR);
    let (code, told) = sinew(folder.path(), "solve bar.toml --check-mesh");
    assert_eq!(code, 0, "{told}");
    let expected = number(&told, "expected to lose ", " %");
    let lost = number(told.split("mean displacement").nth(1).unwrap(), " mm, ", " % lost");
    assert!((0.5..=2.0).contains(&(expected / lost)), "{told}");
    assert!(told.contains("formulation = \"quadratic\"") && told.contains("at most;"), "{told}");

    let quadratic = format!("formulation = \"quadratic\"\n{BAR}");
    std::fs::write(folder.path().join("quadratic.toml"), quadratic).unwrap();
    let (code, told) = sinew(folder.path(), "solve quadratic.toml");
    assert!(code == 0 && !told.contains("too stiff"), "{told}");
    let (code, told) = sinew(folder.path(), "solve quadratic.toml --check-mesh");
    assert!(code == 2 && told.contains("quadratic tetrahedra already"), "{told}");
}

#[test]
fn bulk_and_shear_are_those_of_the_parameters_asked_for() {
    let folder = folder("cube.toml", CUBE);
    let solve = |nu: f64| sinew(folder.path(), &format!("solve cube.toml --theta E=10,nu={nu}"));
    let (code, told) = solve(0.3);
    assert!(code == 0 && told.contains("too stiff") && !told.contains("K/mu"), "{told}");
    let (_, told) = solve(0.45);
    assert!(told.contains("K/mu = 9.7 is above 5"), "{told}");
    // A training is judged in the middle of its ranges, a path at its end.
    for arguments in ["train cube.toml", "solve cube.toml --along nu=0.2..0.3 --frames 2"] {
        let (code, told) = sinew(folder.path(), arguments);
        assert!(code == 0 && told.contains("too stiff"), "{told}");
    }
    for command in ["predict", "correct"] {
        let arguments = format!("{command} cube.toml --theta E=10,nu=0.45");
        let (code, told) = sinew(folder.path(), &arguments);
        assert!(code == 0 && told.contains("K/mu = 9.7 is above 5"), "{told}");
    }
    // The page with sliders says it too.
    let (code, told) = sinew(folder.path(), "export cube.toml --page");
    let page = std::fs::read_to_string(folder.path().join("out/cube/taylor.html")).unwrap();
    assert!(code == 0 && told.contains("too stiff") && page.contains("too stiff"), "{told}");
}

#[test]
fn of_many_sets_the_one_that_moves_most_is_judged() {
    let folder = folder("bar.toml", &BAR.replace("-9.8e-4", "-9.8e-3"));
    std::fs::write(folder.path().join("t.csv"), "E,nu\n16,0.2\n8,0.2\n12,0.2\n").unwrap();
    let lost = |arguments: &str| {
        let (code, told) = sinew(folder.path(), arguments);
        assert_eq!(code, 0, "{arguments}: {told}");
        number(&told, "expected to lose ", " %")
    };
    let [first, most] = [16, 8].map(|e| lost(&format!("solve bar.toml --theta E={e},nu=0.2")));
    assert_ne!(first, most);
    lost("train bar.toml");
    for command in ["solve", "predict", "correct"] {
        let alone = lost(&format!("{command} bar.toml --theta E=8,nu=0.2"));
        assert_eq!(lost(&format!("{command} bar.toml --theta t.csv")), alone, "{command}");
    }
    assert_eq!(lost("predict bar.toml --theta t.csv --accuracy 1e-3"), most);
    lost("sample bar.toml --count 2 --solve");
}

#[test]
fn auto_chooses_cells_that_lose_little() {
    let body = |text: &str| Case::parse(text, "case.toml").unwrap().body().unwrap();
    let auto = |text: &str| body(&format!("formulation = \"auto\"\n{text}"));
    assert_eq!(auto(BAR).nodes_per_cell, 10, "bending needs quadratic tetrahedra");
    let cube = auto(&CUBE.replace("0.45", "0.3").replace("[3, 3, 3]", "[6, 6, 6]"));
    assert_eq!((cube.nodes_per_cell, cube.patches.len()), (4, 0), "nothing locks");
    let incompressible = |text: &str, range: &str| text.replace(range, "[0.45, 0.49]");
    let cube = auto(&incompressible(CUBE, "[0.2, 0.45]"));
    assert!(cube.nodes_per_cell == 4 && !cube.patches.is_empty(), "only the volume locks");
    let bricks = BAR.replace("[8, 2, 2] }", "[8, 2, 2] }\nmesh.element = \"hexahedra\"");
    let bricks = auto(&incompressible(&bricks, "[0.2, 0.3]"));
    assert!(bricks.nodes_per_cell == 8 && !bricks.patches.is_empty());
    // Whatever it chooses, a body that was lowered so is the body of that formulation.
    let own = body(&format!("formulation = \"quadratic\"\n{BAR}"));
    assert_eq!(auto(BAR).positions, own.positions);
}

#[test]
fn a_scene_that_is_copied_is_the_body_of_its_name() {
    let folder = tempfile::tempdir().unwrap();
    for scene in sinew::scenes::SCENES {
        let (_, text) = sinew(folder.path(), &format!("new {}", scene.name));
        assert_eq!(text, scene.text, "{}", scene.name);
        assert!(text.contains("\nformulation = "), "{}", scene.name);
    }
}

#[test]
fn the_head_of_a_report_says_what_has_to_be_known() {
    let folder = folder("bar.toml", BAR);
    let run = |arguments: &str| {
        let (code, told) = sinew(folder.path(), arguments);
        assert_eq!(code, 0, "{told}");
        told
    };
    run("train bar.toml");
    assert!(run("evaluate bar.toml --cases 6").contains("expected to lose"));
    let page = std::fs::read_to_string(folder.path().join("out/bar/report.html")).unwrap();
    let head = page.split("In short").nth(1).unwrap().split("<h2").next().unwrap();
    for said in ["expected to lose", "regression is the most accurate", "95 % within"] {
        assert!(head.contains(said), "{said}: {head}");
    }
    // Largest and 95 % beside medians; refused and hurt; motion; seed, case and options of the training.
    for said in [
        "largest",
        "0 of 6",
        "How the body moves",
        "one linear scale",
        "training of regression",
        "neo-hookean-young",
        "seed",
        "32343",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // Three digits are enough; positions in drawings have more.
    let cells = page.split("<td").skip(1).map(|cell| cell.split("</td>").next().unwrap());
    let long = cells.filter(|cell| cell.contains(".666666") || cell.contains(".333333"));
    assert_eq!(long.collect::<Vec<_>>(), [""; 0]);
}

//! `docs/case-file.md` and the parser say the same, and mistakes are answered with the key that was meant.

use sinew::Case;
use std::path::Path;
use toml::{Table, Value};

const PAGE: &str = include_str!("../../../../docs/case-file.md");

/// The TOML blocks of the page.
pub(crate) fn blocks() -> Vec<&'static str> {
    let blocks: Vec<_> =
        PAGE.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(blocks.len() >= 4);
    blocks
}

/// The block with everything at once.
fn chamber() -> &'static str {
    blocks().into_iter().find(|block| block.contains("Chamber")).unwrap()
}

/// Message about a case that must be refused.
pub(crate) fn refusal(text: &str) -> String {
    let body = Case::parse(text, "case.toml").and_then(|case| case.body());
    let error = body.err().unwrap_or_else(|| panic!("was to be refused:\n{text}")).to_string();
    assert!(error.starts_with("case.toml"), "{error}");
    error
}

#[test]
fn every_block_of_the_page_is_a_body() {
    for block in blocks() {
        let case = Case::parse(block, "page.toml").unwrap();
        if let Some(file) = &case.mesh.file {
            let file = file.display().to_string();
            assert!(case.body().unwrap_err().to_string().contains(&file));
        } else {
            case.body().unwrap_or_else(|error| panic!("{error}\n{block}"));
        }
    }
}

/// Calls with every key of every table, and a way to rename it.
fn each_key(value: &mut Value, root: &mut dyn FnMut(&str)) {
    match value {
        Value::Table(table) => {
            for key in table.keys().cloned().collect::<Vec<_>>() {
                root(&key);
                if let Some(inner) = table.get_mut(&key) {
                    each_key(inner, root);
                }
            }
        }
        Value::Array(array) => array.iter_mut().for_each(|inner| each_key(inner, root)),
        _ => {}
    }
}

/// Document with its `wanted`-th key misspelt, and that key.
fn misspelt(document: &Table, wanted: usize) -> Option<(String, String)> {
    fn visit(value: &mut Value, left: &mut usize) -> Option<String> {
        match value {
            Value::Table(table) => {
                for key in table.keys().cloned().collect::<Vec<_>>() {
                    if *left == 0 {
                        let inner = table.remove(&key)?;
                        let last = key.chars().last()?;
                        table.insert(format!("{key}{last}"), inner);
                        return Some(key);
                    }
                    *left -= 1;
                    if let Some(found) = visit(table.get_mut(&key)?, left) {
                        return Some(found);
                    }
                }
                None
            }
            Value::Array(array) => array.iter_mut().find_map(|inner| visit(inner, left)),
            _ => None,
        }
    }
    let mut value = Value::Table(document.clone());
    let mut left = wanted;
    let key = visit(&mut value, &mut left)?;
    Some((toml::to_string(&value).unwrap(), key))
}

#[test]
fn each_misspelt_key_is_named_with_the_one_that_was_meant() {
    let mut tried = std::collections::BTreeSet::new();
    for block in blocks() {
        let document: Table = toml::from_str(block).unwrap();
        let mut count = 0;
        each_key(&mut Value::Table(document.clone()), &mut |_| count += 1);
        for wanted in 0..count {
            let (text, key) = misspelt(&document, wanted).unwrap();
            let error = refusal(&text);
            let last = key.chars().last().unwrap();
            assert!(error.contains(&format!("{key}{last}")), "{key}: {error}");
            // Of a selection and its reference either may be misspelt: both are named.
            let both = error.contains(&format!("nothing reads the selection `{key}{last}`"));
            let meant = error.contains(&format!("did you mean `{key}`?"));
            assert!(both || meant, "{key}: {error}");
            assert!(error.contains("line "), "{key}: {error}");
            tried.insert(key);
        }
    }
    assert!(tried.len() > 55, "{} keys", tried.len());
}

#[test]
fn a_range_of_one_number_is_refused_with_its_key() {
    let error = refusal(
        "law = \"neo-hookean\"\nsupports = [{ clamped = \"x_min\" }]\n\
         mesh.box = { extent = [1.0, 1.0, 1.0], cells = [1, 1, 1] }\n\
         parameters = { mu = [2.0, 2.0], lambda = [1.0, 2.0] }\n",
    );
    assert!(error.contains("line 4") && error.contains("parameters.mu"), "{error}");
    assert!(error.contains("both ends are 2 kPa") && error.contains("write mu = 2"), "{error}");
}

#[test]
fn known_parameters_are_not_in_theta() {
    let text = |a: &str, p: &str| {
        edited("a = [0.1, 0.26]", a).replace("p = { range = [4.0, 10.0], unit = \"mmHg\" }", p)
    };
    let whole = Case::parse(&text("a = [0.1, 0.26]", "p = [0.5, 1.5]"), "whole.toml").unwrap();
    let known = text("a = { value = 200, unit = \"Pa\" }", "p = 1");
    let known = Case::parse(&known, "known.toml").unwrap().body().unwrap();
    let names: Vec<_> = known.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["b", "a_f", "b_f"]);
    let body = whole.body().unwrap();
    let u: Vec<f64> = (0..3 * body.nodes).map(|i| 1e-3 * (i as f64).sin()).collect();
    let whole = body.value(&u, &[0.2, 2.0, 3.0, 2.5, 1.0]);
    assert_eq!(known.value(&u, &[2.0, 3.0, 2.5]), whole);
    let both = refusal(&text("a = { value = 0.2, range = [0.1, 0.2] }", "p = 1"));
    assert!(both.contains("one of `range` and `value`"), "{both}");
    let sampled = refusal(&text("a = { value = 0.2, sampling = \"log\" }", "p = 1"));
    assert!(sampled.contains("parameters.a.sampling"), "{sampled}");
    let negative = refusal(&text("a = -0.2", "p = 1"));
    assert!(negative.contains("parameters.a"), "{negative}");
}

#[test]
fn every_key_that_is_read_is_on_the_page() {
    // Tables with a key that is like no other are answered with all keys.
    let body = "law = \"neo-hookean\"\nsupports = [{ clamped = \"x_min\" }]\n\
                mesh.box = { extent = [1.0, 1.0, 1.0], cells = [1, 1, 1] }\nparameters = { mu = [1.0, 2.0], lambda = [1.0, 2.0] }\n";
    let odd = "qqqqqqqqqqqqqqqqqqqqqq = 1";
    let tables = [
        format!("{odd}\n{body}"),
        body.replace("mesh.box", &format!("mesh.{odd}\nmesh.box")),
        body.replace("cells =", &format!("{odd}, cells =")),
        body.replace("mesh.box", &format!("mesh.ellipsoid = {{ {odd} }}\nmesh.box")),
        body.replace("\"neo-hookean\"", &format!("{{ {odd} }}")),
        body.replace("mu = [1.0, 2.0]", &format!("mu = {{ {odd} }}")),
        body.replace("clamped = ", &format!("{odd}, clamped = ")),
        format!("loads = [{{ {odd} }}]\n{body}"),
        format!("loads = [{{ foundation = {{ {odd} }} }}]\n{body}"),
        format!("fibres = {{ {odd} }}\n{body}"),
        format!("fibres = {{ rule = {{ {odd} }} }}\n{body}"),
        format!("training = {{ {odd} }}\n{body}"),
        format!("select.a = {{ {odd} }}\n{body}"),
        format!("select.a = {{ plane = {{ {odd} }} }}\n{body}"),
        format!("select.a = {{ beyond = {{ {odd} }} }}\n{body}"),
        format!("select.a = {{ box = {{ {odd} }} }}\n{body}"),
        format!("select.a = {{ sphere = {{ {odd} }} }}\n{body}"),
        format!("select.a = {{ facing = {{ {odd} }} }}\n{body}"),
        format!("select.a = {{ near = {{ {odd} }} }}\n{body}"),
        format!("select.a = {{ not = {{ {odd} }} }}\n{body}"),
        format!("training = {{ network = {{ {odd} }} }}\n{body}"),
        format!("formulation = \"qqqqqqqqqqqqqqqqqqqqqq\"\n{body}"),
        format!("training = {{ recipe = \"qqqqqqqqqqqqqqqqqqqqqq\" }}\n{body}"),
        format!("training = {{ design = \"qqqqqqqqqqqqqqqqqqqqqq\" }}\n{body}"),
        format!("mesh.element = \"qqqqqqqqqqqqqqqqqqqqqq\"\n{body}"),
        body.replace(
            "mu = [1.0, 2.0]",
            "mu = { range = [1.0, 2.0], sampling = \"qqqqqqqqqqqqqqqqqqqqqq\" }",
        ),
        body.replace(
            "mu = [1.0, 2.0]",
            "mu = { range = [1.0, 2.0], unit = \"qqqqqqqqqqqqqqqqqqqqqq\" }",
        ),
        body.replace("\"neo-hookean\"", "\"qqqqqqqqqqqqqqqqqqqqqq\""),
    ];
    for text in tables {
        let error = refusal(&text);
        let (_, known) = error.rsplit_once(": ").unwrap();
        for key in known.split(", ") {
            let shown =
                [format!("`{key}`"), format!("`\"{key}\"`")].iter().any(|form| PAGE.contains(form));
            assert!(shown, "{key} is not on the page: {error}");
        }
    }
}

#[test]
fn every_law_has_its_formula_with_its_parameters() {
    let formulas = PAGE.split("### Formulas").nth(1).unwrap().split("\n##").next().unwrap();
    for law in sinew_energy::laws::LAWS {
        let start = format!("| `{}` | ", law.name);
        let row = formulas.lines().find_map(|line| line.strip_prefix(&start));
        let formula = row.unwrap_or_else(|| panic!("{} has no formula", law.name));
        let of_another = formula.starts_with("the same");
        for parameter in law.parameters {
            let symbol = match *parameter {
                "mu" => "μ",
                "lambda" => "λ",
                "nu" => "ν",
                own => own,
            };
            let summed = symbol.ends_with("_s") || symbol == "a_f" || symbol == "b_f";
            assert!(
                formula.contains(symbol) || of_another || summed && formula.contains("Σ"),
                "{parameter} of {}: {formula}",
                law.name
            );
        }
        assert_eq!(formula.contains("κ"), law.bulk_modulus, "{formula}");
    }
}

/// The block with everything, edited; every edit must apply.
fn edited(from: &str, to: &str) -> String {
    let block = chamber();
    assert!(block.contains(from), "the page no longer holds {from:?}");
    block.replace(from, to)
}

#[test]
fn values_that_make_no_sense_are_told_with_key_unit_and_range() {
    let told = |from: &str, to: &str, words: &[&str]| {
        let error = refusal(&edited(from, to));
        for word in words {
            assert!(error.contains(word), "{word:?} is not in: {error}");
        }
    };
    told(
        "[4.0, 10.0], unit = \"mmHg\"",
        "[4.0, 10.0], unit = \"mmHq\"",
        &["parameters.p.unit", "did you mean `mmHg`?"],
    );
    told("unit = \"1\"", "unit = \"kPa\"", &["parameters.b.unit", "number without unit"]);
    told("[4.0, 10.0]", "[10.0, 4.0]", &["parameters.p.range", "10 to 4 mmHg", "[4, 10]"]);
    told("a = [0.1, 0.26]", "a = [0.0, 0.26]", &["parameters.a", "sampling = \"linear\""]);
    told("a = [0.1, 0.26]", "a = [-0.1, 0.26]", &["parameters.a"]);
    told("a = [0.1, 0.26]", "a = [0.1, inf]", &["parameters.a", "finite"]);
    told("a = [0.1, 0.26]\n", "", &["parameters", "`a` is missing", "kPa"]);
    told("a = [0.1, 0.26]", "a = [0.1, 0.26, 0.3]", &["line ", "3 values where 2 belong"]);
    told("a = [0.1, 0.26]", "a = \"soft\"", &["line ", "[smallest, largest]"]);
    told("pressure = \"p\"", "pressure = \"q\"", &["parameters.p", "b_f, q"]);
    told("\"2 mmHg\"", "\"2 bar\"", &["`bar`", "mmHg"]);
    told(
        "pressure = \"p\", facets = \"endo\"",
        "pressure = \"p\", facets = \"end\"",
        &["loads.0.facets", "did you mean `endo`?"],
    );
    told("pressure = \"p\", facets = \"endo\"", "pressure = \"p\"", &["loads.0", "endo, epi"]);
    told(
        "pressure = \"p\", facets",
        "pressure = \"p\", traction = [0.0, 0.0, 1.0], facets",
        &["loads.0", "one of"],
    );
    told("body_force = [0.0, 0.0, -9.8e-3]", "body_force = [0.0, 0.0, nan]", &["loads"]);
    told(
        "nodes = \"base\"\nz",
        "nodes = \"bass\"\nz",
        &["supports.0.nodes", "did you mean `base`?"],
    );
    told("z = 0.0\n", "", &["supports.0", "x, y, z"]);
    told("z = 0.0\n", "z = nan\n", &[", supports: ", "NaN"]);
    told("z = 0.0\n", "z = 0.0\npoint = [0.0, 0.0, 1.0]\n", &["supports.0", "axis and point"]);
    told("bulk_modulus = 25.0", "bulk_modulus = -25.0", &["law", "-25"]);
    told(", bulk_modulus = 25.0", "", &["law", "bulk_modulus"]);
    told("\"holzapfel-ogden\"", "\"holzapfel-odgen\"", &["did you mean `holzapfel-ogden`?"]);
    told("unit = \"cm\"", "unit = \"inch\"", &["mesh.unit", "mm, cm, m"]);
    told("cells = [1, 16, 8]", "cells = [1, 15, 8]", &["mesh.ellipsoid.cells", "multiple of 8"]);
    told("cells = [1, 16, 8]", "cells = [1, 16, 8, 2]", &["line "]);
    told("cells = [1, 16, 8]", "cells = [1, 16, 8, 2]", &["line ", "4 values where 3 belong"]);
    told(
        "cells = [1, 16, 8]",
        "cells = [1000, 16000, 8000]",
        &["mesh.ellipsoid.cells", "at most 2000000"],
    );
    let turn = "axis = [0.0, 0.0, 1.0]\nturn = { degrees = 400.0 }";
    told("axis = [0.0, 0.0, 1.0]", turn, &["supports.1.turn", "400 degrees", "at most 180"]);
    let percent = "axis = [0.0, 0.0, 1.0]\nturn = { degrees = 40.0, share = 50.0 }";
    told("axis = [0.0, 0.0, 1.0]", percent, &["supports.1.turn", "50 is no share"]);
    let overflow = format!("cells = [1, 16, {}]", i64::MAX);
    told("cells = [1, 16, 8]", &overflow, &["mesh.ellipsoid.cells", "at most 2000000"]);
    told("short = [0.7, 1.0]", "short = [1.0, 0.7]", &["mesh.ellipsoid.short", "outer"]);
    told("endocardium = \"endo\"", "endocardium = \"inside\"", &["fibres.rule", "inside"]);
    told("minutes = 20.0", "minutes = 20.0\nsteps = 100", &["training.steps", "not both"]);
    told("[fibres.rule]", "[fibres]\nfield = \"fibre\"\n[fibres.rule]", &["fibres", "one of"]);
}

#[test]
fn abaqus_files_are_bodies() {
    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/mesh/gmsh_quadratic.inp");
    let text = format!(
        "law = \"neo-hookean\"\nsupports = [{{ clamped = \"clamped_side\" }}]\nloads = [{{ body_force = [0.0, 0.0, -1e-2] }}]\n\
         mesh.file = '{fixture}'\nparameters = {{ mu = [50.0, 100.0], lambda = [50.0, 100.0] }}\n"
    );
    let body = Case::parse(&text, "case.toml").unwrap().body().unwrap();
    let volume: f64 = body.volumes.iter().sum();
    // The file has 16 digits.
    assert!((volume - 2.0).abs() < 1e-12, "{volume}");
    // The load reads a name that the law has taken.
    let taken = text.replace(
        "{ body_force = [0.0, 0.0, -1e-2] }",
        "{ pressure = \"mu\", facets = \"clamped_side\" }",
    );
    let error = refusal(&taken);
    assert!(error.contains("loads") && error.contains("two parameters `mu`"), "{error}");
}

#[test]
fn edges_of_two_ventricles_have_bounds() {
    let scene = sinew::scenes::find(Path::new("Biventricle")).unwrap().text;
    let told = |edge: &str, wall: &str, words: &[&str]| {
        let text = scene.replace("edge = 5.5", &format!("edge = {edge}"));
        let error = refusal(&text.replace("wall = 10.0", &format!("wall = {wall}")));
        for word in words {
            assert!(error.contains(word), "{word:?} is not in: {error}");
        }
    };
    told("0.01", "10.0", &["mesh.biventricle.edge", "an edge of 0.01", "give at least 0.7"]);
    told("5.6", "10.0", &["mesh.biventricle.edge", "give at most 5.5"]);
    told("0.1", "0.2", &["mesh.biventricle", "a wall of 0.2 is too thin"]);
}

#[test]
fn a_range_is_converted_and_a_budget_is_read() {
    let case = Case::parse(chamber(), "page.toml").unwrap();
    let body = case.body().unwrap();
    let range = |index: usize| body.parameters[index].range;
    assert!(
        (range(2)[0] - 1.5).abs() < 1e-12 && (range(4)[0] - 4.0 * 0.133_322_387_415).abs() < 1e-12
    );
    // Two centimetres.
    let lowest = body.positions.iter().fold(0.0f64, |least, x| least.min(x[2]));
    assert!((lowest + 20.0).abs() < 1e-9, "{lowest}");
    let options = case.training.options();
    assert_eq!((options.seed, options.budget), (7, sinew_emulate::Budget::Seconds(1200.0)));
}

mod theta {
    use sinew::{Parameter, outside, parse_theta, read_thetas};
    use sinew_energy::Sampling;

    fn parameters() -> Vec<Parameter> {
        let parameter = |name: &str, unit: &str| Parameter {
            name: name.into(),
            unit: unit.into(),
            range: [1.0, 4.0],
            sampling: Sampling::Log,
        };
        vec![parameter("a", "kPa"), parameter("b", "1"), parameter("p", "kPa")]
    }

    #[test]
    fn units_are_converted_where_they_make_sense() {
        let theta = parse_theta("p=7.5006157585mmHg, a=2e3 Pa, b=1e0", &parameters()).unwrap();
        assert!((theta[2] - 1.0).abs() < 1e-9 && theta[..2] == [2.0, 1.0], "{theta:?}");
        let error = |text| parse_theta(text, &parameters()).unwrap_err().to_string();
        assert!(error("a=1,b=2kPa,p=1").contains("b is a number without unit, not in kPa"));
        assert!(error("a=1,b=2").contains("p (from 1 to 4 kPa) is missing"));
        assert!(error("a=1,a=2,b=1,p=1").contains("twice"));
        assert!(error("a=1,b=nan,p=1").contains("not a finite number"));
        assert!(error("a=1;b=2").contains("`a=1;b=2` holds two pairs"), "{}", error("a=1;b=2"));
        assert!(error("a=1,b=1;2,p=1").contains("`1;2`"), "{}", error("a=1,b=1;2,p=1"));
    }

    #[test]
    fn bad_rows_of_tables_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("thetas.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_thetas(&path, &parameters()).map_err(|error| error.to_string())
        };
        let table = read("# all\np [mmHg],b,a\n7.5006157585,2,3\n\n15.001231517, 3, 2\n").unwrap();
        assert!((table[1][2] - 2.0).abs() < 1e-9 && table[0][..2] == [3.0, 2.0], "{table:?}");
        let error = read("a,b,p\n1,2,3\n1,2\n").unwrap_err();
        assert!(
            error.contains("line 3") && error.contains("2 values for the 3 columns"),
            "{error}"
        );
        let error = read("a,b,p\n1,x,3\n").unwrap_err();
        assert!(error.contains("line 2") && error.contains("`x`"), "{error}");
        assert!(read("a,b,pp\n").unwrap_err().contains("did you mean `p`?"));
        assert!(read("\n").unwrap_err().contains("a,b,p"));
        assert!(read("a,b,p\n# 1,2,3\n").unwrap_err().contains("line 1: only names"));
    }

    #[test]
    fn values_outside_are_told_and_rounding_is_not() {
        assert!(outside(&parameters(), &[1.0 - 1e-12, 4.0, 2.0]).is_empty());
        let said = outside(&parameters(), &[0.5, 4.0, 5.0]);
        assert!(said[0].contains("a = 0.5 kPa") && said[1].contains("p = 5 kPa"), "{said:?}");
        let wide = [Parameter::log("k", "kPa", 1e-6..=1e3)];
        let is_told = |value: f64| !outside(&wide, &[value]).is_empty();
        assert_eq!(
            [1e-6 * (1.0 - 1e-12), 9e-7, 1e-9, 0.0, -1.0].map(is_told),
            [false, true, true, true, true]
        );
    }
}

mod arrays {
    use sinew::npz::write;
    use sinew::output::{Results, Row};
    use std::io::Read;

    #[test]
    fn an_archive_holds_its_npy_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arrays.npz");
        let values: Vec<f64> = (0..6).map(f64::from).collect();
        let cells = sinew_mesh::to_npy_of("<i8", &[1], &3_i64.to_le_bytes());
        let arrays = [
            ("theta".to_string(), sinew_mesh::to_npy(&[2, 3], &values)),
            ("energy".into(), sinew_mesh::to_npy(&[1], &[7.5])),
            ("cells".into(), cells),
        ];
        write(&path, arrays.clone()).unwrap();
        let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
        for (name, content) in arrays {
            let mut found = Vec::new();
            archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut found).unwrap();
            assert_eq!(found, content);
        }
        assert_eq!(archive.len(), 3);
    }

    #[test]
    fn a_case_is_read_back_with_its_difference() {
        let folder = tempfile::tempdir().unwrap();
        let body = sinew::Case::read("OnceClampedBeam".as_ref()).unwrap().body().unwrap();
        let [truth, other] = [0.0, 1.0].map(|u| vec![u; 3 * body.nodes]);
        let fields = vec![&truth[..], &other];
        let rows = vec![Row { theta: body.centre(), fields, ..Row::default() }];
        let results = Results { body: &body, names: vec!["fem", "dd"], rows, stresses: false };
        results.write(folder.path(), 1, true).unwrap();
        let (read, _) = sinew_mesh::read_mesh::<4>(folder.path().join("0000.vtu")).unwrap();
        assert!(read.point_fields["difference_dd"].to_f64().iter().all(|&e| e == 3f64.sqrt()));
        let series = std::fs::read_to_string(folder.path().join("cases.pvd")).unwrap();
        assert!(series.contains("0000.vtu"));
    }
}

mod scenes {
    use sinew::case::Case;
    use sinew::scenes::SCENES;

    #[test]
    fn every_scene_is_a_case_of_its_name() {
        for scene in SCENES {
            let case = Case::parse(scene.text, scene.name).unwrap();
            assert_eq!(case.name, scene.name);
            assert!(!case.about.is_empty());
            if case.mesh.file.is_none() {
                let body = case.lowered().unwrap();
                let size = scene.name.starts_with("Refined");
                assert_eq!(body.nodes == 7696, size, "{} has {} nodes", scene.name, body.nodes);
            } else {
                let error = case.body().unwrap_err().to_string();
                assert!(error.contains("--mesh FILE"), "{error}");
            }
        }
    }
}

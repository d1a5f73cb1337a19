//! Mistakes of newcomers and their messages: file, key, number, unit, and what to do.

use sinew::Case;

/// A plate under pressure in mmHg and its own weight.
pub(crate) const PLATE: &str = r#"
law = "neo-hookean"
loads = [{ pressure = "p", facets = "z_min" }, { body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }, { clamped = "x_max" }, { clamped = "y_min" }, { clamped = "y_max" }]

[mesh]
box = { extent = [30.0, 20.0, 6.0], cells = [6, 4, 2] }

[parameters]
mu = [8.0, 16.0]
lambda = { range = [8.0, 16.0] }
p = { range = [1.0, 4.0], unit = "mmHg" }

[training]
recipe = "regression"
samples = 12
held_out = 4
"#;

/// Text of the case, its replacement, and the words of the message.
type Mistake = (&'static str, &'static str, &'static [&'static str]);

/// Words of a debugger or a compiler, which no message may hold.
const FOREIGN: [&str; 15] = [
    "Err(",
    "Some(",
    "None",
    "\\\"",
    "f64",
    "usize",
    "u64",
    "struct ",
    "enum ",
    "invalid type",
    ", expected a",
    "panicked",
    "SceneError",
    "os error 0",
    "unwrap",
];

/// Faults of all messages, before the test ends.
#[derive(Default)]
pub(crate) struct Faults(Vec<String>);

impl Faults {
    /// Requires a sentence of one's own language that holds `words`.
    pub(crate) fn judge(&mut self, told: &str, attempt: &str, words: &[&str]) {
        println!("{attempt}\n  -> {told}");
        let foreign = FOREIGN.iter().filter(|word| told.contains(**word));
        let missing = words.iter().filter(|word| !told.contains(**word));
        self.0.extend(foreign.map(|word| format!("{attempt}: `{word}` in: {told}")));
        self.0.extend(missing.map(|word| format!("{attempt}: no `{word}` in: {told}")));
    }
}

impl Drop for Faults {
    fn drop(&mut self) {
        assert!(self.0.is_empty() || std::thread::panicking(), "\n{}", self.0.join("\n"));
    }
}

fn case_mistakes() -> Vec<Mistake> {
    vec![
        // Keys.
        ("law = ", "laws = ", &["line 2", "laws", "did you mean `law`?"]),
        ("[mesh]", "[msh]", &["line 6", "did you mean `mesh`?"]),
        ("supports = ", "support = ", &["line 4", "did you mean `supports`?"]),
        ("body_force", "bodyforce", &["line 3", "loads.1.bodyforce", "did you mean `body_force`?"]),
        ("clamped = \"x_min\"", "clamp = \"x_min\"", &["line 4", "did you mean `clamped`?"]),
        ("extent", "extents", &["line 7", "mesh.box.extents", "did you mean `extent`?"]),
        ("range = [8.0", "rnge = [8.0", &["line 11", "did you mean `range`?"]),
        ("held_out", "heldout", &["line 17", "did you mean `held_out`?"]),
        ("law = \"neo-hookean\"\n", "", &["`law` is missing", "add it"]),
        ("[mesh]\nbox", "# box", &["`mesh` is missing", "add it"]),
        (", cells = [6, 4, 2]", "", &["line 7", "`cells` is missing", "add it"]),
        (
            "mu = [8.0, 16.0]\n",
            "",
            &["line 9", "`mu` is missing", "mu = [smallest, largest]", "kPa"],
        ),
        (
            "mu = [8.0, 16.0]\n",
            "mu = [8.0, 16.0]\nE = [1, 2]\n",
            &["parameters.E", "mu, lambda, p"],
        ),
        ("mu = [8.0, 16.0]\n", "mu = [8.0, 16.0]\nmu = [1, 2]\n", &["line 11", "twice"]),
        // Syntax.
        ("[mesh]", "[mesh", &["line 6", "]"]),
        ("\"neo-hookean\"", "neo-hookean", &["line 2", "quotes"]),
        ("\"neo-hookean\"", "\"neo-hookean", &["line 2"]),
        ("held_out = 4", "held_out 4", &["line 17", "="]),
        ("mu = [8.0, 16.0]", "mu = [8,0; 16,0]", &["line 10"]),
        ("mu = [8.0, 16.0]", "mu =", &["line 10"]),
        // Laws.
        ("\"neo-hookean\"", "\"neohookean\"", &["law", "did you mean `neo-hookean`?"]),
        ("\"neo-hookean\"", "\"mooney-rivlin\"", &["law", "laws: neo-hookean"]),
        ("\"neo-hookean\"", "{ bulk_modulus = 25.0 }", &["law", "`name` is missing"]),
        (
            "\"neo-hookean\"",
            "{ name = \"neo-hookean\", bulk_modulus = 9.0 }",
            &["law.bulk_modulus", "leave it out"],
        ),
        (
            "\"neo-hookean\"",
            "{ name = \"guccione\", bulk_modulus = \"hard\" }",
            &["line 2", "law", "the text \"hard\"", "a number"],
        ),
        ("\"neo-hookean\"", "\"guccione\"", &["law", "bulk_modulus = 25.0", "kPa"]),
        ("\"neo-hookean\"", "3", &["line 2", "law", "the number 3", "the name of a law"]),
        // Ranges and units.
        (
            "mu = [8.0, 16.0]",
            "mu = [16.0, 8.0]",
            &["line 10", "parameters.mu", "16 to 8 kPa", "[8, 16]"],
        ),
        ("mu = [8.0, 16.0]", "mu = [8.0, 8.0]", &["parameters.mu", "8 kPa", "write mu = 8"]),
        ("mu = [8.0, 16.0]", "mu = [8.0]", &["line 10", "parameters.mu", "1 value where 2 belong"]),
        (
            "mu = [8.0, 16.0]",
            "mu = \"soft\"",
            &["line 10", "parameters.mu", "the text \"soft\"", "[smallest, largest]"],
        ),
        ("mu = [8.0, 16.0]", "mu = [8.0, nan]", &["parameters.mu", "finite"]),
        ("mu = [8.0, 16.0]", "mu = [8.0, inf]", &["parameters.mu", "8 to inf kPa", "finite"]),
        (
            "mu = [8.0, 16.0]",
            "mu = [0.0, 16.0]",
            &["parameters.mu", "0 kPa", "sampling = \"linear\""],
        ),
        ("mu = [8.0, 16.0]", "mu = -8.0", &["parameters.mu", "-8 kPa", "positive"]),
        (
            "mu = [8.0, 16.0]",
            "mu = [8.0, 1e120]",
            &["parameters.mu", "kPa", "1e120 kPa", "between 1e-100 and 1e100"],
        ),
        (
            "mu = [8.0, 16.0]",
            "mu = { range = [8.0, 16.0], value = 9.0 }",
            &["parameters.mu", "one of `range` and `value`"],
        ),
        (
            "mu = [8.0, 16.0]",
            "mu = { value = 9.0, sampling = \"log\" }",
            &["parameters.mu.sampling", "leave it out"],
        ),
        (
            "mu = [8.0, 16.0]",
            "mu = { range = [8.0, 16.0], sampling = \"logarithmic\" }",
            &["line 10", "log"],
        ),
        ("\"mmHg\"", "\"bar\"", &["line 12", "parameters.p.unit", "`bar`", "kPa, mmHg"]),
        ("\"mmHg\"", "\"mPa\"", &["parameters.p.unit", "mega", "did you mean `MPa`?"]),
        (
            "[1.0, 4.0], unit = \"mmHg\"",
            "[4.0, 1.0], unit = \"mmHg\"",
            &["parameters.p", "4 to 1 mmHg", "[1, 4]"],
        ),
        // Mesh.
        (
            "[mesh]\nbox",
            "[mesh]\nfile = \"none.vtk\"\n# box",
            &["line 7", "mesh.file", "no file none.vtk", "--mesh FILE"],
        ),
        ("[mesh]\nbox", "[mesh]\nfile = \"none.vtk\"\nbox", &["mesh", "one of `file`, `box`"]),
        (
            "box = { extent = [30.0, 20.0, 6.0], cells = [6, 4, 2] }",
            "",
            &["mesh", "one of `file`, `box`"],
        ),
        (
            "extent = [30.0",
            "extent = [-30.0",
            &["line 7", "mesh.box.extent", "[-30, 20, 6]", "positive"],
        ),
        (
            "extent = [30.0, 20.0, 6.0]",
            "extent = [30.0, 20.0]",
            &["line 7", "mesh.box.extent", "2 values where 3 belong"],
        ),
        ("cells = [6, 4, 2]", "cells = [6, 0, 2]", &["mesh.box.cells", "at least 1"]),
        (
            "cells = [6, 4, 2]",
            "cells = [6, 1.5, 2]",
            &["line 7", "mesh.box.cells", "the number 1.5", "whole number"],
        ),
        (
            "cells = [6, 4, 2]",
            "cells = [6, -4, 2]",
            &["line 7", "mesh.box.cells", "the number -4", "whole number"],
        ),
        ("cells = [6, 4, 2]", "cells = [6000, 4000, 2000]", &["mesh.box.cells", "at most 2000000"]),
        ("[mesh]\n", "[mesh]\nunit = \"inch\"\n", &["mesh.unit", "`inch`", "mm, cm, m"]),
        ("[mesh]\n", "[mesh]\nelement = \"quads\"\n", &["line 7", "mesh.element", "tetrahedra"]),
        (
            "[mesh]\n",
            "formulation = \"quadratik\"\n[mesh]\n",
            &["line 6", "formulation", "did you mean `quadratic`?"],
        ),
        (
            "[mesh]\n",
            "formulation = \"quadratic\"\n[mesh]\nelement = \"hexahedra\"\n",
            &["formulation", "hexahedra", "averaged"],
        ),
        // Supports.
        (
            "{ clamped = \"x_min\" }",
            "{ clamped = \"xmin\" }",
            &["supports.0.clamped", "did you mean `x_min`?"],
        ),
        (
            "{ clamped = \"x_min\" }",
            "{ clamped = \"base\" }",
            &["supports.0.clamped", "`base`", "the mesh has: ", "x_max"],
        ),
        (
            "{ clamped = \"x_min\" }",
            "{ clamped = \"x_min\", nodes = \"x_max\" }",
            &["supports.0", "clamped = \"SET\""],
        ),
        ("{ clamped = \"x_min\" }", "{ nodes = \"x_min\" }", &["supports.0", "x, y, z"]),
        (
            "{ clamped = \"x_min\" }",
            "{ nodes = \"x_min\", x = \"0\" }",
            &["line 4", "supports.0.x", "the text \"0\"", "a number"],
        ),
        (
            "{ clamped = \"x_min\" }",
            "{ nodes = \"x_min\", y = nan }",
            &["supports", "NaN", "finite"],
        ),
        (
            "{ clamped = \"x_min\" }",
            "{ nodes = \"x_min\", y = 2.0 }",
            &["supports", "2", "let the supports agree"],
        ),
        (
            "{ clamped = \"x_min\" }",
            "{ nodes = \"x_min\", normal = [0.0, 0.0, 0.0] }",
            &["supports", "not 0"],
        ),
        (
            "supports = [{ clamped = \"x_min\" }, { clamped = \"x_max\" }, { clamped = \"y_min\" }, { clamped = \"y_max\" }]",
            "supports = []",
            &["line 4", "supports", "clamped = \"NODE SET\""],
        ),
        // Loads.
        (
            "facets = \"z_min\"",
            "facets = \"bottom\"",
            &["line 3", "loads.0.facets", "`bottom`", "z_min"],
        ),
        (", facets = \"z_min\"", "", &["line 3", "loads.0", "name the facets", "z_min"]),
        (
            "pressure = \"p\"",
            "pressure = \"8 bar\"",
            &["line 3", "loads.0.pressure", "`bar`", "mmHg"],
        ),
        (
            "pressure = \"p\"",
            "pressure = \"q\"",
            &["parameters.p", "nothing reads it", "mu, lambda, q"],
        ),
        (
            "pressure = \"p\"",
            "pressure = [1.0]",
            &["line 3", "loads.0.pressure", "a list", "a pressure in kPa"],
        ),
        (
            "pressure = \"p\"",
            "pressure = \"p\", traction = [0.0, 0.0, 1.0]",
            &["loads.0", "a table of its own"],
        ),
        ("{ body_force = [0.0, 0.0, -9.8e-3] }", "{}", &["loads.1", "one of body_force"]),
        (
            "{ body_force = [0.0, 0.0, -9.8e-3] }",
            "{ body_force = [0.0, -9.8e-3] }",
            &["line 3", "2 values where 3 belong"],
        ),
        (
            "{ body_force = [0.0, 0.0, -9.8e-3] }",
            "{ body_force = -9.8e-3 }",
            &["line 3", "loads.1.body_force", "-0.0098", "a list"],
        ),
        ("[0.0, 0.0, -9.8e-3]", "[0.0, 0.0, inf]", &["loads", "inf", "finite"]),
        (
            "-9.8e-3] }",
            "-9.8e-3], facets = \"z_min\" }",
            &["loads.1.facets", "leave the facets out"],
        ),
        (", { clamped = \"x_max\" }", "", &["loads", "z_min", "rim", "hold the rim"]),
        // Training.
        (
            "\"regression\"",
            "\"regresion\"",
            &["line 15", "training.recipe", "did you mean `regression`?"],
        ),
        (
            "samples = 12",
            "samples = -12",
            &["line 16", "training.samples", "the number -12", "whole number"],
        ),
        (
            "samples = 12",
            "samples = \"many\"",
            &["line 16", "training.samples", "the text \"many\""],
        ),
        ("samples = 12", "minutes = 2\nsteps = 9", &["training.steps", "not both"]),
        (
            "samples = 12",
            "network = { layers = 3 }",
            &["line 16", "training.network.layers", "width"],
        ),
        ("samples = 12", "design = \"grid\"", &["line 16", "training.design", "sobol"]),
    ]
}

#[test]
fn mistakes_in_a_case_file_are_told_with_file_key_number_and_remedy() {
    let mut faults = Faults::default();
    let mistakes = case_mistakes();
    for (from, to, words) in &mistakes {
        assert!(PLATE.contains(from), "the plate no longer holds {from}");
        let text = PLATE.replacen(from, to, 1);
        let refused = Case::parse(&text, "plate.toml").and_then(|case| case.body());
        let told = refused.map_or_else(|error| error.to_string(), |_| "nothing".into());
        faults.judge(&told, to, &[*words, &["plate.toml"]].concat());
    }
    assert!(Case::parse(PLATE, "plate.toml").unwrap().body().is_ok());
    assert!(mistakes.len() >= 70, "{} attempts", mistakes.len());
}

#[test]
fn fibres_that_are_missing_or_none_are_told() {
    let mut faults = Faults::default();
    let law = "law = { name = \"holzapfel-ogden\", bulk_modulus = 25.0 }";
    let text = PLATE.replace("law = \"neo-hookean\"", law).replace(
        "mu = [8.0, 16.0]\nlambda = { range = [8.0, 16.0] }",
        "a = [0.1, 0.3]\nb = { range = [1.0, 4.0] }\na_f = [1.5, 5.0]\nb_f = [1.0, 4.0]",
    );
    let mistakes: [Mistake; 7] = [
        ("", "", &["law", "reads fibres", "[fibres]", "field, direction or rule"]),
        ("[mesh]", "fibres.field = \"fibers\"\n[mesh]", &["fibres.field", "`fibers`"]),
        (
            "[mesh]",
            "fibres.direction = [0.0, 0.0, 0.0]\n[mesh]",
            &["fibres.direction", "without length"],
        ),
        (
            "[mesh]",
            "fibres.direction = [1.0, 0.0]\n[mesh]",
            &["line 6", "fibres.direction", "2 values where 3 belong"],
        ),
        (
            "[mesh]",
            "fibres = { field = \"f\", direction = [1.0, 0.0, 0.0] }\n[mesh]",
            &["fibres", "one of `field`, `direction`"],
        ),
        (
            "[mesh]",
            "fibres.rule = { endocardium = \"z_min\", epicardium = \"z_max\", base = \"top\", angles = [60.0, -60.0] }\n[mesh]",
            &["fibres.rule", "top"],
        ),
        (
            "range = [1.0, 4.0] }",
            "range = [1.0, 4.0], unit = \"kPa\" }\nfibres.direction = 1",
            &["parameters.fibres"],
        ),
    ];
    for (from, to, words) in mistakes {
        assert!(text.contains(from));
        let text = text.replacen(from, to, 1);
        let refused = Case::parse(&text, "plate.toml").and_then(|case| case.body());
        faults.judge(&refused.unwrap_err().to_string(), to, words);
    }
    let known = "fibres.direction = [1.0, 0.0, 0.0]\n[mesh]";
    let text = text
        .replace("[mesh]", known)
        .replace("range = [1.0, 4.0] }", "range = [1.0, 4.0], unit = \"kPa\" }");
    let refused = Case::parse(&text, "plate.toml").and_then(|case| case.body());
    faults.judge(
        &refused.unwrap_err().to_string(),
        "b in kPa",
        &["parameters.b.unit", "number without unit", "leave it out"],
    );
    let young = PLATE.replace("neo-hookean", "neo-hookean-young").replace("mu =", "E =");
    for (nu, words) in [
        ("nu = 0.5", ["parameters.nu", "0.5 makes no sense", "at least 0 and less than 0.5"]),
        (
            "nu = [0.3, 0.6]",
            ["parameters.nu", "0.6 makes no sense", "at least 0 and less than 0.5"],
        ),
        ("nu = -0.1", ["parameters.nu", "-0.1 makes no sense", "at least 0"]),
    ] {
        let text = young.replace("lambda = { range = [8.0, 16.0] }", nu);
        let refused = Case::parse(&text, "plate.toml").and_then(|case| case.body());
        faults.judge(&refused.unwrap_err().to_string(), nu, &words);
    }
}

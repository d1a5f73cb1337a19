//! Keys of networks in case files, and the files that a network leaves, as `docs/case-file.md` and `docs/emulators.md` describe them.

use crate::case_files::refusal;
use crate::program::{BAR, done};
use sinew::case::{RecipeName, Training};
use sinew::npz;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const PAGE: &str = include_str!("../../../../docs/emulators.md");

/// The first cells of a table of the page that begins with this head.
fn first_cells(head: &str) -> Vec<&'static str> {
    let table = PAGE.split(head).nth(1).unwrap().trim_start();
    let rows = table.lines().skip(1).take_while(|line| line.starts_with('|'));
    rows.map(|row| row.split('|').nth(1).unwrap().trim()).collect()
}

/// Name of an array with N for its numbers.
fn pattern(name: &str) -> String {
    let part = |part: &'_ str| if part.parse::<usize>().is_ok() { "N" } else { part }.to_string();
    name.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// Names of the arrays in a file.
fn arrays(file: &Path) -> Vec<String> {
    let told = npz::read(file, "none").unwrap_err().to_string();
    told.split_once("it holds: ").unwrap().1.split(", ").map(String::from).collect()
}

#[test]
fn keys_of_networks_are_trained_with_printed_stored_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let keys = "recipe = \"dd\"\nnetwork = { latent = 8, width = 16, message_passing_steps = 2, virtual_nodes = [12, 3] }\n\
                optimiser = \"adam\"\nlearning_rate = 1e-3\nbatch = 4";
    fs::write(folder.join("bar.toml"), BAR.replace("recipe = \"regression\"", keys)).unwrap();
    let trained = [("dd", "12, 3"), ("pi", "12, 3, 1")].map(|(recipe, levels)| {
        let told = done(folder, &format!("train bar.toml --recipe {recipe} --steps 6"));
        let words = format!(
            "2 message-passing steps, embeddings of 8, hidden layers of 16 and of 32 for clusters, virtual nodes: {levels}; \
             Adam at 1e-3, 4 parameter sets a step"
        );
        assert!(told.contains(&words), "{told}");
        let stored = folder.join(format!("out/bar/{recipe}"));
        let [record, run] = ["emulator/emulator.json", "run.json"]
            .map(|file| fs::read_to_string(stored.join(file)).unwrap());
        assert!(record.contains(&words), "{record}");
        // Both stages of pi.
        let stages = if recipe == "pi" { 2 } else { 1 };
        for setting in ["\"learning_rate\": 0.001", "\"batch\": 4", "\"kind\": \"adam\""] {
            assert_eq!(run.matches(setting).count(), stages, "{setting} in {run}");
        }
        let curve: Vec<serde_json::Map<_, _>> =
            serde_json::from_slice(&fs::read(stored.join("curve.json")).unwrap()).unwrap();
        let found: BTreeSet<_> = curve[0].keys().map(|key| format!("`{key}`")).collect();
        assert_eq!(found, first_cells("| key | what it holds |").into_iter().map(String::from).collect());
        done(folder, &format!("export bar.toml --weights --emulator {recipe}"));
        let file = folder.join(format!("out/bar/{recipe}.npz"));
        for (name, shape) in [
            ("node_encoder.layers.2.weight", vec![16, 8]),
            ("edge_updates.1.layers.0.weight", vec![24, 16]),
            ("local_normalisation.gain", vec![16]),
            ("decoders.0.layers.0.bias", vec![16]),
        ] {
            assert_eq!(npz::read(&file, name).unwrap().0, shape, "{name}");
        }
        arrays(&file).iter().map(|name| pattern(name)).collect::<BTreeSet<_>>()
    });
    // Every array is in the table, under its own name or that of the module it stands in, and every row has one.
    let rows = first_cells("| array | shape | meaning |");
    let documented = rows.iter().flat_map(|row| row.split('`').skip(1).step_by(2));
    let documented: Vec<_> = documented.filter(|name| !name.starts_with('.')).collect();
    let holds = |known: &str, name: &str| match known.strip_suffix('…') {
        Some(module) => name.starts_with(module),
        None => {
            name == known
                || name.rsplit_once('.').map(|(at, _)| at)
                    == known.rsplit_once('.').map(|(at, _)| at)
        }
    };
    let found: BTreeSet<_> = trained.iter().flatten().collect();
    for name in &found {
        assert!(documented.iter().any(|known| holds(known, name)), "{name} is not on the page");
    }
    for known in documented {
        assert!(found.iter().any(|name| holds(known, name)), "no network has {known}: {found:?}");
    }
}

#[test]
fn recipes_learn_from_the_samples_that_are_asked_for() {
    for (recipe, key) in [(RecipeName::Dd, "simulations"), (RecipeName::Regression, "most")] {
        let training = Training { recipe: Some(recipe), samples: Some(30), ..Training::default() };
        let recipe = serde_json::to_value(training.recipe()).unwrap();
        assert_eq!(recipe[key], 30, "{recipe}");
    }
}

#[test]
fn numbers_that_train_no_network_are_refused_with_key_line_and_bounds() {
    let with = |keys: &str| refusal(&BAR.replace("recipe = \"regression\"", keys));
    for (keys, words) in [
        ("recipe = \"pi\"\nlearning_rate = 0.0", ["training.learning_rate", "above 0, at most 1"]),
        ("recipe = \"pi\"\nlearning_rate = nan", ["training.learning_rate", "NaN"]),
        ("recipe = \"dd\"\nbatch = 0", ["training.batch", "give 1 to 1024"]),
        ("recipe = \"dd\"\nnetwork = { width = 0 }", ["training.network.width", "give 1 to 1024"]),
        ("recipe = \"dd\"\nnetwork = { latent = 4000 }", ["training.network.latent", "4000"]),
        (
            "recipe = \"dd\"\nnetwork = { virtual_nodes = [6, 24] }",
            ["training.network.virtual_nodes", "fewer than"],
        ),
        (
            "recipe = \"dd\"\nnetwork = { virtual_nodes = [6, 0] }",
            ["training.network.virtual_nodes", "at least one"],
        ),
        ("recipe = \"dd\"\noptimiser = \"adm\"", ["training.optimiser", "did you mean `adam`?"]),
        ("recipe = \"dd\"\nlerning_rate = 1e-3", ["training", "did you mean `learning_rate`?"]),
        (
            "recipe = \"dd\"\nnetwork = { virtual_node = [4] }",
            ["training.network", "did you mean `virtual_nodes`?"],
        ),
        (
            "recipe = \"regression\"\nbatch = 4",
            ["training.batch", "`regression` trains no network"],
        ),
        ("recipe = \"taylor\"\nnetwork = { width = 8 }", ["training.network", "choose pi or dd"]),
    ] {
        let told = with(keys);
        for word in words {
            assert!(told.contains(word) && told.contains("line 1"), "{keys}: {told}");
        }
    }
    // Of a case that trains one, another recipe takes what it reads.
    let case = BAR.replace("recipe = \"regression\"", "recipe = \"dd\"\nbatch = 4");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bar.toml"), &case).unwrap();
    done(folder.path(), "train bar.toml --recipe taylor");
    let many = case.replace("batch = 4", "network = { virtual_nodes = [63, 4] }");
    fs::write(folder.path().join("bar.toml"), many).unwrap();
    let (_, told) = crate::program::refused(folder.path(), "train bar.toml");
    assert!(told.contains("the first level has 63, and the mesh 63 nodes"), "{told}");
    done(folder.path(), "train bar.toml --recipe taylor --name other");
}

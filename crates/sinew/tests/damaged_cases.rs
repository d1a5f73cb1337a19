//! Damaged case files: each is a body or an error that names the file, never a panic.

#[path = "../../sinew-mesh/tests/damage/mod.rs"]
mod damage;

use damage::damaged;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use sinew::Case;
use sinew_mesh::{Selection, box_tetrahedra, write_vtu};
use std::path::Path;
use std::sync::LazyLock;

/// Damaged files of each kind; together, with their bodies, they take some ten seconds.
const CASES: u32 = 10_000;

/// Most cells (boxes, or cells between ellipsoids) of a mesh that a body is made of here: damage makes larger ones too.
const MOST_CELLS: usize = 200;

/// A body without sets in a file, for cases that choose them by place.
static ORGAN: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = box_tetrahedra([20.0, 10.0, 10.0], [2, 1, 1]);
    mesh.select("loaded", &Selection::plane([20.0, 0.0, 0.0], [1.0, 0.0, 0.0])).unwrap();
    mesh.node_sets.clear();
    write_vtu(folder.path().join("organ.vtu"), &mesh).unwrap();
    folder
});

/// The cases of the page and the built-in scenes on coarse meshes, and one on a file.
fn bases() -> Vec<String> {
    const PAGE: &str = include_str!("../../../docs/case-file.md");
    let blocks = PAGE.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    let scenes = sinew::scenes::SCENES.iter().map(|scene| scene.text);
    let mut bases: Vec<String> = blocks.chain(scenes).map(coarse).collect();
    bases.push(
        "law = { name = \"guccione\", bulk_modulus = 25.0 }\nloads = [{ pressure = \"p\", facets = \"loaded\" }]\n\
         supports = [{ clamped = \"base\" }, { nodes = \"tip\", axis = [0, 0, 1], turn = { degrees = 10 } }]\n\
         mesh = { file = \"organ.vtu\", unit = \"mm\" }\nfibres.direction = [1, 0, 0]\n\
         [select.base]\nplane = { point = [0, 0, 0], normal = [1, 0, 0], within = 0.1 }\n\
         [select.tip]\nany = [{ nearest = [20, 10, 10] }, { sphere = { centre = [20, 0, 0], radius = 1.0 } }]\nnot = { set = \"base\" }\n\
         [parameters]\nC = [1, 2]\nb_f = [1, 2]\nb_t = [1, 2]\nb_fs = 1.5\np = { range = [1, 2], unit = \"mmHg\" }\n"
            .into(),
    );
    bases
}

/// The same on a coarse mesh.
fn coarse(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let cells =
            if line.contains("ellipsoid") { "cells = [1, 8, 2]" } else { "cells = [2, 1, 1]" };
        lines.push(match line.split_once("cells = [") {
            Some((before, after)) => {
                let rest = after.split_once(']').map_or("", |(_, rest)| rest);
                format!("{before}{cells}{rest}")
            }
            None => line.into(),
        });
    }
    lines.join("\n")
}

/// A word of one base in place of one of another, which keeps the file well-formed more often than a flipped bit.
fn rewritten() -> impl Strategy<Value = String> {
    let bases = bases();
    let is_word = |c: char| c.is_alphanumeric() || "_.-".contains(c);
    let mut words: Vec<String> = bases
        .iter()
        .flat_map(|text| text.split(|c| !is_word(c)))
        .filter(|word| !word.is_empty())
        .map(String::from)
        .collect();
    words.sort();
    words.dedup();
    words.extend(
        [
            "nan",
            "inf",
            "-inf",
            "1e308",
            "-1",
            "0",
            "9223372036854775807",
            "1e-320",
            "\"\"",
            "[]",
            "{}",
        ]
        .map(String::from),
    );
    let edits = vec((any::<Index>(), any::<Index>()), 1..4);
    (any::<Index>(), edits).prop_map(move |(base, edits)| {
        let mut text = bases[base.index(bases.len())].clone();
        for (at, word) in edits {
            let spans: Vec<(usize, usize)> = spans(&text, is_word);
            let (start, end) = spans[at.index(spans.len())];
            text.replace_range(start..end, &words[word.index(words.len())]);
        }
        text
    })
}

fn spans(text: &str, is_word: impl Fn(char) -> bool) -> Vec<(usize, usize)> {
    let mut spans = vec![(0, 0)];
    let mut start = None;
    for (at, c) in text.char_indices() {
        match (is_word(c), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                spans.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    spans
}

/// Reads the case, and makes its body where that takes little time.
fn read_safely(text: &str) {
    let mut case = match Case::parse(text, "damaged.toml") {
        Ok(case) => case,
        Err(error) => return assert!(error.to_string().starts_with("damaged.toml"), "{error}"),
    };
    if let Some(file) = &mut case.mesh.file {
        if file != Path::new("organ.vtu") {
            return;
        }
        *file = ORGAN.path().join("organ.vtu");
    }
    let cells =
        [case.mesh.cuboid.map(|mesh| mesh.cells), case.mesh.ellipsoid.map(|mesh| mesh.cells)];
    let large = |cells: [usize; 3]| {
        cells
            .iter()
            .try_fold(1usize, |all, &n| all.checked_mul(n))
            .is_none_or(|all| all > MOST_CELLS)
    };
    // A grid of two ventricles is large whatever its edge is.
    if case.mesh.biventricle.is_some() || cells.into_iter().flatten().any(large) {
        return;
    }
    match case.body() {
        Ok(body) => assert!(body.nodes > 0 && body.volumes.iter().all(|volume| volume.is_finite())),
        Err(error) => assert!(error.to_string().starts_with("damaged.toml"), "{error}"),
    }
}

/// How many of the undamaged cases are made into bodies, so that the tests below try more than the parser.
#[test]
fn most_of_the_cases_lower() {
    let lowers = |text: &&String| {
        let mut case = Case::parse(text, "case.toml").unwrap();
        if let Some(file) = &mut case.mesh.file {
            *file = ORGAN.path().join(&*file);
        }
        case.mesh.biventricle.is_none() && case.body().is_ok()
    };
    let bases = bases();
    let lowered = bases.iter().filter(lowers).count();
    assert!(2 * lowered > bases.len(), "{lowered} of {}", bases.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: CASES, failure_persistence: None, ..Default::default() })]

    #[test]
    fn damaged_bytes(bytes in damaged(bases().into_iter().map(String::into_bytes).collect())) {
        read_safely(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn damaged_words(text in rewritten()) {
        read_safely(&text);
    }
}

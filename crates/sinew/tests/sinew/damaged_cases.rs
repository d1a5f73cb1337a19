//! Damaged case files: each is a body or an error that names the file, never a panic.

use crate::damage::damaged;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::TestRunner;
use sinew::Case;
use sinew::case::Exactly;
use sinew_mesh::{Selection, box_tetrahedra, write_vtu};
use std::cell::Cell;
use std::ops::Range;
use std::path::Path;
use std::sync::LazyLock;

/// Damaged files of each kind; together they take some five seconds, of which bodies take most.
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
    const PAGE: &str = include_str!("../../../../docs/case-file.md");
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

/// Case on a coarse mesh, without comments.
fn coarse(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default();
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

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || "_.-".contains(c)
}

fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}

/// Numbers in place of numbers and names in place of names, which keeps a file well-formed more often than a flipped bit.
fn rewritten() -> impl Strategy<Value = String> {
    let bases = bases();
    let mut words: Vec<String> = bases
        .iter()
        .flat_map(|text| text.split(|c| !is_word(c)))
        .filter(|word| !word.is_empty())
        .map(String::from)
        .collect();
    words.extend(
        ["nan", "inf", "-inf", "1e308", "-1", "0", "9223372036854775807", "1e-320", "0.5"]
            .map(String::from),
    );
    words.sort();
    words.dedup();
    let (numbers, names): (Vec<String>, Vec<String>) =
        words.into_iter().partition(|word| is_number(word));
    let edits = vec((any::<Index>(), any::<Index>()), 1..4);
    (any::<Index>(), edits).prop_map(move |(base, edits)| {
        let mut text = bases[base.index(bases.len())].clone();
        for (at, word) in edits {
            // Most names are keys, without which a case ends at the parser: three edits of four are of numbers.
            let (some, others): (Vec<_>, Vec<_>) =
                spans(&text).into_iter().partition(|span| is_number(&text[span.clone()]));
            let spans = if at.index(4) > 0 && !some.is_empty() { some } else { others };
            let span = spans[at.index(spans.len())].clone();
            let words = if is_number(&text[span.clone()]) { &numbers } else { &names };
            text.replace_range(span, &words[word.index(words.len())]);
        }
        text
    })
}

/// Places of the words of a text.
fn spans(text: &str) -> Vec<Range<usize>> {
    let mut at = 0;
    let pieces = text.split_inclusive(|c| !is_word(c)).map(|piece| {
        let start = at;
        at += piece.len();
        start..start + piece.trim_end_matches(|c| !is_word(c)).len()
    });
    pieces.filter(|span| !span.is_empty()).collect()
}

/// Reads the case, and makes its body where that takes little time; says whether there is one.
fn read_safely(text: &str) -> bool {
    let mut case = match Case::parse(text, "damaged.toml") {
        Ok(case) => case,
        Err(error) => {
            assert!(error.to_string().starts_with("damaged.toml"), "{error}");
            return false;
        }
    };
    if let Some(file) = &mut case.mesh.file {
        if file != Path::new("organ.vtu") {
            return false;
        }
        *file = ORGAN.path().join("organ.vtu");
    }
    let cells =
        [case.mesh.cuboid.map(|mesh| mesh.cells), case.mesh.ellipsoid.map(|mesh| mesh.cells)];
    let large = |Exactly(cells): Exactly<usize, 3>| {
        cells
            .iter()
            .try_fold(1usize, |all, &n| all.checked_mul(n))
            .is_none_or(|all| all > MOST_CELLS)
    };
    // Grids that a surface cuts are large whatever their edge is: they would take most of the time.
    if case.mesh.biventricle.is_some() || cells.into_iter().flatten().any(large) {
        return false;
    }
    match case.lowered() {
        Ok(body) => {
            assert!(body.nodes > 0 && body.volumes.iter().all(|volume| volume.is_finite()));
        }
        Err(error) => assert!(error.to_string().starts_with("damaged.toml"), "{error}"),
    }
    true
}

/// Tries all cases of a strategy, of which so many must get beyond the parser.
fn try_all(damaged: impl Strategy<Value = String>, lowered_at_least: u32) {
    let config = ProptestConfig { cases: CASES, failure_persistence: None, ..Default::default() };
    let lowered = Cell::new(0);
    let try_one = |text: String| {
        lowered.set(lowered.get() + u32::from(read_safely(&text)));
        Ok(())
    };
    TestRunner::new(config).run(&damaged, try_one).unwrap();
    println!("{} of {CASES} damaged cases were lowered", lowered.get());
    assert!(lowered.get() >= lowered_at_least, "{}", lowered.get());
}

/// Most of the undamaged cases are made into bodies, so that the tests below try more than the parser.
#[test]
fn most_of_the_cases_lower() {
    let lowers = |text: &&String| {
        let mut case = Case::parse(text, "case.toml").unwrap();
        if let Some(file) = &mut case.mesh.file {
            *file = ORGAN.path().join(&*file);
        }
        case.mesh.biventricle.is_none() && case.lowered().is_ok()
    };
    let bases = bases();
    let lowered = bases.iter().filter(lowers).count();
    println!("{lowered} of {}", bases.len());
    assert!(2 * lowered > bases.len(), "{lowered} of {}", bases.len());
}

#[test]
fn damaged_bytes() {
    let files = bases().into_iter().map(String::into_bytes).collect();
    try_all(
        damaged(files).prop_map(|bytes| String::from_utf8_lossy(&bytes).into_owned()),
        CASES / 25,
    );
}

#[test]
fn damaged_words() {
    try_all(rewritten(), CASES / 3);
}

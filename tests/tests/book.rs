//! The book and the chapter on Gaussian processes quote programs word for word, and the book's programs keep what they promise.

#[path = "../../crates/sinew/examples/book_beam.rs"]
mod book_beam;
#[path = "../../crates/sinew/examples/book_law.rs"]
mod book_law;
#[path = "../../crates/sinew/examples/book_population.rs"]
mod book_population;
#[path = "../../crates/sinew/examples/book_ventricle.rs"]
mod book_ventricle;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Quotation of a page: the file that the comment `<!-- file -->` before the code names, and the code.
struct Quotation {
    page: PathBuf,
    file: String,
    code: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Pages of the book, Markdown as it lies there.
fn chapters() -> Vec<PathBuf> {
    let folder = root().join("docs/book/src");
    let entries = std::fs::read_dir(&folder).expect("the book is part of the repository");
    let mut pages: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    pages.sort();
    pages
}

/// Every block of Rust and TOML in a page.
fn quotations(page: &Path) -> Vec<Quotation> {
    let text = read(page);
    let blocks: Vec<&str> = text.split("```").collect();
    // Text and blocks take turns.
    let pairs = blocks.chunks(2).filter_map(|pair| Some((pair[0], *pair.get(1)?)));
    let quoted = pairs.filter_map(|(before, block)| {
        let (language, code) = block.split_once('\n')?;
        matches!(language, "rust" | "toml").then_some((before, code))
    });
    let named = quoted.map(|(before, code)| {
        let name =
            before.trim_end().rsplit("<!-- ").next().and_then(|end| end.strip_suffix(" -->"));
        let missing = || panic!("{}: which program is this of?\n{code}", page.display());
        let file = name.unwrap_or_else(missing).to_owned();
        Quotation { page: page.to_owned(), file, code: code.to_owned() }
    });
    named.collect()
}

/// The example or built-in scene of a name, in whichever crate it is.
fn source(file: &str) -> String {
    let crates = std::fs::read_dir(root().join("crates")).expect("the crates lie there");
    let places = crates.flat_map(|entry| {
        let folder = entry.expect("readable").path();
        ["examples", "scenes"].map(|kind| folder.join(kind).join(file))
    });
    let found: Vec<_> = places.filter(|path| path.exists()).collect();
    assert_eq!(found.len(), 1, "one file named {file}: {found:?}");
    read(&found[0])
}

/// Lines without what they are indented by.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

#[test]
fn every_piece_of_code_is_part_of_a_program() {
    let mut pages = chapters();
    pages.push(root().join("docs/gaussian-processes.md"));
    let quoted: Vec<_> = pages.iter().flat_map(|page| quotations(page)).collect();
    assert!(quoted.len() > 15, "the pages show code");
    for Quotation { page, file, code } in &quoted {
        let (program, code) = (source(file), lines(code));
        let found = lines(&program).windows(code.len()).any(|window| window == code);
        assert!(found, "{}: not in {file}:\n{}", page.display(), code.join("\n"));
    }
}

#[test]
fn every_chapter_is_in_the_table_of_contents() {
    let [summary, pages] = [root().join("docs/book/src/SUMMARY.md"), root().join("docs/book/src")];
    let contents = read(&summary);
    for page in chapters().iter().filter(|page| **page != summary) {
        let name = page.strip_prefix(&pages).expect("inside").display().to_string();
        assert!(contents.contains(&format!("({name})")), "{name} is not in SUMMARY.md");
    }
}

#[test]
fn equations_are_set_by_one_header() {
    let header = read(&root().join("docs/book/theme/head.hbs"));
    for name in ["sinew-energy", "sinew-fem", "sinew-emulate", "sinew-gnn", "sinew-gp"] {
        let folder = root().join("crates").join(name);
        assert_eq!(read(&folder.join("katex-header.html")), header, "{name}");
        let manifest = read(&folder.join("Cargo.toml"));
        let argument = r#"rustdoc-args = ["--html-in-header", "katex-header.html"]"#;
        assert!(manifest.contains(argument), "{name} names its header for docs.rs");
        assert!(read(&folder.join("src/lib.rs")).contains("//! ```math"), "{name} has equations");
    }
}

#[test]
fn every_program_of_the_book_is_run() {
    // Each has a test, which this file takes in, or the tests of the Gaussian processes do.
    let here = include_str!("book.rs").to_owned()
        + include_str!("../../crates/sinew-gp/tests/gp/examples.rs");
    let quoted: BTreeSet<_> = chapters()
        .iter()
        .flat_map(|page| quotations(page))
        .map(|quotation| quotation.file)
        .collect();
    let programs: Vec<_> = quoted.iter().filter(|file| file.ends_with(".rs")).collect();
    assert!(programs.len() >= 4, "{programs:?}");
    for file in programs {
        assert!(source(file).contains("#[test]"), "{file} has a test");
        assert!(here.contains(&format!("/examples/{file}\"]")), "{file} is taken in");
    }
}

//! Texts that the program and the Python package print.

use std::path::{Path, PathBuf};

/// Sources of the crates whose texts reach users of the program.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|ext| ext == "rs") => found.push(path),
            false => {}
        }
    }
}

/// Texts between quotes of a source, without its comments.
fn texts(source: &str) -> Vec<String> {
    let (mut found, mut text) = (Vec::new(), None::<String>);
    for line in source.lines() {
        if text.is_none() && line.trim_start().starts_with("//") {
            continue;
        }
        let mut letters = line.chars();
        while let Some(letter) = letters.next() {
            match (letter, &mut text) {
                ('"', None) => text = Some(String::new()),
                ('"', _) => found.extend(text.take()),
                ('\\', Some(text)) => text.extend(letters.next()),
                ('\'', None) if letters.as_str().starts_with("\"'") => {
                    letters = letters.as_str()[2..].chars()
                }
                (_, Some(text)) => text.push(letter),
                _ => {}
            }
        }
    }
    found
}

/// Readers of an error know the case file and the command line, but no type of ours.
#[test]
fn no_text_names_a_rust_item() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    let mut named = Vec::new();
    for own in ["mesh", "energy", "fem", "graph", "emulate", "calibrate", "sample"] {
        let mut files = Vec::new();
        sources(&crates.join(format!("sinew-{own}/src")), &mut files);
        sources(&crates.join("sinew/src"), &mut files);
        for file in files {
            // That library warning has words of its own for the program (`locking_in_words`).
            if file.ends_with("diagnose/locking.rs") {
                continue;
            }
            for text in texts(&std::fs::read_to_string(&file).unwrap()) {
                let item = text.split_whitespace().find(|word| {
                    let (owner, item) = word.split_once("::").unwrap_or_default();
                    !owner.is_empty() && item.starts_with(char::is_alphabetic)
                        || word.starts_with("sinew_")
                });
                if text.contains(' ')
                    && let Some(item) = item
                {
                    named.push(format!("{}: {item}", file.display()));
                }
            }
        }
    }
    assert!(named.is_empty(), "{named:#?}");
}

//! The chapter of the book quotes the examples, word for word.

use std::path::Path;

/// Lines without what they are indented by.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

#[test]
fn every_piece_of_code_is_part_of_an_example() {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let Ok(book) = std::fs::read_to_string(crate_folder.join("../../docs/gaussian-processes.md"))
    else {
        eprintln!("skipped: the book is not part of the packaged crate");
        return;
    };
    let pieces: Vec<&str> = book.split("```rust\n").collect();
    assert!(pieces.len() > 5, "the chapter shows code");
    for pair in pieces.windows(2) {
        // <!-- name.rs --> stands in the line before the code.
        let name =
            pair[0].trim_end().rsplit("<!-- ").next().and_then(|end| end.strip_suffix(" -->"));
        let name = name.unwrap_or_else(|| panic!("which example is this of?\n{}", pair[1]));
        let code = pair[1].split("```").next().map(lines).unwrap_or_default();
        let example = std::fs::read_to_string(crate_folder.join("examples").join(name));
        let example = example.unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = lines(&example).windows(code.len()).any(|window| window == code);
        assert!(found, "not in {name}:\n{}", code.join("\n"));
    }
}

//! The field's words: first doc lines that say nothing alone, paraphrases of the glossary, sentences too long to read aloud.

use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};

const STYLE: &str = "docs/style.md";
/// First words of a doc comment that point to nothing the reader has seen.
const POINTERS: &[&str] = &[
    "What", "Of", "Those", "So many", "The same", "Nothing", "Where", "With", "By", "As", "One of",
    "That", "Which", "And", "Or", "In", "On", "For", "None", "Its", "It", "They", "From", "To",
    "Over", "About", "How", "Told",
];
/// Words of a sentence that can still be read aloud.
const LONGEST: usize = 35;
const RULES: [&str; 3] = [
    "first doc lines that say nothing alone",
    "paraphrases where the glossary has a term",
    "sentences in Markdown of more than 35 words",
];

/// Fails with every finding.
pub(crate) fn check() -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let style = std::fs::read_to_string(root.join(STYLE)).context(STYLE)?;
    let paraphrases = paraphrases(&style);
    ensure!(!paraphrases.is_empty(), "{STYLE} has no glossary with paraphrases in quotation marks");
    let mut found: [Vec<String>; 3] = Default::default();
    let parts = ["crates", "docs", "fixtures", "tests", "xtask", "README.md", "CHANGELOG.md"];
    for path in files(parts.map(|part| root.join(part)).into())? {
        let text = std::fs::read_to_string(&path)?;
        let name = path.strip_prefix(&root).unwrap_or(&path).display().to_string();
        let place = |line: usize, what: &str| format!("{name}:{}: {what}", line + 1);
        let markdown = name.ends_with(".md");
        if markdown {
            found[2].extend(long_sentences(&text).into_iter().map(|s| format!("{name}: {s}")));
        } else {
            let lines = pointers(&text).into_iter();
            found[0].extend(lines.map(|(line, text)| place(line, text)));
        }
        if name != STYLE {
            let prose = |line: &&str| markdown || line.trim_start().starts_with("//");
            for (at, line) in text.lines().enumerate().filter(|(_, line)| prose(line)) {
                let hit = paraphrases.iter().find(|(phrase, _)| line.contains(phrase.as_str()));
                found[1].extend(
                    hit.map(|(phrase, term)| place(at, &format!("\"{phrase}\": write {term}"))),
                );
            }
        }
    }
    let mut wrong = Vec::new();
    for (rule, found) in RULES.iter().zip(&found) {
        eprintln!("words: {} {rule}", found.len());
        if !found.is_empty() {
            wrong.push(format!("{} {rule}:\n  {}", found.len(), found.join("\n  ")));
        }
    }
    if wrong.is_empty() { Ok(()) } else { bail!("{}", wrong.join("\n")) }
}

/// Sources and Markdown below folders, in order.
pub(crate) fn files(mut open: Vec<PathBuf>) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let entries = std::fs::read_dir(&path)?.map(|entry| entry.map(|entry| entry.path()));
            open.extend(entries.collect::<std::io::Result<Vec<_>>>()?);
        } else if path.extension().is_some_and(|end| end == "rs" || end == "md") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Paraphrases in quotation marks in the glossary's last column, with the term of the row.
fn paraphrases(style: &str) -> Vec<(String, String)> {
    let rows =
        style.lines().filter(|line| line.starts_with("| ") && line.matches(" | ").count() == 3);
    let of_row = |row: &str| -> Vec<(String, String)> {
        let cells: Vec<_> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let quoted = cells[3].split('"').skip(1).step_by(2);
        quoted.map(|phrase| (phrase.to_string(), cells[0].to_string())).collect()
    };
    rows.flat_map(of_row).collect()
}

/// First lines of doc comments that begin with one of [`POINTERS`].
fn pointers(text: &str) -> Vec<(usize, &str)> {
    let is_doc = |line: &str| line.starts_with("///") || line.starts_with("//!");
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let first = |at: &usize| is_doc(lines[*at]) && !(*at > 0 && is_doc(lines[*at - 1]));
    let points = |at: &usize| {
        let said = lines[*at].trim_start_matches(['/', '!']).trim_start();
        let begins = |word: &&str| {
            said.strip_prefix(*word).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        POINTERS.iter().any(begins)
    };
    (0..lines.len()).filter(first).filter(points).map(|at| (at, lines[at])).collect()
}

/// Sentences of plain prose of more than [`LONGEST`] words: tables and code have none.
fn long_sentences(text: &str) -> Vec<String> {
    let mut code = false;
    let mut prose = String::new();
    for line in text.lines() {
        code ^= line.trim_start().starts_with("```");
        let plain = !code && !line.trim_start().starts_with(['|', '#']) && !line.trim().is_empty();
        // An item of a list is a sentence of its own.
        prose.push_str(if line.trim_start().starts_with(['-', '*']) { "\n" } else { "" });
        prose.push_str(if plain { line } else { "\n" });
        prose.push(' ');
    }
    let sentences =
        prose.split('\n').flat_map(|part| part.split_inclusive(['.', '?', '!', ':', ';']));
    let long = sentences.filter(|s| s.split_whitespace().count() > LONGEST);
    long.map(|s| s.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_find_what_they_name() {
        let table = "| term | meaning | source | instead of |\n| unseen | new | GBC | \"never seen\", \"not seen before\" |\n";
        assert_eq!(
            paraphrases(table),
            ["never seen", "not seen before"].map(|p| (p.to_string(), "unseen".to_string()))
        );
        let text = "/// Of the output.\n/// What follows is fine.\nfn a() {}\n/// Offset of a node.\nfn b() {}\n";
        assert_eq!(pointers(text), [(0, "/// Of the output.")]);
        let long = "word ".repeat(LONGEST + 1) + "end.";
        assert_eq!(long_sentences(&long).len(), 1);
        assert!(long_sentences(&format!("| {long} |\n\n```\n{long}\n```\n")).is_empty());
    }
}

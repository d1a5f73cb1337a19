//! Walks of docs/architecture.md: files that a value passes, each with the item that takes it there.

use crate::imports::{File, read};
use anyhow::{Context, Result, bail, ensure};
use std::path::Path;

const PAGE: &str = "docs/architecture.md";

/// Text of a file below `crates/`.
type Source<'s> = &'s dyn Fn(&str) -> Option<String>;

/// Fails with every room that does not exist, lacks its item or is not named by the room before.
pub(crate) fn check() -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let page = std::fs::read_to_string(root.join(PAGE)).context(PAGE)?;
    let (walks, wrong) =
        follow(&page, &|file| std::fs::read_to_string(root.join("crates").join(file)).ok())?;
    ensure!(wrong.is_empty(), "{PAGE}: write walks as the code goes:\n  {}", wrong.join("\n  "));
    eprintln!("walks: {}", walks.join("; "));
    Ok(())
}

/// Number of rooms of each walk, and every fault.
fn follow(page: &str, source: Source<'_>) -> Result<(Vec<String>, Vec<String>)> {
    let section = page.split("\n## ").find(|section| section.starts_with("Walks\n"));
    let section = section.with_context(|| format!("{PAGE} has no section `## Walks`"))?;
    let (mut rooms, mut walks, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for walk in section.split("\n**").skip(1) {
        let mut lines = walk.lines();
        let (title, (mut count, mut beside)) = (lines.next().unwrap_or_default(), (1, 0));
        let name = title.split("**").next().unwrap_or_default();
        let start = quoted(title).next().with_context(|| format!("{name} has no first room"))?;
        rooms.push((start, open(start, source)?));
        for line in lines.filter(|line| line.starts_with(|c: char| c.is_ascii_digit())) {
            count += 1;
            match room(line, &mut rooms, source) {
                Ok(more) => beside += more,
                Err(fault) => wrong.push(format!("{name}: {fault}")),
            }
        }
        walks.push(format!("{name} {count} rooms, {beside} beside them"));
        if wrong.is_empty() && !title.contains(&walks[walks.len() - 1][name.len() + 1..]) {
            wrong.push(format!("the title must say {}", walks[walks.len() - 1]));
        }
    }
    Ok((walks, wrong))
}

/// Follows one line of a walk; the number of rooms beside its own.
fn room<'p>(line: &'p str, rooms: &mut Vec<(&'p str, File)>, source: Source<'_>) -> Result<usize> {
    let words: Vec<&str> = quoted(line).collect();
    let [file, item, others @ ..] = &words[..] else {
        bail!("write a file and an item in backticks: {line}");
    };
    let (from, others) = match others {
        [from, others @ ..] if line.contains("`, from `") => (format!("/{from}"), others),
        others => (String::new(), others),
    };
    let own = open(file, source)?;
    let caller = rooms.iter().rev().find(|(path, _)| path.ends_with(&from));
    let (caller, found) = caller.with_context(|| format!("no room {from} is above {file}"))?;
    let (caller, named) = (*caller, item.split("::").all(|part| found.words.contains(part)));
    let defined = item.rsplit("::").next().is_some_and(|last| own.defined.contains(last));
    rooms.push((file, own));
    ensure!(named, "{caller} does not name `{item}` of {file}; add the room between them");
    ensure!(defined, "{file} does not define `{item}`; name what takes the value there");
    let beside: Vec<_> = others.iter().filter(|word| word.ends_with(".rs")).collect();
    let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
    for other in &beside {
        let found = source(other).or_else(|| source(&format!("{folder}/{other}")));
        ensure!(found.is_some(), "{other} beside {file} does not exist");
    }
    Ok(beside.len())
}

fn open(file: &str, source: Source<'_>) -> Result<File> {
    let text = source(file).with_context(|| format!("crates/{file} is gone; say where it is"))?;
    read(&text).with_context(|| format!("crates/{file} is not Rust"))
}

/// Words in backticks.
fn quoted(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faults of a walk over three files, with a title that says `counted`.
    fn faults(counted: &str, lines: &str) -> Vec<String> {
        let text = |file: &str| match file {
            "x/a.rs" => Some("fn main() { B::go(); c() }"),
            "x/b.rs" => Some("struct B; impl B { fn go() {} }\n#[cfg(test)]\nmod t { use c; }"),
            "x/c.rs" => Some("fn c() {}"),
            _ => None,
        };
        let page = format!("# P\n\n## Walks\n\n**u**, from `x/a.rs`: {counted}\n{lines}\n\n## P");
        follow(&page, &|file| text(file).map(Into::into)).unwrap().1
    }

    #[test]
    fn walks_of_the_code_pass_and_are_counted() {
        let lines = "1. `x/b.rs` `B::go` (`c.rs`)\n2. `x/c.rs` `c`, from `a.rs`: text";
        let counted = "3 rooms, 1 beside them";
        assert!(faults(counted, lines).is_empty());
        assert_eq!(faults("3 rooms", lines), [format!("the title must say u {counted}")]);
    }

    #[test]
    fn missing_rooms_items_and_callers_are_named() {
        let said = |line: &str, fault: &str| faults("", line)[0].contains(fault);
        assert!(said("1. `x/d.rs` `c`", "crates/x/d.rs is gone"));
        assert!(said("1. `x/b.rs` `main`", "x/b.rs does not define `main`"));
        assert!(said("1. `x/c.rs` `c`, from `d.rs`", "no room /d.rs is above x/c.rs"));
        assert!(said("1. `x/b.rs` `B` (`e.rs`)", "e.rs beside x/b.rs does not exist"));
        let lines = "1. `x/b.rs` `B`\n2. `x/c.rs` `c`";
        assert!(said(lines, "x/b.rs does not name `c` of x/c.rs"), "its test does");
    }
}

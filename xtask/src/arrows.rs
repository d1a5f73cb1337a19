//! The table of crates in docs/architecture.md, held against `cargo metadata` in both directions: what a crate
//! depends on is listed, and what is listed is depended on. A new crate is a new row there and nothing here. A crate that is compiled
//! without tests has none.

use crate::command::output;
use crate::words;
use anyhow::{Context, Result, bail, ensure};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package, PackageId, Target};
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

const TABLE: &str = "docs/architecture.md";
/// First cells of the table's head.
const HEAD: &str = "| crate | holds | depends on (ours) | heavy dependency |";
/// Packages that are named in the last column; no crate has one that is not named by it or a crate below it.
const HEAVY: &[&str] = &["burn", "faer", "kiddo", "kuva", "linfa", "quick-xml"];

/// Packages that bring a heavy one to the crates that name them: the sampler factorises its mass matrices.
const THROUGH: [(&str, &str); 1] = [("nuts-rs", "faer")];

/// Crates, and heavy packages that they must do without when their default features are off.
const OPTIONAL: &[(&str, &str)] = &[("sinew", "burn"), ("sinew", "kiddo"), ("sinew", "linfa")];

/// Names of ours and of heavy packages that a crate depends on directly.
#[derive(Debug, Default, PartialEq)]
struct Row {
    ours: BTreeSet<String>,
    heavy: BTreeSet<String>,
}

/// Fails with every difference by name.
pub(crate) fn check() -> Result<()> {
    let metadata = MetadataCommand::new().exec().context("cargo metadata failed")?;
    let path = metadata.workspace_root.join(TABLE);
    let text = std::fs::read_to_string(&path).with_context(|| format!("{path} is unreadable"))?;
    let table = rows(&text)?;
    let packages = metadata.workspace_packages();
    let ours: BTreeSet<&str> = packages.iter().map(|package| package.name.as_str()).collect();
    let actual = packages.iter().map(|&package| (package.name.to_string(), row(package, &ours)));
    let mut wrong = differences(&table, &actual.collect());
    let mut unrun = Vec::new();
    for package in packages {
        unrun.extend(never_run(package, &metadata)?);
        let tree = linked(&metadata, [&package.id])?;
        let is_below = |heavy: &&&str| tree.iter().any(|id| metadata[id].name == **heavy);
        for heavy in HEAVY.iter().filter(is_below) {
            let through = |(other, below): &(&str, &str)| {
                below == heavy && package.dependencies.iter().any(|d| d.name == *other)
            };
            if !reaches(&table, &package.name, heavy) && !THROUGH.iter().any(through) {
                wrong.push(format!("{} has {heavy} below it through none of ours", package.name));
            }
        }
    }
    for (name, heavy) in OPTIONAL {
        let bare = ["-p", name, "--no-default-features", "-e", "normal", "--prefix", "none"];
        let mut tree = Command::new("cargo");
        let [tree, _] = output(tree.arg("tree").args(bare), &format!("cargo tree -p {name}"))?;
        if tree.lines().any(|line| line.split(' ').next() == Some(heavy)) {
            wrong.push(format!("{name} has {heavy} below it without its default features"));
        }
    }
    ensure!(
        wrong.is_empty(),
        "the crates and the table of {TABLE} differ:\n  {}",
        wrong.join("\n  ")
    );
    ensure!(
        unrun.is_empty(),
        "tests of crates that are compiled without them (`test = false`) never run; move them to the crate's `tests`:\n  {}",
        unrun.join("\n  ")
    );
    eprintln!("dependency arrows: {} crates are as {TABLE} says", table.len());
    Ok(())
}

/// Places of tests in the sources of a library that is compiled without tests.
fn never_run(package: &Package, metadata: &Metadata) -> Result<Vec<String>> {
    let untested = |target: &Target| !target.test && target.src_path.ends_with("src/lib.rs");
    let mut found = Vec::new();
    if package.targets.iter().any(untested) {
        for path in words::files(vec![package.manifest_path.with_file_name("src").into()])? {
            let text = std::fs::read_to_string(&path)?;
            let name = path.strip_prefix(&metadata.workspace_root).unwrap_or(&path).display();
            found.extend(tests(&text).map(|line| format!("{name}:{line}")));
        }
    }
    Ok(found)
}

/// Lines of Rust that a test, or code for tests alone, begins with; from 1.
fn tests(text: &str) -> impl Iterator<Item = usize> {
    const STARTS: [&str; 4] = ["#[test]", "#[cfg(test", "#[cfg(all(test", "#[cfg(any(test"];
    let begins = |line: &str| STARTS.iter().any(|start| line.trim_start().starts_with(start));
    text.lines().enumerate().filter_map(move |(at, line)| begins(line).then_some(at + 1))
}

/// Rows of the table by the name of the package; `num` in a row stands for `sinew-num`.
fn rows(text: &str) -> Result<BTreeMap<String, Row>> {
    let lines = text.lines().skip_while(|line| *line != HEAD).skip(2);
    let mut table = BTreeMap::new();
    for line in lines.take_while(|line| line.starts_with('|')) {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [name, _, ours, heavy] = cells[..] else {
            bail!("{TABLE}: a row of four cells, not of {}: {line}", cells.len());
        };
        let names = |cell: &str| -> Vec<String> {
            cell.split(',').map(str::trim).filter(|name| !name.is_empty()).map(Into::into).collect()
        };
        // The crate that opens all others has no second name.
        let full = |name: &String| match name.as_str() {
            "sinew" => name.clone(),
            name => format!("sinew-{name}"),
        };
        let row = Row {
            ours: names(ours).iter().map(full).collect(),
            heavy: names(heavy).iter().map(|name| name.to_lowercase()).collect(),
        };
        table.insert(name.trim_matches('`').into(), row);
    }
    ensure!(!table.is_empty(), "{TABLE} has no table under `{HEAD}`");
    Ok(table)
}

/// Dependencies of a package by `cargo metadata`.
fn row(package: &Package, ours: &BTreeSet<&str>) -> Row {
    let normal = |name: &&str| {
        let of_kind = |d: &&cargo_metadata::Dependency| d.kind == DependencyKind::Normal;
        package.dependencies.iter().filter(of_kind).any(|d| d.name == *name)
    };
    let owned = |name: &str| name.to_string();
    Row {
        ours: ours.iter().copied().filter(normal).map(owned).collect(),
        heavy: HEAVY.iter().copied().filter(normal).map(owned).collect(),
    }
}

/// One sentence per name that is only in the table or only in the crates.
fn differences(table: &BTreeMap<String, Row>, actual: &BTreeMap<String, Row>) -> Vec<String> {
    let mut wrong: Vec<_> = (table.keys().filter(|name| !actual.contains_key(*name)))
        .map(|name| format!("{name} is in the table and no package of the workspace"))
        .collect();
    for (name, found) in actual {
        let Some(listed) = table.get(name) else {
            wrong.push(format!("{name} is not in the table"));
            continue;
        };
        for (listed, found) in [(&listed.ours, &found.ours), (&listed.heavy, &found.heavy)] {
            let forbidden = found.difference(listed);
            wrong.extend(forbidden.map(|other| format!("{name} must not depend on {other}")));
            let unused = listed.difference(found);
            wrong.extend(unused.map(|other| format!("{name} may depend on {other} and does not")));
        }
    }
    wrong
}

/// Whether a crate of the table, or one below it, lists a heavy package.
fn reaches(table: &BTreeMap<String, Row>, name: &str, heavy: &str) -> bool {
    table.get(name).is_some_and(|row| {
        row.heavy.contains(heavy) || row.ours.iter().any(|below| reaches(table, below, heavy))
    })
}

/// Packages in the trees of normal dependencies below `roots`, these included.
pub(crate) fn linked<'m>(
    metadata: &'m Metadata,
    roots: impl IntoIterator<Item = &'m PackageId>,
) -> Result<BTreeSet<&'m PackageId>> {
    let nodes = &metadata.resolve.as_ref().context("cargo metadata resolves dependencies")?.nodes;
    let mut open: Vec<&PackageId> = roots.into_iter().collect();
    let mut seen: BTreeSet<&PackageId> = open.iter().copied().collect();
    while let Some(id) = open.pop() {
        let node = nodes.iter().find(|node| node.id == *id);
        for below in node.into_iter().flat_map(|node| &node.deps) {
            let is_normal = below.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal);
            if is_normal && seen.insert(&below.pkg) {
                open.push(&below.pkg);
            }
        }
    }
    Ok(seen)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Before.\n\n| crate | holds | depends on (ours) | heavy dependency |\n|---|---|---|---|\n\
        | `sinew-num` | numbers | | |\n| `sinew-fem` | solver | num | faer |\n\
        | `sinew-top` | programs | fem | |\n\nAfter.\n| `sinew-late` | no row | | |\n";

    fn with(name: &str, change: impl Fn(&mut Row)) -> Vec<String> {
        let mut actual = rows(TEXT).unwrap();
        change(actual.get_mut(name).unwrap());
        differences(&rows(TEXT).unwrap(), &actual)
    }

    #[test]
    fn forbidden_and_unused_arrows_are_named() {
        assert!(with("sinew-num", |_| {}).is_empty());
        let forbidden = with("sinew-num", |row| _ = row.ours.insert("sinew-fem".into()));
        assert_eq!(forbidden, ["sinew-num must not depend on sinew-fem"]);
        let heavy = with("sinew-num", |row| _ = row.heavy.insert("burn".into()));
        assert_eq!(heavy, ["sinew-num must not depend on burn"]);
        let unused = with("sinew-fem", |row| *row = Row::default());
        let expected =
            ["sinew-num", "faer"].map(|o| format!("sinew-fem may depend on {o} and does not"));
        assert_eq!(unused, expected);
    }

    #[test]
    fn crates_and_rows_without_a_partner_are_named() {
        let (table, mut actual) = (rows(TEXT).unwrap(), rows(TEXT).unwrap());
        actual.insert("sinew-new".into(), Row::default());
        actual.remove("sinew-top");
        let wrong = differences(&table, &actual);
        assert_eq!(wrong.len(), 2);
        assert!(wrong[0].contains("sinew-top") && wrong[1] == "sinew-new is not in the table");
    }

    #[test]
    fn heavy_packages_are_reached_through_rows_below() {
        let table = rows(TEXT).unwrap();
        assert!(reaches(&table, "sinew-top", "faer") && !reaches(&table, "sinew-num", "faer"));
        assert!(!reaches(&table, "sinew-top", "burn"));
    }

    #[test]
    fn lines_of_tests_are_found() {
        let text =
            "fn a() {}\n\n#[cfg(test)]\nmod tests {\n    #[test]\n    fn b() {}\n}\n/// #[test]\n";
        assert_eq!(tests(text).collect::<Vec<_>>(), [3, 5]);
        assert!(tests("#[cfg(target_os = \"linux\")]\nfn a() {}\n").next().is_none());
    }

    #[test]
    fn a_missing_table_and_a_short_row_are_refused() {
        assert!(rows("no table").is_err());
        let short = TEXT.replace("| numbers | | |", "| numbers | |");
        assert!(rows(&short).unwrap_err().to_string().contains("not of 3"));
    }
}

//! Licences of what is linked: every dependency must grant one that is on the list.

use crate::arrows::linked;
use crate::command::cargo;
use anyhow::{Context, Result, ensure};
use cargo_metadata::MetadataCommand;
use std::collections::BTreeMap;
use std::process::Command;

/// Rules of `cargo deny`, with the licences that ask for no more than their notice, by SPDX.
const RULES: &str = include_str!("../../deny.toml");
/// Crates whose manifest names a file in place of a licence, with the licence in it.
const READ: &[(&str, &str)] = &[("cfg_block", "Apache-2.0")];

/// Prints how many crates are linked under each licence, and fails with those whose licence is not on the list.
pub(crate) fn check() -> Result<()> {
    let metadata = MetadataCommand::new().exec().context("cargo metadata failed")?;
    let linked = linked(&metadata, &metadata.workspace_members)?;
    let (mut by_licence, mut wrong) = (BTreeMap::<String, usize>::new(), Vec::new());
    for package in metadata.packages.iter().filter(|package| linked.contains(&package.id)) {
        let read = READ.iter().find(|(name, _)| *name == package.name.as_str());
        let read = read.map(|(_, licence)| licence.to_string());
        let licence = package.license.clone().or(read).unwrap_or_default();
        if !allowed(&licence) {
            wrong.push(format!("{} {}: {licence}", package.name, package.version));
        }
        *by_licence.entry(licence).or_default() += 1;
    }
    for (licence, count) in &by_licence {
        println!("{count:4} {licence}");
    }
    ensure!(wrong.is_empty(), "licences that are not on the list:\n  {}", wrong.join("\n  "));
    eprintln!("licences: {} crates are linked, each under one of the list", linked.len());
    deny()
}

/// Runs `cargo deny` by the rules of `deny.toml`, where it is installed.
fn deny() -> Result<()> {
    let known = Command::new(env!("CARGO")).args(["deny", "--version"]).output()?;
    if !known.status.success() {
        eprintln!("licences: cargo deny is not installed; bans and sources are not checked");
        return Ok(());
    }
    cargo(&["deny", "check", "licenses", "bans", "sources"], &[])
}

/// Whether an SPDX expression grants a licence of the list: one of several joined by OR, all of those joined by AND.
fn allowed(expression: &str) -> bool {
    // Before SPDX expressions a slash was OR.
    let mut text = expression.replace('/', " OR ");
    // From the innermost brackets outwards.
    while let Some(close) = text.find(')') {
        let Some(open) = text[..close].rfind('(') else { return false };
        let granted = if without_brackets(&text[open + 1..close]) { "MIT" } else { "none" };
        text.replace_range(open..=close, granted);
    }
    without_brackets(&text)
}

fn without_brackets(expression: &str) -> bool {
    let list = RULES.split_once("allow = [").and_then(|(_, rest)| rest.split_once(']'));
    let list = list.map_or("", |(list, _)| list);
    let is_listed =
        |licence: &str| list.split('"').skip(1).step_by(2).any(|known| known == licence);
    let all = |part: &str| part.split(" AND ").all(|licence| is_listed(licence.trim()));
    expression.split(" OR ").any(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_read_as_spdx() {
        for good in [
            "MIT",
            "MIT/Apache-2.0",
            "GPL-3.0 OR MIT",
            "(MIT OR GPL-2.0) AND Unicode-3.0",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            assert!(allowed(good), "{good}");
        }
        for bad in ["", "GPL-3.0", "MIT AND GPL-3.0", "(MIT OR Apache-2.0) AND AGPL-3.0"] {
            assert!(!allowed(bad), "{bad}");
        }
    }
}

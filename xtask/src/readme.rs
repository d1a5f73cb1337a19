//! Each published crate's README: the beginning of its own documentation, up to the first example.

use anyhow::{Context, Result, bail};
use cargo_metadata::{Metadata, MetadataCommand, Package};
use std::path::PathBuf;

/// Writes the READMEs that differ from their crates' documentation.
pub(crate) fn write() -> Result<()> {
    for (path, text, _) in stale()? {
        std::fs::write(&path, text).with_context(|| path.display().to_string())?;
        println!("written: {}", path.display());
    }
    Ok(())
}

/// Fails with every README that is missing or differs from its crate's documentation.
pub(crate) fn check() -> Result<()> {
    let stale = stale()?;
    if stale.is_empty() {
        eprintln!("READMEs: as the crates' documentation");
        return Ok(());
    }
    let names: Vec<String> = stale.into_iter().map(|(_, _, name)| name).collect();
    bail!(
        "READMEs that are not as the documentation of their crates: {}; `cargo xtask readmes` writes them",
        names.join(", ")
    )
}

/// Packages that are published, in the order of `cargo metadata`.
pub(crate) fn published(metadata: &Metadata) -> Vec<&Package> {
    let own = metadata.workspace_packages().into_iter();
    own.filter(|package| package.publish.as_ref().is_none_or(|to| !to.is_empty())).collect()
}

/// Path, content and crate of every README that is to be written.
fn stale() -> Result<Vec<(PathBuf, String, String)>> {
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let mut found = Vec::new();
    for package in published(&metadata) {
        let folder = package.manifest_path.parent().context("a manifest lies in a folder")?;
        let source = std::fs::read_to_string(folder.join("src/lib.rs"))?;
        let text = readme(&package.name, &source);
        let path = folder.join("README.md").into_std_path_buf();
        if std::fs::read_to_string(&path).ok().as_ref() != Some(&text) {
            found.push((path, text, package.name.to_string()));
        }
    }
    Ok(found)
}

/// Text of a README from the source of a crate.
fn readme(name: &str, source: &str) -> String {
    let mut text = format!("# {name}\n\n");
    let mut fences = 0;
    for line in source.lines().map_while(|line| line.strip_prefix("//!")) {
        let line = line.strip_prefix(' ').unwrap_or(line);
        let fence = line.starts_with("```");
        fences += usize::from(fence);
        // Lines that documentation hides.
        let hidden = fences == 1 && (line == "#" || line.starts_with("# "));
        match (fence, hidden) {
            (true, _) if fences == 1 => text += "```rust\n",
            (_, false) => text += &format!("{}\n", without_links(line)),
            _ => {}
        }
        if fences == 2 {
            break;
        }
    }
    text + ENDING
}

/// End of every README.
const ENDING: &str = "
Part of Sinew, physics-informed emulation of soft-tissue mechanics in Rust. Outside its workspace, build with `--release`.

MIT or Apache-2.0, at your choice.
";

/// A line whose links to items are their names: ``[`Scene`]`` and ``[`Scene`](crate::Scene)`` are `Scene`.
fn without_links(line: &str) -> String {
    let mut text = String::new();
    let mut rest = line;
    while let Some(start) = rest.find("[`") {
        let Some(length) = rest[start..].find("`]") else { break };
        text += &rest[..start];
        text += &rest[start + 1..=start + length];
        rest = &rest[start + length + 2..];
        let path = rest.strip_prefix('(').and_then(|after| after.split_once(')'));
        if let Some((path, after)) = path
            && !path.contains('/')
        {
            rest = after;
        }
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_readme_is_the_beginning_up_to_the_first_example() {
        let source = "//! Reads [`Scene`](crate::Scene) and [`Body`].\n//!\n//! ```\n//! let a = 1;\n//! # Ok(())\n//! ```\n//!\n//! More.\n\nmod a;\n";
        let text = readme("sinew-a", source);
        assert!(
            text.starts_with(
                "# sinew-a\n\nReads `Scene` and `Body`.\n\n```rust\nlet a = 1;\n```\n"
            ),
            "{text}"
        );
        assert!(!text.contains("More") && text.ends_with("choice.\n"));
    }
}

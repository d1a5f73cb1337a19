//! The arrows between the crates, read from `cargo metadata` and compared with docs/architecture.md.

use anyhow::{Context, Result, bail};
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::BTreeSet;

/// Crates of ours that each crate may name in its normal dependencies.
const ARROWS: &[(&str, &[&str])] = &[
    ("sinew-num", &[]),
    ("sinew-mesh", &[]),
    ("sinew-energy", &["sinew-num", "sinew-mesh"]),
    ("sinew-fem", &["sinew-num", "sinew-mesh", "sinew-energy"]),
    ("sinew-graph", &["sinew-mesh"]),
    ("sinew-burn", &["sinew-num"]),
    ("sinew-gp", &["sinew-num", "sinew-burn"]),
    ("sinew-gnn", &["sinew-num", "sinew-mesh", "sinew-energy", "sinew-graph", "sinew-burn"]),
    ("sinew-emulate", &["sinew-mesh", "sinew-energy", "sinew-fem", "sinew-graph", "sinew-gnn"]),
    (
        "sinew-study",
        &[
            "sinew-num",
            "sinew-mesh",
            "sinew-energy",
            "sinew-fem",
            "sinew-graph",
            "sinew-burn",
            "sinew-gnn",
            "sinew-emulate",
            "sinew-gp",
        ],
    ),
    ("sinew-verify", &["sinew-num", "sinew-mesh", "sinew-energy", "sinew-fem"]),
    ("sinew-tests", &[]),
    ("sinew-examples", &["sinew-mesh", "sinew-energy", "sinew-fem", "sinew-emulate"]),
    ("xtask", &[]),
];

/// Heavy packages and the only crates of ours that may have them anywhere in their trees.
const HEAVY: &[(&str, &[&str])] = &[
    (
        "burn",
        &["sinew-burn", "sinew-gnn", "sinew-emulate", "sinew-gp", "sinew-study", "sinew-examples"],
    ),
    (
        "faer",
        &[
            "sinew-fem",
            "sinew-emulate",
            "sinew-gp",
            "sinew-study",
            "sinew-verify",
            "sinew-examples",
        ],
    ),
    (
        "quick-xml",
        &[
            "sinew-mesh",
            "sinew-energy",
            "sinew-fem",
            "sinew-graph",
            "sinew-gnn",
            "sinew-emulate",
            "sinew-study",
            "sinew-verify",
            "sinew-examples",
        ],
    ),
];

/// Fails with every forbidden arrow by name.
pub fn check() -> Result<()> {
    let metadata = MetadataCommand::new().exec().context("cargo metadata failed")?;
    let ours: BTreeSet<&str> =
        metadata.workspace_packages().iter().map(|package| package.name.as_str()).collect();
    let mut wrong = Vec::new();
    for package in metadata.workspace_packages() {
        let Some((_, allowed)) = ARROWS.iter().find(|(name, _)| *name == package.name.as_str())
        else {
            wrong.push(format!("{} is not in the table of xtask/src/arrows.rs", package.name));
            continue;
        };
        for dependency in normal_dependencies(package) {
            if ours.contains(dependency) && !allowed.contains(&dependency) {
                wrong.push(format!("{} must not depend on {dependency}", package.name));
            }
        }
        let tree = normal_tree(&metadata, package);
        for (heavy, owners) in HEAVY {
            if tree.contains(*heavy) && !owners.contains(&package.name.as_str()) {
                wrong.push(format!("{} must not have {heavy} in its tree", package.name));
            }
        }
    }
    if !wrong.is_empty() {
        bail!("forbidden dependencies (docs/architecture.md):\n  {}", wrong.join("\n  "));
    }
    eprintln!("dependency arrows: {} crates keep to docs/architecture.md", ours.len());
    Ok(())
}

fn normal_dependencies(package: &Package) -> impl Iterator<Item = &str> {
    package
        .dependencies
        .iter()
        .filter(|dependency| dependency.kind == DependencyKind::Normal)
        .map(|dependency| dependency.name.as_str())
}

/// Names of all packages in the tree of normal dependencies below `root`.
fn normal_tree(metadata: &Metadata, root: &Package) -> BTreeSet<String> {
    let nodes = &metadata.resolve.as_ref().expect("cargo metadata resolves dependencies").nodes;
    let mut names = BTreeSet::new();
    let mut seen = BTreeSet::from([&root.id]);
    let mut open = vec![&root.id];
    while let Some(id) = open.pop() {
        names.insert(metadata[id].name.to_string());
        let node = nodes.iter().find(|node| node.id == *id);
        for dependency in node.into_iter().flat_map(|node| &node.deps) {
            let normal =
                dependency.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal);
            if normal && seen.insert(&dependency.pkg) {
                open.push(&dependency.pkg);
            }
        }
    }
    names
}

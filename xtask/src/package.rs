//! Crates as they would be published: packed, looked into, and two of them built and tested outside of the repository.

use crate::command::{cargo, output};
use crate::readme::{self, published};
use anyhow::{Context, Result, ensure};
use cargo_metadata::{Metadata, MetadataCommand, Package};
use std::path::Path;
use std::process::Command;

/// Crates that are built and tested from their packages.
const TRIED: [&str; 2] = ["sinew-mesh", "sinew-fem"];
/// Files that every package holds.
const HELD: [&str; 4] = ["Cargo.toml", "README.md", "LICENSE-MIT", "LICENSE-APACHE"];
/// Largest package that a registry takes \[bytes\].
const MOST_BYTES: u64 = 10 << 20;
/// Platforms whose standard library is looked for, to check crates without Burn on.
const PLATFORMS: [&str; 2] = ["aarch64-unknown-linux-gnu", "wasm32-unknown-unknown"];

/// Packs all published crates, and builds and tests [`TRIED`] from what was packed; fails on a warning.
pub(crate) fn run() -> Result<()> {
    let metadata = MetadataCommand::new().exec().context("cargo metadata failed")?;
    readme::check()?;
    keys(&metadata)?;
    let packages = metadata.target_directory.join("package").into_std_path_buf();
    pack(&metadata)?;
    let trial = packages.join("trial");
    let _ = std::fs::remove_dir_all(&trial);
    std::fs::create_dir_all(&trial)?;
    for package in published(&metadata) {
        unpack(package, &packages, &trial)?;
    }
    test(&metadata, &trial)?;
    // With the features of its own dependencies, which the tests' build unites with those of networks.
    cargo(&["check", "-p", "sinew", "-p", "sinew-python", "--no-default-features"], &[])?;
    crate::licences::check()?;
    platforms()
}

/// Requires what registries show of a crate.
fn keys(metadata: &Metadata) -> Result<()> {
    let mut wrong = Vec::new();
    for package in published(metadata) {
        let missing = [
            ("description", package.description.is_none()),
            ("documentation", package.documentation.is_none()),
            ("licence", package.license.is_none()),
            ("keywords (1 to 5)", !(1..=5).contains(&package.keywords.len())),
            ("categories", package.categories.is_empty()),
        ];
        let missing = missing.iter().filter(|key| key.1);
        wrong.extend(missing.map(|key| format!("{}: {}", package.name, key.0)));
    }
    ensure!(wrong.is_empty(), "keys that are missing:\n  {}", wrong.join("\n  "));
    if published(metadata).iter().any(|package| package.repository.is_none()) {
        eprintln!(
            "package: `repository` is not set; its owner puts the address into [workspace.package] and the crates"
        );
    }
    Ok(())
}

/// Packs all of them together, so that one finds the others.
fn pack(metadata: &Metadata) -> Result<()> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["package", "--no-verify", "--allow-dirty"]);
    published(metadata).iter().for_each(|package| _ = cargo.args(["-p", package.name.as_str()]));
    let said = quiet(&mut cargo)?;
    // What `exclude` leaves out, cargo says.
    let warnings = warnings(&said, "is not included in the published package");
    ensure!(warnings.is_empty(), "cargo package warns:\n  {}", warnings.join("\n  "));
    Ok(())
}

/// Warnings among what was said, but for those that are meant.
fn warnings<'a>(said: &'a str, meant: &str) -> Vec<&'a str> {
    let warns = |line: &&str| line.starts_with("warning") && !line.contains(meant);
    said.lines().filter(warns).collect()
}

/// Unpacks one, and requires what it is to hold.
fn unpack(package: &Package, packages: &Path, trial: &Path) -> Result<()> {
    let name = format!("{}-{}", package.name, package.version);
    let file = packages.join(format!("{name}.crate"));
    let bytes = file.metadata().with_context(|| file.display().to_string())?.len();
    ensure!(bytes <= MOST_BYTES, "{} has {bytes} bytes, more than {MOST_BYTES}", file.display());
    quiet(Command::new("tar").arg("-xzf").arg(&file).arg("-C").arg(trial))?;
    for held in HELD {
        ensure!(trial.join(&name).join(held).exists(), "{name} lacks {held}");
    }
    for part in ["examples", "benches", "tests"] {
        modules(&trial.join(&name).join(part))?;
    }
    println!("{name}: {:.0} kB", bytes as f64 / 1024.0);
    Ok(())
}

/// Requires the files that programs of a folder, and of those in it, name as their modules.
fn modules(folder: &Path) -> Result<()> {
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let file = entry?.path();
        modules(&file)?;
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        for named in text.split("#[path = \"").skip(1).filter_map(|rest| rest.split('"').next()) {
            let (file, found) = (file.display(), folder.join(named).exists());
            ensure!(found, "{file} needs {named}, which is not packed: `exclude` it in Cargo.toml");
        }
    }
    Ok(())
}

/// Builds and tests from packages, in a workspace that knows nothing of the repository.
fn test(metadata: &Metadata, trial: &Path) -> Result<()> {
    let folder = |package: &Package| format!("{}-{}", package.name, package.version);
    let tried =
        published(metadata).into_iter().filter(|package| TRIED.contains(&package.name.as_str()));
    let members: Vec<_> = tried.map(|package| format!("{:?}", folder(package))).collect();
    let patched = published(metadata)
        .into_iter()
        .map(|p| format!("{} = {{ path = {:?} }}\n", p.name, folder(p)));
    let profile = "[profile.test]\nopt-level = 3\n";
    let text = format!(
        "[workspace]\nresolver = \"3\"\nmembers = [{}]\n\n[patch.crates-io]\n{}\n{profile}",
        members.join(", "),
        patched.collect::<String>()
    );
    std::fs::write(trial.join("Cargo.toml"), text)?;
    std::fs::copy(metadata.workspace_root.join("Cargo.lock"), trial.join("Cargo.lock"))?;
    let target = metadata.target_directory.join("package-trial");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["test", "--workspace"]).current_dir(trial).env("CARGO_TARGET_DIR", target);
    let said = quiet(cargo.env("RUSTFLAGS", "-D warnings"))?;
    // Patches of crates that neither needs are no fault of theirs.
    let own = warnings(&said, "was not used in the crate graph");
    ensure!(own.is_empty(), "building from packages warns:\n  {}", own.join("\n  "));
    println!("built and tested from their packages: {}", TRIED.join(", "));
    Ok(())
}

/// Checks crates without Burn for other platforms, where their standard library is installed.
fn platforms() -> Result<()> {
    let [root, _] = output(Command::new("rustc").args(["--print", "sysroot"]), "rustc")?;
    for platform in PLATFORMS {
        if !Path::new(root.trim()).join("lib/rustlib").join(platform).exists() {
            eprintln!(
                "package: {platform} is not checked, for its standard library is not installed"
            );
            continue;
        }
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["check", "--target", platform]);
        quiet(TRIED.iter().fold(&mut cargo, |cargo, name| cargo.args(["-p", name])))?;
        println!("{platform}: {} are checked", TRIED.join(", "));
    }
    Ok(())
}

/// Runs a command; what it said on standard error.
fn quiet(command: &mut Command) -> Result<String> {
    let name = format!("{command:?}");
    eprintln!("$ {name}");
    let [_, said] = output(command, &name)?;
    Ok(said)
}

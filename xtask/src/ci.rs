//! Continuous integration, cheapest steps first.

use crate::command::{self, cargo};
use crate::steps::Steps;
use crate::{arrows, circles, licences, readme, wheel, words};
use anyhow::{Context, Result};
use cargo_metadata::MetadataCommand;
use std::path::Path;

/// Format, dependency arrows, circles of imports, words, READMEs, licences, tests with lints, campaigns, tests of the Python package, examples
/// and benchmarks, a build without networks and documentation; then a table of the seconds of each step, which `ci.md` in the target folder keeps. The
/// wheel, which is a release build of its own, is made by `cargo xtask wheel`.
pub(crate) fn run() -> Result<()> {
    let mut steps = Steps::default();
    let done = all(&mut steps);
    let folder = MetadataCommand::new().no_deps().exec()?.target_directory;
    steps.report(folder.join("ci.md").as_std_path())?;
    done
}

fn all(steps: &mut Steps) -> Result<()> {
    steps.take("format", || cargo(&["fmt", "--all", "--", "--check"], &[]))?;
    steps.take("rules of the text", || {
        arrows::check()?;
        circles::check()?;
        words::check()?;
        readme::check()?;
        licences::check()
    })?;
    // Our crates are compiled by clippy, so that lints cost no build of their own.
    let driver = Path::new(env!("CARGO")).with_file_name("clippy-driver");
    let driver = driver.to_str().context("a path of cargo that is text")?;
    let linted =
        [("RUSTC_WORKSPACE_WRAPPER", driver), ("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__")];
    let test = |more: &[&str]| cargo(&[&["test", "--workspace"], more].concat(), &linted);
    steps.take("build of the tests, with lints", || test(&["--no-run"]))?;
    steps.take("tests", || test(&["--tests"]))?;
    steps.take("examples in documentation", || test(&["--doc"]))?;
    steps.take("campaigns", || command::campaigns(&linted))?;
    steps.take("Python", || wheel::test(&linted))?;
    steps.take("lints of examples and benchmarks", || {
        cargo(&["clippy", "--workspace", "--examples", "--benches", "--", "-D", "warnings"], &[])
    })?;
    // The configuration of the Python wheel too.
    steps.take("without networks", || {
        cargo(&["check", "-p", "sinew", "-p", "sinew-python", "--no-default-features"], &[])
    })?;
    steps.take("documentation", || {
        cargo(&["doc", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])
    })
}

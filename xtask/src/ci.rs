//! Continuous integration, cheapest steps first.

use crate::command::{campaigns, cargo, cargo_aside};
use crate::stand_in::STANDS_IN;
use crate::steps::Steps;
use crate::{arrows, circles, licences, readme, walks, wheel, words};
use anyhow::{Context, Result};
use cargo_metadata::MetadataCommand;
use std::time::Duration;

/// Time in which cargo finds that the tests are built.
const HEAD_START: Duration = Duration::from_secs(20);

/// Format, dependency arrows, circles of imports, walks, words, READMEs, licences, tests, examples and benchmarks with lints, documentation and its examples,
/// tests of the Python package, campaigns; then a table of the seconds of each step, which `ci.md` in the target folder keeps.
/// Everything is compiled in one profile, so that dependencies are compiled once.
/// The wheel, which is a release build of its own, is made by `cargo xtask wheel`.
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
        walks::check()?;
        words::check()?;
        readme::check()?;
        licences::check()
    })?;
    let pages = MetadataCommand::new().no_deps().exec()?.target_directory.join("doc");
    let own = std::env::current_exe()?;
    let own = own.to_str().context("a path of this program that is text")?;
    let linted = [
        ("RUSTC_WORKSPACE_WRAPPER", own),
        ("RUSTDOC", own),
        (STANDS_IN, pages.as_str()),
        ("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__"),
    ];
    let test = |more: &[&str]| cargo(&[&["test", "--workspace"], more].concat(), &linted);
    std::thread::scope(|scope| {
        // Packages arrive while cargo compiles.
        let python = scope.spawn(wheel::testers);
        // As `cargo test` compiles tests; examples are programs, as their users compile them.
        steps.take("build of tests, examples and benchmarks, with lints", || {
            let what = ["--tests", "--examples", "--benches"];
            cargo(&[&["build", "--workspace", "--profile", "test"], &what[..]].concat(), &linted)
        })?;
        // Tests leave a core idle at times.
        let what = "tests, beside documentation, its examples and tests of the Python package";
        steps.take(what, || {
            std::thread::scope(|scope| {
                let beside = scope.spawn(|| {
                    // One cargo at a time uses a folder: the one that finds the tests built is to come first.
                    std::thread::sleep(HEAD_START);
                    cargo_aside(&["test", "--workspace", "--doc"], &linted)?;
                    // A program without libraries of ours.
                    cargo_aside(
                        &["doc", "-p", "xtask", "--no-deps"],
                        &[("RUSTDOCFLAGS", "-D warnings")],
                    )?;
                    let python = python.join().expect("an installation ends with a result")?;
                    python.map_or(Ok(()), |python| wheel::test_aside(&python, &linted))
                });
                let tested = test(&["--tests", "--no-fail-fast"]);
                let beside = beside.join().expect("documentation ends with a result");
                tested.and(beside)
            })
        })?;
        steps.take("campaigns", || campaigns(&linted))
    })
}

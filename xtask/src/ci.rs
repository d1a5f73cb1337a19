//! Continuous integration, cheapest steps first.

use crate::command::{cargo, cargo_aside};
use crate::steps::Steps;
use crate::{arrows, circles, licences, readme, walks, wheel, words};
use anyhow::{Context, Result};
use cargo_metadata::MetadataCommand;
use std::path::Path;
use std::time::Duration;

/// Time in which cargo finds that the tests are built.
const HEAD_START: Duration = Duration::from_secs(20);

/// Format, dependency arrows, circles of imports, walks, words, READMEs, licences, tests with lints, checks of examples, benchmarks, documentation and a
/// build without networks, campaigns, tests of the Python package; then a table of the seconds of each step, which `ci.md` in the target folder keeps.
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
    // Our crates are compiled by clippy, so that lints cost no build of their own.
    let driver = Path::new(env!("CARGO")).with_file_name("clippy-driver");
    let driver = driver.to_str().context("a path of cargo that is text")?;
    let linted =
        [("RUSTC_WORKSPACE_WRAPPER", driver), ("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__")];
    let test = |more: &[&str]| cargo(&[&["test", "--workspace"], more].concat(), &linted);
    steps.take("build of the tests, with lints", || test(&["--tests", "--no-run"]))?;
    // Tests leave a core idle at times, which compiles what is only checked.
    steps.take(
        "tests, beside checks of examples, benchmarks, documentation and a build without networks",
        || {
            std::thread::scope(|scope| {
                let checked = scope.spawn(|| {
                    // One cargo at a time compiles into a folder: the one that finds the tests built is to come first.
                    std::thread::sleep(HEAD_START);
                    checks()
                });
                let tested = test(&["--tests", "--no-fail-fast"]);
                let checked = checked.join().expect("checks end with a result");
                tested.and(checked)
            })
        },
    )?;
    steps.take("examples in documentation", || test(&["--doc"]))?;
    steps
        .take("campaigns", || test(&["--tests", "--", "--ignored", "--nocapture", "campaigns"]))?;
    steps.take("Python", || wheel::test(&linted))
}

/// Lints of what tests do not compile, the configuration of the Python wheel, and documentation.
fn checks() -> Result<()> {
    let clippy = ["clippy", "--workspace", "--examples", "--benches", "--", "-D", "warnings"];
    cargo_aside(&clippy, &[])?;
    let light = ["check", "-p", "sinew", "-p", "sinew-python", "--no-default-features"];
    cargo_aside(&light, &[])?;
    cargo_aside(&["doc", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])
}

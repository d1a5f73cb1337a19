//! Continuous integration, cheapest steps first.

use crate::command::{cargo, cargo_aside};
use crate::steps::Steps;
use crate::{arrows, circles, licences, readme, walks, wheel, words};
use anyhow::{Context, Result};
use cargo_metadata::MetadataCommand;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Variable that names rustdoc to this program, which cargo then calls in its place.
pub(crate) const RUSTDOC: &str = "XTASK_RUSTDOC";

/// Time in which cargo finds that the tests are built.
const HEAD_START: Duration = Duration::from_secs(20);
/// Our crates but those that need networks.
const LIGHT: [&str; 6] = [
    "--workspace",
    "--exclude",
    "sinew-studies",
    "--exclude",
    "sinew-tests",
    "--no-default-features",
];

/// Format, dependency arrows, circles of imports, walks, words, READMEs, licences, tests, examples and benchmarks with lints, documentation and its examples,
/// campaigns, tests of the Python package, a build without networks; then a table of the seconds of each step, which `ci.md` in the target folder keeps.
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
    // Our crates are compiled by clippy, so that lints cost no build of their own.
    let driver = Path::new(env!("CARGO")).with_file_name("clippy-driver");
    let driver = driver.to_str().context("a path of cargo that is text")?;
    let linted =
        [("RUSTC_WORKSPACE_WRAPPER", driver), ("CLIPPY_ARGS", "-Dwarnings__CLIPPY_HACKERY__")];
    let test = |more: &[&str]| cargo(&[&["test", "--workspace"], more].concat(), &linted);
    std::thread::scope(|scope| {
        // Packages arrive while cargo compiles.
        let python = scope.spawn(wheel::testers);
        steps.take("build of tests, examples and benchmarks, with lints", || {
            test(&["--tests", "--examples", "--benches", "--no-run"])
        })?;
        // Tests leave a core idle at times.
        steps.take("tests, beside documentation and its examples", || {
            std::thread::scope(|scope| {
                let documented = scope.spawn(|| {
                    // One cargo at a time uses a folder: the one that finds the tests built is to come first.
                    std::thread::sleep(HEAD_START);
                    document(&linted)
                });
                let tested = test(&["--tests", "--no-fail-fast"]);
                let documented = documented.join().expect("documentation ends with a result");
                tested.and(documented)
            })
        })?;
        steps.take("campaigns", || {
            test(&["--tests", "--", "--ignored", "--nocapture", "campaigns"])
        })?;
        let python = python.join().expect("an installation ends with a result")?;
        steps.take("Python, beside a build without networks", || {
            wheel::tested(python.as_deref(), &linted, || {
                let build =
                    [&["build", "--profile", "test", "--lib", "--bins"], &LIGHT[..]].concat();
                cargo_aside(&build, &linted)
            })
        })
    })
}

/// Documentation of the libraries, without warnings, and its examples.
///
/// `cargo doc` would check every dependency first. Where examples are tested, rustdoc is given the compiled ones: it is called for
/// both ([`documented`]).
fn document(linted: &[(&str, &str)]) -> Result<()> {
    let own = std::env::current_exe()?;
    let own = own.to_str().context("a path of this program that is text")?;
    let rustdoc = Path::new(env!("CARGO")).with_file_name("rustdoc");
    let rustdoc = rustdoc.to_str().context("a path of rustdoc that is text")?;
    let called = [("RUSTDOC", own), (RUSTDOC, rustdoc)];
    cargo_aside(&["test", "--workspace", "--doc"], &[linted, &called].concat())
}

/// Calls rustdoc for the documentation of a library where cargo asks for the tests of its examples, then for these; whether
/// both succeeded. The variable [`RUSTDOC`] names it.
pub(crate) fn documented(rustdoc: &OsStr) -> Result<bool> {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let run = |arguments: &[OsString]| {
        let status = Command::new(rustdoc).args(arguments).status();
        Ok::<_, anyhow::Error>(status.context("rustdoc could not be started")?.success())
    };
    let mut page = Vec::new();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.to_str() {
            Some("--test") => {
                page.extend(["-D", "warnings", "--out-dir", "target/doc"].map(OsString::from))
            }
            Some("--test-run-directory" | "--test-args") => drop(rest.next()),
            _ => page.push(argument.clone()),
        }
    }
    Ok((!arguments.iter().any(|it| it == "--test") || run(&page)?) && run(&arguments)?)
}

//! Continuous integration, cheapest steps first.

use crate::command::{cargo, cargo_aside};
use crate::steps::Steps;
use crate::{arrows, circles, licences, readme, walks, wheel, words};
use anyhow::{Context, Result};
use cargo_metadata::MetadataCommand;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Variable with the folder of the documentation, where cargo calls this program in the place of clippy and rustdoc ([`stand_in`]).
pub(crate) const STANDS_IN: &str = "XTASK_STANDS_IN";

/// Time in which cargo finds that the tests are built.
const HEAD_START: Duration = Duration::from_secs(20);

/// Format, dependency arrows, circles of imports, walks, words, READMEs, licences, tests, examples and benchmarks with lints, documentation and its examples,
/// campaigns, tests of the Python package beside a check without networks; then a table of the seconds of each step, which `ci.md` in the target folder keeps.
/// Everything but the last is compiled in one profile, so that dependencies are compiled once.
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
        steps.take("tests, beside documentation and its examples", || {
            std::thread::scope(|scope| {
                let documented = scope.spawn(|| {
                    // One cargo at a time uses a folder: the one that finds the tests built is to come first.
                    std::thread::sleep(HEAD_START);
                    cargo_aside(&["test", "--workspace", "--doc"], &linted)?;
                    // A program without libraries of ours.
                    cargo_aside(
                        &["doc", "-p", "xtask", "--no-deps"],
                        &[("RUSTDOCFLAGS", "-D warnings")],
                    )?;
                    cargo_aside(&wheel::LIBRARY, &linted)
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
        steps.take("Python, beside a check without networks", || {
            // The features of the wheel, which no other step has: one core is left.
            let check =
                ["check", "-j", "1", "-p", "sinew", "-p", "sinew-python", "--no-default-features"];
            wheel::tested(python.as_deref(), &linted, || cargo_aside(&check, &linted))
        })
    })
}

/// Compiles or documents in the place that cargo gives this program; whether that succeeded.
pub(crate) fn stand_in() -> Result<bool> {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let compiler = arguments.first().map(Path::new).and_then(Path::file_stem);
    if compiler.is_some_and(|name| name == "rustc") {
        compile(arguments)
    } else {
        document(&arguments)
    }
}

/// Compiles one of our crates by clippy, so that lints cost no build of their own; examples and benchmarks, which are not run,
/// without optimisation.
fn compile(mut arguments: Vec<OsString>) -> Result<bool> {
    let is_unrun = |argument: &OsString| {
        let file = Path::new(argument);
        file.extension().is_some_and(|ending| ending == "rs")
            && file.iter().any(|folder| folder == "examples" || folder == "benches")
    };
    if arguments.iter().any(is_unrun) {
        for argument in &mut arguments {
            if argument.to_string_lossy().starts_with("opt-level=") {
                *argument = "opt-level=0".into();
            }
        }
    }
    call("clippy-driver", &arguments)
}

/// Tests the examples of a library's documentation, after the documentation itself without warnings: `cargo doc` would check every
/// dependency again, where here are the compiled ones.
fn document(arguments: &[OsString]) -> Result<bool> {
    let mut page = Vec::new();
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.to_str() {
            Some("--test") => {
                page.extend(["-D", "warnings", "--out-dir"].map(OsString::from));
                page.extend(std::env::var_os(STANDS_IN));
            }
            Some("--test-run-directory" | "--test-args") => drop(rest.next()),
            _ => page.push(argument.clone()),
        }
    }
    let is_tested = arguments.iter().any(|argument| argument == "--test");
    Ok((!is_tested || call("rustdoc", &page)?) && call("rustdoc", arguments)?)
}

/// Calls a program beside cargo; whether it succeeded.
fn call(name: &str, arguments: &[OsString]) -> Result<bool> {
    let program = Path::new(env!("CARGO")).with_file_name(name);
    let status = Command::new(program).args(arguments).status();
    Ok(status.with_context(|| format!("{name} could not be started"))?.success())
}

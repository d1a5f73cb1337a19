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
/// campaigns, tests of the Python package; then a table of the seconds of each step, which `ci.md` in the target folder keeps.
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
        steps.take("Python", || wheel::tested(python.as_deref(), &linted))
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

/// Levels of programs whose inner loops are in libraries, by crate and whether it is one of tests: they compile in half the time or less, and run as fast.
const LEVELS: [(&str, bool, &str); 5] = [
    ("energy", true, "0"),
    ("gnn", true, "1"),
    ("sinew", true, "0"),
    ("sinew", false, "0"),
    ("sinew_studies", false, "0"),
];

/// Compiles one of our crates by clippy, so that lints cost no build of their own; examples and benchmarks, which are not run,
/// without optimisation. What has networks as a feature is checked without them, too.
fn compile(mut arguments: Vec<OsString>) -> Result<bool> {
    let unit = Unit::new(&arguments);
    if let Some(level) = unit.level() {
        for argument in &mut arguments {
            if argument.to_string_lossy().starts_with("opt-level=") {
                *argument = format!("opt-level={level}").into();
            }
        }
    }
    Ok(call("clippy-driver", &arguments)? && (!unit.has_networks || without_networks(&arguments)?))
}

/// One call of the compiler by cargo.
struct Unit {
    name: String,
    is_test: bool,
    is_program: bool,
    is_run: bool,
    has_networks: bool,
}

impl Unit {
    fn new(arguments: &[OsString]) -> Self {
        let is_run = |argument: &OsString| {
            let file = Path::new(argument);
            file.extension().is_none_or(|ending| ending != "rs")
                || !file.iter().any(|folder| folder == "examples" || folder == "benches")
        };
        let after = |key: &str| {
            let place = arguments.iter().position(|argument| argument == key);
            place.and_then(|place| arguments.get(place + 1)).map(|value| value.to_string_lossy())
        };
        let is_test = arguments.iter().any(|argument| argument == "--test");
        Self {
            name: after("--crate-name").unwrap_or_default().into(),
            is_test,
            is_program: is_test || after("--crate-type").is_some_and(|kind| kind == "bin"),
            is_run: arguments.iter().all(is_run),
            has_networks: !is_test && arguments.iter().any(|argument| argument == NETWORKS),
        }
    }

    /// Level in the place of cargo's.
    fn level(&self) -> Option<&'static str> {
        let is_own = |(name, is_test, _): &&(&str, bool, _)| {
            self.is_program && *name == self.name && *is_test == self.is_test
        };
        let listed = || LEVELS.iter().find(is_own).map(|level| level.2);
        if self.is_run { listed() } else { Some("0") }
    }
}

/// The feature of networks, the crate that it brings, and the library that has it.
const NETWORKS: &str = "feature=\"networks\"";
const BROUGHT: &str = "sinew_gnn=";
const LIBRARY: &str = "sinew=";

/// Checks a crate without networks, beside what is compiled of its dependencies: `cargo check` would check all of these once more.
fn without_networks(arguments: &[OsString]) -> Result<bool> {
    let folder = Path::new(&std::env::var_os(STANDS_IN).unwrap_or_default())
        .with_file_name("without-networks");
    std::fs::create_dir_all(&folder)?;
    let mut bare: Vec<OsString> = Vec::new();
    let mut rest = arguments.iter().peekable();
    while let Some(argument) = rest.next() {
        let value = rest.peek().map(|next| next.to_string_lossy());
        let value = value.as_deref().unwrap_or_default();
        match argument.to_str() {
            Some("--cfg") if value == NETWORKS || value == "feature=\"default\"" => {
                rest.next();
            }
            Some("--extern") if value.starts_with(BROUGHT) => {
                rest.next();
            }
            Some("--extern") if value.starts_with(LIBRARY) => {
                let file = Path::new(value.trim_start_matches(LIBRARY)).with_extension("rmeta");
                let file = folder.join(file.file_name().context("a file")?);
                bare.extend(["--extern".into(), format!("{LIBRARY}{}", file.display()).into()]);
                rest.next();
            }
            Some("--out-dir") => {
                bare.extend(["--out-dir".into(), folder.clone().into()]);
                rest.next();
            }
            Some(emit) if emit.starts_with("--emit=") => bare.push("--emit=metadata".into()),
            // Cargo waits for the files of the crate as it is.
            Some(json) if json.starts_with("--json=") => {
                bare.push("--json=diagnostic-rendered-ansi".into())
            }
            _ => bare.push(argument.clone()),
        }
    }
    call("clippy-driver", &bare)
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

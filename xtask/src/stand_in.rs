//! The program that cargo calls in the place of rustc and rustdoc in continuous integration ([`crate::ci`]).

use anyhow::{Context, Result};
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

/// Variable with the folder of the documentation, where cargo calls this program.
pub(crate) const STANDS_IN: &str = "XTASK_STANDS_IN";

/// Levels of programs by a part of their source file: of those that nothing runs, and of those whose inner loops are in libraries, which
/// compile in half the time or less and run as fast.
const LEVELS: [(&str, &str); 7] = [
    ("/examples/", "0"),
    ("/benches/", "0"),
    ("/sinew-energy/tests/", "0"),
    ("/sinew-gnn/tests/", "1"),
    ("/sinew/tests/", "0"),
    ("/sinew/src/main.rs", "0"),
    ("/sinew-studies/src/main.rs", "0"),
];

/// The feature of networks, the default one that brings it, its crate, and the library that has it.
const NETWORKS: &str = "feature=\"networks\"";
const DEFAULT: &str = "feature=\"default\"";
const BROUGHT: &str = "sinew_gnn=";
const LIBRARY: &str = "sinew=";

/// Compiles or documents; whether that succeeded.
pub(crate) fn stand_in() -> Result<bool> {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let compiler = arguments.first().map(Path::new).and_then(Path::file_stem);
    if compiler.is_some_and(|name| name == "rustc") {
        compile(arguments)
    } else {
        document(&arguments)
    }
}

/// Compiles one of our crates by clippy, so that lints cost no build of their own. One with networks is checked without them, too.
fn compile(mut arguments: Vec<OsString>) -> Result<bool> {
    let texts = || arguments.iter().map(|argument| argument.to_string_lossy());
    let source = texts().find(|text| text.ends_with(".rs")).unwrap_or_default();
    let level = LEVELS.iter().find(|(part, _)| source.contains(part)).map(|(_, level)| *level);
    let has_networks =
        texts().any(|text| text == NETWORKS) && !texts().any(|text| text == "--test");
    if let Some(level) = level {
        for argument in &mut arguments {
            if argument.to_string_lossy().starts_with("opt-level=") {
                *argument = format!("opt-level={level}").into();
            }
        }
    }
    Ok(call("clippy-driver", &arguments)? && (!has_networks || without_networks(&arguments)?))
}

/// Checks a crate without networks, beside what is compiled of its dependencies: `cargo check` would check all of these once more.
fn without_networks(arguments: &[OsString]) -> Result<bool> {
    let pages = std::env::var_os(STANDS_IN).unwrap_or_default();
    let folder = Path::new(&pages).with_file_name("without-networks");
    std::fs::create_dir_all(&folder)?;
    let mut bare: Vec<OsString> = Vec::new();
    for argument in arguments {
        let text = argument.to_string_lossy();
        if text == NETWORKS || text == DEFAULT || text.starts_with(BROUGHT) {
            // With the flag before it.
            bare.pop();
        } else if bare.last().is_some_and(|flag| flag == "--out-dir") {
            bare.push(folder.clone().into());
        } else if let Some(file) = text.strip_prefix(LIBRARY) {
            let name = Path::new(file).with_extension("rmeta");
            let file = folder.join(name.file_name().context("a file")?);
            bare.push(format!("{LIBRARY}{}", file.display()).into());
        } else if text.starts_with("--emit=") {
            bare.push("--emit=metadata".into());
        } else if text.starts_with("--json=") {
            // Cargo waits for the files of the crate as it is.
            bare.push("--json=diagnostic-rendered-ansi".into());
        } else {
            bare.push(argument.clone());
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

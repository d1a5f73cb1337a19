//! The Python wheel: built by maturin, tried in a clean virtual environment.

use crate::command::cargo;
use anyhow::{Context, Result, bail};
use cargo_metadata::MetadataCommand;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Largest wheel \[bytes\].
const MOST_BYTES: u64 = 20 << 20;
/// Longest run of the README's program in a clean environment \[s\].
const MOST_SECONDS: f64 = 60.0;
/// Target whose C library zig links an old version of.
const TARGET: &str = "x86_64-unknown-linux-gnu";
/// Packages that build a wheel; the second brings a linker for old C libraries.
const BUILDERS: [&str; 2] = ["maturin>=1.9,<2", "ziglang"];
/// Packages that the tests use.
const TESTERS: [&str; 7] =
    ["pytest", "mypy", "meshio", "pyvista", "xarray", "nbclient", "ipykernel"];
/// A sampler of chains on several levels, its client of `sinew serve`, and what it imports without saying so.
const SAMPLERS: [&str; 4] = ["tinyDA", "umbridge", "ray", "matplotlib<3.11"];

/// Builds the wheel into `target/wheel`, and with `test` runs the Python tests on it. Where Python or its packages are missing it says that
/// this is skipped.
pub(crate) fn run(test: bool) -> Result<()> {
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let root = metadata.workspace_root.into_std_path_buf();
    let folder = metadata.target_directory.into_std_path_buf().join("wheel");
    std::fs::create_dir_all(&folder)?;
    let Some(python) = interpreter() else {
        eprintln!("wheel: skipped, for there is no python3 with venv here");
        return Ok(());
    };
    let builder = environment(&python, &folder.join("build"))?;
    if !install(&builder, &BUILDERS)? {
        eprintln!("wheel: skipped, for maturin cannot be installed here");
        return Ok(());
    }
    let wheel = build(&root, &builder, &folder)?;
    if test { tried(&root, &python, &folder, &wheel) } else { Ok(()) }
}

/// A Python 3 that makes virtual environments; `PYTHON` names another than `python3`.
fn interpreter() -> Option<PathBuf> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut call = Command::new(&python);
    call.args(["-c", "import venv, ensurepip"]).stdout(Stdio::null()).stderr(Stdio::null());
    call.status().is_ok_and(|status| status.success()).then(|| python.into())
}

/// The interpreter of a virtual environment in a folder, made where there is none.
fn environment(python: &Path, folder: &Path) -> Result<PathBuf> {
    let own = folder.join("bin/python");
    if !own.exists() {
        call(Command::new(python).args(["-m", "venv"]).arg(folder))?;
    }
    Ok(own)
}

/// Installs packages; whether that was possible.
fn install(python: &Path, packages: &[impl AsRef<std::ffi::OsStr>]) -> Result<bool> {
    let mut pip = Command::new(python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(packages);
    Ok(pip.status().context("pip could not be started")?.success())
}

fn call(command: &mut Command) -> Result<()> {
    eprintln!("$ {command:?}");
    let status = command.status().with_context(|| format!("{command:?} could not be started"))?;
    if !status.success() {
        bail!("{command:?} failed with {status}");
    }
    Ok(())
}

/// Builds the wheel; where its processor or system is another, for this machine only.
fn build(root: &Path, python: &Path, folder: &Path) -> Result<PathBuf> {
    let out = folder.join("dist");
    let _ = std::fs::remove_dir_all(&out);
    let mut maturin = Command::new(python);
    // Zig is found by way of the first python3 there.
    let path = std::env::var_os("PATH").unwrap_or_default();
    let first = python.parent().map(Path::to_path_buf).into_iter();
    maturin.env("PATH", std::env::join_paths(first.chain(std::env::split_paths(&path)))?);
    maturin.args(["-m", "maturin", "build", "--release", "--locked", "--manifest-path"]);
    maturin.arg(root.join("crates/sinew-python/Cargo.toml")).arg("--out").arg(&out);
    if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        maturin.args(["--zig", "--target", TARGET, "--compatibility", "manylinux2014"]);
    }
    call(&mut maturin)?;
    let wheels = std::fs::read_dir(&out)?.map(|entry| Ok(entry?.path()));
    let [wheel] = &wheels.collect::<Result<Vec<_>>>()?[..] else {
        bail!("{} holds other than one wheel", out.display());
    };
    let bytes = wheel.metadata()?.len();
    println!("{}: {:.1} MB", wheel.display(), bytes as f64 / (1 << 20) as f64);
    if bytes > MOST_BYTES {
        bail!("the wheel has more than {} MB", MOST_BYTES >> 20);
    }
    Ok(wheel.clone())
}

/// Runs the README's program in a clean environment, then the tests beside the program `sinew`.
fn tried(root: &Path, python: &Path, folder: &Path, wheel: &Path) -> Result<()> {
    let clean = folder.join("clean");
    let _ = std::fs::remove_dir_all(&clean);
    let own = environment(python, &clean)?;
    let start = Instant::now();
    if !install(&own, &[wheel])? {
        bail!("{} cannot be installed", wheel.display());
    }
    let package = root.join("crates/sinew-python");
    let readme = std::fs::read_to_string(package.join("README.md"))?;
    let program = readme.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    let file = folder.join("readme.py");
    std::fs::write(&file, program.context("the README has no program")?)?;
    call(Command::new(&own).arg(&file))?;
    let seconds = start.elapsed().as_secs_f64();
    println!("from a clean environment to an emulator with its error: {seconds:.0} s");
    if seconds > MOST_SECONDS {
        bail!("more than {MOST_SECONDS} s");
    }
    if !install(&own, &TESTERS)? {
        eprintln!(
            "Python tests: skipped, for one of {} cannot be installed here",
            TESTERS.join(", ")
        );
        return Ok(());
    }
    if !install(&own, &SAMPLERS)? {
        eprintln!(
            "test of samplers: skipped, for {} cannot be installed here",
            SAMPLERS.join(", ")
        );
    }
    let program = program_to_compare_with()?;
    let mut pytest = Command::new(&own);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(package.join("tests"));
    call(pytest.env("SINEW_PROGRAM", program))
}

/// The program `sinew`, as tests of the workspace build it.
fn program_to_compare_with() -> Result<PathBuf> {
    cargo(&["build", "--workspace", "--bin", "sinew"], &[])?;
    let folder = MetadataCommand::new().no_deps().exec()?.target_directory.into_std_path_buf();
    Ok(folder.join("debug").join(format!("sinew{}", std::env::consts::EXE_SUFFIX)))
}

//! The Python package: a wheel that maturin builds, and tests of a library that is compiled as the workspace's own tests are.

use crate::command::{self, cargo, cargo_aside, output};
use anyhow::{Context, Result, bail, ensure};
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
const TESTERS: [&str; 9] =
    ["numpy", "pytest", "mypy", "meshio", "pyvista", "xarray", "arviz", "nbclient", "ipykernel"];
/// A sampler of chains on several levels, its client of `sinew serve`, and what it imports without saying so.
const SAMPLERS: [&str; 4] = ["tinyDA", "umbridge", "ray", "matplotlib<3.11"];

/// Arguments by which cargo compiles the library and the program that the tests use; tests among the targets choose the features that tests have.
const LIBRARY: [&str; 9] =
    ["build", "--workspace", "--profile", "test", "--lib", "--bin", "sinew", "--test", "sinew"];

/// Builds the wheel into `target/wheel/dist` and runs the README's program on it in a clean environment.
pub(crate) fn run(features: Option<&str>) -> Result<()> {
    let (root, folder, python) = place()?;
    let python = python.context(
        "there is no Python 3 with venv and pip: install them (Debian: python3-venv), or name another by PYTHON",
    )?;
    let builder = environment(&python, &folder.join("build"))?;
    ensure!(
        install(&builder, &BUILDERS)?,
        "pip cannot install {}, which build the wheel",
        BUILDERS.join(" and ")
    );
    let wheel = build(&root, &builder, &folder, features)?;
    tried(&root, &python, &folder, &wheel)
}

/// Runs the Python tests alone.
pub(crate) fn test() -> Result<()> {
    let Some(python) = testers()? else { return Ok(()) };
    cargo(&LIBRARY, &[])?;
    call(&mut tests(&python)?)
}

/// A Python with the packages that the tests use; where Python or its packages are missing it says that tests are skipped.
pub(crate) fn testers() -> Result<Option<PathBuf>> {
    let (_, folder, Some(python)) = place()? else {
        eprintln!("Python tests: skipped, for there is no python3 with venv here");
        return Ok(None);
    };
    let own = environment(&python, &folder.join("tests"))?;
    if !install(&own, &TESTERS)? {
        let named = TESTERS.join(", ");
        eprintln!("Python tests: skipped, for one of {named} cannot be installed here");
        return Ok(None);
    }
    if !install(&own, &SAMPLERS)? {
        let named = SAMPLERS.join(", ");
        eprintln!("test of samplers: skipped, for {named} cannot be installed here");
    }
    Ok(Some(own))
}

/// Runs the Python tests beside other work, on a library and a program in the profile of `cargo test`, of which little is left to compile after it.
pub(crate) fn test_aside(python: &Path, variables: &[(&str, &str)]) -> Result<()> {
    cargo_aside(&LIBRARY, variables)?;
    let [said, _] = output(&mut tests(python)?, "pytest")?;
    eprint!("{said}");
    Ok(())
}

/// The tests of the package around the compiled library.
fn tests(python: &Path) -> Result<Command> {
    let (root, folder, _) = place()?;
    let built = folder.parent().context("no target folder")?.join("debug");
    let package = root.join("crates/sinew-python");
    let whole = folder.join("package");
    let _ = std::fs::remove_dir_all(&whole);
    std::fs::create_dir_all(whole.join("pysinew"))?;
    for file in std::fs::read_dir(package.join("python/pysinew"))? {
        let file = file?;
        if file.file_type()?.is_file() {
            std::fs::copy(file.path(), whole.join("pysinew").join(file.file_name()))?;
        }
    }
    let [prefix, suffix] = [std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX];
    let ending = if cfg!(windows) { "pyd" } else { "abi3.so" };
    std::fs::copy(
        built.join(format!("{prefix}sinew_python{suffix}")),
        whole.join("pysinew").join(format!("_native.{ending}")),
    )?;
    let program = whole.join(format!("sinew{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(built.join(program.file_name().context("a name")?), &program)?;
    let mut pytest = Command::new(python);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations", "5"]);
    pytest.arg(package.join("tests")).env("PYTHONPATH", &whole).env("PYTHONDONTWRITEBYTECODE", "1");
    pytest.env("SINEW_PROGRAM", program);
    Ok(pytest)
}

/// The workspace, the folder for what is made, and a Python if there is one; `PYTHON` names another than `python3`.
fn place() -> Result<(PathBuf, PathBuf, Option<PathBuf>)> {
    let metadata = MetadataCommand::new().no_deps().exec()?;
    let folder = metadata.target_directory.into_std_path_buf().join("wheel");
    std::fs::create_dir_all(&folder)?;
    // A Python 3 that makes virtual environments.
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut call = Command::new(&python);
    call.args(["-c", "import venv, ensurepip"]).stdout(Stdio::null()).stderr(Stdio::null());
    let python = call.status().is_ok_and(|status| status.success()).then(|| python.into());
    Ok((metadata.workspace_root.into_std_path_buf(), folder, python))
}

/// The interpreter of a virtual environment in a folder, made if it does not exist.
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
    let name = format!("{command:?}");
    eprintln!("$ {name}");
    command::call(command, &name)
}

/// Builds the wheel; where its processor or system is another, for this machine only.
fn build(root: &Path, python: &Path, folder: &Path, features: Option<&str>) -> Result<PathBuf> {
    let out = folder.join("dist");
    let _ = std::fs::remove_dir_all(&out);
    let mut maturin = Command::new(python);
    // Zig is found by way of the first python3 there.
    let path = std::env::var_os("PATH").unwrap_or_default();
    let first = python.parent().map(Path::to_path_buf).into_iter();
    maturin.env("PATH", std::env::join_paths(first.chain(std::env::split_paths(&path)))?);
    maturin.args(["-m", "maturin", "build", "--release", "--locked", "--manifest-path"]);
    maturin.arg(root.join("crates/sinew-python/Cargo.toml")).arg("--out").arg(&out);
    maturin.args(features.into_iter().flat_map(|features| ["--features", features]));
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
    ensure!(bytes <= MOST_BYTES, "the wheel has more than {} MB", MOST_BYTES >> 20);
    Ok(wheel.clone())
}

/// Runs the README's program in a clean environment.
fn tried(root: &Path, python: &Path, folder: &Path, wheel: &Path) -> Result<()> {
    let clean = folder.join("clean");
    let _ = std::fs::remove_dir_all(&clean);
    let own = environment(python, &clean)?;
    let start = Instant::now();
    ensure!(install(&own, &[wheel])?, "{} cannot be installed", wheel.display());
    let package = root.join("crates/sinew-python");
    let readme = std::fs::read_to_string(package.join("README.md"))?;
    let program = readme.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    let file = folder.join("readme.py");
    std::fs::write(&file, program.context("the README has no program")?)?;
    call(Command::new(&own).arg(&file))?;
    let seconds = start.elapsed().as_secs_f64();
    println!("from a clean environment to an emulator with its error: {seconds:.0} s");
    ensure!(seconds <= MOST_SECONDS, "more than {MOST_SECONDS} s");
    Ok(())
}

//! Starting cargo and the study programs.

use anyhow::{Context, Result, ensure};
use cargo_metadata::MetadataCommand;
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// Runs a command, which its errors call by a name.
pub(crate) fn call(command: &mut Command, name: &str) -> Result<()> {
    let status = command.status().with_context(|| format!("{name} could not be started"))?;
    ensure!(status.success(), "{name} failed with {status}");
    Ok(())
}

/// Runs a command; its standard output and error, which are shown if it fails.
pub(crate) fn output(command: &mut Command, name: &str) -> Result<[String; 2]> {
    let output = command.output().with_context(|| format!("{name} could not be started"))?;
    let said =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    ensure!(output.status.success(), "{name} failed with {}\n{}", output.status, said.concat());
    Ok(said)
}

/// Runs cargo with `arguments`, showing what is run.
pub(crate) fn cargo(arguments: &[&str], environment: &[(&str, &str)]) -> Result<()> {
    let name = format!("cargo {}", arguments.join(" "));
    eprintln!("$ {name}");
    let mut command = Command::new(env!("CARGO"));
    call(command.args(arguments).envs(environment.iter().copied()), &format!("`{name}`"))
}

/// Runs cargo beside other work; what it says is shown at its end, and only if it fails.
pub(crate) fn cargo_aside(arguments: &[&str], environment: &[(&str, &str)]) -> Result<()> {
    let name = format!("`cargo {}`", arguments.join(" "));
    let mut command = Command::new(env!("CARGO"));
    output(command.args(arguments).envs(environment.iter().copied()), &name).map(drop)
}

/// Builds the program of all studies and runs one.
///
/// Naming a test beside the program makes cargo resolve features as it does for the tests of the whole
/// workspace, so that the heavy dependencies are compiled once for both; this one is the smallest.
pub(crate) fn study(task: &str, options: &[String]) -> Result<()> {
    let mut build = vec!["build", "--workspace", "--bin", PROGRAM, "--test", "report"];
    // A backend is compiled in by its feature, so that the default build stays small.
    let features = backend(options).map(|backend| format!("{PROGRAM}/{backend}"));
    if let Some(features) = &features {
        build.extend(["--features", features]);
    }
    eprintln!(
        "Building {PROGRAM}: about seven minutes on two cores the first time, seconds from then on."
    );
    let clock = Instant::now();
    cargo(&build, &[])?;
    eprintln!("Built {PROGRAM} in {:.0} s.\n", clock.elapsed().as_secs_f64());
    let folder = MetadataCommand::new().no_deps().exec()?.target_directory;
    let program = folder.join("debug").join(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX));
    let what = format!("{program} {task}");
    call(Command::new(&program).arg(task).args(options), &what)
}

/// Crate and program of all studies.
const PROGRAM: &str = "sinew-studies";

/// The backend among the options of a study that has a feature of its name.
fn backend(options: &[String]) -> Option<&str> {
    let mut words = options.iter().flat_map(|option| option.split('='));
    words.find(|word| *word == "--backend")?;
    words.next().filter(|backend| *backend != "flex")
}

/// Runs the example `coverage` of `sinew-gp`, which needs none of the heavy dependencies.
pub(crate) fn coverage(options: &[String]) -> Result<()> {
    let build = ["run", "--package", "sinew-gp", "--example", "coverage", "--"];
    let options = options.iter().map(String::as_str);
    cargo(&build.into_iter().chain(options).collect::<Vec<_>>(), &[])
}

/// Benchmarks of every crate, one after the other.
pub(crate) fn benches(options: &[String]) -> Result<()> {
    let mut arguments = vec!["bench", "--workspace", "--benches", "--profile", "dev", "--"];
    arguments.extend(options.iter().map(String::as_str));
    cargo(&arguments, &[])
}

/// A campaign on a Slurm, which is started for it; not run where Slurm is missing.
pub(crate) fn campaigns(environment: &[(&str, &str)]) -> Result<()> {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    // Daemons are where a user's PATH may not look.
    let known = ["/usr/sbin", "/usr/local/sbin"].map(PathBuf::from);
    let folders: Vec<_> = std::env::split_paths(&folders).chain(known).collect();
    let is_missing = |program: &&str| !folders.iter().any(|at| at.join(program).is_file());
    if let Some(program) = ["munged", "slurmctld", "slurmd"].into_iter().find(is_missing) {
        eprintln!(
            "test of campaigns: not run, for there is no {program} here (Debian: slurmctld slurmd slurm-client munge)"
        );
        return Ok(());
    }
    let test =
        ["test", "--workspace", "--test", "sinew", "slurm", "--", "--ignored", "--nocapture"];
    cargo(&test, environment)
}

//! Starting cargo and the study programs.

use anyhow::{Context, Result, bail};
use std::process::Command;

/// Runs cargo with `arguments`, showing what is run.
pub fn cargo(arguments: &[&str], environment: &[(&str, &str)]) -> Result<()> {
    eprintln!("$ cargo {}", arguments.join(" "));
    let status = Command::new(env!("CARGO"))
        .args(arguments)
        .envs(environment.iter().copied())
        .status()
        .context("cargo could not be started")?;
    if !status.success() {
        bail!("`cargo {}` failed with {status}", arguments.join(" "));
    }
    Ok(())
}

/// Builds and runs a study of `sinew-study`, in the profile that tests use too.
pub fn study(name: &str, options: &[String]) -> Result<()> {
    let mut arguments = vec!["run", "--quiet", "--package", "sinew-study", "--bin", "sinew-study"];
    // A backend is compiled in by its feature, so that the default build stays small.
    let ndarray = options.windows(2).any(|pair| pair == ["--backend", "ndarray"])
        || options.iter().any(|option| option == "--backend=ndarray");
    if ndarray {
        arguments.extend(["--features", "ndarray"]);
    }
    arguments.extend(["--", name]);
    arguments.extend(options.iter().map(String::as_str));
    cargo(&arguments, &[])
}

/// Benchmarks of every crate, one after the other.
pub fn benches(options: &[String]) -> Result<()> {
    let mut arguments = vec!["bench", "--workspace", "--benches", "--profile", "dev", "--"];
    arguments.extend(options.iter().map(String::as_str));
    cargo(&arguments, &[])
}

//! The matrix product of `sinew-gnn`, our one module of pointers, interpreted by Miri, which finds reads and writes
//! outside of what they may touch.

use anyhow::{Context, Result, ensure};
use std::process::Command;

const TESTS: &[&str] =
    &["test", "--package", "sinew-gnn", "--test", "gnn", "--", "fused::products::"];
/// Vector instructions of the interpreted processor; Miri knows no AVX-512.
const PROCESSORS: &[(&str, &str)] =
    &[("without vector instructions", ""), ("AVX2", "-C target-feature=+avx2,+fma")];

/// Runs the tests on each processor.
pub(crate) fn run() -> Result<()> {
    ensure!(
        miri(&["--version"], "")?,
        "Miri is not installed; `rustup toolchain install nightly --component miri,rust-src` installs it"
    );
    for (processor, flags) in PROCESSORS {
        eprintln!("-- {processor}");
        ensure!(miri(TESTS, flags)?, "a test failed under Miri, {processor}");
    }
    Ok(())
}

/// Whether `cargo miri` of the nightly toolchain succeeds.
fn miri(arguments: &[&str], flags: &str) -> Result<bool> {
    let status = Command::new("rustup")
        .args(["run", "nightly", "cargo", "miri"])
        .args(arguments)
        .env("RUSTFLAGS", flags)
        // The toolchain that runs this task must not reach the other one.
        .env_remove("RUSTC")
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("CARGO")
        .status()
        .context("rustup could not be started")?;
    Ok(status.success())
}

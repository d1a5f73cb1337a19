//! What continuous integration runs, cheapest first.

use crate::{arrows, command::cargo};
use anyhow::Result;
use std::time::Instant;

/// Format, dependency arrows, lints, documentation, tests.
pub(crate) fn run() -> Result<()> {
    let start = Instant::now();
    let done =
        |step: &str| eprintln!("-- {step}: done after {:.0} s\n", start.elapsed().as_secs_f64());
    cargo(&["fmt", "--all", "--", "--check"], &[])?;
    done("format");
    arrows::check()?;
    done("dependency arrows");
    cargo(&["test", "--workspace"], &[])?;
    done("tests");
    cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"], &[])?;
    done("lints");
    cargo(&["doc", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    done("documentation");
    Ok(())
}

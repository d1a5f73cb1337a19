//! Continuous integration, cheapest steps first.

use crate::command::{self, cargo};
use crate::{arrows, circles, licences, readme, wheel, words};
use anyhow::Result;
use std::time::Instant;

/// Format, dependency arrows, circles of imports, words, READMEs, licences, tests, campaigns, tests of the Python package, lints, a build without
/// networks and documentation. The wheel, which is a release build of its own, is made by `cargo xtask wheel`.
pub(crate) fn run() -> Result<()> {
    let start = Instant::now();
    let done =
        |step: &str| eprintln!("-- {step}: done after {:.0} s\n", start.elapsed().as_secs_f64());
    cargo(&["fmt", "--all", "--", "--check"], &[])?;
    done("format");
    arrows::check()?;
    done("dependency arrows");
    circles::check()?;
    done("circles of imports");
    words::check()?;
    done("words");
    readme::check()?;
    licences::check()?;
    done("READMEs and licences");
    cargo(&["test", "--workspace"], &[])?;
    done("tests");
    command::campaigns()?;
    done("campaigns");
    wheel::test()?;
    done("Python");
    cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"], &[])?;
    done("lints");
    // The configuration of the Python wheel too.
    cargo(&["check", "-p", "sinew", "-p", "sinew-python", "--no-default-features"], &[])?;
    done("without networks");
    cargo(&["doc", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    done("documentation");
    Ok(())
}

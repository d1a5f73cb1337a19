//! Versions, seeds and settings of a result.

use sinew_report::Provenance;

/// Packages that numbers depend on.
const NUMERIC: &[&str] = &[
    "sinew-studies",
    "sinew-gp",
    "burn",
    "burn-flex",
    "faer",
    "kiddo",
    "linfa-clustering",
    "nalgebra",
    "rand_chacha",
];

/// Manifest of the running program, with the versions in the lock file it was built with.
pub fn of_this_run(seed: u64, config: &impl serde::Serialize) -> anyhow::Result<Provenance> {
    let mut provenance = Provenance::of_this_run("cargo xtask", env!("CARGO_MANIFEST_DIR"));
    let mut name = "";
    for line in include_str!("../../../Cargo.lock").lines() {
        let quoted = |key: &str| line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"');
        if let Some(found) = quoted("name") {
            name = found;
        } else if let Some(version) = quoted("version").filter(|_| NUMERIC.contains(&name)) {
            provenance.versions.insert(name.into(), version.into());
        }
    }
    Ok(Provenance {
        seed: Some(seed),
        threads: rayon::current_num_threads(),
        config: toml::to_string_pretty(config)?,
        ..provenance
    })
}

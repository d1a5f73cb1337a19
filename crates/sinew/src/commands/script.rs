//! Campaigns on a Slurm: the script that submits all shards, and the merge after them.

use std::ffi::OsStr;
use std::path::Path;

/// The script for jobs of a name: `sample` is the command line of a shard without its number, `merge` that of the merge, and logs go
/// into the folder of the samples.
pub(crate) fn slurm(
    name: &str,
    shards: usize,
    [sample, merge]: [String; 2],
    folder: &Path,
) -> String {
    let [logs, log] = ["slurm-%A_%a.log", "slurm-%j.log"].map(|name| quoted(folder.join(name)));
    let parts = [
        ("shards", shards.to_string()),
        ("name", quoted(name)),
        ("here", quoted(std::env::current_dir().unwrap_or_default())),
        ("sample", sample),
        ("merge", merge),
        ("logs", logs),
        ("log", log),
    ];
    let mut text = include_str!("script/slurm.sh").to_string();
    for (name, part) in parts {
        text = text.replace(&format!("«{name}»"), &part);
    }
    text
}

/// A word for a shell, quoted where it needs to be.
pub(crate) fn quoted(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref().to_string_lossy();
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.into_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

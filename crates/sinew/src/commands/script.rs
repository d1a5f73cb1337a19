//! Campaigns for a scheduler: the script that submits all shards, and the merge after them.

use clap::ValueEnum;
use std::ffi::OsStr;
use std::path::Path;

/// Scheduler of a job array and of a merge that waits for it.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Scheduler {
    /// sh OUT/sample/slurm.sh
    Slurm,
    /// sh OUT/sample/lsf.sh
    Lsf,
}

impl Scheduler {
    /// Name and text of the script: `sample` is the command line of a shard without its number, `merge` that of the merge, and logs go
    /// into the folder of the samples.
    pub(crate) fn script(
        self,
        name: &str,
        shards: usize,
        [sample, merge]: [String; 2],
        folder: &Path,
    ) -> (&'static str, String) {
        let (file, template) = match self {
            Self::Slurm => ("slurm.sh", include_str!("script/slurm.sh")),
            Self::Lsf => ("lsf.sh", include_str!("script/lsf.sh")),
        };
        let parts = [
            ("shards", shards.to_string()),
            ("name", quoted(name)),
            ("here", quoted(std::env::current_dir().unwrap_or_default())),
            ("sample", sample),
            ("merge", merge),
            ("folder", quoted(folder)),
        ];
        let mut text = template.to_string();
        for (name, part) in parts {
            text = text.replace(&format!("«{name}»"), &part);
        }
        (file, text)
    }
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

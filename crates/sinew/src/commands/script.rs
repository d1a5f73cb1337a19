//! Campaigns for a scheduler: the file that submits all shards, and the merge after them.

use clap::ValueEnum;
use std::ffi::OsStr;
use std::path::Path;

/// Program that a campaign is written for.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Scheduler {
    /// A job array and a merge that waits for it: sh OUT/sample/slurm.sh
    Slurm,
    /// A job array of LSF and its merge: sh OUT/sample/lsf.sh
    Lsf,
    /// A workflow with a job for every shard: snakemake --snakefile OUT/sample/Snakefile
    Snakemake,
}

/// Command lines of a campaign.
pub(crate) struct Script<'a> {
    /// Name of the jobs.
    pub name: &'a str,
    /// `sinew sample …` without its shard.
    pub sample: &'a str,
    /// `sinew merge …`.
    pub merge: &'a str,
    /// Folder of the samples.
    pub folder: &'a Path,
    pub shards: usize,
}

impl Script<'_> {
    /// Name of the file, what it holds, and the command that starts it.
    pub(crate) fn written(&self, scheduler: Scheduler) -> (&'static str, String, &'static str) {
        match scheduler {
            Scheduler::Slurm => {
                let logs = ["slurm-%A_%a.log", "slurm-%j.log"];
                ("slurm.sh", self.shell(include_str!("script/slurm.sh"), logs), "sh")
            }
            Scheduler::Lsf => {
                let logs = ["lsf-%J-%I.log", "lsf-%J.log"];
                ("lsf.sh", self.shell(include_str!("script/lsf.sh"), logs), "sh")
            }
            Scheduler::Snakemake => {
                ("Snakefile", self.snakemake(), "snakemake --cores all --snakefile")
            }
        }
    }

    /// A script for a shell, with the names of the logs of shards and merge.
    fn shell(&self, template: &str, logs: [&str; 2]) -> String {
        let [logs, log] = logs.map(|name| quoted(self.folder.join(name)));
        let parts = [
            ("name", quoted(self.name)),
            ("array", quoted(format!("{}[1-{}]", self.name, self.shards))),
            ("here", quoted(here())),
            ("sample", self.sample.into()),
            ("merge", self.merge.into()),
            ("logs", logs),
            ("log", log),
        ];
        self.filled(template, &parts)
    }

    fn snakemake(&self) -> String {
        let line = |line: &str| python(&line.replace('{', "{{").replace('}', "}}"));
        let file = |name: &str| python(&self.folder.join(name).to_string_lossy());
        let parts = [
            ("here", python(&here())),
            ("sample", line(self.sample)),
            ("merge", line(self.merge)),
            ("table", file("cases.csv")),
            ("seal", file(&format!("shards/{{index}}-of-{:05}/done.json", self.shards))),
        ];
        self.filled(include_str!("script/Snakefile"), &parts)
    }

    /// A template with its parts in the places of their names in guillemets.
    fn filled(&self, template: &str, parts: &[(&str, String)]) -> String {
        let template = template.replace("«shards»", &self.shards.to_string());
        parts.iter().fold(template, |text, (name, part)| text.replace(&format!("«{name}»"), part))
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

/// The folder that paths are relative to.
fn here() -> String {
    std::env::current_dir().unwrap_or_default().to_string_lossy().into_owned()
}

/// A literal of Python.
fn python(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

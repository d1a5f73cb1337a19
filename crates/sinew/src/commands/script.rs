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
            Scheduler::Slurm => ("slurm.sh", self.slurm(), "sh"),
            Scheduler::Lsf => ("lsf.sh", self.lsf(), "sh"),
            Scheduler::Snakemake => {
                ("Snakefile", self.snakemake(), "snakemake --cores all --snakefile")
            }
        }
    }

    /// A file in the folder, as a word for a shell.
    fn file(&self, name: &str) -> String {
        quoted(self.folder.join(name))
    }

    fn slurm(&self) -> String {
        let Self { name, sample, merge, shards, .. } = self;
        let [logs, log] = ["slurm-%A_%a.log", "slurm-%j.log"].map(|name| self.file(name));
        let (here, name) = (quoted(here()), quoted(name));
        format!(
            r#"#!/bin/sh
# Submits {shards} shards of a campaign as a job array, and their merge. Options of sbatch may follow, for both:
#   sh slurm.sh --time=04:00:00 --cpus-per-task=4
cd {here} || exit
array=$(sbatch --parsable --job-name={name} --array=1-{shards} --output={logs} --open-mode=append \
  --requeue --signal=TERM@60 "$@" <<'SHARD'
#!/bin/bash
export RAYON_NUM_THREADS=${{SLURM_CPUS_PER_TASK:-1}}
srun {sample} --shard auto:1-{shards}
code=$?
# Stopped a minute before its time was up, with everything stored: the same task again.
if [ $code -eq 3 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit $code
SHARD
) || exit
echo "Submitted array job $array"
sbatch --job-name={name} --output={log} --dependency="afterok:$array" --kill-on-invalid-dep=yes "$@" <<'MERGE'
#!/bin/bash
{merge}
MERGE
"#
        )
    }

    fn lsf(&self) -> String {
        let Self { name, sample, merge, shards, .. } = self;
        let [logs, log] = ["lsf-%J-%I.log", "lsf-%J.log"].map(|name| self.file(name));
        let (array, name) = (quoted(format!("{name}[1-{shards}]")), quoted(name));
        let here = quoted(here());
        format!(
            r#"#!/bin/sh
# Submits {shards} shards of a campaign as a job array, and their merge. Options of bsub may follow, for both:
#   sh lsf.sh -W 240 -n 4
cd {here} || exit
# A task that is stopped a minute before its time is up, with everything stored, ends with 3 and begins again.
told=$(bsub -J {array} -o {logs} -Q 3 -wa TERM -wt 1 "$@" <<'SHARD'
#!/bin/bash
export RAYON_NUM_THREADS=${{LSB_DJOB_NUMPROC:-1}}
exec {sample} --shard auto:1-{shards}
SHARD
) || exit
array=$(echo "$told" | sed -n 's/^Job <\([0-9]*\)>.*/\1/p')
echo "Submitted array job $array"
bsub -J {name} -o {log} -w "done($array)" "$@" <<'MERGE'
#!/bin/bash
{merge}
MERGE
"#
        )
    }

    fn snakemake(&self) -> String {
        let Self { sample, merge, folder, shards, .. } = self;
        let [sample, merge] =
            [sample, merge].map(|line| python(&line.replace('{', "{{").replace('}', "}}")));
        let [table, seal] = ["cases.csv", "shards/{index}-of-COUNT/done.json"].map(|name| {
            let name = name.replace("COUNT", &format!("{shards:05}"));
            python(&folder.join(name).to_string_lossy())
        });
        let here = python(&here());
        format!(
            r#"# {shards} shards of a campaign, and their merge: snakemake --cores all --snakefile Snakefile
workdir: {here}

SEALS = expand({seal}, index=[f"{{index:05}}" for index in range(1, {shards} + 1)])

wildcard_constraints:
    index=r"\d+"

rule merge:
    input: SEALS
    output: {table}
    shell: {merge}

rule shard:
    output: {seal}
    threads: 4
    retries: 3
    shell: "RAYON_NUM_THREADS={{threads}} " + {sample} + " --shard {{wildcards.index}}/{shards}"
"#
        )
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

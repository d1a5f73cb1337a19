//! Parameters drawn from their ranges.

use super::script::{Scheduler, quoted};
use super::stop::stoppable;
use super::{CaseArguments, count, refuse, refuse_if, solved, tell_found};
use anyhow::{Result, ensure};
use clap::Args;
use serde::{Deserialize, Serialize};
use sinew::output::{Results, csv_line};
use sinew::{Body, Design, heads};
use sinew_emulate::{Shard, ShardState, merge, simulate_shard, store};
use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Duration;

/// Number and design of the parameter sets.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/sample.txt"))]
pub(crate) struct Sample {
    #[command(flatten)]
    case: CaseArguments,
    /// Number of parameter sets
    #[arg(long, default_value_t = 100, value_parser = count)]
    count: usize,
    /// Design: Latin hypercube (one sample in each of COUNT slices of every range), Sobol sequence, or independent
    /// uniform samples
    #[arg(long, value_parser = ["latin-hypercube", "sobol", "uniform"], default_value = "latin-hypercube")]
    design: String,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Solve each parameter set
    #[arg(long)]
    solve: bool,
    /// Solve one shard only, such as 3/16, or $SLURM_ARRAY_TASK_ID/16 in a task of a job array
    #[arg(long, value_name = "INDEX/COUNT", requires = "solve")]
    shard: Option<Shard>,
    /// Write the script of a campaign for a scheduler: all shards as a job array, and a merge that waits for it
    #[arg(long, value_name = "SCHEDULER", conflicts_with_all = ["solve", "shard"])]
    script: Option<Scheduler>,
    /// Shards of the campaign that --script writes
    #[arg(long, value_name = "COUNT", default_value = "16", requires = "script")]
    shards: NonZeroUsize,
}

/// Design, seed and counts of the samples, stored for the merging of the shards.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Campaign {
    count: usize,
    design: Design,
    seed: u64,
    shards: usize,
}

const CAMPAIGN: &str = "campaign.json";
const THETAS: &str = "thetas.csv";
/// Files and folders that solves of samples leave.
const SOLVED: [&str; 4] = ["cases.csv", "simulations.json", "under-way", "shards"];

impl Sample {
    pub(crate) fn run(&self) -> Result<()> {
        let (_, body, folder) = &self.case.open_lowered()?;
        let (shards, count) = (self.campaign_shards(), self.count);
        refuse_if(shards.is_some() && !body.has_potential(), || {
            "a body without a potential (mixed elements, or a pressure whose rim moves freely) is solved by one process; leave \
                 --shard and --script out"
        })?;
        let folder = folder.join("sample");
        let shards = shards.unwrap_or_default();
        let reason = || format!("{shards} shards of {count} samples: give at most {count} shards");
        refuse_if(shards > count, reason)?;
        let design: Design = serde_json::from_value(self.design.as_str().into())?;
        let thetas = design.sample(&body.parameters, self.count, self.seed)?;
        let (path, text) = (folder.join(THETAS), table(body, &thetas));
        self.check_campaign(design, &text, &folder)?;
        store::write_bytes(&path, text.as_bytes())?;
        if let Some(shard) = self.shard {
            let found = simulate_shard(body, &thetas, shard, &folder, &mut stoppable()?)?;
            tell_found(body, &found);
            let (solved, of) = (found.fields.len(), shard.samples(self.count).len());
            println!("shard {shard}: {solved} of {of} samples solved");
            return Ok(());
        }
        if let Some(scheduler) = self.script {
            return self.write_script(scheduler, body, &folder);
        }
        if self.solve {
            // Those of a body with a potential are stored on the way, so that a killed run goes on.
            let kept = body.has_potential().then_some(folder.as_path());
            let found = solved(body, &thetas, "solve", kept)?;
            let (failed, tried) = (found.failures.len(), thetas.len());
            Results::of(body, &thetas, &found).write(&folder, 0, true)?;
            ensure!(
                failed == 0,
                "{failed} of {tried} samples have no equilibrium; the column `failure` of cases.csv says why"
            );
        }
        println!("written: {}", path.display());
        Ok(())
    }

    /// Number of shards of the campaign; none where one process solves all.
    fn campaign_shards(&self) -> Option<usize> {
        self.shard.map(Shard::of).or(self.script.map(|_| self.shards.get()))
    }

    fn write_script(&self, scheduler: Scheduler, body: &Body, folder: &Path) -> Result<()> {
        let Self { count, seed, design, .. } = self;
        let (case, merge) = (self.case.words(), format!("sinew merge {}", self.case.words()));
        let sample =
            format!("sinew sample {case} --count {count} --seed {seed} --design {design} --solve");
        let shards = self.shards.get();
        let (name, text) = scheduler.script(&body.name, shards, [sample, merge], folder);
        let path = folder.join(name);
        store::write_bytes(&path, text.as_bytes())?;
        println!("written: {}", path.display());
        println!("start {shards} shards of {count} samples: sh {}", quoted(&path));
        Ok(())
    }

    /// Refuses to mix with another campaign or with solved samples in the folder, and notes this campaign.
    fn check_campaign(&self, design: Design, table: &str, folder: &Path) -> Result<()> {
        let file = folder.join(CAMPAIGN);
        let (count, seed) = (self.count, self.seed);
        let shards = self.campaign_shards();
        let own = shards.map(|shards| Campaign { count, design, seed, shards });
        match (store::read_json::<Campaign>(&file)?, own) {
            (Some(stored), own) if own.as_ref() != Some(&stored) => {
                let Campaign { count, shards, seed, .. } = stored;
                let design = serde_json::to_value(stored.design)?;
                refuse(format!(
                    "{} holds another campaign ({count} samples in {shards} shards, design {}, seed {seed}); repeat its \
                     options, or choose another --out",
                    folder.display(),
                    design.as_str().unwrap_or_default()
                ))
            }
            (None, Some(own)) => {
                self.check_solved(table, folder)?;
                Ok(store::write_json(&file, &own)?)
            }
            _ => self.check_solved(table, folder),
        }
    }

    /// Refuses a table of samples beside solutions of others. One process that solves may go on from the first of its samples.
    fn check_solved(&self, table: &str, folder: &Path) -> Result<()> {
        if !SOLVED.iter().any(|name| folder.join(name).exists()) {
            return Ok(());
        }
        let earlier = std::fs::read_to_string(folder.join(THETAS)).unwrap_or_default();
        let goes_on = self.solve && self.shard.is_none() && table.starts_with(&earlier);
        refuse_if(!goes_on && table != earlier, || {
            format!(
                "{} holds solutions of other parameter sets; choose another --out, or remove this folder",
                folder.display()
            )
        })
    }
}

/// Case and output.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/merge.txt"))]
pub(crate) struct Merge {
    #[command(flatten)]
    case: CaseArguments,
    /// Only tell which shards are done, begun or missing
    #[arg(long)]
    status: bool,
}

/// Time after which a shard that has stored nothing may have ended.
const SILENT: Duration = Duration::from_secs(120);

impl Merge {
    pub(crate) fn run(&self) -> Result<()> {
        let (_, body, folder) = self.case.open()?;
        let folder = folder.join("sample");
        let Some(campaign) = store::read_json::<Campaign>(&folder.join(CAMPAIGN))? else {
            return refuse(format!(
                "there is no campaign in {}; begin one: sinew sample CASE --solve --shard 1/16",
                folder.display()
            ));
        };
        if self.status {
            return tell_status(&campaign, &folder);
        }
        let Campaign { count, design, seed, shards } = campaign;
        let thetas = design.sample(&body.parameters, count, seed)?;
        let found = merge(&body, &thetas, shards, &folder)?;
        let failed: Vec<_> = found.failures.iter().map(|failure| failure.theta.clone()).collect();
        tell_found(&body, &found);
        if !failed.is_empty() {
            store::write_bytes(&folder.join("failures.csv"), table(&body, &failed).as_bytes())?;
        }
        Results::of(&body, &thetas, &found).write(&folder, 0, true)?;
        let solved = found.fields.len();
        println!("{solved} of {count} samples solved, {} without equilibrium", failed.len());
        println!("written: {}", folder.display());
        Ok(())
    }
}

/// Prints how many shards are done, and a line for each of the others.
fn tell_status(&Campaign { count, shards, .. }: &Campaign, folder: &Path) -> Result<()> {
    let (mut done, mut without, mut lines) = (0, 0, Vec::new());
    for shard in (1..=shards).filter_map(|index| Shard::new(index, shards)) {
        let told = match shard.state(folder)? {
            ShardState::Done { failed } => {
                (done, without) = (done + 1, without + failed);
                continue;
            }
            ShardState::Begun { tried, failed, since } => {
                let of = shard.samples(count).len();
                let silent = if since > SILENT { ": ended, or in a long solve" } else { "" };
                format!(
                    "{tried} of {of} samples tried, {failed} without equilibrium, stored {} s ago{silent}",
                    since.as_secs()
                )
            }
            ShardState::Damaged(name) => {
                format!("{name} changed since it was solved; solve it again")
            }
            ShardState::Missing => "nothing stored yet".into(),
        };
        lines.push(format!("{shard}: {told}"));
    }
    println!("{done} of {shards} shards done, {without} samples without equilibrium in them");
    lines.iter().for_each(|line| println!("{line}"));
    Ok(())
}

/// A row per θ, in the parameters' own units.
fn table(body: &Body, thetas: &[Vec<f64>]) -> String {
    let row = |theta: &Vec<f64>| {
        let pairs = body.parameters.iter().zip(theta);
        csv_line(&pairs.map(|(p, &x)| p.unit.shown(x)).collect::<Vec<_>>())
    };
    csv_line(&heads(&body.parameters)) + &thetas.iter().map(row).collect::<String>()
}

//! Simulations that outgrow one machine: solved in shards, by the tasks of a job array, merged into one set.

use crate::error::{at, ensure, require_usable};
use crate::recipe::progress::Observer;
use crate::sample::block::UNDER_WAY;
use crate::sample::simulate::{LOG, STORED, Simulations, simulate, store, stored};
use crate::store::{checksums, identity, read_json, write_json};
use crate::{Body, Error, Result};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// Part of a set of samples that are solved apart, on as many machines as there are.
///
/// Printed and read as `3/16`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    index: usize,
    of: usize,
}

/// State of a shard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShardState {
    /// Solved and sealed, with the number of samples without equilibrium.
    Done {
        /// Samples without equilibrium.
        failed: usize,
    },
    /// Begun, with the samples that are stored.
    Begun {
        /// Samples that are solved or have no equilibrium.
        tried: usize,
        /// Samples without equilibrium.
        failed: usize,
        /// Time since something was stored, which a running process does every ten seconds or after the solve under way.
        since: Duration,
    },
    /// A file, by its name, changed since the shard was sealed.
    Damaged(String),
    /// No file is stored.
    Missing,
}

impl Shard {
    /// Shard `index`, from 1, of `of`; `None` where there is no such one.
    pub fn new(index: usize, of: usize) -> Option<Self> {
        (1..=of).contains(&index).then_some(Self { index, of })
    }

    /// Number of shards.
    pub fn of(self) -> usize {
        self.of
    }

    /// The samples that belong to it, of `count`.
    pub fn samples(self, count: usize) -> Range<usize> {
        (self.index - 1) * count / self.of..self.index * count / self.of
    }

    fn folder(self, folder: &Path) -> PathBuf {
        folder.join(format!("shards/{:05}-of-{:05}", self.index, self.of))
    }

    /// State in the folder of a campaign.
    ///
    /// # Errors
    /// Files that cannot be read.
    pub fn state(self, folder: &Path) -> Result<ShardState> {
        let own = self.folder(folder);
        let (mut tried, mut failed, mut last) = (0, 0, None);
        for file in [own.join(LOG), own.join(UNDER_WAY).join(LOG)] {
            if let Some(log) = read_json::<Counts>(&file)? {
                tried += log.tried;
                failed += log.failures.len();
                last = last.max(file.metadata().and_then(|file| file.modified()).ok());
            }
        }
        let sealed = read_json::<Seal>(&own.join(SEAL))?.map(|seal| damaged(&seal, &own));
        Ok(match (sealed, last) {
            (Some(Some(name)), _) => ShardState::Damaged(name),
            (Some(None), _) => ShardState::Done { failed },
            (None, Some(last)) => {
                ShardState::Begun { tried, failed, since: last.elapsed().unwrap_or_default() }
            }
            (None, None) => ShardState::Missing,
        })
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// ```
    /// use sinew_emulate::Shard;
    /// let shard: Shard = "3/16".parse()?;
    /// assert_eq!(shard.samples(100), 12..18);
    /// assert!("0/4".parse::<Shard>().is_err() && "5/4".parse::<Shard>().is_err());
    /// # Ok::<(), String>(())
    /// ```
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/');
        let shard = numbers.and_then(|(a, b)| Self::new(a.parse().ok()?, b.parse().ok()?));
        shard.ok_or_else(|| {
            format!("`{text}` is not a shard; write INDEX/COUNT counted from 1, such as 3/16")
        })
    }
}

/// Solves the samples of one shard in a folder of its own within `folder`; what a killed shard has solved is kept.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_shard(
    body: &Body,
    thetas: &[Vec<f64>],
    shard: Shard,
    folder: &Path,
    observer: &mut dyn Observer,
) -> Result<Simulations> {
    let own = shard.folder(folder);
    let thetas = &thetas[shard.samples(thetas.len())];
    if read_json::<Seal>(&own.join(SEAL))?.is_some_and(|seal| damaged(&seal, &own).is_some()) {
        // A shard whose files changed is solved again.
        std::fs::remove_dir_all(&own).map_err(at(&own))?;
    }
    let stage = format!("solve shard {shard}");
    let found = simulate(body, thetas, &stage, Some(&own), observer)?;
    let seal = Seal { shard, samples: thetas.len(), checksums: sums(&own)? };
    write_json(&own.join(SEAL), &seal)?;
    Ok(found)
}

/// Puts the shards of `folder` together, in the order of `thetas`. Merging again gives the same; afterwards [`simulate`] with this
/// folder has nothing left to solve.
///
/// # Errors
/// Shards that are missing, not done or damaged, all of them by number; samples of other parameters or of another body.
pub fn merge(body: &Body, thetas: &[Vec<f64>], of: usize, folder: &Path) -> Result<Simulations> {
    let (mut merged, identity) = (Simulations::default(), identity::of(body));
    let (mut missing, mut tried) = (Vec::new(), 0);
    for shard in (1..=of).filter_map(|index| Shard::new(index, of)) {
        let own = shard.folder(folder);
        let samples = &thetas[shard.samples(thetas.len())];
        let Some(seal) = read_json::<Seal>(&own.join(SEAL))? else {
            missing.push(shard.to_string());
            continue;
        };
        let same = seal.shard == shard && seal.samples == samples.len();
        ensure(same, Error::OtherSamples { folder: own.clone() })?;
        if let Some(name) = damaged(&seal, &own) {
            missing.push(format!("{shard} ({name} changed since it was solved)"));
            continue;
        }
        if !samples.is_empty() {
            let (tried, found) = stored(&own, &identity, samples)?;
            ensure(tried == samples.len(), Error::OtherSamples { folder: own })?;
            merged.extend(found);
        }
        tried += samples.len();
    }
    require_usable(missing.is_empty() && of > 0, || {
        let (folder, missing) = (folder.display(), missing.join(", "));
        format!("{folder} lacks the shards {missing}; solve them, then merge")
    })?;
    store(folder, &identity, tried, &merged)?;
    Ok(merged)
}

/// Written when a shard is done, with a checksum of every file of it.
#[derive(PartialEq, Serialize, Deserialize)]
struct Seal {
    shard: Shard,
    samples: usize,
    /// CRC-32 of each file, by name.
    checksums: Vec<(String, u32)>,
}

const SEAL: &str = "done.json";

/// Numbers of a log of simulations.
#[derive(Deserialize)]
struct Counts {
    tried: usize,
    failures: Vec<IgnoredAny>,
}

/// The first file that is not as it was sealed.
fn damaged(seal: &Seal, folder: &Path) -> Option<String> {
    let found = sums(folder).unwrap_or_default();
    let changed = seal.checksums.iter().find(|pair| !found.contains(pair));
    changed.map(|(name, _)| name.clone())
}

fn sums(folder: &Path) -> Result<Vec<(String, u32)>> {
    let files = STORED.into_iter().filter(|name| folder.join(name).exists());
    Ok(checksums(folder, files.map(String::from))?.into_iter().collect())
}

//! Finite-element solutions that emulators learn from and are judged by.

use crate::error::{ensure, require_usable};
use crate::parameters::in_words;
use crate::recipe::progress::{Counter, Observer};
use crate::sample::block::Block;
use crate::store::identity::{self, Identity};
use crate::store::{read_json, read_table, write_json, write_table};
use crate::{Body, Error, Result};
use serde::{Deserialize, Serialize};
use sinew_fem::{LoadSteps, Options, SolveError, resume_sweep};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Samples that are solved together. The partition is fixed, so a run that is resumed between two blocks gives the
/// numbers of an uninterrupted one; so does one within a block, but for chains of neighbours that took long (see `block.rs`).
const BLOCK: usize = 100;

/// Solutions of a block that are compared with that of a rising load, which costs two more solves each; of bodies with more than
/// 500 000 unknowns none is.
pub const MOST_COMPARED: usize = 5;
pub(crate) const LARGEST_COMPARED: usize = 500_000;

/// Parameters with their equilibria.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulations {
    /// Parameters, sample by sample.
    #[serde(skip)]
    pub thetas: Vec<Vec<f64>>,
    /// Displacements, sample by sample, node by node \[length\].
    #[serde(skip)]
    pub fields: Vec<Vec<f64>>,
    /// Fields of pressure of mixed elements, sample by sample \[stress\]; none for other bodies. Not stored.
    #[serde(skip)]
    pub pressures: Vec<Vec<f64>>,
    /// Samples that have no solution.
    pub failures: Vec<Failure>,
    /// Parameters at which a rising load leads to another stable equilibrium than the solution. At most [`MOST_COMPARED`]
    /// solutions of a hundred samples are compared, of bodies with more than 500 000 unknowns none: those whose search met an indefinite stiffness.
    pub branched: Vec<Vec<f64>>,
    /// Number of solutions that were compared. Not stored.
    #[serde(skip)]
    pub compared: usize,
    /// Parameters whose solution may be on another branch than that of a rising load: those of `branched`, and those that were not
    /// compared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub jumped: Vec<Vec<f64>>,
    /// Parameters whose solution is an unstable equilibrium, as of a straight column beyond its Euler load.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unstable: Vec<Vec<f64>>,
    /// Wall time of all solves on all threads \[s\].
    pub seconds: f64,
    /// Wall time of each solve on its thread \[s\].
    pub solve_seconds: Vec<f64>,
}

/// A sample that was not solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Parameters of the sample.
    pub theta: Vec<f64>,
    /// Error of the solver, in words.
    pub reason: String,
}

/// Log stored beside the fields; written last, so that it says how many rows count.
#[derive(Serialize, Deserialize)]
struct Log<B, S> {
    body: B,
    /// Samples that were tried.
    tried: usize,
    #[serde(flatten)]
    found: S,
    /// CRC-32 of this log without checksums, of the parameters and of the fields. Only the rows that the log counts enter:
    /// a killed run may have written more.
    checksums: [u32; 3],
}

fn sums(body: &Identity, tried: usize, found: &Simulations) -> [u32; 3] {
    let Simulations { failures, branched, jumped, unstable, seconds, solve_seconds, .. } = found;
    let own = format!("{body:?} {tried} {failures:?} {branched:?} {seconds:?} {solve_seconds:?}");
    let doubtful = checksum(&own, &[&unstable[..], jumped].concat());
    [doubtful, checksum("", &found.thetas), checksum("", &found.fields)]
}

/// CRC-32 of a text and of rows of numbers behind it.
fn checksum(text: &str, rows: &[Vec<f64>]) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(text.as_bytes());
    rows.iter().flatten().for_each(|value| sum.update(&value.to_le_bytes()));
    sum.finalize()
}

impl Simulations {
    /// Keeps the first `count` at most.
    pub(crate) fn keep(&mut self, count: usize) {
        let share = count.min(self.fields.len()) as f64 / self.fields.len().max(1) as f64;
        self.thetas.truncate(count);
        self.fields.truncate(count);
        self.pressures.truncate(count);
        self.solve_seconds.truncate(count);
        self.seconds *= share;
    }

    /// Appends more of them.
    pub(crate) fn extend(&mut self, more: Self) {
        self.thetas.extend(more.thetas);
        self.fields.extend(more.fields);
        self.pressures.extend(more.pressures);
        self.failures.extend(more.failures);
        self.branched.extend(more.branched);
        self.jumped.extend(more.jumped);
        self.unstable.extend(more.unstable);
        self.compared += more.compared;
        self.solve_seconds.extend(more.solve_seconds);
        self.seconds += more.seconds;
    }

    /// Requires `least` solutions.
    pub(crate) fn require(&self, body: &Body, least: usize) -> Result<()> {
        if self.fields.len() >= least {
            return Ok(());
        }
        let tried = self.fields.len() + self.failures.len();
        let first = self.failures.first().map_or(String::new(), |failure| {
            format!("; the first failed at {}: {}", in_words(body, &failure.theta), failure.reason)
        });
        let solved = self.fields.len();
        let what = format!("{solved} of {tried} simulations succeeded, {least} are needed{first}");
        Err(Error::Refused(what))
    }
}

/// Solves a body for each of `thetas` on all cores.
///
/// With a `folder`, fields and failures are stored there after every hundred samples (`theta.npy`,
/// `displacement.npy`, `simulations.json`), within a hundred every ten seconds and when the observer breaks (`under-way`). What it already
/// holds for the same θ and body is kept.
///
/// # Errors
/// A body that cannot be solved for any θ, a folder for one without a potential, files that cannot be written or hold other samples or those of
/// another body, an observer that breaks. Samples without a solution are no error, see [`Simulations::failures`].
#[doc(alias("snapshots", "training data"))]
pub fn simulate(
    body: &Body,
    thetas: &[Vec<f64>],
    stage: &str,
    folder: Option<&Path>,
    observer: &mut dyn Observer,
) -> Result<Simulations> {
    simulate_by(body, thetas, stage, folder, &Options::default(), observer)
}

/// [`simulate`] by a solver's own options, such as load steps for bodies with several stable equilibria. A folder does not keep them: resume with
/// the same.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_by(
    body: &Body,
    thetas: &[Vec<f64>],
    stage: &str,
    folder: Option<&Path>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Simulations> {
    // Neither its identity nor its files would hold followers and pressures.
    ensure(folder.is_none() || body.has_potential(), SolveError::NoPotential)?;
    let folder = folder.map(|folder| (folder, identity::of(body)));
    let (mut tried, mut simulations) = match &folder {
        Some((folder, body)) => stored(folder, body, thetas)?,
        None => (0, Simulations::default()),
    };
    if tried == thetas.len() {
        return Ok(simulations);
    }
    let mut counter = Counter::new(observer, stage, tried, thetas.len());
    let folder = folder.as_ref().map(|(folder, body)| (*folder, body));
    for samples in thetas[tried..].chunks(BLOCK) {
        let block = Block::open(samples, folder)?;
        counter.keep(block.len());
        let found = solved(body, block, options, &mut counter)?;
        tried += samples.len();
        simulations.extend(found);
        if let Some((folder, body)) = folder {
            store(folder, body, tried, &simulations)?;
            Block::forget(folder);
        }
    }
    let failed = match simulations.failures.len() {
        0 => String::new(),
        failed => format!(", {failed} failed"),
    };
    counter.finish(&format!("{} solves{failed}", simulations.fields.len()));
    Ok(simulations)
}

/// Solves the remaining samples of a block; stores it and ends with an error where the observer breaks.
fn solved(
    body: &Body,
    block: Block<'_>,
    options: &Options,
    counter: &mut Counter<'_>,
) -> Result<Simulations> {
    let (thetas, earlier) = (block.thetas, block.earlier());
    let shared = Mutex::new((block, counter, Ok(())));
    let each = |index, result| {
        let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
        let (block, counter, outcome) = &mut *shared;
        block.take(index, result);
        let stop = counter.step(1, "").is_break();
        if stop || block.is_due() {
            *outcome = block.store().and_then(|()| counter.check());
        }
        if outcome.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let watch = |state: &sinew_fem::Progress<'_>| {
        // A break shows after the solve. No solve waits for another that is being stored.
        if let Ok(mut shared) = shared.try_lock() {
            let _ = shared.1.within(|| state.in_words());
        }
    };
    resume_sweep(body, thetas, &earlier, options, each, watch)?;
    let (block, counter, outcome) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    outcome?;
    let compare = body.has_potential() && options.load_steps == LoadSteps::WhenNeeded;
    let watch = |state: &sinew_fem::Progress<'_>| {
        let _ = counter.within(|| format!("compared with a rising load: {}", state.in_words()));
    };
    block.close(body, compare.then_some(watch))
}

const THETAS: &str = "theta.npy";
const FIELDS: &str = "displacement.npy";
pub(crate) const LOG: &str = "simulations.json";
/// Names of the files that simulations are stored in.
pub(crate) const STORED: [&str; 3] = [THETAS, FIELDS, LOG];

/// Stores simulations of the first `tried` samples of a set.
pub(crate) fn store(
    folder: &Path,
    body: &Identity,
    tried: usize,
    simulations: &Simulations,
) -> Result<()> {
    write_table(&folder.join(THETAS), &simulations.thetas)?;
    write_table(&folder.join(FIELDS), &simulations.fields)?;
    let checksums = sums(body, tried, simulations);
    write_json(&folder.join(LOG), &Log { body, tried, found: simulations, checksums })
}

/// Simulations of a body that [`simulate`] or [`crate::merge`] left in a folder, whatever their parameters.
///
/// # Errors
/// No simulations there, or those of another body.
pub fn read_simulations(body: &Body, folder: &Path) -> Result<Simulations> {
    match read(folder, &identity::of(body))? {
        Some((_, found)) => Ok(found),
        None => Err(Error::Request(format!(
            "{} holds no simulations; name a folder that simulations were stored or merged in",
            folder.display()
        ))),
    }
}

/// Simulations of a body in a folder, and how many samples were tried; `None` where it holds no simulations.
pub(crate) fn read(folder: &Path, body: &Identity) -> Result<Option<(usize, Simulations)>> {
    let Some(log) = read_json(&folder.join(LOG))? else { return Ok(None) };
    let Log::<Identity, Simulations> { body: stored, tried, mut found, checksums } = log;
    let solved = found.solve_seconds.len();
    let rows = |name: &str| -> Result<Vec<Vec<f64>>> {
        let mut rows = read_table(&folder.join(name))?;
        rows.truncate(solved);
        Ok(rows)
    };
    (found.thetas, found.fields) = (rows(THETAS)?, rows(FIELDS)?);
    let sums = checksums.into_iter().zip(sums(&stored, tried, &found));
    for (name, (stored, found)) in [LOG, THETAS, FIELDS].into_iter().zip(sums) {
        require_usable(stored == found, || {
            format!(
                "{} was changed after it was stored, or an earlier version stored it; delete its folder to solve the simulations again",
                folder.join(name).display()
            )
        })?;
    }
    let same = identity::difference(&stored, body).is_none();
    ensure(same, Error::OtherSamples { folder: folder.into() })?;
    Ok(Some((tried, found)))
}

/// Whether two θ are the same but for the rounding of another machine's logarithms.
pub fn alike(a: &[f64], b: &[f64]) -> bool {
    const ROUNDING: f64 = 1e-12;
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
    a.len() == b.len() && a.iter().zip(b).all(close)
}

/// Simulations of the samples `thetas` of a body in a folder, and how many of them were tried.
///
/// # Errors
/// Other samples, or those of another body.
pub(crate) fn stored(
    folder: &Path,
    body: &Identity,
    thetas: &[Vec<f64>],
) -> Result<(usize, Simulations)> {
    let (tried, found) = read(folder, body)?.unwrap_or_default();
    let failed = |theta: &[f64]| found.failures.iter().any(|failure| alike(&failure.theta, theta));
    let expected = thetas.iter().take(tried).filter(|theta| !failed(theta));
    let same = expected.clone().count() == found.thetas.len()
        && expected.zip(&found.thetas).all(|(a, b)| alike(a, b));
    ensure(tried <= thetas.len() && same, Error::OtherSamples { folder: folder.into() })?;
    Ok((tried, found))
}

/// Folder of complete simulations that runs of one body and one set of samples share. A set gets there by renaming its
/// folder: two runs at once both solve, and the first that ends leaves what later ones read.
pub(crate) struct Shared {
    place: PathBuf,
    body: Identity,
}

impl Shared {
    /// Within a folder, by body and samples.
    pub(crate) fn new(folder: &Path, body: &Body, thetas: &[Vec<f64>]) -> Self {
        let body = identity::of(body);
        let key = checksum(&format!("{body:?}"), thetas);
        Self { place: folder.join(format!("{}-{key:08x}", thetas.len())), body }
    }

    /// Simulations that another run has solved.
    ///
    /// # Errors
    /// Files that are damaged.
    pub(crate) fn find(&self, thetas: &[Vec<f64>]) -> Result<Option<Simulations>> {
        let (tried, found) = stored(&self.place, &self.body, thetas)?;
        Ok((tried == thetas.len() && tried > 0).then_some(found))
    }

    /// Leaves a run's own folder of simulations, which is whole, to others.
    pub(crate) fn leave(&self, own: &Path) {
        // A failure does no harm: the run keeps its simulations in its own folder.
        let above = self.place.parent().map_or(Ok(()), std::fs::create_dir_all);
        let _ = above.and_then(|()| std::fs::rename(own, &self.place));
    }
}

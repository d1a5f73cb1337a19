//! Samples that are solved together, and what is stored of them on the way.

use crate::sample::simulate::{Failure, MOST_COMPARED, Simulations, alike, read, store};
use crate::store::identity::Identity;
use crate::{Body, Result};
use sinew_fem::{CHAIN, Earlier, Options, Solution, SolveError, Solver, neighbours};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two stores within a block: a kill loses what was found since, and the solves under way.
const PAUSE: Duration = Duration::from_secs(10);
/// Least time between two stores, in times that the last one took: on a slow file system they cost a twentieth at most.
const SHARE: u32 = 20;

/// Time of the solves in an unfinished chain of neighbours below which they are repeated \[s\]: the numbers are then those of a run without a
/// stop, to the bit. A longer chain goes on from its last solution, to the solver's rounding.
const REPEATED_S: f64 = 30.0;

/// Folder of a block that is under way, in that of the simulations.
pub(crate) const UNDER_WAY: &str = "under-way";

/// A block that is being solved.
pub(crate) struct Block<'a> {
    pub(crate) thetas: &'a [Vec<f64>],
    store: Option<(PathBuf, &'a Identity)>,
    /// Results in the order in which they were found, so that files of which a kill left one short agree in their first rows.
    found: Simulations,
    /// Solutions that a rising load may not lead to, by index. They are found again after a kill, to be compared.
    jumped: Vec<(usize, Solution)>,
    opened: Instant,
    stored: Instant,
    /// Time that the last store took.
    cost: Duration,
}

impl<'a> Block<'a> {
    /// Samples of a block, with what an earlier run left of it in the folder of the simulations.
    ///
    /// # Errors
    /// Files that cannot be read, or are of another body.
    pub(crate) fn open(
        thetas: &'a [Vec<f64>],
        folder: Option<(&Path, &'a Identity)>,
    ) -> Result<Self> {
        let store = folder.map(|(folder, body)| (folder.join(UNDER_WAY), body));
        let earlier = match &store {
            Some((folder, body)) => read(folder, body)?.map(|(_, found)| found),
            None => None,
        };
        let now = Instant::now();
        let (found, jumped, cost) = (earlier.unwrap_or_default(), Vec::new(), Duration::ZERO);
        let mut block = Self { thetas, store, found, jumped, opened: now, stored: now, cost };
        // A kill after the last block was stored leaves its own.
        if block.earlier().iter().flatten().count() != block.len() {
            block.found = Simulations::default();
        }
        block.restart_short_chains();
        Ok(block)
    }

    /// Drops the results of chains that are unfinished and took less than [`REPEATED_S`].
    fn restart_short_chains(&mut self) {
        let known: Vec<bool> = self.earlier().iter().map(Option::is_some).collect();
        if !known.contains(&true) {
            return;
        }
        let place = |theta: &Vec<f64>| self.thetas.iter().position(|own| alike(own, theta));
        let mut seconds = vec![0.0; known.len()];
        for (theta, took) in self.found.thetas.iter().zip(&self.found.solve_seconds) {
            place(theta).into_iter().for_each(|place| seconds[place] += took);
        }
        let mut repeated = vec![false; known.len()];
        for chain in neighbours(self.thetas).chunks(CHAIN) {
            let spent: f64 = chain.iter().map(|&place| seconds[place]).sum();
            if spent < REPEATED_S && !chain.iter().all(|&place| known[place]) {
                chain.iter().for_each(|&place| repeated[place] = true);
            }
        }
        let stays = |theta: &Vec<f64>| place(theta).is_some_and(|place| !repeated[place]);
        let kept: Vec<bool> = self.found.thetas.iter().map(stays).collect();
        self.found.failures.retain(|failure| stays(&failure.theta));
        let Simulations { thetas, fields, solve_seconds, .. } = &mut self.found;
        retain(thetas, &kept);
        retain(fields, &kept);
        retain(solve_seconds, &kept);
    }

    /// Samples that are found.
    pub(crate) fn len(&self) -> usize {
        self.found.fields.len() + self.found.failures.len()
    }

    /// Results so far, sample by sample.
    pub(crate) fn earlier(&self) -> Vec<Option<Earlier>> {
        let Simulations { thetas, fields, failures, .. } = &self.found;
        let solved =
            thetas.iter().zip(fields).map(|(theta, u)| (theta, Earlier::Solved(u.clone())));
        let failed = failures.iter().map(|failure| (&failure.theta, Earlier::Failed));
        let mut known = vec![None; self.thetas.len()];
        for (theta, earlier) in solved.chain(failed) {
            let is_its =
                |&place: &usize| known[place].is_none() && alike(theta, &self.thetas[place]);
            if let Some(place) = (0..known.len()).find(is_its) {
                known[place] = Some(earlier);
            }
        }
        known
    }

    /// Takes a result.
    pub(crate) fn take(&mut self, index: usize, result: std::result::Result<Solution, SolveError>) {
        match result {
            Ok(solution) if solution.jumped => self.jumped.push((index, solution)),
            Ok(solution) => self.found.push(self.thetas[index].clone(), solution),
            Err(error) => self
                .found
                .failures
                .push(Failure { theta: self.thetas[index].clone(), reason: error.to_string() }),
        }
    }

    /// Whether the time has come to store.
    pub(crate) fn is_due(&self) -> bool {
        self.stored.elapsed() >= PAUSE.max(SHARE * self.cost)
    }

    /// Stores what is found.
    pub(crate) fn store(&mut self) -> Result<()> {
        let start = Instant::now();
        if let Some((folder, body)) = &self.store {
            let seconds = self.found.seconds + self.opened.elapsed().as_secs_f64();
            store(folder, body, self.len(), &Simulations { seconds, ..self.found.clone() })?;
        }
        (self.stored, self.cost) = (Instant::now(), start.elapsed());
        Ok(())
    }

    /// All results in the order of the samples, those of several equilibria compared with the one that a rising load leads to.
    pub(crate) fn close(mut self, body: &Body, compare: bool) -> Result<Simulations> {
        self.jumped.sort_by_key(|&(index, _)| index);
        let [branched, jumped] =
            if compare { branches(body, &self.jumped)? } else { <_>::default() };
        self.jumped.drain(..).for_each(|(_, solution)| {
            self.found.push(solution.theta.clone(), solution);
        });
        let place = |theta: &Vec<f64>| self.thetas.iter().position(|own| alike(own, theta));
        let mut order: Vec<usize> = (0..self.found.thetas.len()).collect();
        order.sort_by_key(|&row| place(&self.found.thetas[row]));
        self.found.failures.sort_by_key(|failure| place(&failure.theta));
        let Simulations {
            thetas, mut fields, mut pressures, failures, solve_seconds, seconds, ..
        } = self.found;
        let pressure = |&row: &usize| pressures.get_mut(row).map(std::mem::take);
        Ok(Simulations {
            thetas: order.iter().map(|&row| thetas[row].clone()).collect(),
            fields: order.iter().map(|&row| std::mem::take(&mut fields[row])).collect(),
            pressures: order.iter().filter_map(pressure).collect(),
            solve_seconds: order.iter().map(|&row| solve_seconds[row]).collect(),
            failures,
            branched,
            jumped,
            seconds: seconds + self.opened.elapsed().as_secs_f64(),
        })
    }

    /// Removes what was stored on the way, once the block is stored itself.
    pub(crate) fn forget(folder: &Path) {
        // Left behind it is read once more, found to be of other samples, and replaced.
        let _ = std::fs::remove_dir_all(folder.join(UNDER_WAY));
    }
}

fn retain<T>(rows: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    rows.retain(|_| kept.next() == Some(&true));
}

/// Parameters of solutions beside which a rising load leads to another one, and of all that were not shown to be its own.
fn branches(body: &Body, jumped: &[(usize, Solution)]) -> Result<[Vec<Vec<f64>>; 2]> {
    let [mut branched, mut open] = [Vec::new(), Vec::new()];
    let mut solver = if jumped.is_empty() { None } else { Some(Solver::new(body)?) };
    for (place, (_, solution)) in jumped.iter().enumerate() {
        let compared = solver.as_mut().filter(|_| place < MOST_COMPARED);
        // Where no rising load arrives, there is nothing to compare with.
        match compared.map(|solver| solver.under_rising_load(solution, &Options::default())) {
            Some(Ok(None)) => continue,
            Some(Ok(Some(_))) => branched.push(solution.theta.clone()),
            _ => {}
        }
        open.push(solution.theta.clone());
    }
    Ok([branched, open])
}

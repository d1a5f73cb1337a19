//! Samples that are solved together, and what is stored of them on the way.

use crate::sample::simulate::{
    Failure, LARGEST_COMPARED, MOST_COMPARED, Simulations, alike, read, store,
};
use crate::store::identity::Identity;
use crate::{Body, Result};
use sinew_fem::{CHAIN, Earlier, Options, Progress, Solution, SolveError, Solver, neighbours};
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

/// Displacement, pressure field and seconds of a sample, or why it has no solution.
type Outcome = std::result::Result<(Vec<f64>, Vec<f64>, f64), String>;

/// A block that is being solved.
pub(crate) struct Block<'a> {
    pub(crate) thetas: &'a [Vec<f64>],
    store: Option<(PathBuf, &'a Identity)>,
    /// Results by index, in the order in which they were found, so that files of which a kill left one short agree in their first rows.
    found: Vec<(usize, Outcome)>,
    /// Solutions that a rising load may not lead to, by index. They are found again after a kill, to be compared.
    jumped: Vec<(usize, Solution)>,
    /// Unstable solutions, by index.
    unstable: Vec<usize>,
    /// Seconds of earlier runs.
    earlier_s: f64,
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
        let earlier = store.as_ref().map_or(Ok(None), |(folder, body)| read(folder, body))?;
        let (opened, stored) = (Instant::now(), Instant::now());
        let (found, jumped, unstable, cost) = (vec![], vec![], vec![], Duration::ZERO);
        let earlier_s = 0.0;
        let mut block =
            Self { thetas, store, found, jumped, unstable, earlier_s, opened, stored, cost };
        if let Some((_, earlier)) = earlier {
            block.go_on_from(earlier);
        }
        Ok(block)
    }

    /// Takes the results of an earlier run, but for those of chains that are unfinished and took less than [`REPEATED_S`].
    fn go_on_from(&mut self, earlier: Simulations) {
        let Simulations { thetas, fields, failures, unstable, solve_seconds, seconds, .. } =
            earlier;
        let solved = fields.into_iter().zip(solve_seconds).map(|(u, took)| Ok((u, vec![], took)));
        let solved = thetas.into_iter().zip(solved);
        let failed = failures.into_iter().map(|failure| (failure.theta, Err(failure.reason)));
        let mut took = vec![None; self.thetas.len()];
        for (theta, outcome) in solved.chain(failed) {
            let is_its = |&at: &usize| took[at].is_none() && alike(&theta, &self.thetas[at]);
            // A kill after the last block was stored leaves its own.
            let Some(place) = (0..took.len()).find(is_its) else { return self.found.clear() };
            took[place] = Some(outcome.as_ref().map_or(0.0, |(.., seconds)| *seconds));
            self.found.push((place, outcome));
        }
        self.earlier_s = seconds;
        let is_short = |chain: &&[usize]| {
            let known = chain.iter().filter_map(|&place| took[place]);
            known.clone().count() < chain.len() && known.sum::<f64>() < REPEATED_S
        };
        let order = neighbours(self.thetas);
        let repeated: Vec<&usize> = order.chunks(CHAIN).filter(is_short).flatten().collect();
        self.found.retain(|(place, _)| !repeated.contains(&place));
        let is_unstable =
            |place: &usize| unstable.iter().any(|theta| alike(theta, &self.thetas[*place]));
        self.unstable = self.found.iter().map(|(place, _)| *place).filter(is_unstable).collect();
    }

    /// Samples that are found.
    pub(crate) fn len(&self) -> usize {
        self.found.len()
    }

    /// Results so far, sample by sample.
    pub(crate) fn earlier(&self) -> Vec<Option<Earlier>> {
        let mut known = vec![None; self.thetas.len()];
        for (place, outcome) in &self.found {
            let solved = outcome.as_ref().map(|(u, ..)| Earlier::Solved(u.clone()));
            known[*place] = Some(solved.unwrap_or(Earlier::Failed));
        }
        known
    }

    /// Takes a result.
    pub(crate) fn take(&mut self, index: usize, result: std::result::Result<Solution, SolveError>) {
        let is_unstable = |found: &Solution| found.has_potential && !found.is_stable();
        self.unstable.extend(result.as_ref().is_ok_and(is_unstable).then_some(index));
        match result {
            Ok(solution) if solution.jumped => self.jumped.push((index, solution)),
            Ok(found) => self.found.push((index, Ok(outcome(found)))),
            Err(error) => self.found.push((index, Err(error.to_string()))),
        }
    }

    /// Results so far, in their order.
    fn simulations(&self) -> Simulations {
        let seconds = self.earlier_s + self.opened.elapsed().as_secs_f64();
        let unstable = self.unstable.iter().map(|&place| self.thetas[place].clone()).collect();
        let mut all = Simulations { seconds, unstable, ..Simulations::default() };
        for (place, outcome) in &self.found {
            let theta = self.thetas[*place].clone();
            match outcome.clone() {
                Err(reason) => all.failures.push(Failure { theta, reason }),
                Ok((displacement, pressure, took)) => {
                    all.thetas.push(theta);
                    all.fields.push(displacement);
                    all.pressures.extend(Some(pressure).filter(|field| !field.is_empty()));
                    all.solve_seconds.push(took);
                }
            }
        }
        all
    }

    /// Whether the time has come to store.
    pub(crate) fn is_due(&self) -> bool {
        self.stored.elapsed() >= PAUSE.max(SHARE * self.cost)
    }

    /// Stores what is found.
    pub(crate) fn store(&mut self) -> Result<()> {
        let start = Instant::now();
        if let Some((folder, body)) = &self.store {
            store(folder, body, self.len(), &self.simulations())?;
        }
        (self.stored, self.cost) = (Instant::now(), start.elapsed());
        Ok(())
    }

    /// All results in the order of the samples, those of several equilibria compared with the one that a rising load leads to if there is a `watch`,
    /// which receives the states of these solves.
    pub(crate) fn close(
        mut self,
        body: &Body,
        watch: Option<impl FnMut(&Progress<'_>)>,
    ) -> Result<Simulations> {
        self.jumped.sort_by_key(|&(index, _)| index);
        let ([branched, jumped], compared) = match watch {
            Some(watch) => branches(body, &self.jumped, watch)?,
            None => <_>::default(),
        };
        let late = self.jumped.drain(..).map(|(index, solution)| (index, Ok(outcome(solution))));
        self.found.extend(late);
        self.found.sort_by_key(|&(index, _)| index);
        self.unstable.sort_unstable();
        Ok(Simulations { branched, jumped, compared, ..self.simulations() })
    }

    /// Removes what was stored on the way, once the block is stored itself.
    pub(crate) fn forget(folder: &Path) {
        // Left behind it is read once more, found to be of other samples, and replaced.
        let _ = std::fs::remove_dir_all(folder.join(UNDER_WAY));
    }
}

fn outcome(solution: Solution) -> (Vec<f64>, Vec<f64>, f64) {
    (solution.displacement, solution.pressure, solution.seconds)
}

/// Parameters of solutions beside which a rising load leads to another one, and of all that were not shown to be its own; and how many were
/// compared.
fn branches(
    body: &Body,
    jumped: &[(usize, Solution)],
    mut watch: impl FnMut(&Progress<'_>),
) -> Result<([Vec<Vec<f64>>; 2], usize)> {
    let ([mut branched, mut open], mut agreed) = ([Vec::new(), Vec::new()], 0);
    let mut solver = if jumped.is_empty() { None } else { Some(Solver::new(body)?) };
    for (place, (_, solution)) in jumped.iter().enumerate() {
        let compared = solver
            .as_mut()
            .filter(|solver| place < MOST_COMPARED && solver.unknowns() <= LARGEST_COMPARED);
        // Where no rising load arrives, there is nothing to compare with.
        let options = Options::default();
        match compared.map(|solver| solver.under_rising_load(solution, &options, &mut watch)) {
            Some(Ok(None)) => {
                agreed += 1;
                continue;
            }
            Some(Ok(Some(_))) => branched.push(solution.theta.clone()),
            _ => {}
        }
        open.push(solution.theta.clone());
    }
    let compared = branched.len() + agreed;
    Ok(([branched, open], compared))
}

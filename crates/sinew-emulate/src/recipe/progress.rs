//! Progress of a run.

use crate::error::ensure;
use crate::{Error, Result, Warning};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Progress of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Stage, such as `"simulate training"`.
    pub stage: &'a str,
    /// Share of the stage that is done, from 0 to 1.
    pub fraction: f64,
    /// Seconds until the stage ends, at the pace so far; infinite while that is unknown.
    pub seconds_left: f64,
    /// Something that changes, such as the loss; may be empty.
    pub message: &'a str,
}

/// Receives the progress of a run. `()` ignores it; [`Terminal`](crate::Terminal) draws bars (feature `terminal`).
pub trait Observer: Send {
    /// Called often. Breaking ends the run with [`Error::Interrupted`](crate::Error::Interrupted), to be resumed from
    /// what is stored.
    fn progress(&mut self, _progress: &Progress<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Called at the end of a stage with what it gave and the seconds it took.
    fn finished(&mut self, _stage: &str, _outcome: &str, _seconds: f64) {}

    /// Called at each warning. Warnings that hold at the end are also in the result.
    fn warning(&mut self, _warning: &Warning) {}
}

impl Observer for () {}

/// Counts pieces of a stage and estimates the time left.
pub struct Counter<'a> {
    observer: &'a mut dyn Observer,
    stage: &'a str,
    start: Instant,
    /// Pieces of an earlier run, which took no time of this one.
    kept: usize,
    done: usize,
    count: usize,
    /// When the observer was told last, and whether it broke then.
    told: Instant,
    broken: bool,
}

/// Time without news after which the observer is told of a piece under way.
const QUIET: Duration = Duration::from_secs(1);

impl<'a> Counter<'a> {
    /// Counter over `count` pieces of one size, or that many units of work, of which some are `kept` from an earlier run.
    pub fn new(observer: &'a mut dyn Observer, stage: &'a str, kept: usize, count: usize) -> Self {
        let now = Instant::now();
        Self { observer, stage, start: now, kept, done: kept, count, told: now, broken: false }
    }

    /// Counts pieces of an earlier run.
    pub(crate) fn keep(&mut self, pieces: usize) {
        self.kept += pieces;
        self.done += pieces;
    }

    /// Counts some more; whether to go on.
    pub fn step(&mut self, pieces: usize, message: &str) -> ControlFlow<()> {
        self.done += pieces;
        self.tell(message)
    }

    /// Progress within a piece, at most once a second; whether to go on.
    pub fn within(&mut self, message: impl FnOnce() -> String) -> ControlFlow<()> {
        if self.told.elapsed() < QUIET { ControlFlow::Continue(()) } else { self.tell(&message()) }
    }

    /// Leaves the time before the first piece out of the pace.
    pub(crate) fn begin(&mut self) {
        self.start = Instant::now();
    }

    /// Requires that the observer has not broken.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn check(&self) -> Result<()> {
        ensure(!self.broken, Error::Interrupted { stage: self.stage.into() })
    }

    fn tell(&mut self, message: &str) -> ControlFlow<()> {
        self.told = Instant::now();
        let seconds_left = match (self.count.saturating_sub(self.done), self.done - self.kept) {
            // What follows the last piece has no pace.
            (0, _) | (_, 0) => f64::INFINITY,
            (left, done) => self.start.elapsed().as_secs_f64() / done as f64 * left as f64,
        };
        let flow = self.observer.progress(&Progress {
            stage: self.stage,
            fraction: self.done as f64 / self.count.max(1) as f64,
            seconds_left,
            message,
        });
        self.broken |= flow.is_break();
        if self.broken { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Says what the stage gave.
    pub fn finish(self, outcome: &str) {
        self.observer.finished(self.stage, outcome, self.start.elapsed().as_secs_f64());
    }
}

//! Progress of a run.

use crate::Warning;
use std::ops::ControlFlow;

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
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let _ = progress;
        ControlFlow::Continue(())
    }

    /// Called at the end of a stage with what it gave and the seconds it took.
    fn finished(&mut self, stage: &str, outcome: &str, seconds: f64) {
        let _ = (stage, outcome, seconds);
    }

    /// Called at each warning. Warnings that hold at the end are also in the result.
    fn warning(&mut self, warning: &Warning) {
        let _ = warning;
    }
}

impl Observer for () {}

/// Counts pieces of a stage and estimates the time left.
pub struct Counter<'a> {
    observer: &'a mut dyn Observer,
    stage: &'a str,
    start: std::time::Instant,
    /// Pieces of an earlier run, which took no time of this one.
    kept: usize,
    done: usize,
    count: usize,
}

impl<'a> Counter<'a> {
    /// Counter over `count` pieces of one size, or that many units of work, of which some are `kept` from an earlier run.
    pub fn new(observer: &'a mut dyn Observer, stage: &'a str, kept: usize, count: usize) -> Self {
        Self { observer, stage, start: std::time::Instant::now(), kept, done: kept, count }
    }

    /// Counts pieces of an earlier run.
    pub(crate) fn keep(&mut self, pieces: usize) {
        self.kept += pieces;
        self.done += pieces;
    }

    /// Counts some more; whether to go on.
    pub fn step(&mut self, pieces: usize, message: &str) -> ControlFlow<()> {
        self.done += pieces;
        let pace = self.start.elapsed().as_secs_f64() / (self.done - self.kept) as f64;
        self.observer.progress(&Progress {
            stage: self.stage,
            fraction: self.done as f64 / self.count.max(1) as f64,
            seconds_left: pace * self.count.saturating_sub(self.done) as f64,
            message,
        })
    }

    /// Says that a part of the stage is done.
    pub fn finished(&mut self, part: &str, outcome: &str) {
        self.observer.finished(part, outcome, self.start.elapsed().as_secs_f64());
    }

    /// Says what the stage gave.
    pub fn finish(mut self, outcome: &str) {
        self.finished(self.stage, outcome);
    }
}

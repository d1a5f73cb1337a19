//! SIGTERM and Ctrl-C: what is found is stored, and the program ends.

use anyhow::Result;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use sinew_emulate::{Observer, Progress, Terminal, Warning};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that SIGTERM and Ctrl-C set from now on; a second signal ends the program at once.
pub(crate) fn signalled() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_default(signal, Arc::clone(&stop))?;
        flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// A terminal whose run ends by a signal: after the solves that are under way, with what they found stored. A second signal ends it at once.
pub(crate) struct Stoppable {
    terminal: Terminal,
    stop: Arc<AtomicBool>,
}

impl Stoppable {
    /// Listens to signals from now on: for runs that ask the observer often.
    pub(crate) fn new() -> Result<Self> {
        Ok(Self { terminal: Terminal::default(), stop: signalled()? })
    }
}

impl Observer for Stoppable {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        self.terminal.progress(progress)?;
        if self.stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn finished(&mut self, stage: &str, outcome: &str, seconds: f64) {
        self.terminal.finished(stage, outcome, seconds);
    }

    fn warning(&mut self, warning: &Warning) {
        self.terminal.warning(warning);
    }
}

//! SIGTERM and Ctrl-C: what is found is stored, and the program ends.

use anyhow::Result;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use sinew_emulate::Terminal;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A flag that SIGTERM and Ctrl-C set from now on; a second signal ends the program at once.
pub(crate) fn signalled() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_default(signal, Arc::clone(&stop))?;
        flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// A terminal whose run ends by a signal from now on: after the solves that are under way, with what they found stored. For runs that ask
/// the observer often.
pub(crate) fn stoppable() -> Result<Terminal> {
    let mut terminal = Terminal::default();
    terminal.stop = signalled()?;
    Ok(terminal)
}

//! Progress on the terminal: stage, share done, time left.

use crate::{Observer, Progress, Warning};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Draws a bar for the stage under way on standard error when it is a terminal; elsewhere (a log file, continuous
/// integration) prints a line every ten seconds, and one when the stage ends. A standard error that nobody reads is no error.
#[derive(Debug, Default)]
pub struct Terminal {
    /// Request to end the run at its next sign of progress.
    pub stop: Arc<AtomicBool>,
    /// The stage under way, when it began or last printed a line, and its bar.
    stage: Option<(String, Instant, Option<ProgressBar>)>,
}

/// Time between two lines of one stage where there is no terminal.
const PAUSE: Duration = Duration::from_secs(10);

/// One line on standard error.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Parts of a stage that the bar tells apart.
const LENGTH: u64 = 1000;

/// A bar, if standard error is a terminal.
fn bar(stage: &str) -> Option<ProgressBar> {
    let style = ProgressStyle::with_template("{prefix:<28} {bar:28} {percent:>3} %  {msg}")
        .expect("the template is a constant");
    let bar = || ProgressBar::new(LENGTH).with_prefix(stage.to_string());
    let shown = std::io::stderr().is_terminal();
    shown.then(|| bar().with_style(style.progress_chars("━╸ ")))
}

impl Terminal {
    /// Ends the stage under way, if there is one, and removes its bar.
    fn clear(&mut self) {
        if let Some((.., Some(bar))) = self.stage.take() {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Terminal {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let Progress { stage, fraction, seconds_left, message } = *progress;
        if self.stage.as_ref().is_none_or(|(current, ..)| current != stage) {
            self.clear();
        }
        let begun = || (stage.to_string(), Instant::now(), bar(stage));
        let (_, told, bar) = self.stage.get_or_insert_with(begun);
        let is_known = seconds_left.is_finite();
        let left =
            if is_known { format!("{} left  ", duration(seconds_left)) } else { String::new() };
        if let Some(bar) = bar {
            bar.set_position((fraction * LENGTH as f64) as u64);
            bar.set_message(format!("{left}{message}"));
        } else if told.elapsed() >= PAUSE {
            *told = Instant::now();
            let percent = format!("{:.0} %", 100.0 * fraction);
            tell(format!("{stage:<28} {percent:>5}  {left}{message}").trim_end());
        }
        let stops = self.stop.load(Ordering::Relaxed);
        if stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn finished(&mut self, stage: &str, outcome: &str, seconds: f64) {
        self.clear();
        tell(&format!("{stage:<28} {outcome} in {}", duration(seconds)));
    }

    fn warning(&mut self, warning: &Warning) {
        let tell = || tell(&format!("warning: {warning}"));
        match &self.stage {
            Some((.., Some(bar))) => bar.suspend(tell),
            _ => tell(),
        }
    }
}

/// "0.4 s", "12 s", "3 min 05 s".
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 90.0 => format!("{s:.0} s"),
        s => format!("{} min {:02} s", (s / 60.0) as u64, s as u64 % 60),
    }
}

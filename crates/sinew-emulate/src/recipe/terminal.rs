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
    bar: Option<(String, ProgressBar)>,
    /// The stage, and when it began or last printed a line.
    last: Option<(String, Instant)>,
}

/// Time between two lines of one stage where there is no terminal.
const PAUSE: Duration = Duration::from_secs(10);

/// One line on standard error.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Parts of a stage that the bar tells apart.
const LENGTH: u64 = 1000;

impl Terminal {
    fn bar(&mut self, stage: &str) -> &ProgressBar {
        if self.bar.as_ref().is_none_or(|(current, _)| current != stage) {
            let bar = ProgressBar::new(LENGTH);
            let style = ProgressStyle::with_template("{prefix:<28} {bar:28} {percent:>3} %  {msg}")
                .expect("the template is a constant");
            bar.set_style(style.progress_chars("━╸ "));
            bar.set_prefix(stage.to_string());
            self.clear();
            self.bar = Some((stage.to_string(), bar));
        }
        &self.bar.as_ref().expect("a bar was just made").1
    }

    /// Whether the stage prints a line now: after a pause since it began or last did.
    fn is_due(&mut self, stage: &str) -> bool {
        let last = self.last.as_ref().filter(|(current, _)| current == stage);
        let due = last.is_some_and(|(_, last)| last.elapsed() >= PAUSE);
        if due || last.is_none() {
            self.last = Some((stage.to_string(), Instant::now()));
        }
        due
    }

    fn clear(&mut self) {
        if let Some((_, bar)) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Terminal {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let Progress { stage, fraction, seconds_left, message } = *progress;
        let is_known = seconds_left.is_finite();
        let left =
            if is_known { format!("{} left  ", duration(seconds_left)) } else { String::new() };
        if std::io::stderr().is_terminal() {
            let bar = self.bar(stage);
            bar.set_position((fraction * LENGTH as f64) as u64);
            bar.set_message(format!("{left}{message}"));
        } else if self.is_due(stage) {
            let percent = format!("{:.0} %", 100.0 * fraction);
            tell(format!("{stage:<28} {percent:>5}  {left}{message}").trim_end());
        }
        if self.stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn finished(&mut self, stage: &str, outcome: &str, seconds: f64) {
        self.clear();
        self.last = None;
        tell(&format!("{stage:<28} {outcome} in {}", duration(seconds)));
    }

    fn warning(&mut self, warning: &Warning) {
        let tell = || tell(&format!("warning: {warning}"));
        self.bar.as_ref().map_or_else(tell, |(_, bar)| bar.suspend(tell));
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

//! Progress on the terminal: what is being done, how far, how long still.

use crate::{Observer, Progress, Warning};
use indicatif::{ProgressBar, ProgressStyle};
use std::ops::ControlFlow;

/// Draws a bar for the stage under way on standard error when it is a terminal; elsewhere (a log file, continuous
/// integration) each stage prints one line when it ends.
#[derive(Debug, Default)]
pub struct Terminal {
    bar: Option<(String, ProgressBar)>,
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

    fn clear(&mut self) {
        if let Some((_, bar)) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Terminal {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let bar = self.bar(progress.stage);
        bar.set_position((progress.fraction * LENGTH as f64) as u64);
        let left = match progress.seconds_left {
            left if left.is_finite() => format!("{} left  ", duration(left)),
            _ => String::new(),
        };
        bar.set_message(format!("{left}{}", progress.message));
        ControlFlow::Continue(())
    }

    fn finished(&mut self, stage: &str, outcome: &str, seconds: f64) {
        self.clear();
        eprintln!("{stage:<28} {outcome} in {}", duration(seconds));
    }

    fn warning(&mut self, warning: &Warning) {
        match &self.bar {
            Some((_, bar)) => bar.suspend(|| eprintln!("warning: {warning}")),
            None => eprintln!("warning: {warning}"),
        }
    }
}

/// "0.4 s", "12 s", "3 min 05 s".
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 90.0 => format!("{s:.0} s"),
        s => format!("{} min {:02} s", (s / 60.0) as u64, s as u64 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_read_well() {
        assert_eq!([0.42, 12.3, 185.0].map(duration), ["0.4 s", "12 s", "3 min 05 s"]);
    }
}

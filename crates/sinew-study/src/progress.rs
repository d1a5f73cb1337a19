//! Progress on the terminal: what is being done, how far, how long still.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar of `length` steps with time left, drawn on standard error when it is a terminal.
///
/// Elsewhere (a log file, continuous integration) each phase prints one line when it ends.
pub fn bar(title: &str, length: u64) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let style = ProgressStyle::with_template(
        "{prefix:<28} {bar:28} {pos}/{len}  {elapsed} elapsed, {eta} left  {msg}",
    )
    .expect("the template is a constant");
    bar.set_style(style.progress_chars("━╸ "));
    bar.set_prefix(title.to_string());
    bar
}

/// A bar over work of uneven pieces, in units that add up to `total`; it shows the share done.
pub fn weighted_bar(title: &str, total: u64) -> ProgressBar {
    let bar = ProgressBar::new(total);
    let style = ProgressStyle::with_template(
        "{prefix:<28} {bar:28} {percent:>3} %  {elapsed} elapsed, {eta} left  {msg}",
    )
    .expect("the template is a constant");
    bar.set_style(style.progress_chars("━╸ "));
    bar.set_prefix(title.to_string());
    bar
}

/// Ends a bar; the line that stays says what the phase gave.
pub fn finish(bar: &ProgressBar, outcome: &str) {
    bar.finish_and_clear();
    let line = format!("{:<28} {} in {}", bar.prefix(), outcome, seconds(bar.elapsed()));
    eprintln!("{line}");
}

/// "0.4 s", "12 s", "3 min 05 s".
pub fn seconds(duration: Duration) -> String {
    let s = duration.as_secs_f64();
    match s {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 90.0 => format!("{s:.0} s"),
        s => format!("{} min {:02} s", (s / 60.0) as u64, s as u64 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_read_well() {
        let text = |s: f64| seconds(Duration::from_secs_f64(s));
        assert_eq!([text(0.42), text(12.3), text(185.0)], ["0.4 s", "12 s", "3 min 05 s"]);
    }
}

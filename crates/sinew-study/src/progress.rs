//! Progress on the terminal: what is being done, how far, how long still.

use indicatif::{ProgressBar, ProgressStyle};
use sinew_report::format;

/// A bar over work of uneven pieces, in units that add up to `total`; it shows the share done.
///
/// It is drawn on standard error when that is a terminal; elsewhere (a log file, continuous integration) a phase prints
/// one line when it ends.
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
    let seconds = format::seconds(bar.elapsed().as_secs_f64());
    eprintln!("{:<28} {outcome} in {seconds}", bar.prefix());
}

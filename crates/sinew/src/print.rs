//! Printing without a panic on a closed pipe, as in `sinew scenes | head -1`, or on a full disk: a computation goes on and writes its files.
//! The macros replace the standard ones, which panic.

use std::fmt::Arguments;
use std::io::Write;
use std::sync::OnceLock;

static LOST: OnceLock<String> = OnceLock::new();

/// Prints on standard output.
pub(crate) fn out(text: Arguments<'_>) {
    note(std::io::stdout().write_fmt(text));
}

/// Keeps the first reason for which something was not printed; a pipe that its reader closed is no reason.
fn note(printed: std::io::Result<()>) {
    if let Err(error) = printed
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        LOST.get_or_init(|| error.to_string());
    }
}

/// The reason for which standard output is incomplete.
pub(crate) fn lost() -> Option<&'static str> {
    note(std::io::stdout().flush());
    LOST.get().map(String::as_str)
}

/// Prints on standard error.
pub(crate) fn err(text: Arguments<'_>) {
    let _ = std::io::stderr().write_fmt(text);
}

macro_rules! print {
    ($($text:tt)*) => { $crate::print::out(format_args!($($text)*)) };
}

macro_rules! println {
    () => { print!("\n") };
    ($($text:tt)*) => { print!("{}\n", format_args!($($text)*)) };
}

macro_rules! eprintln {
    ($($text:tt)*) => { $crate::print::err(format_args!("{}\n", format_args!($($text)*))) };
}

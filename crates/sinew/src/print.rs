//! Printing without a panic on a closed pipe, as in `sinew scenes | head -1`: a computation goes on and writes its files.
//! The macros replace the standard ones, which panic.

use std::fmt::Arguments;
use std::io::Write;

/// Prints on standard output.
pub(crate) fn out(text: Arguments<'_>) {
    let _ = std::io::stdout().write_fmt(text);
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

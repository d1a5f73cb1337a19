//! Printing that does not care whether anybody reads: `sinew scenes | head -1` closes the pipe, and a computation goes on to
//! write its files all the same. These macros take the place of the standard ones, which panic then.

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

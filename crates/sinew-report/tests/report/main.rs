//! Reports as a whole: what is refused, what is written, what is read back, and what a page shows.

mod files;
mod labels;
mod packed;
mod page;
mod support;
mod surfaces;
mod values;

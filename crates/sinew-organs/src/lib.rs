//! The organs of the thesis (chapter 3 and appendix B), from one command: `cargo xtask reproduce-organs`.
//!
//! `organs` lists the scenes and what is printed about them, [`reproduce`] takes each from its case file to errors and times,
//! `cubes` carries one network from small meshes to large ones, `newcomers` one from a ventricle to others,
//! `rates` trains beams at several learning rates.

pub mod coverage;
mod cubes;
pub mod map;
mod newcomers;
pub mod options;
mod organs;
pub mod populations;
mod rates;
pub mod regions;
pub mod reproduce;
pub mod run;

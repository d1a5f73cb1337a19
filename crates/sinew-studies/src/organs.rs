//! The organs of the thesis (chapter 3 and appendix B).
//!
//! `scenes` lists them with the printed figures, [`reproduce`] takes each from its case file to errors and times.
//! Studies beyond one scene: `cubes` fine-tunes one network from small meshes on large ones, `newcomers` one ventricle's network on others.

mod cubes;
pub(crate) mod newcomers;
pub mod options;
pub mod reproduce;
mod run;
mod scenes;

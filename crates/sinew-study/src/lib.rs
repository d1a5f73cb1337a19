//! Studies of mechanics: the thesis' beams, organs and populations, coverage of error estimates, posteriors of patients.
//!
//! Each is a list of scenes and a report: [`beams`] (`cargo xtask reproduce-beam`), [`organs`] (`reproduce-organs`), [`populations`]
//! (`reproduce-populations`), [`coverage`] (`coverage-estimates`), [`calibration`] (`reproduce-calibration`). [`thesis`] holds all printed figures against
//! their reports. [`program`], [`manifest`] and [`timing`] are what they share.

pub mod beams;
pub mod calibration;
pub mod coverage;
pub mod manifest;
pub mod organs;
pub mod populations;
pub mod program;
pub mod thesis;
pub mod timing;

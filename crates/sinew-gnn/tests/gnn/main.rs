//! Networks: objectives, trainings, hard cases.

mod best;
mod common;
mod emulator;
mod hard_cases;
mod motions;
mod objectives;
mod principal;
mod training;

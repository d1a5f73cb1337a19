//! Patients and posteriors: derivatives, formulations, hard cases.

mod emulator;
mod formulations;
mod hard;
mod patient;
mod posterior;
mod problem;
mod support;
mod wall;

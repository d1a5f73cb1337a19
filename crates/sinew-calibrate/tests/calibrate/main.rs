//! Patients and posteriors: derivatives, formulations, hard cases.

mod formulations;
mod hard;
mod patient;
mod posterior;
mod support;

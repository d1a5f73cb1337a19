//! The solver against ground truth: closed forms, FEniCS, manufactured solutions, hard cases.

#[path = "../../../../fixtures/solids/distort.rs"]
mod distort;
#[path = "../../../../fixtures/solids/membrane.rs"]
mod membrane;
#[path = "../../../../fixtures/solids/shells.rs"]
mod shells;
#[path = "../../../../fixtures/organ/ventricles.rs"]
mod ventricles;

mod beams;
mod continuation;
mod diagnostics;
mod elements;
mod elimination;
mod fenics;
mod fibres;
mod hard_cases;
mod lids;
mod linear;
mod locking;
mod methods;
mod patch;
mod patches;
mod prescribed;
mod stresses;
mod support;
mod sweeps;
mod unload;
mod unload_verdicts;
mod ventricle;

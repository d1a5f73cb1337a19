//! The solver against ground truth: closed forms, FEniCS, manufactured solutions, hard cases.

#[path = "../../../sinew-mesh/tests/mesh/distort.rs"]
mod distort;
#[path = "../../../sinew-mesh/tests/mesh/membrane.rs"]
mod membrane;
#[path = "../../../sinew-mesh/tests/mesh/shells.rs"]
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

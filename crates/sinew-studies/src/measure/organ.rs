//! Ventricles and parameter sets of the solver's tests.

#[path = "../../../sinew-fem/tests/fem/support/ventricle.rs"]
pub(super) mod ventricle;
#[path = "../../../../fixtures/organ/ventricles.rs"]
pub(super) mod ventricles;

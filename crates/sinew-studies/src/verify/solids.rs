//! Solids of benchmarks, whose meshes tests share.

#[path = "../../../../fixtures/solids/distort.rs"]
pub(crate) mod distort;
#[path = "../../../../fixtures/solids/membrane.rs"]
pub(crate) mod membrane;
#[path = "../../../../fixtures/solids/shells.rs"]
pub(crate) mod shells;

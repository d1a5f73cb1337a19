//! Laws, elements, loads and scenes against closed forms and differences.

#[path = "../../../../fixtures/organ/ventricles.rs"]
mod ventricles;

mod cavities;
mod conformance;
mod elements;
mod homogeneous;
mod left_ventricle;
mod lids;
mod numbers;
mod pressure;
mod rates;
mod scene;
mod solid;

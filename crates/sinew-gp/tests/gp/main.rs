//! Gaussian processes against closed forms, exact posteriors, coverage and hard cases.

mod accuracy;
mod beyond;
mod conditions;
mod doubts;
mod edges;
mod exactness;
mod examples;
mod front;
mod hard_cases;
mod honesty;
mod identified;
mod kernels;
mod many_values;
mod penalised;
mod scales;
mod semilinear;
mod theorems;

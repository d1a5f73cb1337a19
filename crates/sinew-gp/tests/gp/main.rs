//! Gaussian processes against closed forms, exact posteriors, coverage and hard cases.

mod accuracy;
mod beyond;
mod conditions;
mod constraints;
mod domains;
mod doubts;
mod edges;
mod ensembles;
mod exactness;
mod examples;
mod faults;
mod front;
mod hard_cases;
mod honesty;
mod identified;
mod kernels;
mod many_values;
mod numerics;
mod penalised;
mod scales;
mod search;
mod semilinear;
mod series;
mod theorems;

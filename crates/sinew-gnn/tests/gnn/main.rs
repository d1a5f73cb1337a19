//! Networks and their parts: fused operations, training, recipes, damaged and resumed runs, laws over tensors.

mod batches;
mod best;
mod budgets;
mod clustered;
mod common;
mod concerns;
mod damage;
mod descent;
mod devices;
mod emulator;
mod fused;
mod hard_cases;
mod keeping;
mod lanes;
mod laws;
mod motions;
mod optimisers;
mod principal;
mod progress;
mod recipes;
mod storage;
mod support;
mod training;
mod trust;

//! Networks and their parts: training, recipes, damaged and resumed runs, laws over tensors.

mod best;
mod common;
mod damage;
mod devices;
mod emulator;
mod hard_cases;
mod keeping;
mod laws;
mod motions;
mod principal;
mod recipes;
mod support;
mod training;
mod trust;

//! The fused operations beside plain tensors and plain sums.

mod activations;
mod comparison;
mod edges;
mod lanes;
mod orthogonal;
mod perceptrons;
mod potentials;
mod products;
mod rows;
mod trees;

pub(crate) use products::by_plain_sums;

use std::process::Command;

#[test]
fn narrower_instruction_sets_pass_the_same_tests() {
    const TESTS: [&str; 3] =
        ["fused::products::", "fused::activations::", "fused::perceptrons::perceptrons_of_whole"];
    for instructions in ["avx2", "baseline"] {
        let mut program = Command::new(std::env::current_exe().unwrap());
        let run = program.args(TESTS).env("SINEW_INSTRUCTIONS", instructions).output().unwrap();
        let told = String::from_utf8_lossy(&run.stdout);
        assert!(run.status.success() && !told.contains(" 0 passed"), "{instructions}: {told}");
    }
}

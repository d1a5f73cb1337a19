//! Examples, compiled and run here too; each asserts its own numbers.

#[path = "../../examples/coverage/main.rs"]
#[allow(dead_code, reason = "the command line of the example")]
mod coverage;
#[path = "../../examples/diffusivity.rs"]
mod diffusivity;
#[path = "../../examples/own_kernel.rs"]
mod own_kernel;
#[path = "../../examples/own_operator.rs"]
mod own_operator;
#[path = "../../examples/pentagon.rs"]
mod pentagon;
#[path = "../../examples/stiffening_bed.rs"]
mod stiffening_bed;

use std::error::Error;

#[test]
fn intervals_hold_the_truth() -> Result<(), Box<dyn Error + Send + Sync>> {
    // Twelve sets of two problems, f = 0 and f ≠ 0, for every day; `cargo xtask coverage 100` is the study. Of four sets two may miss
    // by chance.
    let options = coverage::Options::of_sets(0..12);
    let slab = coverage::rows(&coverage::problems::slab()?, &options)?;
    let rod = coverage::rows(&coverage::problems::graded_rod()?, &options)?;
    assert_eq!((slab.len(), rod.len()), (1, 2), "slab D, graded rod a and b");
    for row in slab.iter().chain(&rod) {
        println!("{row}");
        let columns: Vec<&str> = row.split('|').map(str::trim).collect();
        assert_eq!(columns[2], "UnitInformation");
        let number = |column: usize| -> f64 { columns[column].parse().expect("a number") };
        // From column 3: θ held, u held, estimates inside, width over Cramér–Rao.
        assert!(number(3) >= 80.0 && number(4) >= 80.0, "{row}");
        assert_eq!(number(5), 100.0, "{row}");
        assert!((0.6..2.0).contains(&number(6)), "{row}");
    }
    Ok(())
}

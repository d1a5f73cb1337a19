//! Cost of a solve from rest by the size of a ventricle.

use super::by_size::{peak_gb, three};
use super::mean_ventricle::{THETA, ventricle};
use crate::timing::cpu_seconds;
use anyhow::Result;
use sinew_fem::{Method, Options, Solver};

/// Seconds are of the CPU: set RAYON_NUM_THREADS=1.
#[derive(clap::Args)]
pub struct Arguments {
    /// Bulk modulus in kPa
    #[arg(long, default_value_t = 25.0)]
    bulk_modulus: f64,
    /// Averaged volume ratios
    #[arg(long)]
    averaged: bool,
    /// A factor of each stiffness, whatever the size
    #[arg(long)]
    factor: bool,
    /// Cells of each body, such as 4,48,40: 9005 nodes; 6,72,60: 28 231; 10,112,88: 100 419; 14,160,130: 289 215
    #[arg(required = true, value_parser = three)]
    cells: Vec<[usize; 3]>,
}

/// Prints a line for each size.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { bulk_modulus, averaged, factor, cells } = arguments;
    let method = if *factor { Method::Factor } else { Method::Automatic };
    for &cells in cells {
        let start = cpu_seconds();
        let body = ventricle(cells, *bulk_modulus, *averaged)?;
        let mut solver = Solver::new(&body)?;
        let prepared = cpu_seconds();
        let found = solver.solve(&THETA, &Options { method, ..Options::default() })?;
        println!(
            "{} nodes: prepared in {:.1} s, solved in {:.1} s; {} iterations, {} of conjugate gradients; energy {:.14e}; \
             {} negative eigenvalues{}; {:.2} GB",
            body.nodes,
            prepared - start,
            cpu_seconds() - prepared,
            found.iterations(),
            found.linear_iterations,
            found.energy,
            found.negative_pivots,
            if found.counted { "" } else { ", not counted" },
            peak_gb(),
        );
    }
    Ok(())
}

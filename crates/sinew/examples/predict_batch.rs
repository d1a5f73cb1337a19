//! Trains an emulator of a case, predicts many parameter sets at once, and says how far and how much faster than the solver
//! it is.
//!
//! ```sh
//! cargo run -p sinew --example predict_batch -- OnceClampedBeam 200
//! ```

use sinew::{Case, Comparison, Design, TestSet, Train, recipe::Regression, simulate};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or("OnceClampedBeam".into());
    let count = arguments.next().unwrap_or("200".into());
    let count: usize = count.parse().map_err(|_| format!("COUNT is {count:?}; give a number"))?;

    let case = Case::read(Path::new(&name))?;
    let body = case.body()?;
    let emulator = Regression::default().train(&body, &case.training.options(), &mut ())?;

    let thetas = Design::Uniform.sample(&body.parameters, count.max(1), 99)?;
    let test = TestSet::new(&body, simulate(&body, &thetas, "test", None, &mut ())?);
    let mut comparison = Comparison::new(&test)?;
    comparison.add("regression", &emulator, &test, 1)?;
    println!("{comparison}");
    Ok(())
}

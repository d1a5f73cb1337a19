//! Loads an emulator that `sinew train` left in a folder, and asks it for one answer.
//!
//! ```sh
//! cargo run --release -p sinew -- train OnceClampedBeam --recipe regression
//! cargo run --release -p sinew --example load_trained -- OnceClampedBeam out/OnceClampedBeam/regression mu=75,lambda=80
//! ```

use sinew::{Case, EmulatorError, parse_theta, theta_in_words};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [case, folder, theta] = &arguments[..] else {
        return Err("usage: load_trained CASE FOLDER THETA, such as mu=75,lambda=80".into());
    };
    let body = Case::read(Path::new(case))?.body()?;
    // The folder of the run holds the emulator in a folder of its own; it is refused where it belongs to another body.
    let emulator = match sinew::load(&Path::new(folder).join("emulator"), &body) {
        Err(EmulatorError::NoEmulator { folder }) => {
            return Err(
                format!("train first, into {}: sinew train {case}", folder.display()).into()
            );
        }
        loaded => loaded?,
    };
    emulator.record.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    // Numbers are in the units that the case gives its parameters.
    let theta = parse_theta(theta, &body.parameters)?;
    let predicted = emulator.predict(std::slice::from_ref(&theta))?;
    let corrected = emulator.correct(&theta, 1)?;
    let moved = |field: &[f64]| sinew::output::displacement_in_words(field, &body.units.length);
    println!("{}", theta_in_words(&body, &theta));
    println!("predicted: {}", moved(predicted.field(0)));
    println!("after a Newton step: {}", moved(&corrected.displacement));
    Ok(())
}

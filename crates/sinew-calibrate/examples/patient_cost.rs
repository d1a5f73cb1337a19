//! Times of a patient's observables on an ideal left ventricle: `cargo run -p sinew-calibrate --example patient_cost [LAYERS AROUND ALONG]`.

#[path = "../tests/calibrate/support/heart.rs"]
mod heart;

use heart::{MMHG, NAMES, THETA, passive, segments, wall};
use sinew_calibrate::{Direction, Forward, Observable, Patient};
use sinew_mesh::TruncatedEllipsoid;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut cells = std::env::args().skip(1).map(|word| word.parse::<usize>());
    let mut next = |default: usize| cells.next().unwrap_or(Ok(default));
    let cells = [next(2)?, next(16)?, next(10)?];
    let mesh = TruncatedEllipsoid { short: [20.0, 30.0], long: [52.0, 62.0], base: 15.0 };
    let mesh = mesh.wall(cells).tetrahedra();
    let body = passive(mesh.clone(), 25.0).lower()?;
    println!("{} nodes, {} cells", body.nodes, body.cell_count());
    let wall = wall(&mesh);
    let segments = segments(&wall);
    let patient = Patient::of(&body)
        .parameters(NAMES)
        .image([("pressure", 8.0 * MMHG)])
        .phase("low", [("pressure", 3.0 * MMHG)])
        .phase("high", [("pressure", 14.0 * MMHG)])
        .wall(&wall)
        .segments(&segments)
        .observe(Observable::volume("endo", "rest"))
        .observe(Observable::volume("endo", "low"))
        .observe(Observable::volume("endo", "high"))
        .observe_strains(Direction::Circumferential, "rest", "high")
        .build()?;
    let time = |what: &str,
                derivatives: bool,
                theta: &[f64]|
     -> Result<(), sinew_calibrate::ForwardError> {
        let (start, cpu) = (Instant::now(), cpu());
        let seen = patient.observe(theta, derivatives)?;
        println!(
            "{what}: {:.3} s of wall clock, {:.3} s of processor, V0 {:.4}",
            start.elapsed().as_secs_f64(),
            self::cpu() - cpu,
            seen.values[0]
        );
        Ok(())
    };
    time("start and one", true, &THETA)?;
    time("values", false, &THETA)?;
    time("with derivatives", true, &THETA)?;
    for theta in [[0.15, 1.5, 2.0, 3.0], [0.3, 3.0, 4.0, 1.5], [0.12, 3.5, 4.5, 4.0]] {
        time(&format!("values at {theta:?}"), false, &theta)?;
        time(&format!("with derivatives at {theta:?}"), true, &theta)?;
    }
    Ok(())
}

/// Processor time of the program [s]; 0 where the system does not tell.
fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}

//! Synthetic patients: an image and parameters that know nothing of each other, and data of the unloaded body.

use anyhow::Result;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::PatientFile;
use sinew_sample::split_seed;

/// Parameters whose truth is drawn from their prior.
pub(super) const NAMES: [&str; 4] = ["a", "b", "a_f", "b_f"];
/// Ranges of the priors.
const RANGES: [[f64; 2]; 4] = [[0.1, 0.4], [1.0, 4.0], [1.5, 5.0], [1.0, 4.5]];
/// Cells through the wall, around and along of the patients' meshes.
const CELLS: [usize; 3] = [2, 8, 5];
/// Seed stream of shapes and parameters.
const SHAPES: u64 = 0x5348;

/// A patient file with data.
pub(super) struct Synthetic {
    pub file: PatientFile,
    pub theta: Vec<f64>,
}

/// A patient of a random shape in the image; θ is drawn from the prior, independent of it. Draws without a body at rest are
/// made again, which the count of them tells. With a stiffness \[kPa/mm\] there are springs along the normal of the epicardium.
pub(super) fn random(seed: u64, number: u64, springs: Option<f64>) -> Result<(Synthetic, usize)> {
    let mut random = ChaCha8Rng::seed_from_u64(split_seed(split_seed(seed, SHAPES), number));
    let mut failed = 0;
    loop {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let (radius, wall) = (between(18.0, 26.0), between(8.0, 12.0));
        let (long, base) = (radius * between(2.2, 2.8), between(10.0, 18.0));
        let theta: Vec<f64> =
            RANGES.iter().map(|[low, high]| low * (high / low).powf(between(0.0, 1.0))).collect();
        let blank = PatientFile::parse(
            &text([radius, radius + wall], [long, long + wall], base, CELLS, &RANGES, springs),
            "synthetic",
        )?;
        match blank.synthesise(&theta, split_seed(seed, number)) {
            Ok(text) => {
                let file = PatientFile::parse(&text, "synthetic")?;
                return Ok((Synthetic { file, theta }, failed));
            }
            Err(error) if failed > 20 => return Err(error.into()),
            Err(_) => failed += 1,
        }
    }
}

/// A patient of one shape, of whose parameters a and a_f are unknown.
pub(super) fn of_two(seed: u64, cells: [usize; 3]) -> Result<Synthetic> {
    let ranges = [RANGES[0], [2.0, 2.0], RANGES[2], [2.1, 2.1]];
    let text = text([20.0, 30.0], [52.0, 62.0], 15.0, cells, &ranges, None);
    let theta = vec![0.2, 2.8];
    let text = PatientFile::parse(&text, "synthetic")?.synthesise(&theta, seed)?;
    Ok(Synthetic { file: PatientFile::parse(&text, "synthetic")?, theta })
}

/// The file: volumes at three pressures (3 %) and strains of 24 segments (± .02); equal ends of a range are a known value.
fn text(
    short: [f64; 2],
    long: [f64; 2],
    base: f64,
    cells: [usize; 3],
    ranges: &[[f64; 2]; 4],
    springs: Option<f64>,
) -> String {
    let parameter = |(name, [low, high]): (&&str, &[f64; 2])| match low == high {
        true => format!("{name} = {low:?}\n"),
        false => format!("{name} = [{low:?}, {high:?}]\n"),
    };
    let parameters: String = NAMES.iter().zip(ranges).map(parameter).collect();
    let springs = springs.map_or(String::new(), |normal| {
        format!(r#", {{ foundation = {{ normal = {normal:?} }}, facets = "epi" }}"#)
    });
    format!(
        include_str!("patient.toml.in"),
        short = short,
        long = long,
        base = base,
        cells = cells,
        parameters = parameters,
        springs = springs
    )
}

//! Posteriors against brute force.

use super::options::{Options, listing, row};
use super::reference::Reference;
use crate::calibration::coverage::{self, Synthetic};
use crate::program;
use anyhow::{Result, anyhow};
use sinew::Prepared;
use sinew_calibrate::{
    CalibrateError, CalibrateOptions, Patient, Solves, calibrate, check_identifiability,
};
use sinew_report::{Block, Cell, Section};

/// Patients, solves of importance sampling for each, and draws that are compared.
const IMPORTANCE: (u64, usize, usize) = (3, 20_000, 4800);
const QUICK_IMPORTANCE: (u64, usize, usize) = (1, 300, 240);
const HEAD: [&str; 8] = [
    "total variation",
    "error of means [sd]",
    "error of sds",
    "k̂",
    "share",
    "accepted",
    "solves",
    "time [s]",
];

/// Four parameters against importance sampling.
pub(super) fn importance(options: &Options) -> Result<Section> {
    let (patients, solves, draws) = if options.quick { QUICK_IMPORTANCE } else { IMPORTANCE };
    let (mut texts, mut rows) = (Vec::new(), Vec::new());
    for number in 0..patients {
        let (Synthetic { file, .. }, _) = coverage::random(options.seed, number)?;
        let prepared = file.prepare()?;
        let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
        let problem = &prepared.problem;
        let at = options.out.join(format!("importance-{number}.json"));
        let reference = program::kept(&at, options.resume, || {
            let mut search = Solves::new(&model);
            let (mode, _) = check_identifiability(problem, &mut search)?;
            Reference::importance(problem, &model, &mode, solves, options.seed)
        })?;
        let Reference { failed, share, seconds, .. } = &reference;
        let (name, nodes) = (format!("patient {number}"), prepared.body.nodes);
        texts.push(format!(
            "{name}: {solves} solves of importance sampling on {nodes} nodes, {failed} without an answer, effective share {share:.3}, {seconds:.0} s."
        ));
        let (seed, steps) = (options.seed, 2 * draws);
        let settings = CalibrateOptions { seed, draws, steps, ..CalibrateOptions::default() };
        rows.push(compared(&name, &prepared, &model, &settings, &reference)?);
    }
    let listing = listing("Largest distances over the parameters", "posterior", &HEAD, rows);
    Ok(Section {
        name: "importance".into(),
        title: "Four parameters against importance sampling".into(),
        blocks: vec![Block::List(texts), listing],
    })
}

fn compared(
    name: &str,
    prepared: &Prepared,
    model: &Patient,
    settings: &CalibrateOptions,
    reference: &Reference,
) -> Result<Vec<Cell>> {
    let mut solves = Solves::new(model);
    let (name, distance, c) = match calibrate(&prepared.problem, &mut solves, settings) {
        Ok(found) => (name.to_string(), reference.distance(&found), found.correction),
        Err(CalibrateError::Unconfirmed(c)) => (format!("{name}: refused"), [f64::NAN; 3], *c),
        Err(other) => return Err(other.into()),
    };
    let [variation, means, deviations] = distance;
    let accepted = if variation.is_nan() { f64::NAN } else { c.acceptance };
    let solves = c.solves as f64;
    let numbers = [variation, means, deviations, c.k_hat, c.share, accepted, solves, c.seconds];
    Ok(row(&name, &HEAD, &numbers))
}

//! Models with the wrong springs: patients with a pericardium that are calibrated without one, and the reverse.

use super::coverage::{LEVELS, NAMES, Synthetic, VOLUMES, calibrated, held, ranks};
use super::options::{Options, listing, row};
use crate::calibration::coverage;
use crate::program;
use anyhow::{Result, anyhow, ensure};
use serde::{Deserialize, Serialize};
use sinew::PatientFile;
use sinew_calibrate::{Forward, Posterior, Solves, Verdict, check_identifiability};
use sinew_report::{Block, Cell, Section};
use sinew_sample::{Summary, psis, quantile};

/// Stiffness of springs along the normal of the epicardium \[kPa/mm\], none and those of a pericardium: M. R. Pfaller et al., "The importance of the
/// pericardium for cardiac biomechanics" (Biomechanics and Modeling in Mechanobiology, 2019).
const STIFFNESS: [f64; 2] = [0.0, 0.2];
const SPRINGS: [&str; 2] = ["without", "with"];
const QUICK_PATIENTS: usize = 1;
/// Share of the patients of the coverage study in each pair.
const PAIRS: usize = 4;
/// Probability below which misfits contradict the noise, as [`sinew_calibrate::Predictive`] has it.
const UNLIKELY: f64 = 0.01;

/// One patient by one model.
#[derive(Serialize, Deserialize)]
struct Outcome {
    /// Whether the check before sampling says that the model does not calibrate the data.
    fails: bool,
    found: Result<Found, String>,
}

/// Posterior of one patient beside the truth.
#[derive(Serialize, Deserialize)]
struct Found {
    /// Ranks of the truth: parameters, then volumes.
    ranks: Vec<f64>,
    /// Mean of the draws minus the truth \[posterior standard deviations\].
    errors: Vec<f64>,
    /// Posterior predictive probability of larger misfits.
    p: f64,
    /// Whether a datum contradicts the others.
    contradicted: bool,
    /// Leave-one-out predictive density of each datum, its logarithm.
    left_out: Vec<f64>,
    seconds: f64,
}

pub(super) fn section(options: &Options) -> Result<Section> {
    let patients = match options.quick {
        true => QUICK_PATIENTS,
        false => options.patients.div_ceil(PAIRS),
    };
    let mut outcomes: [[Vec<Outcome>; 2]; 2] = Default::default();
    for number in 0..patients as u64 {
        for truth in 0..2 {
            let name = format!("springs/{}-{number}.json", SPRINGS[truth]);
            let both: [Outcome; 2] =
                program::kept(&options.out.join(name), options.resume, || {
                    let springs = Some(STIFFNESS[truth]);
                    let (patient, _) = coverage::random(options.seed, number, springs)?;
                    Ok([
                        one(options, &patient, truth, 0, number)?,
                        one(options, &patient, truth, 1, number)?,
                    ])
                })?;
            for (model, outcome) in both.into_iter().enumerate() {
                let said = match &outcome.found {
                    Ok(found) => format!(
                        "p {:.3}, ranks {:.2?}, {:.0} s",
                        found.p, found.ranks, found.seconds
                    ),
                    Err(reason) => reason.clone(),
                };
                println!(
                    "patient {number}, truth {}, model {}: {said}",
                    SPRINGS[truth], SPRINGS[model]
                );
                outcomes[truth][model].push(outcome);
            }
        }
    }
    Ok(written(&outcomes, patients))
}

fn one(
    options: &Options,
    patient: &Synthetic,
    truth: usize,
    model: usize,
    number: u64,
) -> Result<Outcome> {
    let exact = patient.file.prepare()?;
    let exact = exact.patient().map_err(|reason| anyhow!(reason))?;
    let exact = exact.observe(&patient.theta, false)?.values;
    let [from, to] = [truth, model].map(|springs| format!("normal = {:?}", STIFFNESS[springs]));
    let text = patient.file.case.text();
    ensure!(text.contains(&from), "the case of a patient does not have `{from}`");
    let file = PatientFile::parse(&text.replace(&from, &to), "synthetic")?;
    let failed = |reason: String| Outcome { fails: true, found: Err(reason) };
    let prepared = match file.prepare() {
        Ok(prepared) => prepared,
        Err(error) => return Ok(failed(error.to_string())),
    };
    let model = match prepared.patient() {
        Ok(model) => model,
        Err(reason) => return Ok(failed(reason)),
    };
    let problem = &prepared.problem;
    let mut ahead = Solves::new(&model, Box::new(|_, _, _| ()));
    let fails = check_identifiability(problem, &mut ahead)
        .is_ok_and(|(mode, seen)| seen.verdict(problem, &mode).0 == Verdict::DoesNot);
    let found = calibrated(options, (&prepared, &model), (patient, &exact), number)?;
    let (posterior, quantities) = match found {
        Ok(found) => found,
        Err(reason) => return Ok(Outcome { fails, found: Err(reason) }),
    };
    let error = |(draws, truth): &(Vec<f64>, f64)| {
        let found = Summary::of(std::slice::from_ref(draws));
        (found.mean - truth) / found.deviation
    };
    let found = Found {
        ranks: ranks(&quantities),
        errors: quantities.iter().map(error).collect(),
        p: posterior.predictive.p_overall,
        contradicted: posterior.predictive.contradicting().next().is_some(),
        left_out: left_out(&posterior),
        seconds: posterior.correction.seconds,
    };
    Ok(Outcome { fails, found: Ok(found) })
}

/// Logarithm of the predictive density of each datum given the others, by smoothed importance weights.
fn left_out(posterior: &Posterior) -> Vec<f64> {
    let draws = posterior.log_likelihood().concat();
    let of = |datum: usize| {
        let ratios: Vec<f64> = draws.iter().map(|draw| -draw[datum]).collect();
        let weights = psis(&ratios, 1.0).log_weights;
        let terms: Vec<f64> = weights.iter().zip(&ratios).map(|(w, ratio)| w - ratio).collect();
        let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        largest + terms.iter().map(|term| (term - largest).exp()).sum::<f64>().ln()
    };
    (0..posterior.problem.data.len()).map(of).collect()
}

fn written(outcomes: &[[Vec<Outcome>; 2]; 2], patients: usize) -> Section {
    const CHECKS: [&str; 6] = [
        "check fails",
        "misfits too large",
        "a datum contradicts",
        "refused",
        "any of these",
        "median p",
    ];
    let quantities: Vec<&str> = NAMES.into_iter().chain(VOLUMES).collect();
    let level = LEVELS[2];
    let [mut coverage, mut errors, mut checks] = [const { Vec::new() }; 3];
    for (truth, of_truth) in outcomes.iter().enumerate() {
        for (model, all) in of_truth.iter().enumerate() {
            let name = format!("truth {}, model {}", SPRINGS[truth], SPRINGS[model]);
            let found: Vec<&Found> =
                all.iter().filter_map(|outcome| outcome.found.as_ref().ok()).collect();
            let each = |of: &dyn Fn(&Found, usize) -> f64| -> Vec<Vec<f64>> {
                let values = |at: usize| found.iter().map(|found| of(found, at)).collect();
                (0..quantities.len()).map(values).collect()
            };
            let shares: Vec<f64> =
                each(&|found, at| found.ranks[at]).iter().map(|ranks| held(ranks, level)).collect();
            coverage.push(row(&name, &quantities, &shares));
            let shifts: Vec<f64> = each(&|found, at| found.errors[at])
                .iter()
                .map(|errors| errors.iter().sum::<f64>() / errors.len() as f64)
                .collect();
            errors.push(row(&name, &quantities, &shifts));
            // In the order of CHECKS; the last is whether any of them speaks.
            let flags = |outcome: &Outcome| {
                let found = outcome.found.as_ref();
                let large = found.is_ok_and(|found| found.p < UNLIKELY);
                let contradicted = found.is_ok_and(|found| found.contradicted);
                let [fails, refused] = [outcome.fails, found.is_err()];
                [fails, large, contradicted, refused, fails || large || contradicted || refused]
            };
            let share = |check: usize| {
                all.iter().filter(|outcome| flags(outcome)[check]).count() as f64 / all.len() as f64
            };
            let p: Vec<f64> = found.iter().map(|found| found.p).collect();
            let numbers: Vec<f64> = (0..5).map(share).chain([quantile(&p, 0.5)]).collect();
            checks.push(row(&name, &CHECKS, &numbers));
        }
    }
    let compared = (0..2).map(|truth| compared(truth, &outcomes[truth])).collect();
    let about = format!(
        "{patients} patients each. Springs of {} kPa/mm along the normal of the epicardium, or none, in the patient (truth) and in the model.",
        STIFFNESS[1]
    );
    let share = format!("Share of {:.0} % intervals that hold the truth", 100.0 * level);
    let blocks = vec![
        Block::Text(about),
        listing(share, "springs", &quantities, coverage),
        listing("Mean error [posterior sd]", "springs", &quantities, errors),
        listing("Share of patients whose data speak against the model", "springs", &CHECKS, checks),
        listing(
            "Both models on the same data by leave-one-out predictive density",
            "springs",
            &COMPARED,
            compared,
        ),
    ];
    Section { name: "springs".into(), title: "Wrong springs".into(), blocks }
}

const COMPARED: [&str; 3] =
    ["right model is better", "by 2 standard errors", "wrong one by 2 standard errors"];

/// Shares in which the leave-one-out predictive density tells the right model from the wrong one, where both have a posterior.
fn compared(truth: usize, models: &[Vec<Outcome>; 2]) -> Vec<Cell> {
    let pairs = models[truth].iter().zip(&models[1 - truth]);
    let gains: Vec<f64> = pairs
        .filter_map(|(right, wrong)| {
            let [right, wrong] = [&right.found, &wrong.found].map(|found| found.as_ref().ok());
            let differences = right?.left_out.iter().zip(&wrong?.left_out).map(|(a, b)| a - b);
            let found = Summary::of(&[differences.collect()]);
            let count = right?.left_out.len() as f64;
            // Sum over its standard error.
            Some(count.sqrt() * found.mean / found.deviation)
        })
        .collect();
    let share = |of: &dyn Fn(f64) -> bool| {
        gains.iter().filter(|gain| of(**gain)).count() as f64 / gains.len() as f64
    };
    let numbers =
        [share(&|gain| gain > 0.0), share(&|gain| gain > 2.0), share(&|gain| gain < -2.0)];
    row(&format!("truth {}", SPRINGS[truth]), &COMPARED, &numbers)
}

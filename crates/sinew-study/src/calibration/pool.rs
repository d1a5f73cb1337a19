//! Ranks of the truth in exact posteriors: draws of the prior, each in turn the truth of noisy data, weigh all others.

use super::options::Options;
use super::patients;
use super::row::row;
use anyhow::{Result, anyhow};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sinew_calibrate::{Datum, Forward};
use sinew_report::{Block, Section};
use sinew_sample::{effective_share, quantile, split_seed, standard_normals};

/// Shapes, and draws of the prior for each.
const SIZE: (u64, usize) = (4, 1000);
const QUICK_SIZE: (u64, usize) = (1, 100);
const STREAM: u64 = 0x504f;
const HEAD: [&str; 4] = ["mean rank", "standard error", "held by 95 %", "median effective draws"];
/// Ways in which a share of noise is read.
const READINGS: [&str; 3] =
    ["3 % of the measured volume", "3 % of the exact volume", "3 % by its logarithm"];

/// Draws of the prior: observables of the data, and of the volume that is ranked.
struct Pool {
    seen: Vec<Vec<f64>>,
    ranked: Vec<f64>,
}

/// Ranks of the volume at 30 mmHg by the way in which 3 % of noise are read.
pub(super) fn section(options: &Options) -> Result<Section> {
    let (shapes, draws) = if options.quick { QUICK_SIZE } else { SIZE };
    let cells = patients::cells(options)?;
    let mut found: [Vec<[f64; 2]>; 3] = Default::default();
    for number in 0..shapes {
        let (patient, _) = patients::random(options.seed, number, cells)?;
        let prepared = patient.file.prepare()?;
        let model = prepared.patient().map_err(|reason| anyhow!(reason))?;
        let named = prepared.reported.iter().find(|seen| seen.name == "volume of endo at top");
        let at = named.ok_or_else(|| anyhow!("no volume at the highest pressure"))?.observable;
        let mut random = ChaCha8Rng::seed_from_u64(split_seed(options.seed, STREAM + number));
        let problem = &prepared.problem;
        let coordinates: Vec<_> =
            (0..draws).map(|_| standard_normals(problem.dimension(), &mut random)).collect();
        let solved = coordinates.par_iter();
        let solved = solved.filter_map(|y| model.observe(&problem.theta(y), false).ok());
        let solved: Vec<_> = solved.collect();
        let of = |values: &[f64]| problem.data.iter().map(|d| values[d.observable]).collect();
        let pool = Pool {
            seen: solved.iter().map(|o| of(&o.values)).collect(),
            ranked: solved.iter().map(|o| o.values[at]).collect(),
        };
        for truth in 0..solved.len() {
            let noise = standard_normals(problem.data.len(), &mut random);
            for (reading, found) in found.iter_mut().enumerate() {
                found.push(pool.rank(&problem.data, truth, &noise, reading));
            }
        }
    }
    let rows = READINGS.iter().zip(&found).map(|(name, found)| {
        let [ranks, effective] = [0, 1].map(|i| found.iter().map(|f| f[i]).collect::<Vec<_>>());
        let count = ranks.len() as f64;
        let mean = ranks.iter().sum::<f64>() / count;
        let variance = ranks.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let held = ranks.iter().filter(|r| (**r - 0.5).abs() <= 0.475).count() as f64 / count;
        row(name, &HEAD, &[mean, (variance / count).sqrt(), held, quantile(&effective, 0.5)])
    });
    let rows = rows.collect();
    let head = ["3 % of noise is"].into_iter().chain(HEAD).map(String::from).collect();
    let title = "Rank of the volume at 30 mmHg in exact posteriors; 0.5 is unbiased";
    let blocks = vec![Block::Listing { title: title.into(), head, rows }];
    Ok(Section { name: "pool".into(), title: "How a share of noise is read".into(), blocks })
}

impl Pool {
    /// Rank of a truth among all others, weighed by its data, and their effective number.
    fn rank(&self, data: &[Datum], truth: usize, noise: &[f64], reading: usize) -> [f64; 2] {
        let exact = &self.seen[truth];
        let is_share = |at: usize| data[at].kind == "volume";
        let height = |seen: &Vec<f64>| {
            let misfit = |at: usize| {
                let (deviation, z) = (if is_share(at) { 0.03 } else { 0.02 }, noise[at]);
                if !is_share(at) {
                    return (exact[at] + deviation * z - seen[at]) / deviation;
                }
                let measured = exact[at] * (1.0 + deviation * z);
                match reading {
                    0 => (measured - seen[at]) / (deviation * measured),
                    1 => (measured - seen[at]) / (deviation * exact[at]),
                    _ => ((exact[at] / seen[at]).ln() + deviation * z) / deviation,
                }
            };
            -0.5 * (0..data.len()).map(|at| misfit(at).powi(2)).sum::<f64>()
        };
        let others: Vec<usize> = (0..self.seen.len()).filter(|other| *other != truth).collect();
        let heights: Vec<f64> = others.iter().map(|other| height(&self.seen[*other])).collect();
        let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (mut below, mut all) = (0.0, 0.0);
        for (other, height) in others.iter().zip(&heights) {
            let weight = (height - most).exp();
            all += weight;
            below += if self.ranked[*other] < self.ranked[truth] { weight } else { 0.0 };
        }
        [below / all, effective_share(&heights) * heights.len() as f64]
    }
}

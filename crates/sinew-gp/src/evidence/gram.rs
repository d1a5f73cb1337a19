//! Covariances of linear functionals: per pair only a table of kernel derivatives is computed.
//!
//! For two points p, q and a part of the prior, K_pq = Σ_{β, β′} a_{p,β} a_{q,β′} ∂^β ∂′^{β′} k; of a
//! stationary kernel the last factor is (−1)^|β′| G_{β+β′} with the derivatives G in the difference.

use crate::Formula;
use crate::kernel::table::lane_sum;
use crate::kernel::{Hermites, MOST_PAIRS, Orders, Request};
use crate::prior::Part;
use crate::prior::coefficients::{PointCoefficients, position};
use sinew_num::vectorised;

/// Entry of a kernel's table that each pair of orders reads.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairPlan<const D: usize> {
    pub entries: Vec<Orders<D>>,
    /// Entry of (β, β′), at `[β · width + β′]`.
    reads: Vec<usize>,
    /// (−1)^|β′| for stationary kernels, else 1.
    signs: Vec<f64>,
}

impl<const D: usize> PairPlan<D> {
    pub(crate) fn new(part: &Part<D>, first: &[[usize; D]], second: &[[usize; D]]) -> Self {
        let (mut entries, mut reads) = (Vec::new(), Vec::new());
        for orders in first.iter().flat_map(|a| second.iter().map(move |b| [*a, *b])) {
            reads.push(position(&mut entries, part.kernel.entry(orders).0));
        }
        let sign = |orders: &[usize; D]| part.kernel.entry([[0; D], *orders]).1;
        let signs = second.iter().map(sign).collect();
        Self { entries, reads, signs }
    }
}

/// Points of a group with the coefficients of the prior at the current parameters.
pub(crate) struct Leg<'a, const D: usize> {
    /// Number of the group.
    pub group: usize,
    pub points: &'a PointCoefficients<D>,
    /// a_β of each part at `[β · points + point]`, with the amplitude in it.
    pub coefficients: Vec<Vec<f64>>,
}

/// One part of the prior between two sets of points.
pub(crate) struct Block<'a, const D: usize> {
    pub kernel: &'a Formula<D>,
    pub hyperparameters: &'a [f64],
    pub plan: &'a PairPlan<D>,
    pub part: usize,
    pub first: &'a Leg<'a, D>,
    pub second: &'a Leg<'a, D>,
}

/// Memory reused from column to column.
#[derive(Default)]
pub(crate) struct Scratch {
    table: Vec<f64>,
    weights: Vec<f64>,
    signed: Vec<f64>,
    /// Cotangents of the coefficients of the column's own point, one for each order.
    pub own: Vec<f64>,
    hermites: Hermites,
}

impl<const D: usize> Block<'_, D> {
    fn request(&self, start: usize, count: usize, column: usize) -> Request<'_, D> {
        Request {
            kernel: self.kernel,
            hyperparameters: self.hyperparameters,
            orders: &self.plan.entries,
            first: self.first.points.axes.each_ref().map(|axis| &axis[start..start + count]),
            second: self.second.points.axes.each_ref().map(|axis| axis[column]),
        }
    }

    /// Coefficients of the first points for one order after the other.
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.first.coefficients[self.part].chunks(self.first.points.count)
    }

    /// Signed coefficients of the second point.
    fn signed(&self, column: usize, signed: &mut Vec<f64>) {
        let coefficients = self.second.coefficients[self.part][column..].iter();
        let coefficients = coefficients.step_by(self.second.points.count);
        signed.clear();
        signed.extend(self.plan.signs.iter().zip(coefficients).map(|(sign, a)| sign * a));
    }

    /// Adds the covariances of the first points from `start` on with second point `column`.
    pub(crate) fn add_column(
        &self,
        start: usize,
        column: usize,
        out: &mut [f64],
        scratch: &mut Scratch,
    ) {
        if self.plan.entries.is_empty() {
            return;
        }
        self.signed(column, &mut scratch.signed);
        for (number, out) in out.chunks_mut(MOST_PAIRS).enumerate() {
            let (start, count) = (start + number * MOST_PAIRS, out.len());
            scratch.table.resize(self.plan.entries.len() * count, 0.0);
            let table = scratch.table.as_mut_slice();
            self.request(start, count, column).derivatives(table, &mut scratch.hermites, 0);
            for (order, row) in self.rows().enumerate() {
                let coefficients = &row[start..start + count];
                let reads = &self.plan.reads[order * scratch.signed.len()..];
                contract(table, reads, &scratch.signed, coefficients, out);
            }
        }
    }

    /// Adds the cotangents of what the column depends on, for the cotangents `weights` of its covariances: to those of the first
    /// points' coefficients, in their layout, and of the logarithms of the kernel's hyperparameters. Those of the column's own point
    /// are left in the memory.
    pub(crate) fn pull_column(
        &self,
        start: usize,
        column: usize,
        weights: &[f64],
        [coefficients, hyperparameters]: [&mut Vec<f64>; 2],
        scratch: &mut Scratch,
    ) {
        let Scratch { table, weights: slopes, signed, own, hermites } = scratch;
        own.clear();
        if self.plan.entries.is_empty() {
            return;
        }
        self.signed(column, signed);
        let width = signed.len();
        own.resize(width, 0.0);
        for (number, weights) in weights.chunks(MOST_PAIRS).enumerate() {
            let (start, count) = (start + number * MOST_PAIRS, weights.len());
            let size = self.plan.entries.len() * count;
            table.resize(size, 0.0);
            slopes.clear();
            slopes.resize(size, 0.0);
            let request = self.request(start, count, column);
            request.derivatives(table, hermites, 1);
            let cotangents = coefficients.chunks_mut(self.first.points.count);
            for (order, (row, cotangent)) in self.rows().zip(cotangents).enumerate() {
                let factors = &row[start..start + count];
                let cotangent = &mut cotangent[start..start + count];
                let reads = &self.plan.reads[order * width..];
                expand(table, reads, signed, factors, weights, cotangent, slopes, own);
            }
            request.pull_back(slopes, hermites, hyperparameters);
        }
        own.iter_mut().zip(&self.plan.signs).for_each(|(own, sign)| *own *= sign);
    }
}

vectorised! {
    /// out += a_β · Σ_β′ s_β′ G for one β.
    fn contract(table: &[f64], reads: &[usize], signed: &[f64], coefficients: &[f64], out: &mut [f64]) {
        let count = out.len();
        let mut sums = [0.0; MOST_PAIRS];
        for (factor, read) in signed.iter().zip(reads) {
            for (sum, entry) in sums[..count].iter_mut().zip(&table[read * count..(read + 1) * count]) {
                *sum += factor * entry;
            }
        }
        for ((out, a), sum) in out.iter_mut().zip(coefficients).zip(&sums) {
            *out += a * sum;
        }
    }

    /// The reverse of [`contract`] for the cotangents `weights` of its result.
    fn expand(
        table: &[f64],
        reads: &[usize],
        signed: &[f64],
        coefficients: &[f64],
        weights: &[f64],
        cotangent: &mut [f64],
        table_cotangent: &mut [f64],
        signed_cotangent: &mut [f64],
    ) {
        let count = weights.len();
        let mut scaled = [0.0; MOST_PAIRS];
        for ((s, w), a) in scaled.iter_mut().zip(weights).zip(coefficients) {
            *s = w * a;
        }
        let mut sums = [0.0; MOST_PAIRS];
        for ((factor, read), slope) in signed.iter().zip(reads).zip(signed_cotangent) {
            let entries = &table[read * count..(read + 1) * count];
            let slopes = &mut table_cotangent[read * count..(read + 1) * count];
            for (((sum, entry), own), scaled) in
                sums.iter_mut().zip(entries).zip(slopes.iter_mut()).zip(&scaled)
            {
                *sum += factor * entry;
                *own += factor * scaled;
            }
            *slope += lane_sum(count, |lane| scaled[lane] * entries[lane]);
        }
        for ((c, w), sum) in cotangent.iter_mut().zip(weights).zip(&sums) {
            *c += w * sum;
        }
    }
}

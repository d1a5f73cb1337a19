//! The fused perceptron on slices: forward and backward pass over tiles of rows.
//!
//! A tile's activations stay in the second-level cache from the gather to the output. Forward
//! tiles are independent; in the backward pass a fixed number of groups of tiles each add up
//! their own parameter gradients, which are then summed in order, so that the result does not
//! depend on the number of threads.

use rayon::prelude::*;

use crate::activation::{self, Activation};
use crate::index::{Gather, GatherPlan, Inverse};
use crate::matrix::{Matrix, multiply};
use crate::normalise::{Normalisation, normalise, pull_back_normalisation};
use crate::pool::Buffer;
use crate::simd::{sum_of, vectorised};

/// Rows of a tile: activations of two layers of 128 then take 128 KiB.
const TILE_ROWS: usize = 128;
/// Groups of tiles with parameter gradients of their own.
const GROUPS: usize = 8;
/// Target rows that one task of the scatter adds up.
const ROWS_PER_TASK: usize = 64;

/// Parameters after the products of the first layer.
#[derive(Clone, Copy)]
pub(crate) struct Parameters<'a> {
    pub activation: Activation,
    pub first_bias: &'a [f32],
    pub second_weight: &'a [f32],
    pub second_bias: &'a [f32],
    pub third_weight: &'a [f32],
    pub third_bias: &'a [f32],
    pub normalisation: Option<Normalisation<'a>>,
}

impl Parameters<'_> {
    fn widths(&self) -> [usize; 3] {
        [self.first_bias.len(), self.second_bias.len(), self.third_bias.len()]
    }
}

/// Activations of all rows, kept from the forward to the backward pass.
#[derive(Debug)]
pub(crate) struct Activations {
    first: Buffer,
    second: Buffer,
    /// Normalised outputs before gain and offset.
    normal: Buffer,
    /// Inverse standard deviation of each row.
    inverse: Buffer,
}

impl Activations {
    fn take(rows: usize, parameters: &Parameters<'_>) -> Self {
        let [first, second, outputs] = parameters.widths();
        let normalised = if parameters.normalisation.is_some() { rows } else { 0 };
        Self {
            first: Buffer::take(rows * first),
            second: Buffer::take(rows * second),
            normal: Buffer::take(normalised * outputs),
            inverse: Buffer::take(normalised),
        }
    }

    fn all(&mut self) -> TileMut<'_> {
        TileMut {
            first: &mut self.first,
            second: &mut self.second,
            normal: &mut self.normal,
            inverse: &mut self.inverse,
        }
    }
}

/// Activations of some consecutive rows.
struct TileMut<'a> {
    first: &'a mut [f32],
    second: &'a mut [f32],
    normal: &'a mut [f32],
    inverse: &'a mut [f32],
}

impl<'a> TileMut<'a> {
    /// Splits after the first `rows` rows.
    fn split(self, rows: usize, parameters: &Parameters<'_>) -> (Self, Self) {
        let [first_width, second_width, outputs] = parameters.widths();
        let normalised = if parameters.normalisation.is_some() { rows } else { 0 };
        let (first, later_first) = self.first.split_at_mut(rows * first_width);
        let (second, later_second) = self.second.split_at_mut(rows * second_width);
        let (normal, later_normal) = self.normal.split_at_mut(normalised * outputs);
        let (inverse, later_inverse) = self.inverse.split_at_mut(normalised);
        (
            Self { first, second, normal, inverse },
            Self {
                first: later_first,
                second: later_second,
                normal: later_normal,
                inverse: later_inverse,
            },
        )
    }
}

/// Outputs `[rows, outputs]`, and the activations if they are to be kept.
pub(crate) fn forward(
    plan: &GatherPlan,
    sources: &[&[f32]],
    parameters: &Parameters<'_>,
    keep: bool,
) -> (Vec<f32>, Option<Activations>) {
    let outputs = parameters.widths()[2];
    let mut output = vec![0.0; plan.rows() * outputs];
    let mut activations = keep.then(|| Activations::take(plan.rows(), parameters));

    let mut tiles = Vec::with_capacity(plan.rows().div_ceil(TILE_ROWS));
    let mut rest = activations.as_mut().map(Activations::all);
    for output in output.chunks_mut(TILE_ROWS * outputs) {
        let (tile, later) = rest.map(|rest| rest.split(output.len() / outputs, parameters)).unzip();
        rest = later;
        tiles.push((output, tile));
    }
    tiles.into_par_iter().enumerate().for_each(|(number, (output, tile))| {
        let start = number * TILE_ROWS;
        match tile {
            Some(mut tile) => forward_tile(plan, sources, parameters, start, &mut tile, output),
            None => {
                let mut scratch = Activations::take(output.len() / outputs, parameters);
                forward_tile(plan, sources, parameters, start, &mut scratch.all(), output);
            }
        }
    });
    (output, activations)
}

fn forward_tile(
    plan: &GatherPlan,
    sources: &[&[f32]],
    parameters: &Parameters<'_>,
    start: usize,
    tile: &mut TileMut<'_>,
    output: &mut [f32],
) {
    hidden_layers(plan, sources, parameters, start, tile);
    last_layer(parameters, tile, output);
}

fn hidden_layers(
    plan: &GatherPlan,
    sources: &[&[f32]],
    parameters: &Parameters<'_>,
    start: usize,
    tile: &mut TileMut<'_>,
) {
    let [first, second, _] = parameters.widths();
    let activation = parameters.activation;
    gather_and_activate(
        activation,
        parameters.first_bias,
        plan.sources(),
        sources,
        start,
        tile.first,
    );
    let weight = Matrix::new(parameters.second_weight, second);
    multiply(tile.second, 0.0, 1.0, Matrix::new(tile.first, first), weight);
    activation::add_bias_and_activate(activation, parameters.second_bias, tile.second);
}

fn last_layer(parameters: &Parameters<'_>, tile: &mut TileMut<'_>, output: &mut [f32]) {
    let [_, second, outputs] = parameters.widths();
    if outputs == 1 {
        single_output(parameters.third_weight, tile.second, output);
    } else {
        let weight = Matrix::new(parameters.third_weight, outputs);
        multiply(output, 0.0, 1.0, Matrix::new(tile.second, second), weight);
    }
    add_to_rows(parameters.third_bias, output);
    if let Some(normalisation) = parameters.normalisation {
        normalise(normalisation, output, tile.normal, tile.inverse);
    }
}

/// Gradients of a scalar with respect to sources and parameters, in the order of the operation.
pub(crate) struct Gradients {
    /// Of those sources that were asked for.
    pub sources: Vec<Option<Vec<f32>>>,
    /// First bias, second weight and bias, third weight and bias, gain and offset.
    pub parameters: [Vec<f32>; 7],
}

/// Pulls `cotangent` `[rows, outputs]` back; activations not kept are computed again.
pub(crate) fn backward(
    plan: &GatherPlan,
    sources: &[&[f32]],
    parameters: &Parameters<'_>,
    activations: Option<&Activations>,
    cotangent: &[f32],
    needed: &[bool],
) -> Gradients {
    let [width, _, outputs] = parameters.widths();
    let sizes = sizes(plan, parameters, needed);
    let row_wise = |gather: &Gather| matches!(gather, Gather::Identity | Gather::Indexed { .. });
    let needs_rows =
        plan.sources().iter().zip(needed).any(|(gather, needed)| *needed && row_wise(gather));
    let mut row_gradients = vec![0.0; if needs_rows { plan.rows() * width } else { 0 }];

    let group_rows = TILE_ROWS * plan.rows().div_ceil(TILE_ROWS).div_ceil(GROUPS).max(1);
    let mut groups = Vec::with_capacity(GROUPS);
    let mut rest = row_gradients.as_mut_slice();
    for cotangent in cotangent.chunks(group_rows * outputs) {
        let taken = if needs_rows { cotangent.len() / outputs * width } else { 0 };
        let (here, later) = rest.split_at_mut(taken);
        rest = later;
        groups.push((cotangent, here));
    }
    let partial: Vec<Buffer> = groups
        .into_par_iter()
        .enumerate()
        .map(|(number, (cotangent, row_gradients))| {
            let mut sums = Buffer::zeros(sizes.iter().sum());
            let mut pass = BackwardPass {
                plan,
                sources,
                parameters,
                activations,
                sums: split(&mut sums, &sizes),
            };
            pass.group(number * group_rows, cotangent, row_gradients);
            sums
        })
        .collect();

    let mut totals = total(&partial, &sizes);
    let pooled = totals.split_off(PARAMETERS);
    Gradients {
        sources: source_gradients(plan, needed, row_gradients, pooled, width),
        parameters: totals
            .try_into()
            .unwrap_or_else(|_| unreachable!("split off after the parameters")),
    }
}

/// Parameter tensors of [`Gradients::parameters`].
const PARAMETERS: usize = 7;

/// Sizes of the gradients that groups add up: of the parameters, and of sources few of whose
/// rows serve many.
fn sizes(plan: &GatherPlan, parameters: &Parameters<'_>, needed: &[bool]) -> Vec<usize> {
    let [first, second, outputs] = parameters.widths();
    let normalised = if parameters.normalisation.is_some() { outputs } else { 0 };
    let mut sizes =
        vec![first, first * second, second, second * outputs, outputs, normalised, normalised];
    for ((gather, rows), needed) in plan.sources().iter().zip(plan.source_rows()).zip(needed) {
        let pooled = *needed && matches!(gather, Gather::Cyclic { .. } | Gather::Repeated { .. });
        sizes.push(if pooled { rows * first } else { 0 });
    }
    sizes
}

fn split<'a>(mut values: &'a mut [f32], sizes: &[usize]) -> Vec<&'a mut [f32]> {
    let mut parts = Vec::with_capacity(sizes.len());
    for &size in sizes {
        let (part, rest) = values.split_at_mut(size);
        parts.push(part);
        values = rest;
    }
    parts
}

/// Sums over the groups, in their order.
fn total(partial: &[Buffer], sizes: &[usize]) -> Vec<Vec<f32>> {
    let starts: Vec<usize> = sizes
        .iter()
        .scan(0, |start, size| {
            *start += size;
            Some(*start - size)
        })
        .collect();
    let sum = |(&start, &size): (&usize, &usize)| {
        let mut sum = vec![0.0; size];
        for group in partial {
            add_into(&mut sum, &group[start..start + size]);
        }
        sum
    };
    starts.par_iter().zip(sizes).map(sum).collect()
}

struct BackwardPass<'a> {
    plan: &'a GatherPlan,
    sources: &'a [&'a [f32]],
    parameters: &'a Parameters<'a>,
    activations: Option<&'a Activations>,
    sums: Vec<&'a mut [f32]>,
}

impl BackwardPass<'_> {
    /// Adds up the gradients of the rows from `start` on; `row_gradients` is empty or takes
    /// those of the first layer's sums.
    fn group(&mut self, start: usize, cotangent: &[f32], row_gradients: &mut [f32]) {
        let [first, second, outputs] = self.parameters.widths();
        let mut recomputed = match self.activations {
            Some(_) => None,
            None => Some(Activations::take(TILE_ROWS, self.parameters)),
        };
        let mut scratch = Buffer::take(TILE_ROWS * (first + second + outputs));
        for (number, cotangent) in cotangent.chunks(TILE_ROWS * outputs).enumerate() {
            let rows = cotangent.len() / outputs;
            let (offset, here) = (number * TILE_ROWS, start + number * TILE_ROWS);
            let tile = match (&self.activations, &mut recomputed) {
                (Some(kept), _) => Tile::new(kept, here, rows, self.parameters),
                (None, Some(scratch)) => self.recompute(scratch, here, rows),
                (None, None) => unreachable!("taken above"),
            };
            let (d_output, d_hidden) = scratch.split_at_mut(TILE_ROWS * outputs);
            let (d_second, d_first) = d_hidden.split_at_mut(TILE_ROWS * second);
            let d_first = match row_gradients.is_empty() {
                true => &mut d_first[..rows * first],
                false => &mut row_gradients[offset * first..(offset + rows) * first],
            };
            self.last_layer(
                &tile,
                cotangent,
                &mut d_output[..rows * outputs],
                &mut d_second[..rows * second],
            );
            self.second_layer(&tile, &d_second[..rows * second], d_first);
            self.pooled_sources(here, d_first);
        }
    }

    fn recompute<'s>(&self, scratch: &'s mut Activations, start: usize, rows: usize) -> Tile<'s> {
        let mut tile = scratch.all().split(rows, self.parameters).0;
        hidden_layers(self.plan, self.sources, self.parameters, start, &mut tile);
        if self.parameters.normalisation.is_some() {
            let mut output = Buffer::take(rows * self.parameters.third_bias.len());
            last_layer(self.parameters, &mut tile, &mut output);
        }
        Tile::new(scratch, 0, rows, self.parameters)
    }

    fn last_layer(
        &mut self,
        tile: &Tile<'_>,
        cotangent: &[f32],
        d_output: &mut [f32],
        d_second: &mut [f32],
    ) {
        let p = self.parameters;
        let [_, second, outputs] = p.widths();
        let [_, _, d_second_bias, d_weight, d_bias, d_gain, d_offset, ..] = &mut self.sums[..]
        else {
            unreachable!("one sum per parameter")
        };
        let d_output = match p.normalisation {
            Some(Normalisation { gain, .. }) => {
                let (normal, inverse) = (tile.normal, tile.inverse);
                pull_back_normalisation(
                    gain, normal, inverse, cotangent, d_output, d_gain, d_offset,
                );
                &*d_output
            }
            None => cotangent,
        };
        add_rows_into(d_bias, d_output);
        if outputs == 1 {
            activation::pull_back_single_output(
                p.activation,
                tile.second,
                d_output,
                p.third_weight,
                d_second,
                d_second_bias,
                d_weight,
            );
        } else {
            let (hidden, d_output) =
                (Matrix::new(tile.second, second), Matrix::new(d_output, outputs));
            multiply(d_weight, 1.0, 1.0, hidden.transposed(), d_output);
            multiply(
                d_second,
                0.0,
                1.0,
                d_output,
                Matrix::new(p.third_weight, outputs).transposed(),
            );
            activation::pull_back_rows(p.activation, tile.second, d_second, d_second_bias);
        }
    }

    fn second_layer(&mut self, tile: &Tile<'_>, d_second: &[f32], d_first: &mut [f32]) {
        let p = self.parameters;
        let [first, second, _] = p.widths();
        let [d_bias, d_weight, ..] = &mut self.sums[..] else {
            unreachable!("one sum per parameter")
        };
        let d_second = Matrix::new(d_second, second);
        multiply(d_weight, 1.0, 1.0, Matrix::new(tile.first, first).transposed(), d_second);
        multiply(d_first, 0.0, 1.0, d_second, Matrix::new(p.second_weight, second).transposed());
        activation::pull_back_rows(p.activation, tile.first, d_first, d_bias);
    }

    fn pooled_sources(&mut self, start: usize, d_first: &[f32]) {
        let width = self.parameters.first_bias.len();
        for (gather, sums) in self.plan.sources().iter().zip(&mut self.sums[PARAMETERS..]) {
            if !sums.is_empty() {
                add_gathered_rows(gather, start, width, d_first, sums);
            }
        }
    }
}

/// Activations of some consecutive rows, to read.
struct Tile<'a> {
    first: &'a [f32],
    second: &'a [f32],
    normal: &'a [f32],
    inverse: &'a [f32],
}

impl<'a> Tile<'a> {
    fn new(all: &'a Activations, start: usize, rows: usize, parameters: &Parameters<'_>) -> Self {
        let [first, second, outputs] = parameters.widths();
        let (from, to) = match parameters.normalisation {
            Some(_) => (start, start + rows),
            None => (0, 0),
        };
        Self {
            first: &all.first[start * first..(start + rows) * first],
            second: &all.second[start * second..(start + rows) * second],
            normal: &all.normal[from * outputs..to * outputs],
            inverse: &all.inverse[from..to],
        }
    }
}

/// Distributes the gradients of the first layer's sums to the sources that were asked for.
fn source_gradients(
    plan: &GatherPlan,
    needed: &[bool],
    rows: Vec<f32>,
    pooled: Vec<Vec<f32>>,
    width: usize,
) -> Vec<Option<Vec<f32>>> {
    let mut gradients: Vec<Option<Vec<f32>>> = plan
        .sources()
        .iter()
        .zip(needed)
        .zip(pooled)
        .map(|((gather, needed), pooled)| match gather {
            _ if !needed => None,
            Gather::Identity => None,
            Gather::Cyclic { .. } | Gather::Repeated { .. } => Some(pooled),
            Gather::Indexed { inverse, .. } => Some(add_up(&rows, inverse, width)),
        })
        .collect();
    let identities: Vec<usize> = (0..gradients.len())
        .filter(|&k| needed[k] && matches!(plan.sources()[k], Gather::Identity))
        .collect();
    if let Some((last, others)) = identities.split_last() {
        for &other in others {
            gradients[other] = Some(rows.clone());
        }
        gradients[*last] = Some(rows);
    }
    gradients
}

/// Sums of those `rows` that each target is referred to by.
fn add_up(rows: &[f32], inverse: &Inverse, width: usize) -> Vec<f32> {
    let mut sums = vec![0.0; inverse.targets() * width];
    sums.par_chunks_mut(ROWS_PER_TASK * width).enumerate().for_each(|(task, sums)| {
        add_up_targets(rows, inverse, task * ROWS_PER_TASK, width, sums);
    });
    sums
}

vectorised! {
    fn add_up_targets<FUSED>(rows: &[f32], inverse: &Inverse, start: usize, width: usize, sums: &mut [f32]) {
        for (offset, sum) in sums.chunks_exact_mut(width).enumerate() {
            for &row in inverse.of(start + offset) {
                for (sum, value) in sum.iter_mut().zip(&rows[row as usize * width..][..width]) {
                    *sum += value;
                }
            }
        }
    }
}

vectorised! {
    /// `x = f(bias + Σ_k source_k[index_k[row]])` for consecutive rows from `start` on.
    fn gather_and_activate<FUSED>(
        activation: Activation,
        bias: &[f32],
        gathers: &[Gather],
        sources: &[&[f32]],
        start: usize,
        x: &mut [f32],
    ) {
        let width = bias.len();
        for (offset, x) in x.chunks_exact_mut(width).enumerate() {
            x.copy_from_slice(bias);
            for (gather, source) in gathers.iter().zip(sources) {
                let source = &source[gather.source(start + offset) * width..][..width];
                for (x, value) in x.iter_mut().zip(source) {
                    *x += value;
                }
            }
        }
        activation::activate_in_place::<FUSED>(activation, x);
    }
}

vectorised! {
    /// Adds `rows`, from row `start` on, to the rows of the source they were gathered from.
    fn add_gathered_rows<FUSED>(gather: &Gather, start: usize, width: usize, rows: &[f32], sums: &mut [f32]) {
        for (offset, row) in rows.chunks_exact(width).enumerate() {
            let sum = &mut sums[gather.source(start + offset) * width..][..width];
            for (sum, value) in sum.iter_mut().zip(row) {
                *sum += value;
            }
        }
    }
}

vectorised! {
    /// Products of the rows of `hidden` with the one column of a last layer.
    fn single_output<FUSED>(weight: &[f32], hidden: &[f32], output: &mut [f32]) {
        for (row, output) in hidden.chunks_exact(weight.len()).zip(output) {
            *output = sum_of::<32>(weight.len(), |j| row[j] * weight[j]);
        }
    }
}

vectorised! {
    fn add_to_rows<FUSED>(bias: &[f32], rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(bias.len()) {
            for (x, b) in row.iter_mut().zip(bias) {
                *x += b;
            }
        }
    }
}

vectorised! {
    fn add_rows_into<FUSED>(sum: &mut [f32], rows: &[f32]) {
        for row in rows.chunks_exact(sum.len()) {
            for (sum, x) in sum.iter_mut().zip(row) {
                *sum += x;
            }
        }
    }
}

vectorised! {
    fn add_into<FUSED>(sum: &mut [f32], values: &[f32]) {
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value;
        }
    }
}

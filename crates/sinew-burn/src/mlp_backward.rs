//! The fused perceptron on slices: backward pass.
//!
//! A fixed number of groups of tiles each add up their own parameter gradients, which are then
//! summed in order, so that the result does not depend on the number of threads.

use rayon::prelude::*;

use crate::activation::{pull_back_rows, pull_back_single_output};
use crate::index::{Gather, GatherPlan};
use crate::matrix::{Matrix, multiply};
use crate::mlp_kernel::{Activations, Parameters, TILE_ROWS, Tile, hidden_layers, last_layer};
use crate::normalise::{Normalisation, pull_back_normalisation};
use crate::pool::Buffer;
use crate::rows::{add_gathered_rows, add_into, add_rows_into, add_up};

/// Groups of tiles with parameter gradients of their own.
const GROUPS: usize = 8;

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
            pull_back_single_output(
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
            pull_back_rows(p.activation, tile.second, d_second, d_second_bias);
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
        pull_back_rows(p.activation, tile.first, d_first, d_bias);
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

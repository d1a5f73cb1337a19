//! The fused perceptron on slices: backward pass.
//!
//! A fixed number of groups of tiles each add up their own parameter gradients, which are then
//! summed in order, so that the result does not depend on the number of threads.

use crate::fused::activation::{pull_back_rows, pull_back_single_output};
use crate::fused::host::Cotangents;
use crate::fused::index::{Gather, GatherPlan};
use crate::fused::mlp_kernel::{
    Activations, FirstLayer, Parameters, Source, multiply_in_parallel, second_layer, split_off,
    tile_rows,
};
use crate::fused::moments::transposed;
use crate::fused::normalise::{Normalisation, pull_back_normalisation};
use crate::fused::pool::{Buffer, LINE};
use crate::fused::product::{Panels, Start, add_transposed_product, multiply};
use crate::fused::rows::{add_gathered_rows, add_into, add_rows_into, add_up};
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// Most groups of tiles with parameter gradients of their own.
const GROUPS: usize = 8;
/// Numbers of the gradients that one task sums over the groups.
const NUMBERS_PER_TASK: usize = 1 << 12;
/// Tiles from which on there are so many; fewer tiles make half the groups.
const TILES_FOR_ALL_GROUPS: usize = 64;

/// Pulls `cotangent` `[rows, outputs]` back to the inputs that need a gradient and to the parameters: first weight and bias,
/// second, third; gain and offset. Hidden layers not kept are computed again.
pub(crate) fn backward(
    plan: &GatherPlan,
    sources: &[Source<'_>],
    parameters: &Parameters<'_>,
    activations: &Activations,
    cotangent: &[f32],
    needed: &[bool],
) -> Cotangents {
    let [hidden, second, outputs] = parameters.widths();
    let recomputed = activations.second.is_empty();
    let pass = Pass {
        plan,
        sources,
        parameters,
        activations,
        cotangent,
        needed,
        layer: FirstLayer::new(sources, &activations.products, parameters),
        second_weight: recomputed.then(|| Panels::new(parameters.weights[1], second)),
        second_transposed: Panels::transposed(parameters.weights[1], second),
        third_transposed: Panels::transposed(parameters.weights[2], outputs),
    };
    let sizes = pass.sizes();
    let mut d_first = Buffer::take(if pass.keeps_rows() { plan.rows * hidden } else { 0 });
    let mut rest = &mut d_first[..];
    let with_rest = |rows: Range<usize>| (rows.clone(), split_off(&mut rest, rows.len() * hidden));
    let groups: Vec<_> = pass.groups().into_iter().map(with_rest).collect();
    let length = sizes.iter().map(|size| size.next_multiple_of(LINE)).sum();
    let group = |(rows, d_first)| {
        let mut sums = Buffer::zeros(length);
        pass.group(rows, &mut split(&mut sums, &sizes), d_first);
        sums
    };
    let mut partial: Vec<Buffer> = groups.into_par_iter().map(group).collect();
    let mut sums = if partial.is_empty() { Buffer::zeros(length) } else { partial.remove(0) };
    sums.par_chunks_mut(NUMBERS_PER_TASK).enumerate().for_each(|(task, sums)| {
        let groups = partial.iter().map(|group| &group[task * NUMBERS_PER_TASK..]);
        groups.for_each(|group| add_into(sums, group));
    });
    let totals = split(&mut sums, &sizes).into_iter();
    let mut totals: Vec<Vec<f32>> = totals.map(|part| part.to_vec()).collect();
    let of_sources = totals.split_off(TAIL);
    pass.gradients(totals, of_sources, &d_first)
}

/// Gradients a group adds up besides those of sources: first bias, second weight and bias, third
/// weight (transposed) and bias, gain and offset.
const TAIL: usize = 7;

struct Pass<'a> {
    plan: &'a GatherPlan,
    sources: &'a [Source<'a>],
    parameters: &'a Parameters<'a>,
    activations: &'a Activations,
    cotangent: &'a [f32],
    needed: &'a [bool],
    layer: FirstLayer<'a>,
    /// Recomputes a second layer that was not kept.
    second_weight: Option<Panels>,
    second_transposed: Panels,
    third_transposed: Panels,
}

/// Parts of these sizes, each from the start of a cache line on.
fn split<'a>(values: &'a mut [f32], sizes: &[usize]) -> Vec<&'a mut [f32]> {
    let mut rest = values;
    let part = |&size: &usize| &mut split_off(&mut rest, size.next_multiple_of(LINE))[..size];
    sizes.iter().map(part).collect()
}

impl Pass<'_> {
    /// Whether gradients of the sums in the first layer are kept row by row: where a source is gathered by index, or its rows, each of
    /// which serves one row of the result, need a gradient.
    fn keeps_rows(&self) -> bool {
        self.sources.iter().zip(self.needed).any(|(source, needed)| match source.gather {
            Gather::Identity => *needed,
            Gather::Indexed(_) => true,
            Gather::Cyclic { .. } | Gather::Repeated { .. } => false,
        })
    }

    /// Rows of every group: whole tiles, as even as they come.
    fn groups(&self) -> Vec<Range<usize>> {
        let rows = self.plan.rows;
        let tile = tile_rows(rows);
        let tiles = rows.div_ceil(tile);
        let groups = if tiles < TILES_FOR_ALL_GROUPS { GROUPS / 2 } else { GROUPS }.min(tiles);
        let bound = |group: usize| (group * tiles / groups.max(1) * tile).min(rows);
        (0..groups).map(|group| bound(group)..bound(group + 1)).collect()
    }

    /// Sizes of the gradients a group adds up: [`TAIL`], then per source the weight's if it is
    /// multiplied in tiles, or its rows' if few of them serve many.
    fn sizes(&self) -> Vec<usize> {
        let [first, second, outputs] = self.parameters.widths();
        let normalised = if self.parameters.normalisation.is_some() { outputs } else { 0 };
        let mut sizes =
            vec![first, first * second, second, second * outputs, outputs, normalised, normalised];
        let of_source = |source: &Source<'_>| match source.gather {
            Gather::Identity if source.first_row.is_some() => source.width * first,
            Gather::Identity | Gather::Indexed(_) => 0,
            _ => source.values.len() / source.width.max(1) * first,
        };
        sizes.extend(self.sources.iter().map(of_source));
        sizes
    }

    /// Adds up the gradients of a group, and writes those of its sums in the first layer where they are kept.
    fn group(&self, rows: Range<usize>, sums: &mut [&mut [f32]], kept: &mut [f32]) {
        let [first, second, outputs] = self.parameters.widths();
        let tile = tile_rows(self.plan.rows);
        let [mut first_again, mut second_again, mut d_output, mut d_second, mut d_first] =
            [first, second, outputs, second, first].map(|width| Buffer::take(tile * width));
        for start in rows.clone().step_by(tile) {
            let here = start..(start + tile).min(rows.end);
            let (count, offset) = (here.len(), start - rows.start);
            let d_first = match kept.is_empty() {
                true => &mut d_first[..count * first],
                false => &mut kept[offset * first..(offset + count) * first],
            };
            // Rows that no output depends on, as the last messages between nodes that are not decoded.
            let cotangent = &self.cotangent[here.start * outputs..here.end * outputs];
            if cotangent.iter().all(|c| *c == 0.0) {
                d_first.fill(0.0);
                continue;
            }
            let hidden_first = self.first_hidden(&here, &mut first_again[..count * first]);
            let hidden_second =
                self.second_hidden(&here, hidden_first, &mut second_again[..count * second]);
            let d_second = &mut d_second[..count * second];
            self.last_layer(&here, hidden_second, sums, &mut d_output[..count * outputs], d_second);
            self.second_layer(hidden_first, sums, d_second, d_first);
            self.sources(&here, d_first, &mut sums[TAIL..]);
        }
    }

    fn first_hidden<'s>(&'s self, rows: &Range<usize>, scratch: &'s mut [f32]) -> &'s [f32] {
        let width = self.parameters.biases[0].len();
        if self.activations.first.is_empty() {
            self.layer.evaluate(self.parameters, rows.start, scratch);
            return scratch;
        }
        &self.activations.first[rows.start * width..rows.end * width]
    }

    fn second_hidden<'s>(
        &'s self,
        rows: &Range<usize>,
        first: &[f32],
        scratch: &'s mut [f32],
    ) -> &'s [f32] {
        let width = self.parameters.biases[1].len();
        if let Some(weight) = &self.second_weight {
            second_layer(self.parameters, weight, first, scratch);
            return scratch;
        }
        &self.activations.second[rows.start * width..rows.end * width]
    }

    fn last_layer(
        &self,
        rows: &Range<usize>,
        hidden: &[f32],
        sums: &mut [&mut [f32]],
        d_output: &mut [f32],
        d_second: &mut [f32],
    ) {
        let p = self.parameters;
        let outputs = p.biases[2].len();
        let [_, _, d_second_bias, d_weight, d_bias, d_gain, d_offset, ..] = sums else {
            unreachable!("one sum per parameter")
        };
        let cotangent = &self.cotangent[rows.start * outputs..rows.end * outputs];
        let mut d_rows = cotangent;
        if let Some(Normalisation { gain, .. }) = p.normalisation {
            let normal = &self.activations.normal[rows.start * outputs..rows.end * outputs];
            let inverse = &self.activations.inverse[rows.clone()];
            pull_back_normalisation(gain, normal, inverse, cotangent, d_output, d_gain, d_offset);
            d_rows = d_output;
        }
        add_rows_into(d_bias, d_rows);
        if outputs == 1 {
            let (f, weight) = (p.activation, p.weights[2]);
            pull_back_single_output(f, hidden, d_rows, weight, d_second, d_second_bias, d_weight);
        } else {
            // Transposed: the wider dimension is the one vectorised.
            add_transposed_product(d_rows, outputs, hidden, d_weight);
            multiply(d_rows, &self.third_transposed, Start::Zero, d_second);
            pull_back_rows(p.activation, hidden, d_second, d_second_bias);
        }
    }

    fn second_layer(
        &self,
        hidden: &[f32],
        sums: &mut [&mut [f32]],
        d_second: &[f32],
        d_first: &mut [f32],
    ) {
        let [d_bias, d_weight, ..] = sums else { unreachable!("one sum per parameter") };
        add_transposed_product(hidden, self.parameters.biases[0].len(), d_second, d_weight);
        multiply(d_second, &self.second_transposed, Start::Zero, d_first);
        pull_back_rows(self.parameters.activation, hidden, d_first, d_bias);
    }

    /// Gradients of the sources' weights and rows, as far as a tile knows them.
    fn sources(&self, rows: &Range<usize>, d_first: &[f32], sums: &mut [&mut [f32]]) {
        let hidden = self.parameters.biases[0].len();
        for (source, sum) in self.sources.iter().zip(sums).filter(|(_, sum)| !sum.is_empty()) {
            match source.gather {
                Gather::Identity => {
                    let values = &source.values[rows.start * source.width..rows.end * source.width];
                    add_transposed_product(values, source.width, d_first, sum);
                }
                gather => add_gathered_rows(gather, rows.start, hidden, d_first, sum),
            }
        }
    }

    /// Puts the gradients together; `d_first` are those of the sums in the first layer.
    fn gradients(
        &self,
        mut tail: Vec<Vec<f32>>,
        of_sources: Vec<Vec<f32>>,
        d_first: &[f32],
    ) -> Cotangents {
        let hidden = self.parameters.biases[0].len();
        let mut first_weight = vec![0.0; self.parameters.weights[0].len()];
        let mut gradients = Vec::with_capacity(self.sources.len() + 1 + TAIL);
        for ((source, needed), sum) in self.sources.iter().zip(self.needed).zip(of_sources) {
            let product = match source.gather {
                Gather::Identity => Cow::Borrowed(d_first),
                Gather::Indexed(index) => {
                    let mut product = vec![0.0; index.inverse.len() * hidden];
                    add_up(d_first, &index.inverse, 1.0, hidden, &mut product);
                    product.into()
                }
                _ => Cow::Borrowed(&sum[..]),
            };
            if let Some(row) = source.first_row {
                let of_weight = &mut first_weight[row * hidden..(row + source.width) * hidden];
                match source.gather {
                    Gather::Identity => add_into(of_weight, &sum),
                    _ => add_transposed_product(source.values, source.width, &product, of_weight),
                }
            }
            gradients.push(needed.then(|| {
                if source.first_row.is_none() {
                    return product.into_owned();
                }
                let mut input = vec![0.0; source.values.len()];
                let weight = Panels::transposed(source.weight(self.parameters), hidden);
                multiply_in_parallel(&product, &weight, &mut input);
                input
            }));
        }
        /// Place of the third weight, which is added up transposed.
        const THIRD_WEIGHT: usize = 3;
        tail[THIRD_WEIGHT] = transposed(&tail[THIRD_WEIGHT], self.parameters.widths()[1]);
        gradients.extend([first_weight].into_iter().chain(tail).map(Some));
        gradients
    }
}

//! The fused perceptron on slices: backward pass.
//!
//! A fixed number of groups of tiles each add up their own parameter gradients, which are then
//! summed in order, so that the result does not depend on the number of threads.

use crate::fused::activation::{pull_back_rows, pull_back_single_output};
use crate::fused::index::{Gather, GatherPlan};
use crate::fused::mlp_kernel::{
    Activations, FirstLayer, Parameters, Source, multiply_in_parallel, second_layer, split_off,
    tile_rows,
};
use crate::fused::normalise::{Normalisation, pull_back_normalisation};
use crate::fused::orthogonalise::transposed;
use crate::fused::pool::{Buffer, LINE};
use crate::fused::product::{Panels, Start, add_transposed_product, multiply};
use crate::fused::rows::{add_gathered_rows, add_into, add_rows_into, add_up};
use rayon::prelude::*;
use std::ops::Range;

/// Most groups of tiles with parameter gradients of their own.
const GROUPS: usize = 8;
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
) -> Vec<Option<Vec<f32>>> {
    let [first, second, outputs] = parameters.widths();
    let transposed = |(source, needed): (&Source<'_>, &bool)| {
        (*needed && source.is_multiplied_in_tiles())
            .then(|| Panels::transposed(source.weight(parameters), first))
    };
    let recomputed = activations.second.is_empty();
    let pass = Pass {
        plan,
        sources,
        parameters,
        activations,
        cotangent,
        needed,
        layer: FirstLayer::new(sources, &activations.products, parameters),
        second_weight: recomputed.then(|| Panels::new(parameters.second_weight, second)),
        first_transposed: sources.iter().zip(needed).map(transposed).collect(),
        second_transposed: Panels::transposed(parameters.second_weight, second),
        third_transposed: Panels::transposed(parameters.third_weight, outputs),
    };
    let sizes = pass.sizes();
    let mut row_gradients = RowGradients::new(&pass);
    let partial: Vec<Buffer> = pass
        .groups()
        .into_iter()
        .zip(row_gradients.split(&pass))
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(rows, row_gradients)| {
            let mut sums =
                Buffer::zeros(sizes.iter().map(|size| size.next_multiple_of(LINE)).sum());
            pass.group(rows, &mut split(&mut sums, &sizes), row_gradients);
            sums
        })
        .collect();
    let mut totals = total(&partial, &sizes);
    let of_sources = totals.split_off(TAIL);
    pass.gradients(totals, of_sources, row_gradients)
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
    /// Transposed weights of sources multiplied in tiles that need gradients.
    first_transposed: Vec<Option<Panels>>,
    second_transposed: Panels,
    third_transposed: Panels,
}

/// Gradients per row of the result, filled by all groups.
struct RowGradients {
    /// Gradients of the sums in the first layer, where a source is gathered by index.
    first: Buffer,
    /// Gradients of the inputs that are read row by row.
    inputs: Vec<Vec<f32>>,
}

/// The rows of one group in [`RowGradients`].
struct GroupRows<'a> {
    first: &'a mut [f32],
    inputs: Vec<&'a mut [f32]>,
}

impl RowGradients {
    fn new(pass: &Pass<'_>) -> Self {
        let (rows, hidden) = (pass.plan.rows, pass.parameters.first_bias.len());
        let indexed = |(source, needed): (&Source<'_>, &bool)| {
            matches!(source.gather, Gather::Indexed { .. }) && pass.has_gradient(source, *needed)
        };
        let any = pass.sources.iter().zip(pass.needed).any(indexed);
        let input = |(source, needed): (&Source<'_>, &bool)| {
            let read_row_by_row = *needed && matches!(source.gather, Gather::Identity);
            vec![0.0; if read_row_by_row { source.values.len() } else { 0 }]
        };
        Self {
            first: Buffer::take(if any { rows * hidden } else { 0 }),
            inputs: pass.sources.iter().zip(pass.needed).map(input).collect(),
        }
    }

    fn split<'s>(&'s mut self, pass: &Pass<'_>) -> Vec<GroupRows<'s>> {
        let hidden = pass.parameters.first_bias.len();
        let mut first = &mut self.first[..];
        let mut inputs: Vec<&mut [f32]> = self.inputs.iter_mut().map(|x| &mut x[..]).collect();
        let groups = pass.groups().into_iter().map(|rows| GroupRows {
            first: split_off(&mut first, rows.len() * hidden),
            inputs: inputs
                .iter_mut()
                .zip(pass.sources)
                .map(|(rest, source)| split_off(rest, rows.len() * source.width))
                .collect(),
        });
        groups.collect()
    }
}

/// Parts of these sizes, each from the start of a cache line on.
fn split<'a>(values: &'a mut [f32], sizes: &[usize]) -> Vec<&'a mut [f32]> {
    let mut rest = values;
    let part = |&size: &usize| &mut split_off(&mut rest, size.next_multiple_of(LINE))[..size];
    sizes.iter().map(part).collect()
}

/// Sums over the groups, in their order.
fn total(partial: &[Buffer], sizes: &[usize]) -> Vec<Vec<f32>> {
    let mut start = 0;
    let ranges: Vec<Range<usize>> = sizes
        .iter()
        .map(|size| {
            let range = start..start + size;
            start += size.next_multiple_of(LINE);
            range
        })
        .collect();
    let sum = |range: &Range<usize>| match partial.split_first() {
        None => vec![0.0; range.len()],
        Some((first, others)) => {
            let mut sum = first[range.clone()].to_vec();
            for group in others {
                add_into(&mut sum, &group[range.clone()]);
            }
            sum
        }
    };
    ranges.par_iter().map(sum).collect()
}

impl Pass<'_> {
    /// Whether the gradient of a source's product is of use.
    fn has_gradient(&self, source: &Source<'_>, needed: bool) -> bool {
        needed || source.first_row.is_some()
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
        for (source, needed) in self.sources.iter().zip(self.needed) {
            sizes.push(match source.gather {
                Gather::Identity if source.first_row.is_some() => source.width * first,
                Gather::Cyclic { .. } | Gather::Repeated { .. }
                    if self.has_gradient(source, *needed) =>
                {
                    source.values.len() / source.width.max(1) * first
                }
                _ => 0,
            });
        }
        sizes
    }

    /// Adds up the gradients of a group.
    fn group(&self, rows: Range<usize>, sums: &mut [&mut [f32]], mut to: GroupRows<'_>) {
        let [first, second, outputs] = self.parameters.widths();
        let tile = tile_rows(self.plan.rows);
        let scratch = |width: usize| Buffer::take(tile * width);
        let (mut first_again, mut second_again) = (scratch(first), scratch(second));
        let (mut d_output, mut d_second, mut d_first) =
            (scratch(outputs), scratch(second), scratch(first));
        for start in rows.clone().step_by(tile) {
            let here = start..(start + tile).min(rows.end);
            let (count, offset) = (here.len(), start - rows.start);
            let hidden_first = self.first_hidden(&here, &mut first_again[..count * first]);
            let hidden_second =
                self.second_hidden(&here, hidden_first, &mut second_again[..count * second]);
            let d_second = &mut d_second[..count * second];
            self.last_layer(&here, hidden_second, sums, &mut d_output[..count * outputs], d_second);
            let d_first = match to.first.is_empty() {
                true => &mut d_first[..count * first],
                false => &mut to.first[offset * first..(offset + count) * first],
            };
            self.second_layer(hidden_first, sums, d_second, d_first);
            self.sources(&here, offset, d_first, &mut sums[TAIL..], &mut to.inputs);
        }
    }

    fn first_hidden<'s>(&'s self, rows: &Range<usize>, scratch: &'s mut [f32]) -> &'s [f32] {
        let width = self.parameters.first_bias.len();
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
        let width = self.parameters.second_bias.len();
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
        let [_, second, outputs] = p.widths();
        let [_, _, d_second_bias, d_weight, d_bias, d_gain, d_offset, ..] = sums else {
            unreachable!("one sum per parameter")
        };
        let cotangent = &self.cotangent[rows.start * outputs..rows.end * outputs];
        let d_output = match p.normalisation {
            Some(Normalisation { gain, .. }) => {
                let normal = &self.activations.normal[rows.start * outputs..rows.end * outputs];
                let inverse = &self.activations.inverse[rows.clone()];
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
                hidden,
                d_output,
                p.third_weight,
                d_second,
                d_second_bias,
                d_weight,
            );
        } else {
            // Transposed: the wider dimension is the one vectorised.
            add_transposed_product(d_output, outputs, hidden, d_weight);
            multiply(d_output, &self.third_transposed, Start::Zero, d_second);
            debug_assert_eq!(d_second.len(), rows.len() * second);
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
        add_transposed_product(hidden, self.parameters.first_bias.len(), d_second, d_weight);
        multiply(d_second, &self.second_transposed, Start::Zero, d_first);
        pull_back_rows(self.parameters.activation, hidden, d_first, d_bias);
    }

    /// Gradients of the sources' weights and rows, as far as a tile knows them.
    fn sources(
        &self,
        rows: &Range<usize>,
        offset: usize,
        d_first: &[f32],
        sums: &mut [&mut [f32]],
        inputs: &mut [&mut [f32]],
    ) {
        let hidden = self.parameters.first_bias.len();
        for (number, source) in self.sources.iter().enumerate() {
            let width = source.width;
            let input = &mut inputs[number];
            match source.gather {
                Gather::Identity => {
                    if source.first_row.is_some() {
                        let values = &source.values[rows.start * width..rows.end * width];
                        add_transposed_product(values, width, d_first, sums[number]);
                    }
                    if input.is_empty() {
                        continue;
                    }
                    let input = &mut input[offset * width..(offset + rows.len()) * width];
                    match &self.first_transposed[number] {
                        Some(weight) => multiply(d_first, weight, Start::Zero, input),
                        None => input.copy_from_slice(d_first),
                    }
                }
                Gather::Cyclic { .. } | Gather::Repeated { .. } => {
                    if !sums[number].is_empty() {
                        add_gathered_rows(source.gather, rows.start, hidden, d_first, sums[number]);
                    }
                }
                Gather::Indexed { .. } => {}
            }
        }
    }

    /// Puts the gradients together.
    fn gradients(
        &self,
        mut tail: Vec<Vec<f32>>,
        of_sources: Vec<Vec<f32>>,
        rows: RowGradients,
    ) -> Vec<Option<Vec<f32>>> {
        let hidden = self.parameters.first_bias.len();
        let mut first_weight = vec![0.0; self.parameters.first_weight.len()];
        let mut gradients = Vec::with_capacity(self.sources.len() + 1 + TAIL);
        let RowGradients { first, inputs: row_by_row } = rows;
        for (number, (sum, row_by_row)) in of_sources.into_iter().zip(row_by_row).enumerate() {
            let (source, needed) = (&self.sources[number], self.needed[number]);
            let weight_rows =
                source.first_row.map(|row| row * hidden..(row + source.width) * hidden);
            if let Gather::Identity = source.gather {
                if let Some(range) = weight_rows {
                    add_into(&mut first_weight[range], &sum);
                }
                gradients.push(needed.then_some(row_by_row));
                continue;
            }
            let product = match source.gather {
                Gather::Indexed { inverse, .. } if self.has_gradient(source, needed) => {
                    let mut product = vec![0.0; inverse.targets() * hidden];
                    add_up(&first, inverse, 1.0, hidden, &mut product);
                    product
                }
                _ => sum,
            };
            let Some(range) = weight_rows else {
                gradients.push(needed.then_some(product));
                continue;
            };
            add_transposed_product(source.values, source.width, &product, &mut first_weight[range]);
            gradients.push(needed.then(|| {
                let mut input = vec![0.0; source.values.len()];
                let weight = Panels::transposed(source.weight(self.parameters), hidden);
                multiply_in_parallel(&product, hidden, &weight, source.width, &mut input);
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

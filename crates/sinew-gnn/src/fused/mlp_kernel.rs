//! The fused perceptron on slices: forward pass over tiles of rows.
//!
//! A tile's activations stay in the second-level cache from the gather to the output.

use crate::fused::activation::{Activation, add_bias_and_activate};
use crate::fused::index::{Gather, GatherPlan};
use crate::fused::normalise::{Normalisation, normalise};
use crate::fused::pool::Buffer;
use crate::fused::product::{Panels, Start, multiply};
use crate::fused::rows::{add_to_rows, gather_and_activate, single_output};
use rayon::prelude::*;

/// Most rows of a tile: activations of two layers of 128 then take 60 KiB, and weight gradients,
/// whose factors are read in strides, meet few conflicts in the first-level cache.
const TILE_ROWS: usize = 60;
/// Tiles that few rows are cut into, so that every thread has some.
const FEWEST_TILES: usize = 8;
/// Rows of a tile are a multiple of this, so that products run in whole blocks.
const ROWS_PER_BLOCK: usize = 6;

/// Rows of the tiles that `rows` rows are cut into.
pub(crate) fn tile_rows(rows: usize) -> usize {
    rows.div_ceil(FEWEST_TILES).next_multiple_of(ROWS_PER_BLOCK).clamp(ROWS_PER_BLOCK, TILE_ROWS)
}

/// Parameters of a perceptron.
pub(crate) struct Parameters<'a> {
    pub activation: Activation,
    /// Weight of each layer, row by row.
    pub weights: [&'a [f32]; 3],
    pub biases: [&'a [f32]; 3],
    pub normalisation: Option<Normalisation<'a>>,
}

impl Parameters<'_> {
    pub(crate) fn widths(&self) -> [usize; 3] {
        self.biases.map(<[f32]>::len)
    }
}

/// Rows of an input, and what of the first weight they meet.
pub(crate) struct Source<'a> {
    pub values: &'a [f32],
    /// Length of a row.
    pub width: usize,
    pub gather: &'a Gather,
    /// First row of the weight; `None` if the rows are products already.
    pub first_row: Option<usize>,
}

impl Source<'_> {
    /// Whether its rows are multiplied tile by tile, because each serves one row of the result.
    pub(crate) fn is_multiplied_in_tiles(&self) -> bool {
        self.first_row.is_some() && matches!(self.gather, Gather::Identity)
    }

    /// The rows of the first weight it meets; none for products.
    pub(crate) fn weight<'w>(&self, parameters: &Parameters<'w>) -> &'w [f32] {
        let hidden = parameters.biases[0].len();
        self.first_row
            .map_or(&[], |row| &parameters.weights[0][row * hidden..(row + self.width) * hidden])
    }

    /// Products with the weight once per row; empty where that is left to the tiles or done.
    fn product(&self, parameters: &Parameters<'_>) -> Buffer {
        let hidden = parameters.biases[0].len();
        if self.first_row.is_none() || self.is_multiplied_in_tiles() || self.values.is_empty() {
            return Buffer::take(0);
        }
        let rows = self.values.len() / self.width;
        let mut product = Buffer::take(rows * hidden);
        let weight = Panels::new(self.weight(parameters), hidden);
        multiply_in_parallel(self.values, &weight, &mut product);
        product
    }
}

/// [`multiply`] spread over threads.
pub(crate) fn multiply_in_parallel(rows: &[f32], weight: &Panels, output: &mut [f32]) {
    let chunk = tile_rows(output.len() / weight.columns.max(1));
    output
        .par_chunks_mut((chunk * weight.columns).max(1))
        .zip(rows.par_chunks((chunk * weight.depth).max(1)))
        .for_each(|(output, rows)| multiply(rows, weight, Start::Zero, output));
}

/// The inputs of a perceptron, multiplied where each row serves several.
pub(crate) struct FirstLayer<'a> {
    /// Products of sources with the weight, and how their rows are gathered.
    gathered: Vec<(&'a Gather, &'a [f32])>,
    /// Sources that are multiplied in tiles, with their weights.
    tiled: Vec<(&'a Source<'a>, Panels)>,
}

impl<'a> FirstLayer<'a> {
    pub(crate) fn new(
        sources: &'a [Source<'a>],
        products: &'a [Buffer],
        parameters: &Parameters<'_>,
    ) -> Self {
        let (mut gathered, mut tiled) = (Vec::new(), Vec::new());
        for (source, product) in sources.iter().zip(products) {
            if source.is_multiplied_in_tiles() {
                let weight = Panels::new(source.weight(parameters), parameters.biases[0].len());
                tiled.push((source, weight));
            } else {
                let is_product = source.first_row.is_none();
                gathered.push((source.gather, if is_product { source.values } else { product }));
            }
        }
        Self { gathered, tiled }
    }

    /// The first hidden layer of the rows from `start` on.
    pub(crate) fn evaluate(&self, parameters: &Parameters<'_>, start: usize, first: &mut [f32]) {
        let rows = first.len() / parameters.biases[0].len();
        first.fill(0.0);
        for (source, weight) in &self.tiled {
            let values = &source.values[start * source.width..(start + rows) * source.width];
            multiply(values, weight, Start::Kept, first);
        }
        let (activation, bias) = (parameters.activation, parameters.biases[0]);
        gather_and_activate(activation, bias, &self.gathered, start, first);
    }
}

/// Activations kept for the backward pass. A hidden layer not kept is empty.
#[derive(Debug)]
pub(crate) struct Activations {
    /// Products of the sources with the first weight, see [`Source::product`].
    pub products: Vec<Buffer>,
    pub first: Buffer,
    pub second: Buffer,
    /// Normalised outputs before gain and offset.
    pub normal: Buffer,
    /// Inverse standard deviation of each row.
    pub inverse: Buffer,
}

/// Activations of some consecutive rows; hidden layers that are not kept are empty.
struct Tile<'a> {
    first: &'a mut [f32],
    second: &'a mut [f32],
    normal: &'a mut [f32],
    inverse: &'a mut [f32],
    output: &'a mut [f32],
}

/// Outputs `[rows, outputs]` and what is kept: each hidden layer where `keep` says so.
pub(crate) fn forward(
    plan: &GatherPlan,
    sources: &[Source<'_>],
    parameters: &Parameters<'_>,
    keep: [bool; 2],
) -> (Vec<f32>, Activations) {
    let [first, second, outputs] = parameters.widths();
    let rows = plan.rows;
    let kept = |keep: bool, width: usize| Buffer::take(if keep { rows * width } else { 0 });
    let normalised = parameters.normalisation.is_some();
    let mut output = vec![0.0; rows * outputs];
    let mut all = Activations {
        products: sources.iter().map(|source| source.product(parameters)).collect(),
        first: kept(keep[0], first),
        second: kept(keep[1], second),
        normal: kept(normalised, outputs),
        inverse: kept(normalised, 1),
    };

    let layer = FirstLayer::new(sources, &all.products, parameters);
    let weights =
        [Panels::new(parameters.weights[1], second), Panels::new(parameters.weights[2], outputs)];
    let mut rest =
        (&mut all.first[..], &mut all.second[..], &mut all.normal[..], &mut all.inverse[..]);
    let tile = tile_rows(rows);
    let mut tiles = Vec::with_capacity(rows.div_ceil(tile));
    for output in output.chunks_mut(tile * outputs) {
        let rows = output.len() / outputs;
        tiles.push(Tile {
            first: split_off(&mut rest.0, rows * first),
            second: split_off(&mut rest.1, rows * second),
            normal: split_off(&mut rest.2, rows * outputs),
            inverse: split_off(&mut rest.3, rows),
            output,
        });
    }
    tiles.into_par_iter().enumerate().for_each(|(number, mut tile_of_rows)| {
        forward_tile(&layer, &weights, parameters, number * tile, &mut tile_of_rows);
    });
    (output, all)
}

/// The first `count` numbers, or none of an empty slice.
pub(crate) fn split_off<'a>(rest: &mut &'a mut [f32], count: usize) -> &'a mut [f32] {
    let count = count.min(rest.len());
    rest.split_off_mut(..count).unwrap_or_default()
}

fn forward_tile(
    layer: &FirstLayer<'_>,
    [second_weight, third_weight]: &[Panels; 2],
    parameters: &Parameters<'_>,
    start: usize,
    tile: &mut Tile<'_>,
) {
    let [first, second, outputs] = parameters.widths();
    let rows = tile.output.len() / outputs;
    let scratch =
        |kept: &[f32], width| Buffer::take(if kept.is_empty() { rows * width } else { 0 });
    let (mut of_first, mut of_second) = (scratch(tile.first, first), scratch(tile.second, second));
    let first = if tile.first.is_empty() { &mut of_first[..] } else { &mut *tile.first };
    let second = if tile.second.is_empty() { &mut of_second[..] } else { &mut *tile.second };
    layer.evaluate(parameters, start, first);
    second_layer(parameters, second_weight, first, second);
    if outputs == 1 {
        single_output(parameters.weights[2], second, tile.output);
    } else {
        multiply(second, third_weight, Start::Zero, tile.output);
    }
    add_to_rows(parameters.biases[2], tile.output);
    if let Some(normalisation) = parameters.normalisation {
        normalise(normalisation, tile.output, tile.normal, tile.inverse);
    }
}

/// The second hidden layer, from the first.
pub(crate) fn second_layer(
    parameters: &Parameters<'_>,
    weight: &Panels,
    first: &[f32],
    second: &mut [f32],
) {
    multiply(first, weight, Start::Zero, second);
    add_bias_and_activate(parameters.activation, parameters.biases[1], second);
}

//! The fused perceptron on slices: forward pass over tiles of rows.
//!
//! A tile's activations stay in the second-level cache from the gather to the output.

use rayon::prelude::*;

use crate::activation::{Activation, add_bias_and_activate};
use crate::index::GatherPlan;
use crate::matrix::{Matrix, multiply};
use crate::normalise::{Normalisation, normalise};
use crate::pool::Buffer;
use crate::rows::{add_to_rows, gather_and_activate, single_output};

/// Rows of a tile: activations of two layers of 128 then take 128 KiB.
pub(crate) const TILE_ROWS: usize = 128;

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
    pub fn widths(&self) -> [usize; 3] {
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
    pub fn take(rows: usize, parameters: &Parameters<'_>) -> Self {
        let [first, second, outputs] = parameters.widths();
        let normalised = if parameters.normalisation.is_some() { rows } else { 0 };
        Self {
            first: Buffer::take(rows * first),
            second: Buffer::take(rows * second),
            normal: Buffer::take(normalised * outputs),
            inverse: Buffer::take(normalised),
        }
    }

    pub fn all(&mut self) -> TileMut<'_> {
        TileMut {
            first: &mut self.first,
            second: &mut self.second,
            normal: &mut self.normal,
            inverse: &mut self.inverse,
        }
    }
}

/// Activations of some consecutive rows.
pub(crate) struct TileMut<'a> {
    pub first: &'a mut [f32],
    pub second: &'a mut [f32],
    pub normal: &'a mut [f32],
    pub inverse: &'a mut [f32],
}

impl<'a> TileMut<'a> {
    /// Splits after the first `rows` rows.
    pub fn split(self, rows: usize, parameters: &Parameters<'_>) -> (Self, Self) {
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

/// Activations of some consecutive rows, to read.
pub(crate) struct Tile<'a> {
    pub first: &'a [f32],
    pub second: &'a [f32],
    pub normal: &'a [f32],
    pub inverse: &'a [f32],
}

impl<'a> Tile<'a> {
    pub fn new(
        all: &'a Activations,
        start: usize,
        rows: usize,
        parameters: &Parameters<'_>,
    ) -> Self {
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

pub(crate) fn hidden_layers(
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
    add_bias_and_activate(activation, parameters.second_bias, tile.second);
}

pub(crate) fn last_layer(parameters: &Parameters<'_>, tile: &mut TileMut<'_>, output: &mut [f32]) {
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

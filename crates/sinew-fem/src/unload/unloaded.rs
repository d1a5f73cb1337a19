//! The body at rest, and options of the search for it.

use crate::elements::{largest, least, per_cell};
use crate::{CellValue, Options};
use sinew_energy::{Body, Fibres};

/// A body at rest whose loaded state is the image.
#[derive(Clone, Debug)]
pub struct Unloaded {
    /// The body at rest, ready to be solved: with its directions, loads and supports.
    pub rest: Body,
    /// Displacement from the image to the body at rest, `[w_x, w_y, w_z]` node by node \[length\]; minus the displacement that loading gives.
    pub motion: Vec<f64>,
    /// Parameters of law and loads.
    pub theta: Vec<f64>,
    /// Convention of the material directions.
    pub fibres: Fibres,
    /// Least and largest ratio det f of a cell's volume at rest to that in the image.
    pub volume_ratios: [CellValue; 2],
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Norm of the loads and reactions \[stress·length²\].
    pub force_scale: f64,
    /// The check that loading from rest leads to the image, if it was asked for.
    pub loading: Option<Loading>,
    /// Newton iterations, all load steps together.
    pub iterations: usize,
    /// Number of load steps, 1 when the whole load was taken at once.
    pub load_steps: usize,
    /// Wall-clock time of search and checks \[s\].
    pub seconds: f64,
}

/// Check that loading from rest leads to the image: by a stable equilibrium half-way whose tangent leads to the image, or by loading where
/// this leaves doubt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Largest distance of a node from its image \[length\], by a Newton step from there or after loading.
    pub distance: f64,
    /// Newton iterations.
    pub iterations: usize,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

impl Unloaded {
    /// Displacement from the body at rest to the image, as [`crate::Solution::displacement`] \[length\].
    pub fn displacement(&self) -> Vec<f64> {
        self.motion.iter().map(|w| -w).collect()
    }
}

/// Least and largest volume of a cell at rest relative to that in the image, at a quadrature point.
pub(super) fn volume_ratios(image: &Body, rest: &Body) -> [CellValue; 2] {
    let ratios = rest.volumes.iter().zip(&image.volumes).map(|(rest, image)| rest / image);
    let ratios: Vec<f64> = ratios.collect();
    let [low, high] =
        [f64::min, f64::max].map(|pick| per_cell(&ratios, image.points_per_cell, pick));
    let least = least(&low, 1).first().copied();
    [least.unwrap_or(CellValue { cell: 0, value: f64::NAN }), largest(&high)]
}

/// Options of the search for a body at rest and of its check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnloadOptions {
    /// Most Newton iterations, all load steps together.
    pub iterations: usize,
    /// Most of them at one load.
    pub iterations_per_load: usize,
    /// Smallest load step before the search gives up [part of the load].
    pub least_load_step: f64,
    /// Unbalanced forces that are enough \[relative to loads and reactions\]; 0, the default, is what rounding errors amount to.
    pub accuracy: f64,
    /// Options of the check that loading from rest leads to the image, see [`crate::Loading`]. `None` skips it, where the body at rest is a
    /// neighbour of one that was checked; whether the image is a stable equilibrium is checked in either case.
    pub load: Option<Options>,
}

impl Default for UnloadOptions {
    fn default() -> Self {
        Self {
            iterations: 300,
            iterations_per_load: 25,
            least_load_step: 1e-3,
            accuracy: 0.0,
            load: Some(Options::default()),
        }
    }
}

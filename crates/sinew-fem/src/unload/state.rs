//! The image, a body at rest on trial, the balance of both, and the one found.

use crate::elements::{Followers, System, largest, least, load_gradient, per_cell};
use crate::linear::{Norm, norm};
use crate::{CellValue, Options};
use sinew_energy::{Body, Fibres};
use sinew_num::Mat3;

/// Part of a load and θ: what is continued where the whole load fails.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    pub factor: f64,
    pub theta: Vec<f64>,
}

impl Level {
    /// The whole load.
    pub(super) fn whole(theta: &[f64]) -> Self {
        Self { factor: 1.0, theta: theta.to_vec() }
    }
}

/// A trial body at rest, with the residual of its image.
pub(super) struct Trial {
    /// Displacement from the image to the body at rest \[length\], `3 × nodes`.
    pub motion: Vec<f64>,
    /// The body at rest.
    pub rest: Body,
    /// Displacement from the body at rest to the image: minus `motion`.
    pub displacement: Vec<f64>,
    /// Unbalanced forces in the unknowns.
    pub residual: Vec<f64>,
    /// Their norm \[stress·length²\].
    pub force: f64,
    /// Norm of loads and reactions \[stress·length²\].
    pub scale: f64,
    /// Least volume ratio of a cell at rest to its image.
    pub least: f64,
}

impl Trial {
    /// `None` where a cell is inverted or an energy overflows.
    pub(super) fn new(image: &Image<'_>, motion: Vec<f64>, level: &Level) -> Option<Self> {
        let rest = image.moved(&motion)?;
        let displacement: Vec<f64> = motion.iter().map(|w| -w).collect();
        let loads = loads(&rest, &displacement, level);
        let mut forces = inner_forces(&rest, &displacement, &level.theta)?;
        forces.iter_mut().zip(&loads).for_each(|(force, load)| *force += load);
        let sparsity = &image.system.sparsity;
        let residual: Vec<f64> = sparsity.gather(&forces).collect();
        let mut size = Norm::default();
        loads.iter().for_each(|&load| size.add(load));
        let held = rest.prescribed.iter().enumerate().filter(|(_, held)| held.is_some());
        held.for_each(|(dof, _)| size.add(rest.frames.component(dof, &forces)));
        let force = norm(&residual);
        let ratios = rest.volumes.iter().zip(&image.system.body.volumes);
        let least = ratios.map(|(rest, image)| rest / image).fold(f64::INFINITY, f64::min);
        let scale = size.value();
        let finite = force.is_finite() && scale.is_finite();
        finite.then_some(Self { motion, rest, displacement, residual, force, scale, least })
    }

    /// A body at rest whose image, itself for now, is in balance.
    pub(super) fn balanced(rest: Body) -> Self {
        let (motion, displacement, residual) = (Vec::new(), Vec::new(), Vec::new());
        Self { motion, rest, displacement, residual, force: 0.0, scale: 0.0, least: 1.0 }
    }

    /// Unbalanced forces relative to loads and reactions.
    pub(super) fn size(&self) -> f64 {
        if self.force == 0.0 { 0.0 } else { self.force / self.scale.max(f64::MIN_POSITIVE) }
    }
}

/// Derivative of the loads' potential, with the sign of a derivative.
fn loads(rest: &Body, displacement: &[f64], level: &Level) -> Vec<f64> {
    let mut loads = load_gradient(rest, displacement, &level.theta);
    Followers::new(&rest.followers).add_forces(displacement, &level.theta, &mut loads);
    loads.iter_mut().for_each(|load| *load *= level.factor);
    loads
}

/// Forces of the material and of springs.
fn inner_forces(rest: &Body, displacement: &[f64], theta: &[f64]) -> Option<Vec<f64>> {
    let parameters = rest.law_parameters(theta);
    let mut forces = vec![0.0; displacement.len()];
    for spring in &rest.springs {
        spring.value_and_add_gradient(displacement, &mut forces);
    }
    let law = |point: usize, h: &Mat3<f64>| {
        let found = rest.material.stress(point, parameters, h, None);
        found.0.is_finite().then_some(found)
    };
    rest.add_stress_forces(displacement, law, &mut forces)?;
    Some(forces)
}

/// The image with what is prepared once.
pub(super) struct Image<'p> {
    pub system: System<'p>,
    pub fibres: Fibres,
}

impl Image<'_> {
    /// The body at rest; `None` where a cell is inverted.
    pub(super) fn moved(&self, motion: &[f64]) -> Option<Body> {
        self.system.body.moved(motion, self.fibres)
    }

    /// Whether the law has directions that move with the tissue.
    pub(super) fn carries(&self) -> bool {
        let directed = !self.system.body.material.directions(0).is_empty();
        self.fibres == Fibres::Carried && directed
    }
}

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

//! The image, a trial body at rest, and the balance of both.

use crate::elements::{Followers, System, load_gradient};
use crate::linear::{Norm, norm};
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

//! The image, a body at rest on trial, the balance of both and how it changes at a quadrature point, and the body found.

use crate::elements::{Followers, System, load_gradient};
use crate::linear::{add, dot, norm};
use crate::{CellValue, Options};
use nalgebra::{Matrix3, Vector3};
use sinew_energy::laws::Guccione;
use sinew_energy::{Body, Fibres, Response};
use sinew_num::{Mat3, cross};

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
        add(&mut forces, 1.0, &loads);
        let sparsity = &image.system.sparsity;
        let residual: Vec<f64> = sparsity.gather(&forces).collect();
        let held = rest.prescribed.iter().enumerate().filter(|(_, held)| held.is_some());
        let reactions = held.map(|(dof, _)| rest.frames.component(dof, &forces));
        let scale = loads.into_iter().chain(reactions).fold(0.0, f64::hypot);
        let force = norm(&residual);
        let least = volume_ratios(image.system.body, &rest)[0].value;
        let finite = force.is_finite() && scale.is_finite();
        finite.then_some(Self { motion, rest, displacement, residual, force, scale, least })
    }

    /// The body at rest with the displacement to its image.
    pub(super) fn at(&self) -> (&Body, &[f64]) {
        (&self.rest, &self.displacement)
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
    let by_value = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    let points = || ratios.clone().enumerate();
    [points().min_by(by_value), points().max_by(by_value)].map(|found| {
        let (point, value) = found.unwrap_or((0, f64::NAN));
        CellValue { cell: point / image.points_per_cell, value }
    })
}

/// Options of the search for a body at rest and of its check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnloadOptions {
    /// Most Newton iterations, all load steps together.
    pub iterations: usize,
    /// Unbalanced forces that are enough \[relative to loads and reactions\]; 0, the default, is what rounding errors amount to.
    pub accuracy: f64,
    /// Options of the check that loading from rest leads to the image, see [`crate::Loading`]. `None` skips it, where the body at rest is a
    /// neighbour of one that was checked; whether the image is a stable equilibrium is checked in either case.
    pub load: Option<Options>,
}

impl Default for UnloadOptions {
    fn default() -> Self {
        Self { iterations: 300, accuracy: 0.0, load: Some(Options::default()) }
    }
}

/// A tensor of fourth order: entry `ijkl` in row `3i + j` and column `3k + l`.
pub(super) type Tensor = [[f64; 9]; 9];

/// A quadrature point of the image. With E = ∂δX/∂x the unloaded body changes by δF = −F D and δV = V tr D, where D = E F; directions that
/// are carried turn by a spin W of the reference. The law does not see that spin, so `P(F, Q d) = P(F Q, d) Qᵀ` gives what it
/// does to the stress from the tangent A alone: `δP = A : F(W − D) − P W`.
pub(super) struct PointRate {
    /// Kirchhoff stress τ = P Fᵀ \[stress\].
    pub kirchhoff: Matrix3<f64>,
    /// `∂τ_ij/∂E_kl` in row `3i + j` and column `3k + l`.
    pub rate: Tensor,
    /// `∂τ/∂s` where F is scaled by eˢ.
    pub by_scale: Matrix3<f64>,
    /// `∂ tr D/∂E`.
    pub trace: Matrix3<f64>,
}

impl PointRate {
    /// The rate of a law at `scaled` = F̄ − I, which is `h` = F − I but for a scale. `None` outside the law's domain.
    pub(super) fn new(
        rest: &Body,
        point: usize,
        parameters: &[f64],
        [h, scaled]: [&Mat3<f64>; 2],
        carried: bool,
    ) -> Option<Self> {
        let Response { energy, stress, tangent } =
            rest.material.response(point, parameters, scaled);
        if !energy.is_finite() {
            return None;
        }
        let [f, f_bar, stress] = [h.plus_identity(), scaled.plus_identity(), stress]
            .map(|matrix| Matrix3::from_fn(|i, j| matrix[i][j]));
        let tangent_times = |change: Matrix3<f64>| {
            let by_rows = change.transpose();
            Matrix3::from_fn(|i, j| dot(&tangent[3 * i + j], by_rows.as_slice()))
        };
        let axes = axes(rest.material.directions(point)).filter(|_| carried);
        let mut rate = [[0.0; 9]; 9];
        for column in 0..9 {
            let mut d = Matrix3::zeros();
            d.set_row(column / 3, &f.row(column % 3));
            let spin = axes.map_or_else(Matrix3::zeros, |axes| spin(&axes, &d));
            let of_stress = tangent_times(f_bar * (spin - d)) - stress * spin;
            let change = (of_stress - stress * d.transpose()) * f_bar.transpose();
            for (row, entries) in rate.iter_mut().enumerate() {
                entries[column] = change[(row / 3, row % 3)];
            }
        }
        let kirchhoff = stress * f_bar.transpose();
        let by_scale = tangent_times(f_bar) * f_bar.transpose() + kirchhoff;
        Some(Self { kirchhoff, rate, by_scale, trace: f.transpose() })
    }

    /// The rate with `by_scale ⊗ trace` times a weight and `τ ⊗ trace` added.
    pub(super) fn with_volume(&self, by_scale: f64) -> Tensor {
        let weights = self.kirchhoff + by_scale * self.by_scale;
        let mut rate = self.rate;
        for (row, entries) in rate.iter_mut().enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry += weights[(row / 3, row % 3)] * self.trace[(column / 3, column % 3)];
            }
        }
        rate
    }
}

/// Orthonormal axes, of which the first are given; a law of one direction does not see spins about it.
fn axes(directions: &[[f64; 3]]) -> Option<Matrix3<f64>> {
    let (&first, others) = directions.split_first()?;
    let second = others.first().copied().unwrap_or_else(|| Guccione::frame(first)[1]);
    Some(Matrix3::from_columns(&[first, second, cross(&first, &second)].map(Vector3::from)))
}

/// Spin of carried directions, that of the frame Q of `f M = Q R` with R upper triangular:
/// `W = Σ_{i>j} (q_i · D q_j) (q_i q_jᵀ − q_j q_iᵀ)`.
fn spin(axes: &Matrix3<f64>, d: &Matrix3<f64>) -> Matrix3<f64> {
    let lower = (axes.transpose() * d * axes).lower_triangle();
    axes * (lower - lower.transpose()) * axes.transpose()
}

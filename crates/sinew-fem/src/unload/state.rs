//! The image, a body at rest on trial, the balance of both and how it changes at a quadrature point, and the body found.

use crate::elements::{
    Followers, System, largest, least, load_gradient, per_cell, product, tangent_times,
};
use crate::linear::{Norm, add, norm};
use crate::{CellValue, Options};
use sinew_energy::{Body, Fibres};
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
        let scale = loads.into_iter().chain(reactions).collect::<Norm>().value();
        let force = norm(&residual);
        let ratios = rest.volumes.iter().zip(&image.system.body.volumes);
        let least = ratios.map(|(rest, image)| rest / image).fold(f64::INFINITY, f64::min);
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

/// A tensor of fourth order: entry `ijkl` in row `3i + j` and column `3k + l`.
pub(super) type Tensor = [[f64; 9]; 9];

/// A quadrature point of the image. With E = ∂δX/∂x the unloaded body changes by δF = −F D and δV = V tr D, where D = E F; directions that
/// are carried turn by a spin W of the reference. The law does not see that spin, so `P(F, Q d) = P(F Q, d) Qᵀ` gives what it
/// does to the stress from the tangent A alone: `δP = A : F(W − D) − P W`.
pub(super) struct PointRate {
    /// Kirchhoff stress τ = P Fᵀ \[stress\].
    pub kirchhoff: Mat3<f64>,
    /// `∂τ_ij/∂E_kl` in row `3i + j` and column `3k + l`.
    pub rate: Tensor,
    /// `∂τ/∂s` where F is scaled by eˢ.
    pub by_scale: Mat3<f64>,
    /// `∂ tr D/∂E_kl`.
    pub trace: [f64; 9],
}

/// `A Bᵀ`.
fn product_transposed(a: &Mat3<f64>, b: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| a[i][0] * b[j][0] + a[i][1] * b[j][1] + a[i][2] * b[j][2])
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
        let response = rest.material.response(point, parameters, scaled);
        if !response.energy.is_finite() {
            return None;
        }
        let (f, f_bar, stress) = (h.plus_identity(), scaled.plus_identity(), &response.stress);
        let spatial = pushed(&response.tangent, &f_bar);
        let along = product_transposed(&tangent_times(&response.tangent, &f_bar), &f_bar);
        let kirchhoff = product_transposed(stress, &f_bar);
        let (first, mut rate) = (product_transposed(stress, &f), [[0.0; 9]; 9]);
        for (row, entries) in rate.iter_mut().enumerate() {
            let (i, j) = (row / 3, row % 3);
            for k in 0..3 {
                let along = &spatial[row][3 * k..3 * k + 3];
                for l in 0..3 {
                    let stretched = along[0] * f[l][0] + along[1] * f[l][1] + along[2] * f[l][2];
                    entries[3 * k + l] = -stretched - first[i][l] * f_bar[j][k];
                }
            }
        }
        if carried {
            add_spins(&mut rate, rest.material.directions(point), [&f, &f_bar], stress, &spatial);
        }
        let trace = std::array::from_fn(|kl| f[kl % 3][kl / 3]);
        let by_scale = Mat3::from_fn(|i, j| along[i][j] + kirchhoff[i][j]);
        Some(Self { kirchhoff, rate, by_scale, trace })
    }

    /// The rate with `by_scale ⊗ trace` times a weight and `τ ⊗ trace` added.
    pub(super) fn with_volume(&self, by_scale: f64) -> Tensor {
        let mut rate = self.rate;
        for (row, entries) in rate.iter_mut().enumerate() {
            let (i, j) = (row / 3, row % 3);
            let weight = self.kirchhoff[i][j] + by_scale * self.by_scale[i][j];
            entries.iter_mut().zip(&self.trace).for_each(|(entry, t)| *entry += weight * t);
        }
        rate
    }
}

/// `∂(A : F̄ G) F̄ᵀ/∂G`.
fn pushed(tangent: &Tensor, f: &Mat3<f64>) -> Tensor {
    let mut right = [[0.0; 9]; 9];
    for (to, from) in right.iter_mut().zip(tangent) {
        for m in 0..3 {
            for k in 0..3 {
                let weight = f[k][m];
                (0..3).for_each(|n| to[3 * m + n] += weight * from[3 * k + n]);
            }
        }
    }
    let mut both = [[0.0; 9]; 9];
    for (row, to) in both.iter_mut().enumerate() {
        for m in 0..3 {
            let (weight, from) = (f[row % 3][m], &right[3 * (row / 3) + m]);
            (0..9).for_each(|column| to[column] += weight * from[column]);
        }
    }
    both
}

/// Adds what the spin of carried directions does: that of the frame Q of `f M = Q R` with R upper triangular is
/// `W = Σ_{i>j} (q_i · D q_j) (q_i q_jᵀ − q_j q_iᵀ)`.
fn add_spins(
    rate: &mut Tensor,
    directions: &[[f64; 3]],
    [f, f_bar]: [&Mat3<f64>; 2],
    stress: &Mat3<f64>,
    spatial: &Tensor,
) {
    let Some(q) = completed(directions) else { return };
    for (i, j) in [(1, 0), (2, 0), (2, 1)] {
        let spin = Mat3::from_fn(|a, b| q[i][a] * q[j][b] - q[j][a] * q[i][b]);
        let direct = product_transposed(&product(stress, &spin), f_bar);
        let change = tangent_times(spatial, &spin);
        let moved = f.apply(&q[j]);
        for (row, entries) in rate.iter_mut().enumerate() {
            let weight = change[row / 3][row % 3] - direct[row / 3][row % 3];
            for (column, entry) in entries.iter_mut().enumerate() {
                *entry += weight * q[i][column / 3] * moved[column % 3];
            }
        }
    }
}

/// Orthonormal axes, of which the first are given; a law of one direction does not see spins about it.
fn completed(directions: &[[f64; 3]]) -> Option<[[f64; 3]; 3]> {
    let first = directions.first()?;
    let unit = |v: [f64; 3]| v.map(|x| x / v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let least = (0..3).min_by(|&i, &j| first[i].abs().total_cmp(&first[j].abs()))?;
    let second = directions.get(1).copied().unwrap_or_else(|| {
        unit(cross(first, &std::array::from_fn(|i| f64::from(u8::from(i == least)))))
    });
    Some([*first, second, cross(first, &second)])
}

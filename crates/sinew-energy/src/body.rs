//! A body: its total potential energy in plain arrays.

use crate::cavity::Cavity;
use crate::{
    Barriers, Frames, Magnitude, Material, Parameter, PressureField, PressureSurface,
    ReferenceLoads, Spring, ThetaError, Units,
};
use sinew_mesh::{AnyMesh, Element};
use sinew_num::{Mat3, dot, sum, try_in_parallel};
use std::ops::Range;
use std::sync::Arc;

/// Points, or patches, of a share: a fixed division, so that sums do not depend on the number of threads.
const SHARE: usize = 256;
/// Least number of points whose shares are divided over threads.
const LARGE: usize = 16_384;

/// A body with its material, loads and supports, lowered from a [`crate::Scene`]: its total potential energy
/// Π(u; θ), thesis eqs. (3.15)–(3.16), integrated by quadrature.
///
/// Newton's method, the physics-informed objective, errors and reports all read it. Its type names neither law, element
/// nor load. Displacements are flat, `[u_x, u_y, u_z]` node by node.
///
/// It reads as its [`BodyArrays`] do (`body.cells`), which nobody else can change: lowering has checked them, so a body always holds
/// finite numbers that fit each other.
#[doc(alias("weak form", "potential energy"))]
#[derive(Clone, Debug)]
pub struct Body(pub(crate) BodyArrays);

impl std::ops::Deref for Body {
    type Target = BodyArrays;

    fn deref(&self) -> &BodyArrays {
        &self.0
    }
}

/// Arrays of a [`Body`]. A load that a scene does not list is an empty array. Linear tetrahedra have one quadrature
/// point each, which is exact for them.
#[derive(Clone, Debug)]
pub struct BodyArrays {
    /// Name, for reports and files.
    pub name: String,
    /// Units of all its numbers.
    pub units: Units,
    /// The entries of θ: first those of the material, then those of the loads.
    pub parameters: Vec<Parameter>,
    /// Names and values of parameters that are known, so that θ does not list them, see [`Body::with_known`].
    pub known: Vec<(String, f64)>,
    /// The reference configuration with its named sets and fields.
    pub mesh: Arc<AnyMesh>,
    /// The law with its directions at the quadrature points.
    pub material: Arc<dyn Material>,
    /// Barriers that keep the energy finite in training; `None` for the energy as it is, +∞ outside its domain.
    pub barriers: Option<Barriers>,
    /// Number of nodes.
    pub nodes: usize,
    /// Reference positions of the nodes \[length\].
    pub positions: Vec<[f64; 3]>,
    /// Nodes of a cell: 4 and 10 are tetrahedra, 8 hexahedra, 3 and 6 triangles.
    pub nodes_per_cell: usize,
    /// Nodes of the cells, one cell after the other.
    pub cells: Vec<usize>,
    /// Quadrature points of a cell. The next two arrays are ordered by point, cell by cell.
    pub points_per_cell: usize,
    /// Gradients `∂N_a/∂X_j` of the shape functions [1/length], `nodes_per_cell` rows per point.
    pub shape_gradients: Vec<[f64; 3]>,
    /// Reference volume that each point stands for \[length³\].
    pub volumes: Vec<f64>,
    /// Quadrature points that share one volume ratio, see [`crate::Scene::averaged`]: all of them in
    /// patches, or none.
    pub patches: Vec<Vec<usize>>,
    /// Loads per reference volume and area, which `nodal_force` and `springs` sum up.
    pub reference_loads: ReferenceLoads,
    /// Dead loads lumped to the nodes [stress·length²], `3 × nodes`.
    pub nodal_force: Vec<f64>,
    /// Elastic supports, facet by facet.
    pub springs: Vec<Spring>,
    /// Pressures that have a potential.
    pub pressures: Vec<PressureSurface>,
    /// True follower pressures on surfaces with a loose rim, which have none, see [`Body::has_potential`].
    pub followers: Vec<PressureSurface>,
    /// The field of pressure that makes the body incompressible, if it is.
    pub pressure_field: Option<PressureField>,
    /// The cavities that pressures act in.
    pub cavities: Vec<Cavity>,
    /// Prescribed displacement of each degree of freedom \[length\], `None` where it is free; `3 × nodes`.
    /// Degrees of freedom are along the coordinate axes, or the axes of the node's frame if it has one.
    pub prescribed: Vec<Option<f64>>,
    /// Frames of the nodes that supports hold along other directions than the coordinate axes.
    pub frames: Frames,
}

/// Evaluates an expression with the number of nodes of a cell as a constant `N`, so that loops over them unroll:
/// `with_nodes!(body.nodes_per_cell, N => forces::<N>(body))`.
#[macro_export]
macro_rules! with_nodes {
    ($nodes:expr, $N:ident => $value:expr) => {
        $crate::with_constant!($nodes, $N => $value, of 4, 10, 8, 3, 6)
    };
}

/// Evaluates an expression with a number as a constant `N`; the numbers that it may be are listed.
#[doc(hidden)]
#[macro_export]
macro_rules! with_constant {
    ($number:expr, $N:ident => $value:expr, of $($count:literal),+) => {
        match $number {
            $($count => {
                const $N: usize = $count;
                $value
            })+
            other => unreachable!("{other} is not among the numbers"),
        }
    };
}

impl Body {
    /// Shape of a cell.
    pub fn element(&self) -> &'static Element {
        Element::with_nodes(self.nodes_per_cell)
    }

    /// Nodes of every cell.
    pub fn cell_nodes(&self) -> impl ExactSizeIterator<Item = &[usize]> + Clone {
        self.cells.chunks_exact(self.nodes_per_cell)
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / self.nodes_per_cell
    }

    /// Nodes of a cell.
    #[inline]
    pub fn nodes_of_cell(&self, cell: usize) -> &[usize] {
        &self.cells[cell * self.nodes_per_cell..][..self.nodes_per_cell]
    }

    /// Nodes of the cell that a quadrature point belongs to.
    #[inline]
    pub fn nodes_of_point(&self, point: usize) -> &[usize] {
        self.nodes_of_cell(self.cell_of_point(point))
    }

    #[inline]
    fn cell_of_point(&self, point: usize) -> usize {
        if self.points_per_cell == 1 { point } else { point / self.points_per_cell }
    }

    /// Gradients of the shape functions at a quadrature point [1/length], one row per node of the cell.
    #[inline]
    pub fn shape_of_point(&self, point: usize) -> &[[f64; 3]] {
        &self.shape_gradients[point * self.nodes_per_cell..][..self.nodes_per_cell]
    }

    /// Displacement gradient H = ∂u/∂X at one quadrature point; for linear tetrahedra, of one cell.
    ///
    /// # Stress
    /// The material gives the first Piola–Kirchhoff stress P there, and σ = P Fᵀ/J is the Cauchy stress, with F = H + 1 and J = det F.
    /// The points of cell `c` are `c * points_per_cell` and those after it.
    ///
    /// ```
    /// use sinew_energy::{Mat3, Parameter, Scene, Support, laws::NeoHookean};
    ///
    /// let body = Scene::new(sinew_mesh::box_tetrahedra([10.0, 1.0, 1.0], [4, 1, 1]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// // A tenth longer along x; from a solution, this is its displacement.
    /// let u: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.0, 0.0]).collect();
    /// let theta = [30.0, 70.0];
    /// let cauchy = (0..body.volumes.len()).map(|point| {
    ///     let h = body.displacement_gradient(point, &u);
    ///     let (_, piola) = body.material.stress(point, body.law_parameters(&theta), &h, None);
    ///     let f = h.plus_identity();
    ///     let j = f.determinant();
    ///     Mat3::from_fn(|a, b| (0..3).map(|k| piola[a][k] * f[b][k]).sum::<f64>() / j)
    /// });
    /// // σ = μ/J (F Fᵀ − 1) + λ ln J/J 1
    /// let j = 1.1_f64;
    /// let (along, across) = ((30.0 * (j * j - 1.0) + 70.0 * j.ln()) / j, 70.0 * j.ln() / j);
    /// for stress in cauchy {
    ///     assert!((stress[0][0] - along).abs() < 1e-12 && (stress[1][1] - across).abs() < 1e-12);
    /// }
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    ///
    /// In a body with [`BodyArrays::patches`] the law reads `scaled` of [`Body::patch_kinematics`] instead of H.
    #[inline]
    pub fn displacement_gradient(&self, point: usize, displacement: &[f64]) -> Mat3<f64> {
        with_nodes!(self.nodes_per_cell, N => self.gradient_of::<N>(point, displacement))
    }

    #[inline(always)]
    fn gradient_of<const N: usize>(&self, point: usize, displacement: &[f64]) -> Mat3<f64> {
        let (u, _) = displacement.as_chunks::<3>();
        let nodes = &self.cells.as_chunks::<N>().0[self.cell_of_point(point)];
        let shape = &self.shape_gradients.as_chunks::<N>().0[point];
        let origin = u[nodes[0]];
        // The shape functions' gradients sum to zero, so only differences of u enter.
        let mut h = Mat3::ZERO;
        for a in 1..N {
            let (v, g) = (&u[nodes[a]], &shape[a]);
            for i in 0..3 {
                for j in 0..3 {
                    h.0[i][j] += (v[i] - origin[i]) * g[j];
                }
            }
        }
        h
    }

    /// Whether equilibria are stationary points of Π(u; θ): no follower pressure on a surface with a loose rim, and no field of
    /// pressure (a saddle point). Of a body without a potential, [`Body::value`] and its derivatives are those of the part that has one.
    pub fn has_potential(&self) -> bool {
        self.followers.is_empty() && self.pressure_field.is_none()
    }

    /// Π(u; θ) [stress·length³]; +∞ where a cell is inverted or an energy overflows.
    pub fn value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        self.load_value(displacement, theta) + self.inner_value(displacement, theta)
    }

    /// Energy of the material and of elastic supports [stress·length³]; +∞ where a cell is inverted or an
    /// energy overflows.
    pub fn inner_value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let springs = self.springs.iter().map(|spring| spring.value(displacement)).sum::<f64>();
        let (parameters, barriers) = (self.law_parameters(theta), self.barriers.as_ref());
        let at = |point: usize, h: &Mat3<f64>| {
            self.volumes[point] * self.material.energy(point, parameters, h, barriers)
        };
        let of_patch = |patch: &[usize]| {
            let kinematics = self.patch_kinematics(patch, displacement)?;
            let energies = patch.iter().zip(&kinematics.scaled).map(|(&point, h)| at(point, h));
            Some(energies.sum::<f64>())
        };
        let energy = |part: usize| match self.patches.get(part) {
            Some(patch) => of_patch(patch).unwrap_or(f64::INFINITY),
            None => at(part, &self.displacement_gradient(part, displacement)),
        };
        // None where the sum ends, because it is infinite.
        let share = |parts: Range<usize>| {
            let finite = |energy: f64| (energy != f64::INFINITY).then_some(energy);
            parts.map(energy).try_fold(0.0, |total, energy| finite(total + energy))
        };
        self.shares(share).map_or(f64::INFINITY, |shares| springs + sum(&shares))
    }

    /// Potential of the loads alone, dead and pressures [stress·length³].
    pub fn load_value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let mut total = -dot(&self.nodal_force, displacement);
        for pressure in &self.pressures {
            total += pressure.value(displacement, theta);
        }
        total
    }

    /// Π(u; θ), and its gradient (internal minus external nodal forces) written to `gradient`.
    ///
    /// The gradient covers all degrees of freedom; at prescribed ones it is the reaction force.
    pub fn value_and_gradient(
        &self,
        displacement: &[f64],
        theta: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let mut total = -dot(&self.nodal_force, displacement);
        gradient.iter_mut().zip(&self.nodal_force).for_each(|(g, f)| *g = -f);
        let (parameters, barriers) = (self.law_parameters(theta), self.barriers.as_ref());
        let law = |point: usize, h: &Mat3<f64>| {
            Some(self.material.stress(point, parameters, h, barriers))
        };
        total += self.add_stress_forces(displacement, law, gradient).unwrap_or(f64::INFINITY);
        for spring in &self.springs {
            total += spring.value_and_add_gradient(displacement, gradient);
        }
        for pressure in &self.pressures {
            total += pressure.value_and_add_gradient(displacement, theta, gradient);
        }
        total
    }

    /// Adds the nodal forces of first Piola–Kirchhoff stresses [stress·length²]; returns the integral of energy densities [stress·length³]. `law` gives both at a
    /// point and its displacement gradient H, or F̄ − I where there are patches. `None` where it does, or a cell of a patch is inverted.
    ///
    /// ```
    /// use sinew_energy::{Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_num::Mat3;
    ///
    /// let body = Scene::new(sinew_mesh::box_tetrahedra([1.0; 3], [2; 3]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let stretched: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.0, 0.0]).collect();
    /// let (theta, mut forces) = ([1.5, 1.0], vec![0.0; stretched.len()]);
    /// let law = |point, h: &Mat3<f64>| Some(body.material.stress(point, &theta, h, None));
    /// let energy = body.add_stress_forces(&stretched, law, &mut forces).expect("an admissible displacement");
    /// assert!((energy / body.value(&stretched, &theta) - 1.0).abs() < 1e-14);
    /// assert!(forces.iter().sum::<f64>().abs() < 1e-14); // they balance
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    pub fn add_stress_forces(
        &self,
        displacement: &[f64],
        law: impl Fn(usize, &Mat3<f64>) -> Option<(f64, Mat3<f64>)> + Sync,
        forces: &mut [f64],
    ) -> Option<f64> {
        let (energy, stresses) = self.stresses(displacement, law)?;
        stresses.for_each(|(point, stress)| self.add_forces(point, &stress, forces));
        Some(energy)
    }

    /// Integral of energy densities [stress·length³], and the points with the first Piola–Kirchhoff stresses that are conjugate to H; `law` as for
    /// [`Body::add_stress_forces`].
    pub fn stresses(
        &self,
        displacement: &[f64],
        law: impl Fn(usize, &Mat3<f64>) -> Option<(f64, Mat3<f64>)> + Sync,
    ) -> Option<(f64, impl Iterator<Item = (usize, Mat3<f64>)>)> {
        let share = |parts: Range<usize>| {
            let (mut total, mut stresses) = (0.0, Vec::with_capacity(parts.len()));
            let mut stress = |point: usize, h: &Mat3<f64>| {
                let (energy, stress) = law(point, h)?;
                total += self.volumes[point] * energy;
                Some(stress)
            };
            for part in parts {
                let Some(patch) = self.patches.get(part) else {
                    let h = self.displacement_gradient(part, displacement);
                    stresses.push((part, stress(part, &h)?));
                    continue;
                };
                let kinematics = self.patch_kinematics(patch, displacement)?;
                let points = patch.iter().zip(&kinematics.scaled);
                let own = points.map(|(&point, h)| stress(point, h));
                let mut own: Vec<_> = own.collect::<Option<_>>()?;
                let volumes: Vec<_> = patch.iter().map(|&point| self.volumes[point]).collect();
                kinematics.work_conjugate(&volumes, &mut own);
                stresses.extend(patch.iter().copied().zip(own));
            }
            Some((total, stresses))
        };
        let (totals, stresses): (Vec<f64>, Vec<_>) = self.shares(share)?.into_iter().unzip();
        Some((sum(&totals), stresses.into_iter().flatten()))
    }

    /// Values of all shares of the points, or of the patches if there are any, on all threads where they are many; `None` where one is.
    fn shares<T: Send>(&self, share: impl Fn(Range<usize>) -> Option<T> + Sync) -> Option<Vec<T>> {
        let parts = if self.patches.is_empty() { self.volumes.len() } else { self.patches.len() };
        let share = |at: usize| share(SHARE * at..parts.min(SHARE * (at + 1)));
        let shares = 0..parts.div_ceil(SHARE);
        match self.volumes.len() < LARGE {
            true => shares.map(share).collect(),
            false => try_in_parallel(shares, |at| share(at).ok_or(())).ok(),
        }
    }

    /// Whether no cell is inverted at a displacement: J > 0 at every quadrature point.
    pub fn admits(&self, displacement: &[f64]) -> bool {
        let change = |point| self.displacement_gradient(point, displacement).volume_change();
        (0..self.volumes.len()).map(change).all(|change: f64| change > -1.0)
    }

    /// Whether no cell is inverted and no barrier is active at a displacement. Beyond the barriers the energy of the
    /// material is bounded, so that Π has no minimum under loads.
    pub fn is_within_barriers(&self, displacement: &[f64], theta: &[f64]) -> bool {
        /// Rounding error between two evaluations of the same formula.
        const ROUNDING: f64 = 1e-9;
        let parameters = self.law_parameters(theta);
        let within = |(point, h): (usize, &Mat3<f64>)| {
            let own = self.material.energy(point, parameters, h, None);
            let guarded = self.material.energy(point, parameters, h, self.barriers.as_ref());
            own.is_finite() && (own - guarded).abs() <= ROUNDING * own.abs()
        };
        let gradients = self.law_gradients(displacement).filter(|_| self.admits(displacement));
        gradients.is_some_and(|gradients| {
            self.barriers.is_none() || gradients.iter().enumerate().all(within)
        })
    }

    /// The part of θ that the law reads.
    ///
    /// # Panics
    /// If θ is too short; [`Body::check_theta`] tells.
    pub fn law_parameters<'t>(&self, theta: &'t [f64]) -> &'t [f64] {
        &theta[..self.material.parameters().len()]
    }

    /// Number of entries of θ that law and loads read.
    pub fn theta_len(&self) -> usize {
        let surfaces = self.pressures.iter().chain(&self.followers);
        let ends = surfaces.map(|surface| match surface.magnitude {
            Magnitude::Fixed(_) => 0,
            Magnitude::Theta(index) => index + 1,
        });
        ends.fold(self.material.parameters().len(), usize::max)
    }

    /// Checks that θ has the right length, is finite and gives every parameter a value that makes sense.
    ///
    /// # Errors
    /// The first entry that does not.
    pub fn check_theta(&self, theta: &[f64]) -> Result<(), ThetaError> {
        let (given, needed, names) = (theta.len(), self.theta_len(), self.material.parameters());
        if given != needed {
            return Err(ThetaError::Length { given, needed, names: names.to_vec() });
        }
        for (index, &value) in theta.iter().enumerate() {
            let load = (&"a load", f64::MIN..=f64::MAX);
            let of_law = |name| (name, self.material.bounds(index));
            let (&name, bounds) = names.get(index).map_or(load, of_law);
            if !bounds.contains(&value) {
                let (least, most) = (*bounds.start(), *bounds.end());
                return Err(ThetaError::OutOfBounds { index, name, value, least, most });
            }
        }
        Ok(())
    }

    /// The middle of the range of every parameter, of its logarithm where it is sampled so.
    pub fn centre(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.at_share(0.5)).collect()
    }

    /// Parameters within their ranges, off the [middle](Body::centre) at [shares](Parameter::at_share) that differ: loads that are zero or cancel there do not here.
    ///
    /// ```
    /// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_mesh::TruncatedEllipsoid;
    ///
    /// let body = Scene::new(TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra(), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::linear("p", "kPa", -2.0..=2.0))
    ///     .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
    ///     .support(Support::clamped("base"))
    ///     .lower()?;
    /// let beside = body.beside_centre();
    /// assert!(body.centre()[2] == 0.0 && (beside[2] + 1.2).abs() < 1e-12);
    /// assert!((beside[0] - 10f64.powf(1.0 / 3.0)).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    pub fn beside_centre(&self) -> Vec<f64> {
        let numbered = (3..).zip(&self.parameters);
        numbered.map(|(number, parameter)| parameter.at_share(1.0 / f64::from(number))).collect()
    }

    /// Indices `3 × node + component` that no support prescribes, ascending; components of the node's frame, if
    /// it is in [`BodyArrays::frames`].
    pub fn free_degrees_of_freedom(&self) -> Vec<usize> {
        (0..self.prescribed.len()).filter(|&i| self.prescribed[i].is_none()).collect()
    }

    /// Nodes that supports leave free along some direction, ascending.
    pub fn free_nodes(&self) -> Vec<usize> {
        let rows = self.prescribed.chunks_exact(3).enumerate();
        rows.filter(|(_, row)| row.contains(&None)).map(|(node, _)| node).collect()
    }

    /// Body with barriers that keep its energy finite, for training.
    pub fn with_barriers(mut self, barriers: Barriers) -> Self {
        self.0.barriers = Some(barriers);
        self
    }

    /// Body whose volumetric response is multiplied by a factor; `None` where its law does not allow it
    /// ([`crate::Law::with_softer_volume`]).
    pub fn with_softer_volume(&self, factor: f64) -> Option<Self> {
        let mut softer = self.clone();
        softer.0.material = self.material.with_softer_volume(factor)?;
        Some(softer)
    }
}

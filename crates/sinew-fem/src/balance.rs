//! Equilibria that are no minima: incompressible bodies and pressures on surfaces with a loose rim.

mod gmres;
mod linear;
mod newton;
mod solve;
mod state;
mod volume;

pub use solve::BalanceSolution;
pub use volume::{VolumeStep, VolumeTrace};

use crate::SolveError;
use crate::assembly::Assembly;
use crate::factor::Factor;
use crate::rigid::check_supports;
use crate::solver::check_arrays;
use crate::sparsity::Sparsity;
use sinew_energy::{ForceBalance, SurfaceResponse};

/// Finds equilibria of a body for which there is no potential to minimise.
///
/// Newton's method on the balance of forces, under rising load. The linear systems are solved by GMRES; the
/// Cholesky factor of the symmetric part of the stiffness preconditions the displacements, the mass matrix
/// of the pressures over the local moduli their Schur complement, so that 5–30 iterations do.
///
/// ```
/// use sinew_energy::{Load, Magnitude, Parameter, Sampling, Scene, Support, Units, laws::Guccione};
/// use sinew_fem::{BalanceSolver, Options};
/// use sinew_mesh::box_tetrahedra;
///
/// // Problem 1 of Land et al. (2015) on a coarse mesh: a beam under pressure from below.
/// let parameter = |name: &str, unit: &str, value: f64| Parameter {
///     name: name.into(),
///     unit: unit.into(),
///     range: [value, value],
///     sampling: Sampling::Log,
/// };
/// let scene = Scene {
///     name: "land 1".into(),
///     units: Units::mm_kpa(),
///     mesh: box_tetrahedra([10.0, 1.0, 1.0], [10, 1, 1]).quadratic(),
///     law: Guccione.nearly_incompressible(3.0), // the field of pressure brings the rest
///     directions: vec![Guccione::frame([1.0, 0.0, 0.0]); 60],
///     parameters: vec![
///         parameter("C", "kPa", 2.0),
///         parameter("b_f", "1", 8.0),
///         parameter("b_t", "1", 2.0),
///         parameter("b_fs", "1", 4.0),
///     ],
///     loads: vec![Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.004) }],
///     supports: vec![Support::clamped("x_min")],
/// };
/// let body = scene.lower_mixed()?;
/// let solution = BalanceSolver::new(&body)?.solve(&[2.0, 8.0, 2.0, 4.0], &Options::default())?;
/// let corner = scene.mesh.points.iter().position(|&x| x == [10.0, 0.0, 1.0]).unwrap();
/// let z = 1.0 + solution.displacement[3 * corner + 2];
/// assert!((z - 4.05).abs() < 0.1, "{z}"); // mm; 4.16 on fine meshes
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct BalanceSolver<'p> {
    system: System<'p>,
    factor: Factor,
}

/// The balance with its derivatives where they were assembled last.
struct System<'p> {
    body: &'p ForceBalance,
    sparsity: Sparsity,
    assembly: Assembly,
    /// Forces of the facets of the followers with their derivatives, where last assembled.
    followers: Vec<SurfaceResponse>,
    /// `∂r_p/∂u` of each cell: one row per corner, `3N` columns.
    coupling: Vec<f64>,
    /// Modulus of each quadrature point that the pressure works against \[stress\].
    moduli: Vec<f64>,
}

impl<'p> BalanceSolver<'p> {
    /// Prepares the solver.
    ///
    /// # Errors
    /// A potential that is malformed or whose supports leave a part of the body free to move.
    pub fn new(body: &'p ForceBalance) -> Result<Self, SolveError> {
        let potential = &body.body;
        check_arrays(potential)?;
        check_supports(potential)?;
        let sparsity = Sparsity::new(potential, &body.followers)?;
        let factor = Factor::new(&sparsity)?;
        let points = potential.volumes.len();
        let assembly = Assembly::new(&sparsity, points, potential.prescribed.len());
        let corners = body.pressure_field.as_ref().map_or(0, |field| field.corners);
        let coupling = vec![0.0; potential.cell_count() * corners * 3 * potential.nodes_per_cell];
        let (followers, moduli) = (Vec::new(), vec![0.0; points]);
        let system = System { body, sparsity, assembly, followers, coupling, moduli };
        Ok(Self { system, factor })
    }

    /// Number of unknowns: free degrees of freedom, then pressures.
    pub fn unknowns(&self) -> [usize; 2] {
        let field = self.system.body.pressure_field.as_ref();
        [self.system.sparsity.unknowns(), field.map_or(0, |field| field.unknowns)]
    }
}

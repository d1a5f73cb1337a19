//! The solver: what is prepared once per body.

use crate::assembly::Assembly;
use crate::linear_solver::{LinearSolver, LinearSystem};
use crate::rigid::check_supports;
use crate::sparsity::Sparsity;
use crate::{Solution, SolveError};
use sinew_energy::Body;
use std::sync::Arc;

/// Finds equilibria of one body for any θ.
///
/// Sparsity, ordering and symbolic factorisation are prepared once; the memory of the numbers is reused.
pub struct Solver<'p> {
    pub(crate) potential: &'p Body,
    pub(crate) sparsity: Arc<Sparsity>,
    pub(crate) system: LinearSystem,
    pub(crate) assembly: Assembly,
}

impl<'p> Solver<'p> {
    /// Prepares the solver.
    ///
    /// # Errors
    /// A potential that is malformed or whose supports leave a part of the body free to move.
    pub fn new(potential: &'p Body) -> Result<Self, SolveError> {
        Self::with_linear_solver(potential, LinearSolver::Automatic)
    }

    /// Prepares the solver with a linear solver of choice.
    ///
    /// # Errors
    /// As for [`Solver::new`].
    pub fn with_linear_solver(
        potential: &'p Body,
        linear_solver: LinearSolver,
    ) -> Result<Self, SolveError> {
        check_arrays(potential)?;
        check_supports(potential)?;
        let sparsity = Arc::new(Sparsity::new(potential, &[])?);
        let system = LinearSystem::new(linear_solver, &sparsity)?;
        Ok(Self::assembled(potential, sparsity, system))
    }

    /// Another solver of the same body, for another thread; it shares what is prepared.
    ///
    /// # Errors
    /// [`SolveError::OutOfMemory`].
    pub fn fresh(&self) -> Result<Self, SolveError> {
        Ok(Self::assembled(self.potential, self.sparsity.clone(), self.system.fresh()?))
    }

    fn assembled(potential: &'p Body, sparsity: Arc<Sparsity>, system: LinearSystem) -> Self {
        let assembly =
            Assembly::new(&sparsity, potential.volumes.len(), potential.prescribed.len());
        Self { potential, sparsity, system, assembly }
    }

    /// The body that is solved.
    pub fn body(&self) -> &'p Body {
        self.potential
    }

    /// Number of unknowns: degrees of freedom that no support prescribes.
    pub fn unknowns(&self) -> usize {
        self.sparsity.unknowns()
    }

    /// Stored entries of the lower half of the stiffness, and of the linear solver in numbers of the same size:
    /// those of the Cholesky factor, or of an iteration's matrices so far.
    pub fn stored_entries(&self) -> [usize; 2] {
        [self.sparsity.entries(), self.system.bytes() / size_of::<f64>()]
    }

    /// Iterations that the linear solver's preconditioner took for its own matrix when it was last built; `None` for
    /// a direct solver, also one that took over from an iteration.
    pub fn linear_iterations(&self) -> Option<usize> {
        self.system.iterations()
    }

    pub(crate) fn check_solution(&self, solution: &Solution) -> Result<(), SolveError> {
        self.potential.check_theta(&solution.theta)?;
        self.check_displacement(&solution.displacement)
    }

    pub(crate) fn check_displacement(&self, displacement: &[f64]) -> Result<(), SolveError> {
        let (given, needed) = (displacement.len(), self.potential.prescribed.len());
        let finite = displacement.iter().filter(|u| u.is_finite()).count();
        if given == needed && finite == needed {
            return Ok(());
        }
        Err(SolveError::Initial { given, finite, needed })
    }
}

/// The fields of a potential are public: checks that they fit each other.
pub(crate) fn check_arrays(potential: &Body) -> Result<(), SolveError> {
    let (cells, nodes) = (potential.cell_count(), potential.nodes);
    if cells == 0 {
        return Err(SolveError::EmptyMesh);
    }
    let known = |nodes_of: &[usize]| nodes_of.iter().all(|&node| node < nodes);
    let finite = |values: &[f64]| values.iter().all(|x| x.is_finite());
    let facets = || potential.pressures.iter().flat_map(|p| p.facets.as_flattened());
    let surfaces = || potential.surfaces.iter().flat_map(|s| &s.nodes);
    let springs = || potential.springs.iter();
    let points = cells * potential.points_per_cell;
    let frames = || potential.frames.nodes();
    let material = potential.material.points();
    let held = || potential.prescribed.iter().flatten();
    let checks = [
        ("cells", "name nodes that do not exist", known(&potential.cells)),
        ("pressures", "name nodes that do not exist", facets().all(|&node| node < nodes)),
        ("surfaces", "name nodes that do not exist", surfaces().all(|&node| node < nodes)),
        ("springs", "name nodes that do not exist", springs().all(|s| s.node < nodes)),
        ("positions", "are not one per node", potential.positions.len() == nodes),
        ("positions", "are not finite", finite(potential.positions.as_flattened())),
        (
            "shape gradients",
            "are not one per point",
            potential.shape_gradients.len() == points * potential.nodes_per_cell,
        ),
        ("volumes", "are not one per point", potential.volumes.len() == points),
        ("directions", "are not one row per point", material.is_none_or(|rows| rows == points)),
        ("nodal forces", "are not three per node", potential.nodal_force.len() == 3 * nodes),
        ("supports", "are not three per node", potential.prescribed.len() == 3 * nodes),
        ("shape gradients", "are not finite", finite(potential.shape_gradients.as_flattened())),
        (
            "volumes",
            "are not positive",
            potential.volumes.iter().all(|&v| v > 0.0 && v.is_finite()),
        ),
        ("nodal forces", "are not finite", finite(&potential.nodal_force)),
        ("supports", "are not finite", held().all(|u| u.is_finite())),
        ("frames", "name nodes that do not exist", frames().all(|node| node < nodes)),
    ];
    match checks.iter().find(|(_, _, passed)| !passed) {
        Some(&(what, problem, _)) => Err(SolveError::Malformed { what, problem }),
        None => Ok(()),
    }
}

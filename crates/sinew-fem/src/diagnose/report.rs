//! Report on an equilibrium after the solve.

mod display;
mod forces;
mod reaction;
mod warning;

pub use reaction::{Reaction, held_sets, reactions};
pub use warning::Warning;

use crate::diagnose::named::CellValue;
use crate::elements::cells::{
    MOST_WORST, largest, largest_stretches, least, mean_ratios, per_cell, volume_ratios,
};
use crate::elements::check::check_fields;
use crate::elements::state::State;
use crate::linear::vector::relative;
use crate::{Solution, SolveError, locking};
use forces::Forces;
use sinew_energy::Body;

/// Numbers that tell whether a solution can be trusted; its `Display` is a readable block.
#[derive(Clone, Debug, PartialEq)]
pub struct SolutionReport {
    /// Norm of the unbalanced nodal forces over that of loads and reactions.
    pub relative_residual: f64,
    /// Total potential energy Π \[stress·length³\].
    pub energy: f64,
    /// Energy stored in the material and in elastic supports \[stress·length³\].
    pub strain_energy: f64,
    /// Work of the loads that have a potential, at their final magnitude over the whole displacement
    /// \[stress·length³\]; a linear body stores half of it.
    pub external_work: f64,
    /// Reference and deformed volume of the body \[length³\].
    pub volume: [f64; 2],
    /// The cells of least volume ratio J, worst first; five at most.
    pub least_volume_ratios: Vec<CellValue>,
    /// Largest volume ratio J.
    pub largest_volume_ratio: CellValue,
    /// Largest principal stretch.
    pub largest_stretch: CellValue,
    /// The cells of worst shape at rest, by the mean ratio of their corners: 1 for equal edges and angles, 0
    /// for flat ones; worst first, five at most.
    pub worst_reference_shapes: Vec<CellValue>,
    /// Quality of the deformed cells.
    pub worst_deformed_shapes: Vec<CellValue>,
    /// Forces of the supports on the body, for each group of held nodes that share cells.
    pub reactions: Vec<Reaction>,
    /// Resultant of all loads on the body \[stress·length²\].
    pub loads: [f64; 3],
    /// Resultant of the elastic supports on the body \[stress·length²\].
    pub elastic_supports: [f64; 3],
    /// Warnings.
    pub warnings: Vec<Warning>,
}

/// Reports on an equilibrium that a [`crate::Solver`] found for this body. Energy and work omit loose follower loads
/// and the pressure field, which have no potential.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_fem::{Options, Solver, report};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let potential = scene.lower()?;
/// let solution = Solver::new(&potential)?.solve(&[75.0, 75.0], &Options::default())?;
/// let report = report(&potential, &solution)?;
/// assert!((report.reactions[0].force[2] - 98.0).abs() < 1e-6); // the beam's weight
/// assert!(report.imbalance().iter().all(|force| force.abs() < 1e-9));
/// println!("{report}"); // a readable block; warnings last
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A solution that is not one of this body: by the length of displacement, pressure or θ.
pub fn report(body: &Body, solution: &Solution) -> Result<SolutionReport, SolveError> {
    let Solution { displacement, pressure, theta, .. } = solution;
    check_fields(body, displacement, pressure, theta)?;
    let load_factor = solution.load_factor;
    let forces = Forces::of(body, State { displacement, theta, load_factor, pressure });
    let points = body.points_per_cell;
    let ratios = volume_ratios(body, displacement);
    let stretches = largest_stretches(body, displacement);
    let deformed = body.volumes.iter().zip(&ratios).map(|(v, j)| v * j).sum();
    let rest = vec![0.0; displacement.len()];
    let worst_shapes = |u: &[f64]| least(&mean_ratios(body, u), MOST_WORST);
    let mut report = SolutionReport {
        relative_residual: relative(solution.residual, solution.force_scale),
        energy: forces.energy,
        strain_energy: forces.energy + forces.external_work,
        external_work: forces.external_work,
        volume: [body.volumes.iter().sum(), deformed],
        least_volume_ratios: least(&per_cell(&ratios, points, f64::min), MOST_WORST),
        largest_volume_ratio: largest(&per_cell(&ratios, points, f64::max)),
        largest_stretch: largest(&per_cell(&stretches, points, f64::max)),
        worst_reference_shapes: worst_shapes(&rest),
        worst_deformed_shapes: worst_shapes(displacement),
        reactions: reaction::groups(body, displacement, &forces.total),
        loads: forces.loads,
        elastic_supports: forces.elastic_supports,
        warnings: Vec::new(),
    };
    report.warnings = warning::of(&report, (solution.negative_pivots, solution.counted));
    report.warnings.extend(locking(body, theta, displacement)?.map(Warning::Locking));
    Ok(report)
}

impl SolutionReport {
    /// Sum of the forces of loads, supports and elastic supports \[stress·length²\]; zero at an equilibrium, up to the
    /// residual and rounding errors.
    pub fn imbalance(&self) -> [f64; 3] {
        let reaction = |i: usize| self.reactions.iter().map(|r| r.force[i]).sum::<f64>();
        [0, 1, 2].map(|i| self.loads[i] + self.elastic_supports[i] + reaction(i))
    }
}

//! Errors of a solve, with numbers and advice.

use crate::{History, Iteration};
use sinew_energy::{ThetaError, listed};
use sinew_num::norm;
use std::fmt;
use thiserror::Error;

/// A result whose error is that of a solve.
pub(crate) type Result<T, E = SolveError> = std::result::Result<T, E>;

/// Failure of a solve.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SolveError {
    /// A connected part of the body can move without deforming.
    #[error(
        "the part of the body with node {node} ({nodes} nodes) is free in {}; add supports that hold it there",
        listed(modes)
    )]
    FreeToMove { node: usize, nodes: usize, modes: Vec<RigidMode> },
    /// Parameters that make no sense.
    #[error(transparent)]
    Theta(#[from] ThetaError),
    /// A displacement, pressure or direction of the wrong length, or with an entry that is not finite.
    #[error(
        "the displacement, pressure or direction has {given} entries of which {finite} are finite; {needed} finite ones are needed"
    )]
    Initial { given: usize, finite: usize, needed: usize },
    /// Displacement and θ in the wrong order.
    #[error(
        "displacement and theta look swapped: the first has the {parameters} entries of theta, the second the {entries} of a displacement; \
         give the displacement first, then theta"
    )]
    Swapped { entries: usize, parameters: usize },
    /// No equilibrium was found.
    #[error(transparent)]
    NotConverged(Box<NotConverged>),
    /// The stiffness has a zero pivot at the equilibrium, so the response to a change is not defined.
    #[error(
        "the stiffness is singular at this equilibrium (a limit or bifurcation point); move theta a little"
    )]
    Singular,
    /// A curve of equilibria that was lost before the end of its line.
    #[error(
        "the curve of equilibria was followed to place {place:.4}, theta = ({}); {failure}",
        listed(theta)
    )]
    CurveEnded { place: f64, theta: Vec<f64>, failure: Box<NotConverged> },
    /// A body without a potential, where one is needed.
    #[error(
        "mixed elements and pressures with a loose rim have no potential, which this needs; solve the balance of forces, or hold the rim or close it by a lid, and choose elements that are not mixed"
    )]
    NoPotential,
    /// A line in loads and parameters that cannot be followed.
    #[error("this line in loads and parameters cannot be followed because {problem}")]
    Line { problem: &'static str },
    /// A body whose cells or supports differ from those of the frozen stiffness.
    #[error(
        "the frozen stiffness belongs to a body with other {what}; give a body with the same supports, the same numbers of nodes and the same cells, up to their diagonals"
    )]
    OtherBody { what: &'static str },
    /// A body to compare with, whose first nodes are not those of the other.
    #[error(
        "the better body does not begin with the nodes of the first; make its mesh of that one, by `quadratic`"
    )]
    OtherNodes,
    /// A displacement at which a cell is inverted, or the energy or a derivative of it overflows.
    #[error(
        "the energy or a derivative of it is infinite at this displacement, worst in cell {cell}; give an admissible one"
    )]
    Inadmissible { cell: usize },
    /// The factor does not fit in memory.
    #[error("no memory for the factor of {unknowns} unknowns; coarsen the mesh")]
    OutOfMemory { unknowns: usize },
}

/// The best state of a failed solve and how it got there.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "no equilibrium found after {} iterations; the last equilibrium on the way has the load factor {}\n{history}least J where the iteration ended: {}\n{advice}",
    history.iterations.len(), part(*load_factor), listed(worst_cells)
)]
pub struct NotConverged {
    /// Fraction of loads and prescribed motion of the last equilibrium that was found on the way.
    pub load_factor: f64,
    /// Displacement of that equilibrium, `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// All iterations.
    pub history: History,
    /// The cells of least volume ratio J where the iteration ended, worst first; five at most.
    pub worst_cells: Vec<CellValue>,
    /// Advice.
    pub advice: Advice,
}

/// Part of a load, with enough digits to distinguish it from 0 and 1.
fn part(load_factor: f64) -> String {
    if load_factor == 0.0 || load_factor >= 1e-3 {
        format!("{load_factor:.4}")
    } else {
        format!("{load_factor:.2e}")
    }
}

/// Advice after a failed solve.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Advice {
    /// A cell is squeezed flat.
    #[error(
        "cell {cell} is squeezed to J = {volume_ratio:.2e} of its volume: the load may exceed what the body carries; \
         reduce it, stiffen the material, or refine the mesh around that cell"
    )]
    Squeezed { cell: usize, volume_ratio: f64 },
    /// The smallest load increments still invert a cell.
    #[error(
        "cell {cell} is inverted by the smallest load increments: the load or prescribed motion may exceed \
         what the body carries; reduce it, stiffen the material, or refine the mesh around that cell"
    )]
    TurnedOver { cell: usize },
    /// The energy overflows although no cell is inverted.
    #[error(
        "the energy overflows where the search ended, though no cell is inverted: a law with an exponential is \
         stretched too far; reduce load or prescribed motion, or the exponents' factors in theta"
    )]
    Overflow,
    /// Displacements grow ever faster with the load up to a limit point, beyond which no equilibrium was found.
    #[error(
        "the curve of equilibria bends over to a limit point near {} of the load, and none was found at {}: this is what the body \
         bears; reduce the load, stiffen the material, or follow the curve beyond it by a volume or by a prescribed motion",
        part(*limit), part(*refused)
    )]
    LimitPoint { limit: f64, refused: f64 },
    /// The linear model at rest shows that the load is far beyond what the body bears.
    #[error(
        "the load is {times:.0e} times the one that would strain the body by about a quarter if it stayed linear, so that more than its \
         first steps were not looked for; check the units of load, stiffness and mesh, or approach it along a path of rising loads"
    )]
    FarBeyond { times: f64 },
    /// A prescribed rotation so large that its nodes pass through each other on straight lines.
    #[error(
        "the prescribed motion turns its nodes by {degrees:.0} degrees, and load steps lead them there on straight lines, so that halfway the \
         held part is only {:.0} % as wide: turn in parts of at most 90 degrees, each solved from the displacement of the one before",
        100.0 * (0.5 * degrees).to_radians().cos()
    )]
    Turned { degrees: f64 },
    /// Conjugate gradients do not converge, and the factor that would take their place is too large.
    #[error(
        "conjugate gradients found no step, and a factor of the stiffness of {unknowns} unknowns would take {gigabytes:.1} GB, of which {most:.1} are \
         taken unasked: raise the load in steps, reduce load or bulk modulus, or coarsen the mesh; where there is \
         the memory, ask for factors"
    )]
    FactorTooLarge { unknowns: usize, gigabytes: f64, most: f64 },
    /// The stiffness lost positive definiteness.
    #[error(
        "the stiffness is indefinite where the iteration ended: the body may snap or buckle there; \
         load it by a prescribed motion, or less"
    )]
    Unstable,
    /// The iterations ran out.
    #[error("raise the load in smaller steps, reduce it, or allow more iterations")]
    MoreIterations,
}

impl Advice {
    /// Below this J, a squeezed cell is reported as the cause.
    const SQUEEZED: f64 = 0.05;

    /// Advice from the last iterations. Rejected trial states, with inverted cells or infinite energy, count as such,
    /// but their numbers are not quoted: they depend on the step length.
    pub(crate) fn from_history(history: &History) -> Self {
        let tail = history.iterations.iter().rev().take(20);
        let admissible = |i: &&Iteration| i.energy.is_finite() && i.least_volume_ratio > 0.0;
        let by_volume =
            |a: &&Iteration, b: &&Iteration| a.least_volume_ratio.total_cmp(&b.least_volume_ratio);
        let turned = tail.clone().filter(|i| i.least_volume_ratio <= 0.0).min_by(by_volume);
        match (tail.clone().filter(admissible).min_by(by_volume), turned) {
            (Some(i), _) if i.least_volume_ratio < Self::SQUEEZED => {
                Self::Squeezed { cell: i.worst_cell, volume_ratio: i.least_volume_ratio }
            }
            (_, Some(i)) => Self::TurnedOver { cell: i.worst_cell },
            _ if tail.clone().any(|i| i.energy == f64::INFINITY) => Self::Overflow,
            _ if tail.clone().take(3).any(|i| i.shift > 0.0) => Self::Unstable,
            _ => Self::MoreIterations,
        }
    }
}

/// Components of a unit vector below this are left out of its name.
const NAMED: f64 = 1e-6;

/// A number and the cell that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellValue {
    /// Index of the cell.
    pub cell: usize,
    /// The number.
    pub value: f64,
}

impl fmt::Display for CellValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} (cell {})", self.value, self.cell)
    }
}

/// A rigid motion to first order, `translation + rotation × (X − centre)` with the centre of the held
/// nodes (of all nodes when none is held), or of the joints of a part that hangs on others by a node or edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMode {
    /// Velocity of the centre.
    pub translation: [f64; 3],
    /// Angular velocity.
    pub rotation: [f64; 3],
}

impl fmt::Display for RigidMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [("translation along", self.translation), ("rotation about", self.rotation)];
        let parts = parts.iter().filter(|(_, axis)| norm(axis) > NAMED);
        let parts: Vec<_> =
            parts.map(|(what, axis)| format!("{what} {}", in_words(axis))).collect();
        f.write_str(&parts.join(" with "))
    }
}

/// An axis by name, or by components when it is not a coordinate axis.
fn in_words(axis: &[f64; 3]) -> String {
    let largest = axis.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let present: Vec<_> = (0..3).filter(|&i| axis[i].abs() > NAMED * largest).collect();
    match present[..] {
        [i] => ["x", "y", "z"][i].into(),
        _ => format!("({:.3}, {:.3}, {:.3})", axis[0], axis[1], axis[2]),
    }
}

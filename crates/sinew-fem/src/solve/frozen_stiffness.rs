//! The factorised stiffness of one solved state, kept for steps at other parameters and on other bodies.

use crate::elements::System;
use crate::linear::{add, dot, norm};
use crate::solve::Potential;
use crate::{Options, Pairs, Refined, Result, SolveError, Solver, Stop};
use sinew_energy::{Body, Frames};
use sinew_num::Mat3;
use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

/// Cosine below which two directions count as perpendicular.
const ACROSS: f64 = 0.1;
/// Factor by which a start that inverts cells is shortened, and number of times at most.
const SHORTER: f64 = 0.7;
const MOST_TRIALS: usize = 40;

/// Factorised stiffness of a body at one state (modified Newton), for quasi-Newton steps at many parameter sets and on unseen bodies that share
/// its mesh's connectivity and its supports, whatever their shapes, materials and scars.
///
/// A copy shares the factor. On left ventricles of random shape and parameters, 16 steps reach a
/// median error of 1.2 % in a tenth of the time of a solve, and 32 steps 0.03 %. Beams in large deflection need too many
/// steps to pay. For nearly incompressible bodies of another shape the steps do not converge
/// (`cargo xtask reproduce-populations --no-networks`).
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{FrozenStiffness, Options, Solver};
/// let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
///     .support(Support::clamped("x_min"))
///     .lower()?;
/// let known = FrozenStiffness::new(&beam)?; // one solve
/// let near = known.descend(&beam, &[50.0, 90.0], 6)?;
/// let exact = Solver::new(&beam)?.solve(&[50.0, 90.0], &Options::default())?;
/// assert!(near.unbalanced() < 1e-4);
/// assert!((near.energy / exact.energy - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("frozen stiffness", "modified Newton", "quasi-Newton"))]
#[derive(Clone)]
pub struct FrozenStiffness<'p> {
    system: Arc<System<'p>>,
    /// Displacement of the state, node by node \[length\].
    pub displacement: Vec<f64>,
}

impl<'p> Solver<'p> {
    /// The stiffness at a displacement \[length\], best an equilibrium in the middle of the parameters' ranges. An indefinite one is shifted.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell,
    /// [`SolveError::Singular`], [`SolveError::OutOfMemory`].
    pub fn frozen_stiffness(
        &self,
        displacement: &[f64],
        theta: &[f64],
    ) -> Result<FrozenStiffness<'p>> {
        let mut own = self.fresh()?;
        own.visit(displacement, (theta, 1.0), None)?;
        own.system.factorise(true).ok_or(SolveError::Singular)?;
        Ok(FrozenStiffness { system: Arc::new(own.system), displacement: displacement.to_vec() })
    }
}

impl<'p> FrozenStiffness<'p> {
    /// Solves a body, best one in the middle of a population, at the centre of its parameters' ranges.
    ///
    /// # Errors
    /// No equilibrium at the centre.
    pub fn new(body: &'p Body) -> Result<Self> {
        let (mut solver, centre) = (Solver::new(body)?, body.centre());
        let known = solver.solve(&centre, &Options::default())?.displacement;
        solver.frozen_stiffness(&known, &centre)
    }

    /// The body.
    pub fn body(&self) -> &'p Body {
        self.system.body
    }

    /// Requires a body with as many held directions at each node and the same cells, up to the diagonals that linear ones are cut along.
    ///
    /// # Errors
    /// [`SolveError::OtherBody`], [`SolveError::NoPotential`].
    pub fn suits(&self, body: &Body) -> Result<()> {
        self.frames_of(body).map(|_| ())
    }

    /// Quasi-Newton steps on this body, or on another one with the same cells and as many held directions at each node (another shape,
    /// material or load), from a displacement \[length\] near to equilibrium, until `stop`. Prescribed components are put in their places
    /// first.
    ///
    /// The number of steps grows with the difference of both bodies. They do not converge where both are nearly incompressible
    /// ([`Refined::unbalanced`] stays about one), because changes of volume are stiff.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell,
    /// [`SolveError::OtherBody`].
    #[doc(alias("L-BFGS", "quasi-Newton"))]
    pub fn refine(&self, body: &Body, from: &[f64], theta: &[f64], stop: Stop) -> Result<Refined> {
        let frames = self.frames_of(body)?;
        let potential = Potential { body, theta, frames: &frames };
        self.system.refine(potential, from, stop, &mut Pairs::default())
    }

    /// [`FrozenStiffness::refine`] from the state of this stiffness, shortened where it inverts cells of `body`.
    ///
    /// # Errors
    /// As for [`FrozenStiffness::refine`]; [`SolveError::Inadmissible`] where prescribed motions invert cells at once.
    pub fn descend(&self, body: &Body, theta: &[f64], steps: usize) -> Result<Refined> {
        let (mut start, stop) = (self.displacement.clone(), Stop::after(steps));
        for _ in 0..MOST_TRIALS {
            match self.refine(body, &start, theta, stop) {
                Err(SolveError::Inadmissible { .. }) => {
                    start.iter_mut().for_each(|u| *u *= SHORTER);
                }
                found => return found,
            }
        }
        self.refine(body, &vec![0.0; start.len()], theta, stop)
    }

    /// Frames of another body, with its free axes rotated as near as possible to those of this stiffness; an error if
    /// cells or supports differ.
    fn frames_of<'b>(&self, body: &'b Body) -> Result<Cow<'b, Frames>> {
        let own = self.system.body;
        if !body.has_potential() {
            return Err(SolveError::NoPotential);
        }
        let refuse = |what| Err(SolveError::OtherBody { what });
        if own.nodes != body.nodes {
            return refuse("nodes");
        }
        if own.cells != body.cells && !shares_edges(own, body) {
            return refuse("cells");
        }
        let held = |body: &Body, node: usize| -> [bool; 3] {
            std::array::from_fn(|i| body.prescribed[3 * node + i].is_some())
        };
        let mut frames = Cow::Borrowed(&body.frames);
        for node in 0..body.nodes {
            let [ours, theirs] = [held(own, node), held(body, node)];
            let count = |held: [bool; 3]| held.into_iter().filter(|h| *h).count();
            if count(ours) != count(theirs) {
                return refuse("held components");
            }
            if ours == theirs && own.frames.get(node) == body.frames.get(node) {
                continue;
            }
            let axes = |body: &Body, of: [bool; 3], which: bool| -> Vec<[f64; 3]> {
                let all = (0..3).filter(|&i| of[i] == which);
                all.map(|i| body.frames.axis(3 * node + i)).collect()
            };
            let mut fixed = axes(body, theirs, true).into_iter();
            let free = nearest(&axes(own, ours, false), &axes(body, theirs, false));
            let Some(mut free) = free.map(Vec::into_iter) else {
                return refuse("directions of supports");
            };
            let mut row = |held: bool| if held { fixed.next() } else { free.next() };
            let rows = ours.map(|held| row(held).unwrap_or_default());
            frames.to_mut().insert(node, Mat3(rows));
        }
        Ok(frames)
    }
}

impl fmt::Debug for FrozenStiffness<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FrozenStiffness").field("body", &self.body().name).finish()
    }
}

/// Whether linear cells share half of their edges, as those cut from the same hexahedra along other diagonals do.
fn shares_edges(own: &Body, other: &Body) -> bool {
    let edges = |body: &Body| -> HashSet<[usize; 2]> {
        let pairs = body.cell_nodes().flat_map(|cell| cell.iter().map(move |&a| (a, cell)));
        pairs.flat_map(|(a, cell)| cell.iter().map(move |&b| [a, b])).collect()
    };
    let linear = [own, other].iter().all(|body| body.nodes_per_cell == body.element().corners);
    let (own, other) = (edges(own), edges(other));
    linear && 2 * own.intersection(&other).count() >= own.len().max(other.len())
}

/// Orthonormal basis of `space`, each vector the nearest to that of `to`, in order; `None` where one is nearly
/// perpendicular to the space.
fn nearest(to: &[[f64; 3]], space: &[[f64; 3]]) -> Option<Vec<[f64; 3]>> {
    let mut found: Vec<[f64; 3]> = Vec::new();
    for vector in to {
        let mut own = [0.0; 3];
        space.iter().for_each(|axis| add(&mut own, dot(vector, axis), axis));
        for other in &found {
            let along = dot(&own, other);
            add(&mut own, -along, other);
        }
        let length = norm(&own);
        if length < ACROSS {
            return None;
        }
        found.push(own.map(|x| x / length));
    }
    Some(found)
}

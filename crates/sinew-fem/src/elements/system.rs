//! The discrete system of Newton's method: the balance of forces of a body and its derivatives at the assembled state; followers of loose rims, and
//! supports along the coordinate axes or the axes of a node's own frame.

use crate::diagnose::rigid::check_supports;
use crate::elements::{Assembly, Coupling, State, add_product, at_points};
use crate::linear::{Aggregation, Factor, Method, Sparsity, facets_of};
use crate::{Result, SolveError};
use sinew_energy::{Body, BodyArrays, PressureSurface, SurfaceResponse};
use sinew_num::{Mat3, dot3};
use std::sync::Arc;

/// Unknowns at one load: displacement of all nodes, and the field of pressure if there is one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unknowns {
    pub displacement: Vec<f64>,
    pub pressure: Vec<f64>,
}

impl Unknowns {
    /// System of a body without a field of pressure.
    pub(crate) fn of(displacement: &[f64]) -> Self {
        Self { displacement: displacement.to_vec(), pressure: Vec::new() }
    }
}

/// Residual of forces and of changes of volume.
#[derive(Clone, Debug)]
pub(crate) struct Residual {
    /// Unbalanced forces of the free degrees of freedom, then changes of volume of the pressures.
    pub values: Vec<f64>,
    /// Norm of the forces.
    pub force: f64,
    /// Norm of the changes of volume.
    pub volume: f64,
}

/// The balance of a body with its derivatives.
pub(crate) struct System<'p> {
    pub body: &'p Body,
    pub sparsity: Arc<Sparsity>,
    pub assembly: Assembly,
    pub factor: Factor,
    pub aggregation: Aggregation,
    /// Method of the present search for an equilibrium, or of the last one.
    pub method: Method,
    /// Whether the last stiffness was not factorised, but has a hierarchy.
    pub iterates: bool,
    /// Whether the present search, or the last one, failed because the factor in the place of conjugate gradients is too large.
    pub refused: bool,
    pub followers: Followers<'p>,
    /// The field of pressure with its coupling to displacements, if there is one.
    pub coupling: Option<Coupling<'p>>,
}

impl<'p> System<'p> {
    /// Prepares what is the same for all θ.
    pub(crate) fn new(body: &'p Body) -> Result<Self> {
        check_supports(body)?;
        let sparsity = Arc::new(Sparsity::new(body));
        let factor = Factor::new(&sparsity)?;
        let (method, _) = Method::Automatic.chosen(body.has_potential(), None, &factor, &sparsity);
        Self::of(body, sparsity, (factor, Aggregation::default(), method))
    }

    /// System of the same body for another thread, or of one with the same cells and supports but another reference configuration; it
    /// shares what is prepared.
    pub(crate) fn like<'q>(&self, body: &'q Body) -> Result<System<'q>> {
        let linear = (self.factor.fresh(), self.aggregation.fresh(), self.method);
        System::of(body, self.sparsity.clone(), linear)
    }

    fn of(
        body: &'p Body,
        sparsity: Arc<Sparsity>,
        (factor, aggregation, method): (Factor, Aggregation, Method),
    ) -> Result<Self> {
        Ok(Self {
            body,
            assembly: Assembly::new(&sparsity, body),
            sparsity,
            factor: if method == Method::Factor { factor.reserved()? } else { factor },
            aggregation,
            method,
            iterates: false,
            refused: false,
            followers: Followers::new(&body.followers),
            coupling: body.pressure_field.as_ref().map(|field| Coupling::new(body, field)),
        })
    }

    /// Number of unknown pressures.
    pub(crate) fn pressures(&self) -> usize {
        self.body.pressure_field.as_ref().map_or(0, |field| field.unknowns)
    }

    /// The reference configuration.
    pub(crate) fn rest(&self) -> Unknowns {
        let displacement = vec![0.0; self.body.prescribed.len()];
        Unknowns { displacement, pressure: vec![0.0; self.pressures()] }
    }

    /// Reference volume of the body.
    pub(crate) fn volume(&self) -> f64 {
        self.body.volumes.iter().sum()
    }

    /// Size of the residual assembled last: forces relative to loads and reactions, or volumes relative to the
    /// body's, whichever is larger. `None` where something overflows.
    pub(crate) fn size(&self, residual: &Residual) -> Option<f64> {
        let forces = residual.force / self.assembly.force_scale.max(f64::MIN_POSITIVE);
        let volumes = residual.volume / self.volume();
        let finite = residual.force.is_finite() && volumes.is_finite() && self.assembly.is_finite();
        finite.then_some(forces.max(volumes))
    }

    /// The derivative of the balance times a change of the unknowns.
    pub(crate) fn apply(&self, from: &[f64], to: &mut [f64]) {
        let free = self.sparsity.unknowns();
        let (displacements, pressures) = from.split_at(free);
        let (forces, volumes) = to.split_at_mut(free);
        self.sparsity.multiply([&self.assembly.matrix; 2], displacements, forces);
        if self.body.has_potential() {
            return;
        }
        let direction = self.sparsity.scattered(displacements.iter().copied());
        let mut full = vec![0.0; direction.len()];
        self.followers.add_skew(&direction, &mut full);
        if let Some(coupling) = &self.coupling {
            coupling.add_forces(pressures, &mut full);
            volumes.fill(0.0);
            coupling.add_volume_changes(&direction, volumes);
            coupling.add_compliance(pressures, volumes);
        }
        let gathered = self.sparsity.gather(&full);
        forces.iter_mut().zip(gathered).for_each(|(force, more)| *force += more);
    }

    /// Change of the unknown displacements from rest to the whole load by the linear model of the unloaded body, with
    /// the prescribed motions \[length\]. Conjugate gradients leave a residual of `tolerance` times the forces.
    pub(crate) fn linear_response(&mut self, theta: &[f64], tolerance: f64) -> Result<Vec<f64>> {
        let rest = self.rest();
        let mut motion = rest.displacement.clone();
        place(self.body, 1.0, &mut motion);
        self.assemble(&rest, theta, 1.0, None);
        let forces: Vec<f64> = self.sparsity.gather(&self.assembly.gradient).collect();
        let mut right = self.assemble(&rest, theta, 0.0, None).values;
        right.splice(..self.sparsity.unknowns(), forces);
        let state = State { load_factor: 0.0, ..State::whole(&rest.displacement, theta) };
        let moved = self.response_to_supports(state, &motion);
        right.iter_mut().zip(moved).for_each(|(r, m)| *r += m);
        let definite = self.body.has_potential();
        let stable = if definite { self.definite_response(&right, tolerance) } else { None };
        let change = match stable {
            Some(change) => change,
            None => {
                let (shift, _) = self.factorise(definite).ok_or(SolveError::Singular)?;
                self.solve(&right, if definite { 0.0 } else { shift })?.0
            }
        };
        self.sparsity.scatter(change, &mut motion);
        Ok(motion)
    }

    /// Norm of the largest gradient of a displacement.
    pub(crate) fn largest_gradient(&self, displacement: &[f64]) -> f64 {
        let squared = |p| self.body.displacement_gradient(p, displacement).squared_norm();
        at_points(self.body.volumes.len(), squared).into_iter().fold(0.0, f64::max).sqrt()
    }

    /// Entries of θ that stress the body at rest and may be zero, such as active stress: they are loads, not
    /// stiffnesses.
    pub(crate) fn stressing_entries(&self, theta: &[f64]) -> Vec<usize> {
        let stresses = |theta: &[f64]| {
            let parameters = self.body.law_parameters(theta);
            let stress = |point| self.body.material.stress(point, parameters, &Mat3::ZERO, None).1;
            (0..self.body.volumes.len()).map(stress).collect::<Vec<_>>()
        };
        let present = stresses(theta);
        let without = |entry: &usize| {
            let mut without = theta.to_vec();
            without[*entry] = 0.0;
            let admissible = self.body.check_theta(&without).is_ok();
            theta[*entry] != 0.0 && admissible && stresses(&without) != present
        };
        (0..self.body.law_parameters(theta).len()).filter(without).collect()
    }
}

/// The loose followers of a body.
pub(crate) struct Followers<'p> {
    surfaces: &'p [PressureSurface],
    /// Forces of each facet, and the skew part of their derivative, where assembled last.
    responses: Vec<SurfaceResponse>,
}

impl<'p> Followers<'p> {
    pub(crate) fn new(surfaces: &'p [PressureSurface]) -> Self {
        Self { surfaces, responses: Vec::new() }
    }

    /// Adds the forces to the gradient, and the symmetric part of their derivative to the matrix; facets are counted from
    /// `first` on.
    pub(crate) fn assemble(
        &mut self,
        assembly: &mut Assembly,
        sparsity: &Sparsity,
        first: usize,
        state: State<'_>,
    ) {
        self.responses.clear();
        for (place, (surface, facet, nodes)) in (first..).zip(facets_of(self.surfaces)) {
            let magnitude = state.load_factor * surface.magnitude.value(state.theta);
            let mut response = SurfaceResponse::default();
            surface.facet_force(facet, state.displacement, &mut response);
            let (size, mut symmetric) = (response.gradient.len(), response.clone());
            for (at, entry) in symmetric.hessian.iter_mut().enumerate() {
                *entry = 0.5 * (*entry + response.hessian[at % size * size + at / size]);
            }
            let force = assembly.add_facet(nodes, sparsity, place, magnitude, &symmetric);
            assembly.force_scale = assembly.force_scale.hypot(force);
            for (entry, symmetric) in response.hessian.iter_mut().zip(&symmetric.hessian) {
                *entry = magnitude * (*entry - symmetric);
            }
            self.responses.push(response);
        }
    }

    /// Adds the skew part of the derivative times `direction` to `forces`.
    pub(crate) fn add_skew(&self, direction: &[f64], forces: &mut [f64]) {
        for ((_, _, nodes), response) in facets_of(self.surfaces).zip(&self.responses) {
            add_product(nodes, 1.0, &response.hessian, direction, forces);
        }
    }

    /// Adds the forces under the whole load to `forces`.
    pub(crate) fn add_forces(&self, displacement: &[f64], theta: &[f64], forces: &mut [f64]) {
        let mut response = SurfaceResponse::default();
        for (surface, facet, nodes) in facets_of(self.surfaces) {
            let magnitude = surface.magnitude.value(theta);
            surface.facet_force(facet, displacement, &mut response);
            for (slot, force) in response.gradient.iter().enumerate() {
                forces[3 * nodes[slot / 3] + slot % 3] += magnitude * force;
            }
        }
    }
}

/// Deviation of a node from its prescribed place, in a rotated frame, that is a rounding error \[relative to its
/// displacement\].
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Sets prescribed degrees of freedom to a fraction of the prescribed motion.
pub(crate) fn place(body: &Body, load_factor: f64, displacement: &mut [f64]) {
    let BodyArrays { prescribed, frames, .. } = &**body;
    for (dof, target) in prescribed.iter().enumerate() {
        let Some(target) = target.map(|u| load_factor * u) else { continue };
        if frames.get(dof / 3).is_none() {
            displacement[dof] = target;
            continue;
        }
        let off = target - frames.component(dof, displacement);
        let node = &displacement[dof / 3 * 3..][..3];
        let moved = node.iter().fold(target.abs(), |most, u| most.max(u.abs()));
        if off.abs() > ROUNDING * moved {
            frames.add(dof, off, displacement);
        }
    }
}

/// A node of a pressure's surface that slides along a plane which its support moves, if there is one. Lids may move.
pub(crate) fn is_moved_rim(body: &Body) -> Option<usize> {
    let slides = |node: usize| {
        let held = &body.prescribed[3 * node..3 * node + 3];
        held.contains(&None) && held.iter().flatten().any(|&u| u != 0.0)
    };
    let surfaces = body.pressures.iter().filter(|surface| surface.lids.is_empty());
    surfaces.flat_map(|surface| &surface.nodes).copied().find(|&node| slides(node))
}

/// The part of a node's vector that is along its held directions.
pub(crate) fn held_part(body: &Body, node: usize, vector: [f64; 3]) -> [f64; 3] {
    let held = |i: &usize| body.prescribed[3 * node + i].is_some();
    let mut part = [0.0; 3];
    for axis in (0..3).filter(held).map(|i| body.frames.axis(3 * node + i)) {
        let along = dot3(&axis, &vector);
        (0..3).for_each(|k| part[k] += along * axis[k]);
    }
    part
}

//! Supports as prescribed degrees of freedom.

use super::{Setup, finite, named_set};
use crate::error::listed;
use crate::frames::Held;
use crate::{Frames, Load, Prescribed, SceneError, Support};
use sinew_mesh::Mesh;
use sinew_num::{Mat3, cross, dot3, sub3};

/// Largest sine of the angle between two directions that count as the same: files have six digits, and their difference
/// would be a rounding error.
const SAME_DIRECTION: f64 = 1e-6;
/// Nodes this close to an axis \[relative to the largest distance from its point\] have no radial direction.
const ON_AXIS: f64 = 1e-9;

impl Held {
    /// Adds a prescribed direction, a unit vector, to those of a node (Gram–Schmidt).
    ///
    /// # Errors
    /// The displacement that follows from the prescribed directions, if it differs.
    fn hold(&mut self, node: usize, direction: [f64; 3], displacement: f64) -> Result<(), f64> {
        let held = &mut self.prescribed[3 * node..3 * node + 3];
        let mut frame = self.frames.get(node).copied().unwrap_or(Mat3::IDENTITY);
        let (mut axis, mut value, mut known) = (direction, displacement, 0.0);
        // Twice: once is inexact for a direction close to the prescribed ones.
        for _ in 0..2 {
            let mut size = value.abs();
            for (own, u) in frame.0.iter().zip(held.iter()).filter_map(|(a, u)| Some((a, (*u)?))) {
                let along = dot3(&axis, own);
                (0..3).for_each(|i| axis[i] -= along * own[i]);
                value -= along * u;
                known += along * u;
                size += (along * u).abs();
            }
            let length = dot3(&axis, &axis).sqrt();
            if length <= SAME_DIRECTION {
                let agrees = value.is_finite() && value.abs() <= SAME_DIRECTION * size;
                return if agrees { Ok(()) } else { Err(known) };
            }
            axis = axis.map(|x| x / length);
            value /= length;
        }
        let mut free: Vec<_> = (0..3).filter(|&i| held[i].is_none()).collect();
        // The place of the nearest coordinate axis: supports along these need no frame.
        free.sort_by(|&i, &j| axis[j].abs().total_cmp(&axis[i].abs()));
        let place = free.remove(0);
        let sign = 1f64.copysign(axis[place]);
        held[place] = Some(sign * value);
        frame.0[place] = axis.map(|x| sign * x);
        complete(&mut frame, place, &free);
        self.frames.insert(node, frame);
        Ok(())
    }
}

/// Makes the axes at the places `free` orthonormal to the others, of which `new` is one.
fn complete(frame: &mut Mat3<f64>, new: usize, free: &[usize]) {
    if let [first, _] = *free {
        let along = frame[new][first];
        let unit = |i: usize| f64::from(u8::from(i == first));
        let rest: [f64; 3] = std::array::from_fn(|i| unit(i) - along * frame[new][i]);
        let length = dot3(&rest, &rest).sqrt();
        frame.0[first] = rest.map(|x| x / length);
    }
    if let Some(&last) = free.last() {
        let normal = cross(&frame[(last + 1) % 3], &frame[(last + 2) % 3]);
        let sign = 1f64.copysign(normal[last]);
        frame.0[last] = normal.map(|x| sign * x);
    }
}

impl<const N: usize> Setup<'_, N> {
    pub(super) fn held(&self) -> Result<Held, SceneError> {
        let prescribed = vec![None; 3 * self.mesh.points.len()];
        let mut held = Held { prescribed, frames: Frames::default() };
        if Mesh::<N>::ELEMENT.dimension == 2 {
            held.prescribed.iter_mut().skip(2).step_by(3).for_each(|u| *u = Some(0.0));
        }
        let is_along_axes = |support: &&Support| {
            matches!(support.displacement, Prescribed::Uniform(_) | Prescribed::PerNode(_))
        };
        let (along_axes, others): (Vec<_>, Vec<_>) =
            self.scene.supports.iter().partition(is_along_axes);
        for support in along_axes.into_iter().chain(others) {
            self.hold_set(support, &mut held)?;
        }
        // Springs may hold what supports do not; the solver checks the rigid motions.
        let foundation =
            self.scene.loads.iter().any(|load| matches!(load, Load::Foundation { .. }));
        let holds = |axis: usize| {
            let dofs = (0..held.prescribed.len()).filter(|&dof| held.prescribed[dof].is_some());
            dofs.map(|dof| held.frames.axis(dof)).any(|along| along[axis].abs() > SAME_DIRECTION)
        };
        let axes = ["x", "y", "z"].into_iter().enumerate();
        let free: Vec<_> = axes.filter(|(axis, _)| !holds(*axis)).map(|(_, name)| name).collect();
        if !free.is_empty() && !foundation {
            return Err(SceneError::Supports(format!(
                "no support holds the body along {}: it is free to move there and has no unique equilibrium; add a support that holds it there",
                free.join(", ")
            )));
        }
        check_loose_nodes(self.mesh, &held.prescribed)?;
        Ok(held)
    }

    /// Holds the nodes of a support along the axes or other directions.
    fn hold_set(&self, support: &Support, held: &mut Held) -> Result<(), SceneError> {
        let name = &support.nodes;
        let nodes = named_set("node", name, &self.mesh.node_sets).map_err(SceneError::Supports)?;
        let what = || format!("the displacement prescribed on `{name}`");
        let hold = |held: &mut Held, node: usize, direction: [f64; 3], second: f64| {
            let differs = |first| self.contradiction(node, direction, [first, second], support);
            held.hold(node, direction, second).map_err(differs)
        };
        let row = |held: &mut Held, node: usize, row: &[Option<f64>; 3]| {
            for (i, axis) in Mat3::IDENTITY.0.into_iter().enumerate() {
                let Some(value) = row[i] else { continue };
                finite(value, what)?;
                hold(held, node, axis, value)?;
            }
            Ok(())
        };
        match &support.displacement {
            Prescribed::PerNode(rows) if rows.len() != nodes.len() => {
                Err(SceneError::Supports(format!(
                    "the support of node set `{name}` lists {} displacements for {} nodes; give one per node",
                    rows.len(),
                    nodes.len()
                )))
            }
            Prescribed::PerNode(rows) => {
                nodes.iter().zip(rows).try_for_each(|(&node, own)| row(held, node, own))
            }
            Prescribed::Uniform(own) => nodes.iter().try_for_each(|&node| row(held, node, own)),
            &Prescribed::Along { direction, displacement } => {
                finite(displacement, what)?;
                let direction = unit(direction, name)?;
                nodes.iter().try_for_each(|&node| hold(held, node, direction, displacement))
            }
            &Prescribed::Radial { point, axis } => {
                let place = || format!("the point on the axis of the support of `{name}`");
                point.iter().try_for_each(|&x| finite(x, place))?;
                let axis = unit(axis, name)?;
                let arm = |node: usize| sub3(&self.mesh.points[node], &point);
                let reach = nodes.iter().map(|&node| dot3(&arm(node), &arm(node)).sqrt());
                let reach = reach.fold(0.0, f64::max);
                for &node in nodes {
                    let around = cross(&axis, &arm(node));
                    let distance = dot3(&around, &around).sqrt();
                    if distance <= ON_AXIS * reach {
                        return Err(SceneError::Supports(format!(
                            "node {node} of `{name}`, at {:?}, is {distance:.1e} away from the axis of its radial support, so it has no radius to move along; take it out of the set, and clamp it",
                            self.mesh.points[node]
                        )));
                    }
                    hold(held, node, axis, 0.0)?;
                    hold(held, node, around.map(|x| x / distance), 0.0)?;
                }
                Ok(())
            }
        }
    }

    fn contradiction(
        &self,
        node: usize,
        direction: [f64; 3],
        [first, second]: [f64; 2],
        support: &Support,
    ) -> SceneError {
        let holds = |other: &&Support| {
            let nodes = self.mesh.node_sets.get(&other.nodes);
            !std::ptr::eq(*other, support) && nodes.is_some_and(|set| set.contains(&node))
        };
        let others: Vec<_> = self.scene.supports.iter().filter(holds).map(|s| &s.nodes).collect();
        let by = match others.is_empty() {
            true => "the plane section or the same set".into(),
            false => format!("those of {}", listed(&others)),
        };
        SceneError::Supports(format!(
            "the support of `{}` prescribes {second} along ({}) for node {node}, but it is held at {first} there by {by}; take the node out of one of the sets, or let the supports agree",
            support.nodes,
            listed(&direction)
        ))
    }
}

/// The unit vector along a direction of a support.
fn unit(direction: [f64; 3], name: &str) -> Result<[f64; 3], SceneError> {
    // Scaled first, so that neither tiny nor huge vectors lose their length.
    let largest = direction.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let scaled = direction.map(|x| x / largest);
    let length = dot3(&scaled, &scaled).sqrt();
    if largest > 0.0 && length.is_finite() {
        return Ok(scaled.map(|x| x / length));
    }
    Err(SceneError::Supports(format!(
        "the support of `{name}` has the direction ({}); give finite components, one of them not 0",
        listed(&direction)
    )))
}

fn check_loose_nodes<const N: usize>(
    mesh: &Mesh<N>,
    prescribed: &[Option<f64>],
) -> Result<(), SceneError> {
    let mut loose: Vec<bool> = prescribed.chunks(3).map(|u| u.contains(&None)).collect();
    mesh.cells.as_flattened().iter().for_each(|&node| loose[node] = false);
    let Some(first) = loose.iter().position(|&l| l) else { return Ok(()) };
    let count = loose.iter().filter(|&&l| l).count();
    Err(SceneError::Supports(format!(
        "{count} nodes belong to no cell (first: node {first}) and are not held; remove them from the mesh"
    )))
}

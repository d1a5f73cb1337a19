//! Loads and elastic supports in plain arrays.

use super::{Setup, finite};
use crate::cavity::{Cavity, FLAT, Surroundings, sorted};
use crate::frames::Held;
use crate::rim::rim_origin;
use crate::{
    FacetRule, Load, PressedLid, PressureSurface, ReferenceLoads, ReferenceSurface, SceneError,
};
use sinew_mesh::{Mesh, extents};
use sinew_num::sub3;
use std::collections::{HashMap, HashSet};

impl<const N: usize> Setup<'_, N> {
    /// Loads and springs per reference volume and area, and forces on nodes.
    pub(super) fn reference_loads(&self) -> Result<ReferenceLoads, SceneError> {
        let shapes = self.rule.iter().map(|p| Mesh::<N>::shape(p.at).to_vec()).collect();
        let mut loads = ReferenceLoads { shapes, ..ReferenceLoads::default() };
        for load in &self.scene.loads {
            match load {
                Load::BodyForce(density) => {
                    density.iter().try_for_each(|&b| finite(b, || "a body force".into()))?;
                    (0..3).for_each(|i| loads.body_force[i] += density[i]);
                }
                Load::NodalForces(forces) => {
                    let (given, nodes) = (forces.len(), self.mesh.points.len());
                    if given != nodes {
                        return Err(SceneError::Body(format!(
                            "the load lists forces on {given} nodes, but the mesh has {nodes}; give one per node"
                        )));
                    }
                    let what = || "a nodal force".into();
                    forces.as_flattened().iter().try_for_each(|&f| finite(f, what))?;
                    loads.nodal.resize(3 * nodes, 0.0);
                    let sums = loads.nodal.iter_mut().zip(forces.as_flattened());
                    sums.for_each(|(sum, force)| *sum += force);
                }
                Load::Traction { facets, value } => {
                    let what = || format!("the traction on `{facets}`");
                    value.iter().try_for_each(|&t| finite(t, what))?;
                    let surface = self.reference_surface(facets)?;
                    loads.surfaces.push(ReferenceSurface { traction: *value, ..surface });
                }
                Load::Foundation { facets, normal, tangential } => {
                    for (&value, which) in [(normal, "normal"), (tangential, "tangential")] {
                        let what =
                            || format!("the {which} stiffness of the foundation on `{facets}`");
                        finite(value, what)?;
                        if value < 0.0 {
                            return Err(SceneError::Loads(format!(
                                "{} is {value}; a foundation pushes back, so give a stiffness of at least 0",
                                what()
                            )));
                        }
                    }
                    let (normal, tangential) = (*normal, *tangential);
                    let surface = self.reference_surface(facets)?;
                    loads.surfaces.push(ReferenceSurface { normal, tangential, ..surface });
                }
                // They depend on the displacement.
                Load::Pressure { .. }
                | Load::CavityPressure { .. }
                | Load::ThesisPressure { .. } => {}
            }
        }
        Ok(loads)
    }

    /// A surface without loads and springs.
    fn reference_surface(&self, name: &str) -> Result<ReferenceSurface, SceneError> {
        Ok(ReferenceSurface {
            rule: FacetRule::of_products::<N>(),
            nodes: self.facet_nodes(name)?.into_iter().flatten().collect(),
            traction: [0.0; 3],
            normal: 0.0,
            tangential: 0.0,
        })
    }

    pub(super) fn nodal_force(
        &self,
        loads: &ReferenceLoads,
        volumes: &[f64],
    ) -> Result<Vec<f64>, SceneError> {
        let force = loads.nodal_force(self.mesh.cells.as_flattened(), volumes, &self.mesh.points);
        for (i, &sum) in force.iter().enumerate() {
            finite(sum, || format!("the sum of the loads on node {}", i / 3))?;
        }
        Ok(force)
    }

    fn facet_nodes(&self, name: &str) -> Result<Vec<Vec<usize>>, SceneError> {
        let facets = self.facets(name)?.iter();
        Ok(facets.map(|&facet| self.mesh.nodes_of_facet(facet).collect()).collect())
    }

    /// The cavities that pressures act in, in three dimensions.
    pub(super) fn cavities(&self, held: &Held) -> Result<Vec<Cavity>, SceneError> {
        let solid = Mesh::<N>::ELEMENT.dimension == 3;
        let names = self.scene.loads.iter().filter_map(Load::pressure).map(|(name, _)| name);
        let mut seen = HashSet::new();
        let names = names.filter(|name| solid && seen.insert(*name));
        names.filter_map(|name| self.cavity(name, held).transpose()).collect()
    }

    fn cavity(&self, name: &str, held: &Held) -> Result<Option<Cavity>, SceneError> {
        let corners = Mesh::<N>::ELEMENT.facet_corners;
        let (own, facets) = (self.facets(name)?, self.facet_nodes(name)?);
        let (own, nodes): (HashSet<_>, HashSet<_>) =
            (own.iter().collect(), facets.iter().flatten().copied().collect());
        let mut beyond = HashMap::new();
        for facet in self.boundary().iter().filter(|facet| !own.contains(facet)) {
            let other: Vec<_> = self.mesh.nodes_of_facet(*facet).collect();
            let edges = (0..corners).flat_map(|k| {
                let [a, b, m] = [k, (k + 1) % corners, corners + k].map(|k| other.get(k).copied());
                [[a, b], [a, m], [m, b]].into_iter().filter_map(|[a, b]| Some(sorted([a?, b?])))
            });
            for edge in edges.filter(|edge| edge.iter().all(|node| nodes.contains(node))) {
                beyond.insert(edge, other[..corners].to_vec());
            }
        }
        let points = &self.mesh.points;
        let places: Vec<_> = nodes.iter().map(|&node| points[node]).collect();
        let even = FLAT * extents(&places).into_iter().fold(0.0, f64::max);
        let mut middle = HashMap::new();
        for nodes in &facets {
            for a in 0..corners {
                let edge = sorted([nodes[a], nodes[(a + 1) % corners]]);
                middle.extend(nodes.get(corners + a).map(|&node| (edge, node)));
            }
        }
        let around = Surroundings { points, held, beyond, middle, even };
        fn of<const K: usize>(facets: &[Vec<usize>]) -> Vec<[usize; K]> {
            facets.iter().map(|nodes| std::array::from_fn(|k| nodes[k])).collect()
        }
        Ok(match N {
            8 => Cavity::new::<4>(name, &of(&facets), &around),
            10 => Cavity::new::<6>(name, &of(&facets), &around),
            _ => Cavity::new::<3>(name, &of(&facets), &around),
        })
    }

    /// The pressures with a potential, and those without.
    pub(super) fn pressures(
        &self,
        held: &Held,
    ) -> Result<(Vec<PressureSurface>, Vec<PressureSurface>), SceneError> {
        let (mut pressures, mut followers) = (Vec::new(), Vec::new());
        let points = &self.mesh.points;
        let about = |origin: [f64; 3]| (vec![origin; points.len()], Vec::new());
        for load in &self.scene.loads {
            let Some((name, magnitude)) = load.pressure() else { continue };
            let (rule, facets) = (FacetRule::of_cells::<N>(), self.facet_nodes(name)?);
            let closed = match load {
                Load::CavityPressure { .. } => self.lids(name, &rule, held),
                Load::ThesisPressure { .. } if N != 4 => Err(SceneError::Loads(format!(
                    "the thesis' pressure is defined on linear tetrahedra (4 nodes), not on cells of {N} nodes; take a pressure, the true follower load"
                ))),
                Load::ThesisPressure { .. } => Ok(about([0.0; 3])),
                _ => rim_origin(name, &rule, &facets, points, held).map(about),
            };
            let may_be_loose =
                self.scene.discretisation.loose_rims && matches!(load, Load::Pressure { .. });
            let ((origins, lids), has_potential) = match closed {
                Ok(closed) => (closed, true),
                Err(_) if may_be_loose => (about(points[facets[0][0]]), false),
                Err(error) => return Err(error),
            };
            let place = |facet: &Vec<usize>| {
                let origin = origins[facet[0]];
                facet.iter().map(move |&node| sub3(&points[node], &origin)).collect::<Vec<_>>()
            };
            let positions = facets.iter().flat_map(place).collect();
            let nodes = facets.into_iter().flatten().collect();
            let thesis = matches!(load, Load::ThesisPressure { .. });
            let surface = PressureSurface { magnitude, thesis, rule, nodes, positions, lids };
            if has_potential { &mut pressures } else { &mut followers }.push(surface);
        }
        Ok((pressures, followers))
    }

    /// Lids over the rims of a surface, and the origins of the volumes that they close, at the corners of its facets.
    fn lids(
        &self,
        name: &str,
        rule: &FacetRule,
        held: &Held,
    ) -> Result<(Vec<[f64; 3]>, Vec<PressedLid>), SceneError> {
        let refuse = |what: &str| {
            SceneError::Loads(format!(
                "the lids of `{name}` close no cavity: {what}; take a pressure without lids, whose rim is held or loose"
            ))
        };
        if rule.dimension == 2 {
            return Err(refuse("a section of triangles has no lids"));
        }
        let cavity = self.cavity(name, held)?;
        let cavity = cavity.ok_or_else(|| refuse("its symmetry planes leave it open"))?;
        let pressed = cavity.pressed(&self.mesh.points, held);
        pressed.ok_or_else(|| {
            refuse("its rim slides in planes that are parallel or that supports move")
        })
    }
}

//! Rims, lids and symmetry planes of a surface.

use super::{CavityPart, Lid, SymmetryPlane, moved, norm};
use crate::Frames;
use sinew_mesh::{TriangleMesh, boundary_facets, extents};
use sinew_num::{Mat3, connected_components, cross, dot3, sub3};
use std::collections::{BTreeMap, HashMap};

/// Distances from a plane that count as rounding errors \[relative to the size of the surface\]: files have six digits.
const FLAT: f64 = 1e-5;
/// Largest sine of the angle between parallel directions, by the same digits.
const PARALLEL: f64 = 1e-4;

/// Surroundings of a surface: nodes, what supports prescribe, and the corners of the boundary's other facets by their edges, nodes
/// ascending.
pub(crate) struct Surroundings<'a> {
    pub points: &'a [[f64; 3]],
    pub prescribed: &'a [Option<f64>],
    pub frames: &'a Frames,
    pub beyond: HashMap<[usize; 2], Vec<usize>>,
}

/// An edge with its nodes ascending.
pub(crate) fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Cells by connected component, in the order of their least nodes.
pub(super) fn components<const K: usize>(
    nodes: usize,
    cells: &[[usize; K]],
) -> Vec<Vec<[usize; K]>> {
    let mut component = vec![0; nodes];
    for (index, found) in connected_components(nodes, cells).iter().enumerate() {
        found.iter().for_each(|&node| component[node] = index);
    }
    let mut groups = BTreeMap::<usize, Vec<_>>::new();
    cells.iter().for_each(|cell| groups.entry(component[cell[0]]).or_default().push(*cell));
    groups.into_values().collect()
}

impl CavityPart {
    /// Closes a connected surface; `None` where symmetry planes leave the volume undetermined.
    pub(super) fn new(triangles: Vec<[usize; 3]>, around: &Surroundings<'_>) -> Option<Self> {
        let surface = TriangleMesh { cells: triangles.clone(), ..TriangleMesh::default() };
        let rim: Vec<[usize; 2]> = boundary_facets(&surface)
            .into_iter()
            .filter_map(|facet| surface.nodes_of_facet(facet).collect::<Vec<_>>().try_into().ok())
            .map(|[a, b]: [usize; 2]| [b, a])
            .collect();
        let rims = components(around.points.len(), &rim);
        let places: Vec<_> =
            triangles.as_flattened().iter().map(|&node| around.points[node]).collect();
        let even = FLAT * extents(&places).into_iter().fold(0.0, f64::max);
        let lids = rims.iter().map(|rim| Lid { edges: rim.clone(), planes: Vec::new() });
        let field = Mat3::from_fn(|i, j| f64::from(u8::from(i == j)) / 3.0);
        let plain = Self { triangles, lids: lids.collect(), planes: Vec::new(), field };
        let Some((planes, lids)) = around.mirrored(&rims, even) else { return Some(plain) };
        if planes.is_empty() {
            return Some(plain);
        }
        let (field, planes) = around.field(&planes, even)?;
        let mirrored = Self { triangles: plain.triangles.clone(), lids, planes, field };
        Some(if mirrored.is_closed(around.points) { mirrored } else { plain })
    }

    /// Whether lids and planes close the surface: then its volume is the same about any origin in the planes.
    fn is_closed(&self, points: &[[f64; 3]]) -> bool {
        let rest = vec![0.0; 3 * points.len()];
        let (_, left) = self.measure(&moved(points, &rest), &mut |_, _| {});
        let area = |&[a, b, c]: &[usize; 3]| {
            let [a, b, c] = [a, b, c].map(|node| points[node]);
            norm(&cross(&sub3(&b, &a), &sub3(&c, &a)))
        };
        norm(&left) <= PARALLEL * self.triangles.iter().map(area).sum::<f64>()
    }
}

/// A plane by its unit normal and a node.
type Plane = ([f64; 3], usize);

impl Surroundings<'_> {
    /// The symmetry planes that rims run along, and the lids over the rest; `None` for a rim between parallel planes. A rim within one
    /// plane has a lid, of the same volume.
    fn mirrored(&self, rims: &[Vec<[usize; 2]>], even: f64) -> Option<(Vec<Plane>, Vec<Lid>)> {
        let (mut planes, mut lids) = (Vec::new(), Vec::new());
        for rim in rims {
            let found: Vec<_> = rim.iter().map(|edge| self.plane(edge, even)).collect();
            let is_first = |plane: &Option<Plane>| match (plane, &found[0]) {
                (Some(plane), Some(first)) => self.is_same(plane, first, even),
                (plane, first) => plane.is_none() && first.is_none(),
            };
            if found.iter().all(is_first) {
                lids.push(Lid { edges: rim.clone(), planes: Vec::new() });
                continue;
            }
            let free: Vec<_> =
                rim.iter().zip(&found).filter(|(_, p)| p.is_none()).map(|(e, _)| *e).collect();
            for edges in components(self.points.len(), &free) {
                let ends =
                    |edge: &[usize; 2]| edge.iter().any(|node| edges.as_flattened().contains(node));
                let touched = rim.iter().zip(&found).filter(|(edge, _)| ends(edge));
                let mut own = Vec::new();
                touched.filter_map(|(_, p)| *p).for_each(|p| self.insert(&mut own, p, even));
                lids.push(Lid { edges, planes: self.meeting(&own, even)? });
            }
            found.into_iter().flatten().for_each(|plane| self.insert(&mut planes, plane, even));
        }
        Some((planes, lids))
    }

    /// The plane that the boundary facet beyond an edge of the rim slides in.
    fn plane(&self, edge: &[usize; 2], even: f64) -> Option<Plane> {
        let facet = self.beyond.get(&sorted(*edge))?;
        let is_level = |normal: &[f64; 3]| {
            let first = self.height(facet[0], normal);
            let heights = facet.iter().map(|&node| self.height(node, normal));
            heights
                .map(|height| Some((height? - first?).abs() <= even))
                .all(|level| level == Some(true))
        };
        // Supports that hold all directions are no symmetry.
        let slides = |node: &&usize| (0..3).any(|i| self.prescribed[3 * **node + i].is_none());
        let dofs = facet.iter().filter(slides).flat_map(|node| 3 * node..3 * node + 3);
        let held = dofs.filter(|&dof| self.prescribed[dof].is_some());
        Some((held.map(|dof| self.frames.axis(dof)).find(is_level)?, edge[0]))
    }

    /// Position along a normal of a node that supports hold in that direction \[length\].
    fn height(&self, node: usize, normal: &[f64; 3]) -> Option<f64> {
        let moved = self.frames.held_along(node, normal, self.prescribed)?;
        Some(dot3(normal, &self.points[node]) + moved)
    }

    fn is_same(&self, plane: &Plane, other: &Plane, even: f64) -> bool {
        let [first, second] = [plane, other].map(|(_, node)| self.height(*node, &other.0));
        let is_level =
            first.zip(second).is_some_and(|(first, second)| (first - second).abs() <= even);
        is_level && are_parallel(plane, other)
    }

    fn insert(&self, planes: &mut Vec<Plane>, plane: Plane, even: f64) {
        if planes.iter().all(|other| !self.is_same(&plane, other, even)) {
            planes.push(plane);
        }
    }

    /// The matrix of the field, and the planes that its origin lies in; `None` where no field has a flux of zero through all planes.
    /// It has no component across parallel planes.
    fn field(&self, planes: &[Plane], even: f64) -> Option<(Mat3<f64>, Vec<SymmetryPlane>)> {
        let has_parallel =
            |plane: &&Plane| planes.iter().filter(|p| are_parallel(plane, p)).count() > 1;
        let across = orthonormal(planes.iter().filter(has_parallel).map(|plane| plane.0));
        let across: Vec<_> = across.into_iter().flatten().collect();
        let within = Mat3::from_fn(|i, j| {
            let lost: f64 = across.iter().map(|q| q[i] * q[j]).sum();
            f64::from(u8::from(i == j)) - lost
        });
        let dimensions = 3 - across.len();
        let mut meeting = Vec::new();
        for plane in planes {
            let part = norm(&within.apply(&plane.0));
            match part {
                _ if part <= PARALLEL => {}
                _ if part >= 1.0 - PARALLEL => meeting.push(*plane),
                _ => return None,
            }
        }
        let meeting = self.meeting(&meeting, even)?;
        let field = Mat3::from_fn(|i, j| within[i][j] / dimensions as f64);
        (dimensions > 0).then_some((field, meeting))
    }

    /// Planes with the steps that project on their intersection; `None` where they do not meet.
    fn meeting(&self, planes: &[Plane], even: f64) -> Option<Vec<SymmetryPlane>> {
        let mut met: Vec<SymmetryPlane> = Vec::new();
        let mut point = planes.first().map_or([0.0; 3], |plane| self.points[plane.1]);
        let units = orthonormal(planes.iter().map(|plane| plane.0));
        for (&(normal, node), unit) in planes.iter().zip(units) {
            let distance = dot3(&normal, &point) - self.height(node, &normal)?;
            let Some(unit) = unit else {
                if distance.abs() > even {
                    return None;
                }
                continue;
            };
            let dual = unit.map(|x| x / dot3(&unit, &normal));
            for other in &mut met {
                let share = dot3(&other.dual, &normal);
                other.dual = sub3(&other.dual, &dual.map(|x| share * x));
            }
            point = sub3(&point, &dual.map(|x| distance * x));
            met.push(SymmetryPlane { node, normal, dual });
        }
        Some(met)
    }
}

fn are_parallel(plane: &Plane, other: &Plane) -> bool {
    norm(&cross(&plane.0, &other.0)) <= PARALLEL
}

/// Part of each unit vector that is orthogonal to those before, as a unit vector; `None` where none is left (Gram–Schmidt).
fn orthonormal(vectors: impl Iterator<Item = [f64; 3]>) -> Vec<Option<[f64; 3]>> {
    let mut units: Vec<Option<[f64; 3]>> = Vec::new();
    for vector in vectors {
        let part = units.iter().flatten().fold(vector, |part, unit| {
            let along = dot3(&part, unit);
            sub3(&part, &unit.map(|x| along * x))
        });
        let length = norm(&part);
        units.push((length > PARALLEL).then(|| part.map(|x| x / length)));
    }
    units
}

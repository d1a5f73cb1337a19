//! Rims, lids and symmetry planes of a surface.

use super::part::{CavityPart, Lid, SymmetryPlane, moved};
use crate::frames::Held;
use sinew_mesh::{TriangleMesh, boundary_facets};
use sinew_num::{Mat3, connected_cells, cross, dot3, norm, sub3};
use std::collections::{BTreeSet, HashMap};

/// Largest sine of the angle between parallel directions, and largest gap of a closed surface \[relative to its area\]: files have six
/// digits.
const PARALLEL: f64 = 1e-4;

/// Distances from a plane that count as rounding errors \[relative to the size of a surface\].
pub(crate) const FLAT: f64 = 1e-5;

/// Surroundings of a surface: nodes, what supports prescribe, and the corners of the boundary's other facets by their edges, nodes
/// ascending.
pub(crate) struct Surroundings<'a> {
    pub points: &'a [[f64; 3]],
    pub held: &'a Held,
    pub beyond: HashMap<[usize; 2], Vec<usize>>,
    /// Distances from a plane that count as rounding errors \[length\].
    pub even: f64,
}

/// An edge with its nodes ascending.
pub(crate) fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// A plane that nodes slide in.
#[derive(Clone, Copy)]
struct Plane {
    normal: [f64; 3],
    /// Place on the normal, and a node there.
    height: f64,
    node: usize,
}

impl CavityPart {
    /// Closes a connected surface; `None` where symmetry planes leave the volume undetermined.
    pub(super) fn new(triangles: Vec<[usize; 3]>, around: &Surroundings<'_>) -> Option<Self> {
        let surface = TriangleMesh { cells: triangles.clone(), ..TriangleMesh::default() };
        let edge = |facet| {
            let mut nodes = surface.nodes_of_facet(facet);
            let [a, b] = [nodes.next()?, nodes.next()?];
            Some([b, a])
        };
        let rim: Vec<_> = boundary_facets(&surface).into_iter().filter_map(edge).collect();
        let rims = connected_cells(around.points.len(), &rim);
        let mirrored = around.mirrored(&rims).filter(|(planes, _)| !planes.is_empty());
        let lids = rims.into_iter().map(|edges| Lid { edges, planes: Vec::new() }).collect();
        let (field, planes) = around.field(&[])?;
        let plain = Self { triangles: triangles.clone(), lids, planes, field };
        let Some((planes, lids)) = mirrored else { return Some(plain) };
        let (field, planes) = around.field(&planes)?;
        let mirrored = Self { triangles, lids, planes, field };
        Some(if mirrored.is_closed(around.points) { mirrored } else { plain })
    }

    /// Whether lids and planes close the surface: then its volume is the same about any origin in the planes.
    fn is_closed(&self, points: &[[f64; 3]]) -> bool {
        let rest = vec![0.0; 3 * points.len()];
        let (_, left) = self.measure(&moved(points, &rest), &mut |_, _| {});
        let area = |nodes: &[usize; 3]| {
            let [a, b, c] = nodes.map(|node| points[node]);
            norm(&cross(&sub3(&b, &a), &sub3(&c, &a)))
        };
        norm(&left) <= PARALLEL * self.triangles.iter().map(area).sum::<f64>()
    }
}

impl Surroundings<'_> {
    /// The symmetry planes that rims run along, and the lids over the rest; `None` for a rim between parallel planes. A rim within one
    /// plane has a lid, of the same volume.
    fn mirrored(&self, rims: &[Vec<[usize; 2]>]) -> Option<(Vec<Plane>, Vec<Lid>)> {
        let (mut planes, mut used, mut lids) = (Vec::new(), BTreeSet::new(), Vec::new());
        for rim in rims {
            let found: Vec<_> = rim.iter().map(|edge| self.plane(*edge, &mut planes)).collect();
            if found.iter().all(|plane| *plane == found[0]) {
                lids.push(Lid { edges: rim.clone(), planes: Vec::new() });
                continue;
            }
            let pairs = || rim.iter().zip(&found);
            let free: Vec<_> =
                pairs().filter(|(_, p)| p.is_none()).map(|(edge, _)| *edge).collect();
            for edges in connected_cells(self.points.len(), &free) {
                let ends =
                    |edge: &[usize; 2]| edge.iter().any(|n| edges.as_flattened().contains(n));
                let own: BTreeSet<usize> =
                    pairs().filter(|(edge, _)| ends(edge)).filter_map(|(_, p)| *p).collect();
                let own: Vec<_> = own.into_iter().map(|plane| planes[plane]).collect();
                lids.push(Lid { planes: self.meeting(&own)?, edges });
            }
            used.extend(found.into_iter().flatten());
        }
        Some((used.into_iter().map(|plane| planes[plane]).collect(), lids))
    }

    /// Index of the plane that the boundary facet beyond an edge of the rim slides in.
    fn plane(&self, edge: [usize; 2], planes: &mut Vec<Plane>) -> Option<usize> {
        let facet = self.beyond.get(&sorted(edge))?;
        // Supports that hold all directions are no symmetry.
        let is_free = |dof: usize| self.held.prescribed[dof].is_none();
        let slides = |node: &&usize| (0..3).any(|i| is_free(3 * **node + i));
        let dofs = facet.iter().filter(slides).flat_map(|node| 3 * node..3 * node + 3);
        let held = dofs.filter(|&dof| !is_free(dof));
        let level = |normal: [f64; 3]| {
            let height = |&node: &usize| {
                Some(dot3(&normal, &self.points[node]) + self.held.along(node, &normal)?)
            };
            let heights = facet.iter().map(height).collect::<Option<Vec<_>>>()?;
            let is_even = heights.iter().all(|other| (other - heights[0]).abs() <= self.even);
            is_even.then_some(Plane { normal, height: heights[0], node: edge[0] })
        };
        let found = held.map(|dof| self.held.frames.axis(dof)).find_map(level)?;
        let is_found = |plane: &Plane| {
            (plane.height - found.height).abs() <= self.even && are_parallel(plane, &found)
        };
        planes.iter().position(is_found).or_else(|| {
            planes.push(found);
            Some(planes.len() - 1)
        })
    }

    /// The matrix of the field, and the planes that its origin lies in; `None` where no field has a flux of zero through all planes.
    /// It has no component across parallel planes.
    fn field(&self, planes: &[Plane]) -> Option<(Mat3<f64>, Vec<SymmetryPlane>)> {
        let has_parallel =
            |plane: &&Plane| planes.iter().filter(|p| are_parallel(plane, p)).count() > 1;
        let double: Vec<_> = planes.iter().filter(has_parallel).copied().collect();
        let across: Vec<_> = orthonormal(&double).into_iter().flatten().collect();
        let within = Mat3::from_fn(|i, j| {
            f64::from(u8::from(i == j)) - across.iter().map(|q| q[i] * q[j]).sum::<f64>()
        });
        let share = |plane: &Plane| norm(&within.apply(&plane.normal));
        let (single, other): (Vec<_>, Vec<_>) =
            planes.iter().copied().partition(|plane| share(plane) > 1.0 - PARALLEL);
        let dimensions = 3 - across.len();
        let is_one = dimensions > 0 && other.iter().all(|plane| share(plane) < PARALLEL);
        let field = Mat3::from_fn(|i, j| within[i][j] / dimensions as f64);
        Some((field, self.meeting(&single).filter(|_| is_one)?))
    }

    /// Planes with the steps that project on their intersection; `None` where they do not meet.
    fn meeting(&self, planes: &[Plane]) -> Option<Vec<SymmetryPlane>> {
        let (mut met, mut point) = (Vec::<SymmetryPlane>::new(), [0.0; 3]);
        for (&Plane { normal, height, node }, unit) in planes.iter().zip(orthonormal(planes)) {
            let distance = dot3(&normal, &point) - height;
            let Some(unit) = unit else {
                (distance.abs() <= self.even).then_some(())?;
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
    norm(&cross(&plane.normal, &other.normal)) <= PARALLEL
}

/// Part of each normal that is orthogonal to those before, as a unit vector; `None` where none is left (Gram–Schmidt).
fn orthonormal(planes: &[Plane]) -> Vec<Option<[f64; 3]>> {
    let mut units: Vec<Option<[f64; 3]>> = Vec::new();
    for Plane { normal, .. } in planes {
        let part = units.iter().flatten().fold(*normal, |part, unit| {
            let along = dot3(&part, unit);
            sub3(&part, &unit.map(|x| along * x))
        });
        let length = norm(&part);
        units.push((length > PARALLEL).then(|| part.map(|x| x / length)));
    }
    units
}

//! Rims, lids and symmetry planes of a surface, and the volume behind it.

use crate::frames::Held;
use sinew_mesh::{TriangleMesh, boundary_facets};
use sinew_num::{Mat3, add3, connected_cells, cross, dot3, norm, sub3};
use std::collections::{BTreeSet, HashMap};

/// Largest sine of the angle between parallel directions, and largest gap of a closed surface \[relative to its area\]: files have six
/// digits.
const PARALLEL: f64 = 1e-4;

/// Distances from a plane that count as rounding errors \[relative to the size of a surface\].
pub(crate) const FLAT: f64 = 1e-5;

/// A connected surface with its closing. Its volume is the flux of a field `S (x − o)` of divergence one.
#[derive(Clone, Debug, PartialEq)]
pub struct CavityPart {
    /// Triangles, counterclockwise seen from outside the solid. The flux through the surface is the sum of theirs, weighted.
    pub triangles: Vec<[usize; 3]>,
    /// Weights of the triangles of a facet, repeated facet by facet: 1 of a flat facet.
    pub weights: Vec<f64>,
    /// Lids, one for each rim.
    pub lids: Vec<Lid>,
    /// Symmetry planes that the origin o lies in: the projection of the first node on them.
    pub planes: Vec<SymmetryPlane>,
    /// The symmetric matrix S, `I/3` without symmetry planes. No flux passes through these.
    pub field: Mat3<f64>,
}

/// A cone over a rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Lid {
    /// Edges of the rim between corners, in the order that makes its triangles go on with the surface. The apex is their mean.
    pub edges: Vec<[usize; 2]>,
    /// Pairs of nodes a, b with weights w: the cone is that over `½ Σ w x_a × x_b`, the area vector of the rim. A rim of quadratic cells
    /// consists of their parabolas.
    pub chords: Vec<([usize; 2], f64)>,
    /// Symmetry planes that the rim ends in. The apex is projected on them.
    pub planes: Vec<SymmetryPlane>,
}

/// A plane that moves with a node, among others that it meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetryPlane {
    /// The node.
    pub node: usize,
    /// Unit normal.
    pub normal: [f64; 3],
    /// Vector of a step towards the plane that leaves the distances from the other planes as they are; `dual·normal = 1`.
    pub dual: [f64; 3],
}

/// Position of a node.
pub(super) type At<'a> = dyn Fn(usize) -> [f64; 3] + 'a;
/// Adds to the derivative in the position of a node.
pub(super) type Add<'a> = dyn FnMut(usize, [f64; 3]) + 'a;

/// Surroundings of a surface: nodes, what supports prescribe, and the corners of the boundary's other facets by their edges, nodes
/// ascending.
pub(crate) struct Surroundings<'a> {
    pub points: &'a [[f64; 3]],
    pub held: &'a Held,
    pub beyond: HashMap<[usize; 2], Vec<usize>>,
    /// Nodes between two corners, ascending.
    pub middle: HashMap<[usize; 2], usize>,
    /// Distances from a plane that count as rounding errors \[length\].
    pub even: f64,
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
    pub(super) fn new<const K: usize>(
        facets: &[[usize; K]],
        around: &Surroundings<'_>,
    ) -> Option<Self> {
        let (split, weights): (Vec<[usize; 3]>, _) = triangles_of(K).into_iter().unzip();
        let triangles = facets.iter().flat_map(|nodes| split.iter().map(|t| t.map(|k| nodes[k])));
        let corners: &[[usize; 3]] = if K == 4 { &[[0, 1, 2], [0, 2, 3]] } else { &[[0, 1, 2]] };
        let cells = facets.iter().flat_map(|nodes| corners.iter().map(|t| t.map(|k| nodes[k])));
        let surface = TriangleMesh { cells: cells.collect(), ..TriangleMesh::default() };
        let edge = |facet| {
            let mut nodes = surface.nodes_of_facet(facet);
            let [a, b] = [nodes.next()?, nodes.next()?];
            Some([b, a])
        };
        let rim: Vec<_> = boundary_facets(&surface).into_iter().filter_map(edge).collect();
        let rims = connected_cells(around.points.len(), &rim);
        let mirrored = around.mirrored(&rims).filter(|(planes, _)| !planes.is_empty());
        let lids = rims.into_iter().map(|edges| around.lid(edges, Vec::new())).collect();
        let (field, planes) = around.field(&[])?;
        let plain = Self { triangles: triangles.collect(), weights, lids, planes, field };
        let Some((planes, lids)) = mirrored else { return Some(plain) };
        let (field, planes) = around.field(&planes)?;
        let mirrored = Self { lids, planes, field, ..plain.clone() };
        Some(if mirrored.is_closed(around.points) { mirrored } else { plain })
    }

    /// Whether lids and planes close the surface: then its volume is the same about any origin in the planes.
    fn is_closed(&self, points: &[[f64; 3]]) -> bool {
        let rest = vec![0.0; 3 * points.len()];
        let (_, left) = self.measure(&moved(points, &rest), &mut |_, _| {});
        let area = |(nodes, weight): (&[usize; 3], &f64)| {
            let [a, b, c] = nodes.map(|node| points[node]);
            weight * norm(&cross(&sub3(&b, &a), &sub3(&c, &a)))
        };
        norm(&left) <= PARALLEL * self.weighted().map(area).sum::<f64>()
    }

    fn weighted(&self) -> impl Iterator<Item = (&[usize; 3], &f64)> {
        self.triangles.iter().zip(self.weights.iter().cycle())
    }

    /// Volume with its sign, and the derivative in the first node's position that comes from the origin: zero on a closed surface.
    pub(super) fn measure(&self, at: &At<'_>, add: &mut Add<'_>) -> (f64, [f64; 3]) {
        let first = self.triangles[0][0];
        let origin = projected(&self.planes, at(first), at);
        let (mut volume, mut of_origin) = (0.0, [0.0; 3]);
        let mut flux = |weight: f64, corners: [[f64; 3]; 3]| {
            let [a, b, c] = corners.map(|x| sub3(&x, &origin));
            let [bc, ca, ab] = [sub3(&c, &b), sub3(&a, &c), sub3(&b, &a)];
            let area = cross(&ca, &ab).map(|x| 0.5 * weight * x);
            let middle = self.field.apply(&add3(&add3(&a, &b), &c).map(|x| x / 3.0));
            let through = self.field.apply(&area);
            volume += dot3(&middle, &area);
            of_origin = sub3(&of_origin, &through);
            [bc, ca, ab].map(|opposite| {
                let turned = cross(&middle, &opposite);
                std::array::from_fn(|i| through[i] / 3.0 + 0.5 * weight * turned[i])
            })
        };
        for (nodes, &weight) in self.weighted() {
            let slopes = flux(weight, nodes.map(at));
            nodes.iter().zip(slopes).for_each(|(&node, slope)| add(node, slope));
        }
        for lid in &self.lids {
            let (apex, mut of_apex) = (lid.apex(at), [0.0; 3]);
            for &([a, b], weight) in &lid.chords {
                let [of_a, of_b, of_cone] = flux(weight, [at(a), at(b), apex]);
                add(a, of_a);
                add(b, of_b);
                of_apex = add3(&of_apex, &of_cone);
            }
            lid.add_slopes(of_apex, at, add);
        }
        let left = add_projected(&self.planes, of_origin, add);
        add(first, left);
        (volume, left)
    }
}

impl Lid {
    pub(super) fn apex(&self, at: &At<'_>) -> [f64; 3] {
        projected(&self.planes, self.mean(at).0, at)
    }

    /// Mean of the rim weighted by lengths of edges, and its whole length.
    pub(super) fn mean(&self, at: &At<'_>) -> ([f64; 3], f64) {
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for &[a, b] in &self.edges {
            let (length, middle) = (norm(&sub3(&at(b), &at(a))), add3(&at(a), &at(b)));
            sum = add3(&sum, &middle.map(|x| 0.5 * length * x));
            whole += length;
        }
        (sum.map(|x| x / whole.max(f64::MIN_POSITIVE)), whole)
    }

    /// Adds the derivatives of a number whose derivative in the apex is given.
    pub(super) fn add_slopes(&self, of_apex: [f64; 3], at: &At<'_>, add: &mut Add<'_>) {
        let of_mean = add_projected(&self.planes, of_apex, add);
        self.add_mean_slopes(of_mean, at, add);
    }

    /// Adds the derivatives of a number whose derivative in the mean of the rim is given.
    pub(super) fn add_mean_slopes(&self, of_mean: [f64; 3], at: &At<'_>, add: &mut Add<'_>) {
        let (mean, whole) = self.mean(at);
        for &[a, b] in &self.edges {
            let (along, middle) = (sub3(&at(b), &at(a)), add3(&at(a), &at(b)).map(|x| 0.5 * x));
            let length = norm(&along);
            if length > 0.0 {
                let stretch = dot3(&of_mean, &sub3(&middle, &mean)) / (length * whole);
                let shift = of_mean.map(|x| 0.5 * length * x / whole);
                add(a, sub3(&shift, &along.map(|x| stretch * x)));
                add(b, add3(&shift, &along.map(|x| stretch * x)));
            }
        }
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
                lids.push(self.lid(rim.clone(), Vec::new()));
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
                lids.push(self.lid(edges, self.meeting(&own)?));
            }
            used.extend(found.into_iter().flatten());
        }
        Some((used.into_iter().map(|plane| planes[plane]).collect(), lids))
    }

    fn lid(&self, edges: Vec<[usize; 2]>, planes: Vec<SymmetryPlane>) -> Lid {
        let of_edge = |&[a, b]: &[usize; 2]| match self.middle.get(&sorted([a, b])) {
            None => vec![([a, b], 1.0)],
            // ∮ x × dx over a parabola.
            Some(&m) => vec![([a, m], 4.0 / 3.0), ([m, b], 4.0 / 3.0), ([a, b], -1.0 / 3.0)],
        };
        let chords = edges.iter().flat_map(of_edge).collect();
        Lid { edges, chords, planes }
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

/// Triangles of a facet by its nodes, with weights: the flux of a field linear in x through the facet is the sum of theirs. A bilinear facet
/// is the mean of both its diagonals; a triangle with middle nodes is the integral over its quadratic map.
fn triangles_of(nodes: usize) -> Vec<([usize; 3], f64)> {
    match nodes {
        4 => [[0, 1, 2], [0, 2, 3], [1, 2, 3], [1, 3, 0]].map(|t| (t, 0.5)).into(),
        6 => {
            let around = (0..3).flat_map(|a| {
                let [b, c] = [1, 2].map(|k| (a + k) % 3);
                let [ab, bc, ca] = [a, b, c].map(|k| 3 + k);
                let adjacent = [([a, b, ab], 0.2), ([a, ab, ca], 1.6)];
                let across = [([a, b, bc], -1.0 / 3.0), ([a, b, ca], -1.0 / 3.0)];
                let inner = [([a, ab, bc], 4.0 / 15.0), ([a, bc, ca], 4.0 / 15.0)];
                [adjacent, across, inner].concat()
            });
            around.chain([([0, 1, 2], 2.0 / 15.0), ([3, 4, 5], 16.0 / 15.0)]).collect()
        }
        _ => vec![([0, 1, 2], 1.0)],
    }
}

/// An edge with its nodes ascending.
pub(crate) fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Position of a node after a displacement.
pub(super) fn moved(points: &[[f64; 3]], u: &[f64]) -> impl Fn(usize) -> [f64; 3] {
    |node| std::array::from_fn(|i| points[node][i] + u[3 * node + i])
}

/// Projection of a point on the intersection of planes.
pub(super) fn projected(planes: &[SymmetryPlane], point: [f64; 3], at: &At<'_>) -> [f64; 3] {
    planes.iter().fold(point, |on, &SymmetryPlane { node, normal, dual }| {
        let distance = dot3(&normal, &sub3(&point, &at(node)));
        sub3(&on, &dual.map(|x| distance * x))
    })
}

/// Derivative in the point from that in its projection; the planes' nodes are given theirs.
pub(super) fn add_projected(
    planes: &[SymmetryPlane],
    of_projected: [f64; 3],
    add: &mut Add<'_>,
) -> [f64; 3] {
    planes.iter().fold(of_projected, |of_point, &SymmetryPlane { node, normal, dual }| {
        let share = normal.map(|x| x * dot3(&dual, &of_projected));
        add(node, share);
        sub3(&of_point, &share)
    })
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

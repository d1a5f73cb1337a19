//! Positions and normals of a mesh against the conditions of a selection.

use super::{Rule, Selection, SelectionError};
use crate::{Facet, Mesh, SELECTION_TOLERANCE, boundary_facets, extents};
use nalgebra::Vector3;
use sinew_num::ascending;
use std::collections::{HashMap, HashSet};

type Point = Vector3<f64>;

/// Places of the nodes and facets of the boundary, and of facets between regions.
pub(super) struct Places<'m, const N: usize> {
    mesh: &'m Mesh<N>,
    pub boundary: Vec<Facet>,
    /// Facets between the regions that the selection names.
    between: HashMap<[String; 2], Vec<Facet>>,
    /// Outward unit normals of the boundary.
    normals: Vec<Point>,
    /// Distance that counts as zero.
    tolerance: f64,
}

/// Selected nodes and facets of the boundary.
pub(super) struct Chosen {
    pub nodes: Vec<bool>,
    pub facets: Vec<bool>,
}

impl<'m, const N: usize> Places<'m, N> {
    pub(super) fn new(mesh: &'m Mesh<N>, selection: &Selection) -> Result<Self, SelectionError> {
        mesh.check()?;
        let mut boundary = boundary_facets(mesh);
        let mut between = HashMap::new();
        for regions in selection.interfaces() {
            let facets = mesh.facets_between(regions)?;
            boundary.extend(&facets);
            between.insert(regions.clone(), facets);
        }
        let boundary = ascending(boundary);
        let normals = boundary.iter().map(|&facet| normal(mesh, facet)).collect();
        let of_cells = mesh.cells.as_flattened().iter().map(|&node| mesh.points[node]);
        let size = extents(&of_cells.collect::<Vec<_>>());
        let diagonal = Point::from(size.map(|edge| edge.max(0.0))).norm();
        Ok(Self { mesh, boundary, between, normals, tolerance: SELECTION_TOLERANCE * diagonal })
    }

    pub(super) fn choose(&self, selection: &Selection) -> Result<Chosen, SelectionError> {
        if let Some(excess) = self.excess(selection)? {
            let nodes = excess.iter().map(|&excess| excess <= self.tolerance).collect();
            return Ok(self.with_facets(nodes));
        }
        match &selection.0 {
            Rule::All(parts) | Rule::Any(parts) => {
                let is_all = matches!(selection.0, Rule::All(_));
                let join = |a: &mut bool, b: bool| *a = if is_all { *a && b } else { *a || b };
                let (first, rest) = parts.split_first().ok_or(SelectionError::NoSelections)?;
                let mut chosen = self.choose(first)?;
                for part in rest {
                    let Chosen { nodes, facets } = self.choose(part)?;
                    chosen.nodes.iter_mut().zip(nodes).for_each(|(a, b)| join(a, b));
                    chosen.facets.iter_mut().zip(facets).for_each(|(a, b)| join(a, b));
                }
                Ok(chosen)
            }
            Rule::Not(inner) => {
                let mut chosen = self.choose(inner)?;
                let all = chosen.nodes.iter_mut().chain(&mut chosen.facets);
                all.for_each(|one| *one = !*one);
                Ok(chosen)
            }
            Rule::Facing { degrees, .. } => {
                let angles = self.angles(selection)?;
                let facets = angles.iter().map(|angle| angle <= degrees).collect();
                Ok(Chosen { nodes: vec![true; self.mesh.points.len()], facets })
            }
            Rule::Set { name } => self.set(name),
            Rule::Between { regions } => Ok(self.of_facets(&self.between[regions], &[])),
            // The others have a distance.
            _ => Ok(self.with_facets(vec![false; self.mesh.points.len()])),
        }
    }

    /// The facets of the boundary all of whose nodes are chosen.
    fn with_facets(&self, nodes: Vec<bool>) -> Chosen {
        let on = |&facet: &Facet| self.mesh.nodes_of_facet(facet).all(|node| nodes[node]);
        let facets = self.boundary.iter().map(on).collect();
        Chosen { nodes, facets }
    }

    /// Facets with their nodes and others.
    fn of_facets(&self, facets: &[Facet], others: &[usize]) -> Chosen {
        let mut nodes = vec![false; self.mesh.points.len()];
        let own = self.mesh.nodes_of_facets(facets);
        own.iter().chain(others).for_each(|&node| nodes[node] = true);
        let facets: HashSet<_> = facets.iter().collect();
        let facets = self.boundary.iter().map(|facet| facets.contains(facet)).collect();
        Chosen { nodes, facets }
    }

    fn set(&self, name: &str) -> Result<Chosen, SelectionError> {
        let Mesh { node_sets, facet_sets, .. } = self.mesh;
        match (facet_sets.get(name), node_sets.get(name)) {
            (Some(facets), others) => Ok(self.of_facets(facets, others.map_or(&[], Vec::as_slice))),
            (None, Some(set)) => Ok(self.with_facets(self.of_facets(&[], set).nodes)),
            (None, None) => {
                let known = node_sets.keys().chain(facet_sets.keys()).cloned().collect();
                Err(SelectionError::UnknownSet { name: name.into(), known })
            }
        }
    }

    /// Distance of each node outside a region, zero or less inside; `None` for conditions without a distance.
    fn excess(&self, selection: &Selection) -> Result<Option<Vec<f64>>, SelectionError> {
        let each = |excess: &dyn Fn(Point) -> f64| {
            Ok(Some(self.mesh.points.iter().map(|x| excess(Point::from(*x))).collect()))
        };
        match &selection.0 {
            Rule::Plane { point, normal, within } => {
                let (at, normal) = (finite(point)?, unit(normal)?);
                let within = distance("the distance from the plane", *within)?;
                each(&|x| (x - at).dot(&normal).abs() - within)
            }
            Rule::HalfSpace { point, direction } => {
                let (at, normal) = (finite(point)?, unit(direction)?);
                each(&|x| (at - x).dot(&normal))
            }
            Rule::Box { least, most } => {
                let [low, high] = [finite(least)?, finite(most)?];
                if let Some(axis) = (0..3).find(|&axis| least[axis] > most[axis]) {
                    let (least, most) = (least[axis], most[axis]);
                    return Err(SelectionError::Corners { axis, least, most });
                }
                each(&|x| (x - x.sup(&low).inf(&high)).norm())
            }
            Rule::Sphere { centre, radius } => {
                let (centre, radius) = (finite(centre)?, distance("the radius", *radius)?);
                each(&|x| (x - centre).norm() - radius)
            }
            Rule::Near { surface, within } => {
                let within = distance("the distance from the surface", *within)?;
                let surface = surface.with_triangles()?;
                each(&|x| surface.distance(x) - within)
            }
            Rule::Nearer { surface, others } => {
                let (surface, others) = (surface.with_triangles()?, others.with_triangles()?);
                each(&|x| surface.distance(x) - others.distance(x))
            }
            Rule::Nearest { point } => {
                let at = finite(point)?;
                let from = |x: &[f64; 3]| (Point::from(*x) - at).norm();
                let least = self.mesh.points.iter().map(from).fold(f64::INFINITY, f64::min);
                each(&|x| (x - at).norm() - least)
            }
            _ => Ok(None),
        }
    }

    /// Degrees between the normals of the boundary and a direction.
    fn angles(&self, selection: &Selection) -> Result<Vec<f64>, SelectionError> {
        let Rule::Facing { direction, degrees } = selection.0 else { return Ok(Vec::new()) };
        let direction = unit(&direction)?;
        if !(0.0..=180.0).contains(&degrees) {
            return Err(SelectionError::Angle { degrees });
        }
        // Better conditioned than an inverse cosine near 0 and 180 degrees.
        let angle =
            |normal: &Point| 2.0 * (normal - direction).norm().atan2((normal + direction).norm());
        Ok(self.normals.iter().map(|normal| angle(normal).to_degrees()).collect())
    }

    /// Explains an empty selection: the count of each of its parts, and the nearest node or facet to an empty part.
    pub(super) fn explain(&self, selection: &Selection) -> Result<String, SelectionError> {
        let parts = match &selection.0 {
            Rule::All(parts) => parts.as_slice(),
            _ => std::slice::from_ref(selection),
        };
        let found: Result<Vec<_>, _> = parts.iter().map(|part| self.explain_part(part)).collect();
        let together = if parts.len() > 1 { "; none is in all of them" } else { "" };
        Ok(format!("{}{together}", found?.join(", ")))
    }

    fn explain_part(&self, part: &Selection) -> Result<String, SelectionError> {
        let (what, chosen) = (part.what(), self.choose(part)?);
        let (members, away, kind) = match part.reads_normals() {
            true => (chosen.facets, self.angles(part)?, "facets"),
            false => (chosen.nodes, self.excess(part)?.unwrap_or_default(), "nodes"),
        };
        let (found, all) = (members.iter().filter(|&&chosen| chosen).count(), members.len());
        let nearest = (0..away.len()).min_by(|&a, &b| away[a].total_cmp(&away[b]));
        let Some(nearest) = nearest.filter(|_| found == 0) else {
            return Ok(format!("{what} holds {found} of {all} {kind}"));
        };
        let least = short(away[nearest]);
        if part.reads_normals() {
            return Ok(format!(
                "{what} holds none of {all} facets, of which the nearest is {least} degrees away"
            ));
        }
        let [x, y, z] = self.mesh.points[nearest].map(short);
        Ok(format!(
            "{what} holds none of {all} nodes; the nearest, node {nearest} at [{x}, {y}, {z}], misses it by {least}"
        ))
    }
}

impl super::Surfaces {
    fn with_triangles(&self) -> Result<&Self, SelectionError> {
        let has = self.distance(Point::zeros()).is_finite();
        if has { Ok(self) } else { Err(SelectionError::EmptySurface) }
    }
}

impl Selection {
    /// Name of a condition in errors.
    fn what(&self) -> &'static str {
        match &self.0 {
            Rule::Plane { .. } => "the plane",
            Rule::HalfSpace { .. } => "the side of the plane",
            Rule::Box { .. } => "the box",
            Rule::Sphere { .. } => "the sphere",
            Rule::Facing { .. } => "the direction",
            Rule::Near { .. } => "the neighbourhood of the surface",
            Rule::Nearer { .. } => "the side of the nearer surface",
            Rule::Nearest { .. } => "the nearest node",
            Rule::Set { .. } => "the set",
            Rule::Between { .. } => "the surface between the regions",
            Rule::All(_) => "the combination",
            Rule::Any(_) => "any of them together",
            Rule::Not(_) => "the rest",
        }
    }
}

/// Four digits, without a tail of zeros.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn finite(point: &[f64; 3]) -> Result<Point, SelectionError> {
    let finite = point.iter().all(|x| x.is_finite());
    if finite { Ok((*point).into()) } else { Err(SelectionError::Point { point: *point }) }
}

fn unit(direction: &[f64; 3]) -> Result<Point, SelectionError> {
    let unit = Point::from(*direction).try_normalize(f64::MIN_POSITIVE);
    let unit = unit.filter(|unit| unit.iter().all(|x| x.is_finite()));
    unit.ok_or(SelectionError::Direction { direction: *direction })
}

fn distance(what: &'static str, value: f64) -> Result<f64, SelectionError> {
    // Written so that a NaN is an error as well.
    let is_distance = value >= 0.0 && value.is_finite();
    is_distance.then_some(value).ok_or(SelectionError::Distance { what, value })
}

/// Outward unit normal of a facet, from its corners; of an edge of triangles, in their plane of constant z.
fn normal<const N: usize>(mesh: &Mesh<N>, facet: Facet) -> Point {
    let corners = mesh.nodes_of_facet(facet).take(Mesh::<N>::ELEMENT.facet_corners);
    let corners: Vec<Point> = corners.map(|node| mesh.points[node].into()).collect();
    let area = match corners.as_slice() {
        [a, b] => (b - a).cross(&Point::z()),
        [a, b, c] => (b - a).cross(&(c - a)),
        [a, b, c, d] => (c - a).cross(&(d - b)),
        _ => Point::zeros(),
    };
    area.try_normalize(0.0).unwrap_or_else(Point::zeros)
}

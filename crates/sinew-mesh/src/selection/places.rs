//! Positions and normals of a mesh against the conditions of a selection.

use super::{Selection, others};
use crate::topology::{Cells, marked};
use crate::{Facet, Mesh, Refusal, SELECTION_TOLERANCE, extents};
use nalgebra::Vector3;
use sinew_num::ascending;
use std::collections::{BTreeMap, HashMap, HashSet};

type Point = Vector3<f64>;

/// Places of the nodes and facets of the boundary, and of facets between regions.
pub(super) struct Places<'m> {
    cells: Cells<'m>,
    points: &'m [[f64; 3]],
    node_sets: &'m BTreeMap<String, Vec<usize>>,
    facet_sets: &'m BTreeMap<String, Vec<Facet>>,
    boundary: Vec<Facet>,
    /// Facets between the regions that the selection names.
    between: HashMap<[String; 2], Vec<Facet>>,
    /// Outward unit normals of the boundary.
    normals: Vec<Point>,
    /// Distance that counts as zero.
    tolerance: f64,
}

/// Whether each node, and behind the nodes each facet, is chosen.
type Chosen = Vec<bool>;

impl<'m> Places<'m> {
    pub(super) fn new<const N: usize>(
        mesh: &'m Mesh<N>,
        selection: &Selection,
    ) -> Result<Self, Refusal> {
        mesh.check()?;
        let Mesh { points, node_sets, facet_sets, .. } = mesh;
        let cells = mesh.cell_list();
        let mut between = HashMap::new();
        for regions in selection.interfaces() {
            between.insert(regions.clone(), mesh.facets_between(regions)?);
        }
        let inner = between.values().flatten().copied();
        let boundary = ascending(cells.boundary().into_iter().chain(inner));
        let normals = boundary.iter().map(|&facet| normal(cells, points, facet)).collect();
        let of_cells: Vec<_> = cells.nodes.iter().map(|&node| points[node]).collect();
        let diagonal = Point::from(extents(&of_cells).map(|edge| edge.max(0.0))).norm();
        let tolerance = SELECTION_TOLERANCE * diagonal;
        Ok(Self { cells, points, node_sets, facet_sets, boundary, between, normals, tolerance })
    }

    /// The chosen nodes: by their positions, or those of the facets where normals decide; in a union those of its parts.
    pub(super) fn nodes(&self, choice: &Selection) -> Result<Vec<usize>, Refusal> {
        if let (Selection::Any(parts), true) = (choice, choice.reads_normals()) {
            let found: Result<Vec<_>, _> = parts.iter().map(|part| self.nodes(part)).collect();
            return Ok(ascending(found?.into_iter().flatten()));
        }
        Ok(match choice.reads_normals() {
            true => self.cells.of_facets(&self.facets(choice)?),
            false => members(&self.choose(choice)?[..self.points.len()]).collect(),
        })
    }

    /// The chosen facets.
    pub(super) fn facets(&self, choice: &Selection) -> Result<Vec<Facet>, Refusal> {
        let chosen = self.choose(choice)?;
        Ok(members(&chosen[self.points.len()..]).map(|at| self.boundary[at]).collect())
    }

    fn choose(&self, selection: &Selection) -> Result<Chosen, Refusal> {
        if let Some(excess) = self.excess(selection)? {
            return Ok(self.with_facets(excess.iter().map(|&excess| excess <= self.tolerance)));
        }
        match selection {
            Selection::All(parts) | Selection::Any(parts) => {
                let is_all = matches!(selection, Selection::All(_));
                let join = |a: &mut bool, b: bool| *a = if is_all { *a && b } else { *a || b };
                let (first, rest) = parts.split_first().ok_or_else(|| {
                    Refusal("a combination of no selections; give at least one".into())
                })?;
                let mut chosen = self.choose(first)?;
                for part in rest {
                    chosen.iter_mut().zip(self.choose(part)?).for_each(|(a, b)| join(a, b));
                }
                Ok(chosen)
            }
            Selection::Not(inner) => Ok(self.choose(inner)?.into_iter().map(|one| !one).collect()),
            Selection::Facing(_, degrees) => {
                let angles = self.angles(selection)?;
                let nodes = self.points.iter().map(|_| true);
                Ok(nodes.chain(angles.iter().map(|angle| angle <= degrees)).collect())
            }
            Selection::Set(name) => self.set(name),
            Selection::Between(regions) => Ok(self.of_facets(&self.between[regions], &[])),
            // The others have a distance.
            _ => Ok(vec![false; self.points.len() + self.boundary.len()]),
        }
    }

    /// Nodes with the facets of the boundary all of whose nodes are chosen.
    fn with_facets(&self, nodes: impl Iterator<Item = bool>) -> Chosen {
        let mut chosen: Chosen = nodes.collect();
        let on = |&facet: &Facet| self.cells.of_facet(facet).all(|node| chosen[node]);
        let facets: Vec<bool> = self.boundary.iter().map(on).collect();
        chosen.extend(facets);
        chosen
    }

    /// Facets with their nodes and others.
    fn of_facets(&self, facets: &[Facet], others: &[usize]) -> Chosen {
        let nodes = [&self.cells.of_facets(facets), others].concat();
        let facets: HashSet<_> = facets.iter().collect();
        let facets = self.boundary.iter().map(|facet| facets.contains(facet));
        marked(self.points.len(), &nodes).into_iter().chain(facets).collect()
    }

    fn set(&self, name: &str) -> Result<Chosen, Refusal> {
        match (self.facet_sets.get(name), self.node_sets.get(name)) {
            (Some(facets), others) => Ok(self.of_facets(facets, others.map_or(&[], Vec::as_slice))),
            (None, Some(set)) => Ok(self.with_facets(marked(self.points.len(), set).into_iter())),
            (None, None) => {
                let known = self.node_sets.keys().chain(self.facet_sets.keys()).cloned();
                let known = others(&known.collect::<Vec<_>>());
                let fault = format!("the mesh has neither node set nor facet set `{name}`{known}");
                Err(Refusal(fault))
            }
        }
    }

    /// Distance of each node outside a region, zero or less inside; `None` for conditions without a distance.
    fn excess(&self, selection: &Selection) -> Result<Option<Vec<f64>>, Refusal> {
        let each = |excess: &dyn Fn(Point) -> f64| {
            Ok(Some(self.points.iter().map(|x| excess(Point::from(*x))).collect()))
        };
        match selection {
            Selection::Plane(point, normal, within) => {
                let (at, normal) = (finite(point)?, unit(normal)?);
                let within = distance("the distance from the plane", *within)?;
                each(&|x| (x - at).dot(&normal).abs() - within)
            }
            Selection::HalfSpace(point, direction) => {
                let (at, normal) = (finite(point)?, unit(direction)?);
                each(&|x| (at - x).dot(&normal))
            }
            Selection::Box(least, most) => {
                let [low, high] = [finite(least)?, finite(most)?];
                if let Some(axis) = (0..3).find(|&axis| least[axis] > most[axis]) {
                    let (axis, from, to) = (["x", "y", "z"][axis], least[axis], most[axis]);
                    return Err(Refusal(format!(
                        "along {axis} the box goes from {from} to {to}; give the smaller corner first"
                    )));
                }
                each(&|x| (x - x.sup(&low).inf(&high)).norm())
            }
            Selection::Sphere(centre, radius) => {
                let (centre, radius) = (finite(centre)?, distance("the radius", *radius)?);
                each(&|x| (x - centre).norm() - radius)
            }
            Selection::Near(surface, within) => {
                let within = distance("the distance from the surface", *within)?;
                let surface = surface.with_triangles()?;
                each(&|x| surface.distance(x) - within)
            }
            Selection::Nearer(surface, others) => {
                let (surface, others) = (surface.with_triangles()?, others.with_triangles()?);
                each(&|x| surface.distance(x) - others.distance(x))
            }
            Selection::Nearest(point) => {
                let at = finite(point)?;
                let from = |x: &[f64; 3]| (Point::from(*x) - at).norm();
                let least = self.points.iter().map(from).fold(f64::INFINITY, f64::min);
                each(&|x| (x - at).norm() - least)
            }
            _ => Ok(None),
        }
    }

    /// Degrees between the normals of the boundary and a direction.
    fn angles(&self, selection: &Selection) -> Result<Vec<f64>, Refusal> {
        let &Selection::Facing(direction, degrees) = selection else { return Ok(Vec::new()) };
        let direction = unit(&direction)?;
        if !(0.0..=180.0).contains(&degrees) {
            let advice = "is not an angle between normals; give 0 to 180 degrees";
            return Err(Refusal(format!("{degrees} {advice}")));
        }
        // Better conditioned than an inverse cosine near 0 and 180 degrees.
        let angle =
            |normal: &Point| 2.0 * (normal - direction).norm().atan2((normal + direction).norm());
        Ok(self.normals.iter().map(|normal| angle(normal).to_degrees()).collect())
    }

    /// Explains an empty selection: the count of each of its parts, and the nearest node or facet to an empty part.
    pub(super) fn explain(&self, selection: &Selection) -> Result<String, Refusal> {
        let parts = match selection {
            Selection::All(parts) => parts.as_slice(),
            _ => std::slice::from_ref(selection),
        };
        let found: Result<Vec<_>, _> = parts.iter().map(|part| self.explain_part(part)).collect();
        let together = if parts.len() > 1 { "; none is in all of them" } else { "" };
        Ok(format!("{}{together}", found?.join(", ")))
    }

    fn explain_part(&self, part: &Selection) -> Result<String, Refusal> {
        let (what, chosen) = (part.what(), self.choose(part)?);
        let (nodes, facets) = chosen.split_at(self.points.len());
        let (chosen, away, kind) = match part.reads_normals() {
            true => (facets, self.angles(part)?, "facets"),
            false => (nodes, self.excess(part)?.unwrap_or_default(), "nodes"),
        };
        let (found, all) = (members(chosen).count(), chosen.len());
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
        let [x, y, z] = self.points[nearest].map(short);
        Ok(format!(
            "{what} holds none of {all} nodes; the nearest, node {nearest} at [{x}, {y}, {z}], misses it by {least}"
        ))
    }
}

impl super::Surfaces {
    fn with_triangles(&self) -> Result<&Self, Refusal> {
        let has = self.distance(Point::zeros()).is_finite();
        let fault = || Refusal("a surface without triangles; give one that has some".into());
        has.then_some(self).ok_or_else(fault)
    }
}

impl Selection {
    /// Name of a condition in errors.
    fn what(&self) -> &'static str {
        match self {
            Self::Plane(..) => "the plane",
            Self::HalfSpace(..) => "the side of the plane",
            Self::Box(..) => "the box",
            Self::Sphere(..) => "the sphere",
            Self::Facing(..) => "the direction",
            Self::Near(..) => "the neighbourhood of the surface",
            Self::Nearer(..) => "the side of the nearer surface",
            Self::Nearest(..) => "the nearest node",
            Self::Set(..) => "the set",
            Self::Between(..) => "the surface between the regions",
            Self::All(_) => "the combination",
            Self::Any(_) => "any of them together",
            Self::Not(_) => "the rest",
        }
    }
}

/// Indices of what is chosen.
fn members(chosen: &[bool]) -> impl Iterator<Item = usize> {
    (0..chosen.len()).filter(|&at| chosen[at])
}

/// Four digits, without a tail of zeros.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn finite(point: &[f64; 3]) -> Result<Point, Refusal> {
    let [x, y, z] = point;
    let fault = format!("[{x}, {y}, {z}] is not a point; give finite coordinates");
    let point = Some(Point::from(*point)).filter(|point| point.iter().all(|x| x.is_finite()));
    point.ok_or(Refusal(fault))
}

fn unit(direction: &[f64; 3]) -> Result<Point, Refusal> {
    let [x, y, z] = direction;
    let advice = "is not a direction; give one of some length, such as [0, 0, 1]";
    let unit = Point::from(*direction).try_normalize(f64::MIN_POSITIVE);
    let unit = unit.filter(|unit| unit.iter().all(|x| x.is_finite()));
    unit.ok_or(Refusal(format!("[{x}, {y}, {z}] {advice}")))
}

fn distance(what: &str, value: f64) -> Result<f64, Refusal> {
    // Written so that a NaN is an error as well.
    let is_distance = value >= 0.0 && value.is_finite();
    let fault = || format!("{what} is {value}; give a number that is not negative");
    is_distance.then_some(value).ok_or_else(|| Refusal(fault()))
}

/// Outward unit normal of a facet, from its corners; of an edge of triangles, in their plane of constant z.
fn normal(cells: Cells<'_>, points: &[[f64; 3]], facet: Facet) -> Point {
    let corners = cells.of_facet(facet).take(cells.element.facet_corners);
    let corners: Vec<Point> = corners.map(|node| points[node].into()).collect();
    let area = match corners.as_slice() {
        [a, b] => (b - a).cross(&Point::z()),
        [a, b, c] => (b - a).cross(&(c - a)),
        [a, b, c, d] => (c - a).cross(&(d - b)),
        _ => Point::zeros(),
    };
    area.try_normalize(0.0).unwrap_or_else(Point::zeros)
}

//! Report on a wall and its fit.

use super::Chamber;
use super::axis::Base;
use super::fit::POLE;
use super::outside::Outside;
use super::trees::{Point, Trees, shown};
use crate::quality::Spread;
use crate::{
    Facet, QualitySummary, TetMesh, TriangleMesh, boundary_facets, extract_surface, quality,
    self_intersections,
};
use std::fmt;

/// The wall of a [`Chamber`] beside the surfaces it was made from; its `Display` is a small table. Lengths and volumes are in
/// the surfaces' own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ChamberReport {
    /// Layers, cells around, and cells from the apex to the base.
    pub cells: [usize; 3],
    /// A point of the base and its normal, away from the apex.
    pub base: [[f64; 3]; 2],
    /// Quality of the tetrahedra.
    pub quality: QualitySummary,
    /// Thickness of the wall along its columns of nodes.
    pub thickness: Spread,
    /// Columns of nodes, and those among them that end short of the outer surface because the thickness jumps there.
    pub columns: [usize; 2],
    /// Columns with nothing outside along the normal of the endocardium, where a surface has a hole or ends: they are as thick
    /// as the wall beside them.
    pub missed: usize,
    /// Volume of the cavity below the base.
    pub cavity_volume: f64,
    /// Volume that the given endocardium encloses.
    pub cavity_volume_of_surface: f64,
    /// Mean and largest distance of the mesh's endocardium from the given one, at its nodes and the middles of its triangles.
    pub endocardium_distance: [f64; 2],
    /// Distances of its outer surface from the nearest one given.
    pub outer_distance: [f64; 2],
    /// Pairs of triangles of the given surfaces that pass through each other below the base, and where the first is.
    pub crossings: (usize, Option<[f64; 3]>),
    /// Pairs of triangles of the mesh's own boundary that pass through each other.
    pub own_crossings: usize,
}

pub(super) fn of(
    chamber: &Chamber<'_>,
    trees: &Trees,
    base: &Base,
    outside: &Outside,
    mesh: &TetMesh,
    cells: [usize; 3],
) -> Option<ChamberReport> {
    let surface = |name: &str| extract_surface(mesh, &mesh.facet_sets[name]);
    let (inner, outer) = (surface("endocardium"), surface("epicardium"));
    let from_outside = |x: Point| {
        let septum = trees.septum.as_ref().map_or(f64::INFINITY, |tree| tree.distance(x));
        trees.epicardium.distance(x).min(septum)
    };
    let boundary: Vec<Facet> = boundary_facets(mesh);
    Some(ChamberReport {
        cells,
        base: [base.centre.into(), base.normal.into()],
        thickness: Spread::of(outside.thickness.clone())?,
        columns: [outside.points.len(), outside.limited],
        missed: outside.missed,
        cavity_volume: volume_below(&inner, base),
        cavity_volume_of_surface: volume_below(chamber.endocardium, base),
        endocardium_distance: distances(&inner, |x| trees.endocardium.distance(x)),
        outer_distance: distances(&outer, from_outside),
        crossings: crossings(chamber, base),
        own_crossings: self_intersections(&extract_surface(mesh, &boundary)).len(),
        quality: quality(mesh)?,
    })
}

/// Mean and largest distance of nodes and middles of triangles.
fn distances(surface: &TriangleMesh, distance: impl Fn(Point) -> f64) -> [f64; 2] {
    let middles = (0..surface.cells.len()).map(|c| surface.corners(c).iter().sum::<Point>() / 3.0);
    let nodes = surface.points.iter().map(|&x| Point::from(x));
    let all: Vec<f64> = nodes.chain(middles).map(distance).collect();
    [all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max)]
}

/// The volume between a surface and the plane of the base above it: the cones of what lies below to a point of the plane, triangles
/// turned away from the axis.
fn volume_below(surface: &TriangleMesh, base: &Base) -> f64 {
    let height = |x: &Point| x.dot(&base.normal);
    let down = (base.apex - base.centre) * (1.0 - POLE);
    let mut sum = 0.0;
    for cell in 0..surface.cells.len() {
        let corners = surface.corners(cell).map(|x| x - base.centre);
        let [a, b, c] = corners;
        let middle = (a + b + c) / 3.0;
        let on_axis = down * (middle.dot(&down) / down.norm_squared()).clamp(0.0, 1.0);
        let outward = (b - a).cross(&(c - a)).dot(&(middle - on_axis)).signum();
        let mut part = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if height(&a) <= 0.0 {
                part.push(a);
            }
            if (height(&a) < 0.0) != (height(&b) < 0.0) {
                part.push(a.lerp(&b, height(&a) / (height(&a) - height(&b))));
            }
        }
        for k in 2..part.len() {
            sum += outward * part[0].cross(&part[k - 1]).dot(&part[k]) / 6.0;
        }
    }
    sum.abs()
}

fn crossings(chamber: &Chamber<'_>, base: &Base) -> (usize, Option<[f64; 3]>) {
    let mut all = TriangleMesh::default();
    let surfaces = [Some(chamber.endocardium), Some(chamber.epicardium), chamber.septum];
    for surface in surfaces.into_iter().flatten() {
        let step = all.points.len();
        all.points.extend(&surface.points);
        all.cells.extend(surface.cells.iter().map(|cell| cell.map(|node| node + step)));
    }
    let middle = |cell: usize| all.corners(cell).iter().sum::<Point>() / 3.0;
    let is_below = |cell: usize| (middle(cell) - base.centre).dot(&base.normal) < 0.0;
    let pairs = self_intersections(&all);
    let mut below = pairs.iter().filter(|[a, b]| is_below(*a) && is_below(*b));
    let first = below.next().map(|[a, _]| middle(*a).into());
    (first.map_or(0, |_| 1 + below.count()), first)
}

impl ChamberReport {
    /// Warnings before the mesh is used, in words; empty where all is well.
    pub fn warnings(&self) -> Vec<String> {
        let (missed, [columns, _], own) = (self.missed, self.columns, self.own_crossings);
        let given = "the given surfaces cross each other or themselves; look at the mesh there";
        let of_mesh = format!(
            "the mesh's boundary crosses itself at {own} pairs of triangles; smooth the surfaces, choose other cells, \
             or put the base further down"
        );
        let holes = format!(
            "{missed} of {columns} columns of nodes met no outer surface and are as thick as the wall beside them; \
             close the holes of the outer surfaces, or put the base further down"
        );
        let all = [(self.crossings.0, given.into()), (own, of_mesh), (missed, holes)];
        all.into_iter().filter(|(count, _)| *count > 0).map(|(_, warning)| warning).collect()
    }
}

impl fmt::Display for ChamberReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [layers, around, along] = self.cells;
        let [base, normal] = self.base.map(shown);
        let Self { quality, missed, own_crossings, .. } = self;
        let Spread { min, median, max } = self.thickness;
        let [columns, limited] = self.columns;
        let (cavity, given) = (self.cavity_volume, self.cavity_volume_of_surface);
        let share = cavity / given;
        let [inner, outer] = [self.endocardium_distance, self.outer_distance]
            .map(|[mean, largest]| format!("mean {mean:.3}, largest {largest:.3}"));
        let (count, first) = self.crossings;
        let at = first.map_or(String::new(), |x| format!(", the first at {}", shown(x)));
        write!(
            f,
            "{layers} layers of {around} cells around and {along} from the apex to the base\n\
             lengths below are in the unit of the surfaces, volumes in its cube\n\
             base at {base}, normal {normal}\n\
             {quality}\n\
             thickness {min:.2} to {max:.2}, median {median:.2}\n\
             cut short where the thickness jumps: {limited} of {columns} columns of nodes\n\
             nothing outside along their normal: {missed} of {columns}\n\
             cavity {cavity:.1}, {share:.4} of the endocardium's {given:.1}\n\
             distance of the endocardium from the given one: {inner}\n\
             distance of the outer surface from the given one: {outer}\n\
             triangles of the given surfaces that cross below the base: {count} pairs{at}\n\
             triangles of the mesh's boundary that cross: {own_crossings} pairs"
        )
    }
}

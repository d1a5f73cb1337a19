//! Walls of heart chambers between segmented surfaces.

mod axis;
mod fault;
mod fit;
mod outside;
mod report;
mod size;
mod trees;

use super::ventricle::Disk;
use super::wall::{InSet, Sheet, Wall, between, side};
use crate::tree::SurfaceTree;
use crate::{HexMesh, Refusal, TetMesh, TriangleMesh, folded_facets, min_dihedral_angle};
use axis::Axis;
use fit::Fit;
use outside::Outside;
pub use report::ChamberReport;
pub use size::{Size, Trim, WallOptions};
use trees::{Point, Trees, shown};

/// Surfaces of a ventricle, as segmentation tools write them: open or closed, of any resolution, with triangles turned
/// either way. The mesh of the wall has the same grid in layers for every heart: a square patch of cells at the apex
/// and rings of cells up to the base. Inner nodes lie on rays from the cavity's axis, outer ones along the normal on
/// the nearest outer surface.
///
/// Requirements: below the base, every ray from the axis meets the endocardium once (smooth a ventricle with deep folds
/// first), and an outer surface lies around it.
///
/// ```
/// use sinew_mesh::{Chamber, Size, TruncatedEllipsoid, WallOptions, extract_surface, quality};
///
/// // Surfaces of an idealised ventricle in place of segmented ones.
/// let ideal = TruncatedEllipsoid { short: [25.0, 36.0], long: [66.0, 75.0], base: 15.0 }.wall([1, 32, 16]).tetrahedra();
/// let surface = |name: &str| extract_surface(&ideal, &ideal.facet_sets[name]);
/// let (endocardium, epicardium) = (surface("endo"), surface("epi"));
///
/// let chamber = Chamber { endocardium: &endocardium, epicardium: &epicardium, septum: None };
/// let wall = chamber.wall(&WallOptions { size: Size::Nodes(1500), ..WallOptions::default() })?;
/// let mesh = wall.tetrahedra();
/// assert!(mesh.points.len().abs_diff(1500) < 150);
/// assert!(quality(&mesh).unwrap().dihedral.min > 14.0);
/// assert!((wall.report().cavity_volume / wall.report().cavity_volume_of_surface - 1.0).abs() < 0.02);
/// # Ok::<(), sinew_mesh::Refusal>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Chamber<'a> {
    /// Inner surface.
    pub endocardium: &'a TriangleMesh,
    /// Outer surface; it may be that of the whole heart.
    pub epicardium: &'a TriangleMesh,
    /// A further outer surface: the endocardium of the other ventricle, whose near side is the septum.
    pub septum: Option<&'a TriangleMesh>,
}

/// Smoothing sweeps of the directions through the wall, and largest slope of its thickness; tried in order until the
/// cells are well shaped.
const TRIES: [(usize, f64); 4] = [(8, 0.6), (16, 0.5), (32, 0.4), (64, 0.3)];
/// Smallest dihedral angle that ends the trials \[degrees\].
const FAIR: f64 = 12.0;

impl Chamber<'_> {
    /// Fits a wall to the surfaces.
    ///
    /// # Errors
    /// Surfaces or options that give none, with places and advice.
    pub fn wall(&self, options: &WallOptions) -> Result<ChamberWall, Refusal> {
        let surfaces = [Some(self.endocardium), Some(self.epicardium), self.septum];
        surfaces.into_iter().flatten().try_for_each(TriangleMesh::check)?;
        let empty = "a surface has no triangles; give an endocardium and an epicardium";
        let empty = || Refusal(empty.into());
        if self.endocardium.cells.is_empty() || self.epicardium.cells.is_empty() {
            return Err(empty());
        }
        fault::units(self.endocardium, self.epicardium).map_or(Ok(()), Err)?;
        let trees = Trees {
            endocardium: SurfaceTree::new(self.endocardium),
            epicardium: SurfaceTree::new(self.epicardium),
            septum: self.septum.map(SurfaceTree::new),
        };
        let axis = Axis::new(self.endocardium);
        let base = axis.base(&trees, &options.trim)?.ok_or_else(|| {
            let fault = fault::of([self.endocardium, self.epicardium], &trees);
            fault.unwrap_or_else(|| axis.no_base())
        })?;
        let fit = Fit::new(&trees, base, self.towards())?;
        let [layers, around, along] = fit.lengths().cells(options)?;
        let disk = Disk { half: around / 8, along };
        let sheet = disk.sheet();
        let inner = fit.inner(&sheet, &disk)?;
        let mut best: Option<(f64, Point, Wall, Outside, TetMesh)> = None;
        for (sweeps, slope) in TRIES {
            let outside = match outside::carry(&trees, &sheet, &inner, &fit.base, sweeps, slope) {
                Ok(outside) => outside,
                Err(error) if best.is_none() => return Err(error),
                // Another trial has succeeded.
                Err(_) => continue,
            };
            let wall = cup(disk.sheet(), layers, &inner, &outside);
            let mesh = wall.tetrahedra();
            let (angle, at) = worst(&mesh);
            if best.as_ref().is_none_or(|(least, ..)| angle > *least) {
                best = Some((angle, at, wall, outside, mesh));
            }
            if angle >= FAIR {
                break;
            }
        }
        let (angle, at, wall, outside, mesh) = best.ok_or_else(empty)?;
        if angle <= 0.0 {
            return Err(Refusal(format!(
                "a cell is inside out at {}: the surfaces turn too sharply there for this size of cells; smooth them, choose other cells, or put the base further down",
                shown(at)
            )));
        }
        let cells = [layers, around, along];
        let report = report::of(self, &trees, &fit.base, &outside, &mesh, cells);
        Ok(ChamberWall { wall, report: report.ok_or_else(empty)? })
    }

    /// Direction of the first grid line around the axis: towards the other ventricle, so that grids of one heart agree.
    fn towards(&self) -> Option<Point> {
        let points = &self.septum?.points;
        Some(points.iter().map(|&x| Point::from(x)).sum::<Point>() / points.len().max(1) as f64)
    }
}

/// The smallest dihedral angle \[degrees\] and the middle of its cell; of a folded mesh minus the number of folds and the middle of the first.
fn worst(mesh: &TetMesh) -> (f64, Point) {
    let middle = |nodes: &[usize]| {
        nodes.iter().map(|&node| Point::from(mesh.points[node])).sum::<Point>() / nodes.len() as f64
    };
    // One of the two cells was inverted before it was made positive.
    let folds = folded_facets(mesh);
    if let Some(&[first, _]) = folds.first() {
        return (-(folds.len() as f64), middle(&mesh.facet_nodes(first)));
    }
    let angles =
        mesh.cells.iter().zip(0..).map(|(nodes, cell)| (min_dihedral_angle(mesh, cell), nodes));
    let least = angles.min_by(|a, b| a.0.total_cmp(&b.0));
    least.map_or((f64::INFINITY, Point::zeros()), |(angle, nodes)| (angle, middle(nodes)))
}

/// A wall fitted to the surfaces of a [`Chamber`], ready to be meshed.
///
/// Its sides are the node sets and facet sets `base`, `endocardium` and `epicardium`, the whole of the outer surface; the
/// facets of the latter that face the other ventricle are the facet set `septum`. The point field `depth` goes from 0 on the
/// endocardium to 1 outside.
#[derive(Debug)]
pub struct ChamberWall {
    wall: Wall,
    report: ChamberReport,
}

impl ChamberWall {
    /// The wall as linear tetrahedra, all of positive volume.
    pub fn tetrahedra(&self) -> TetMesh {
        self.wall.tetrahedra()
    }

    /// The wall as trilinear hexahedra.
    ///
    /// # Errors
    /// A hexahedron that is folded over at a corner; tetrahedra may still do.
    pub fn hexahedra(&self) -> Result<HexMesh, Refusal> {
        let mesh = self.wall.hexahedra();
        mesh.check()?;
        Ok(mesh)
    }

    /// Report on the mesh and its fit to the surfaces.
    pub fn report(&self) -> &ChamberReport {
        &self.report
    }
}

/// The layers between two fitted surfaces. Of the reference body only the sets matter: its points are a node of the sheet,
/// whether that is on the rim, and a depth.
fn cup(mut sheet: Sheet, layers: usize, inner: &[Point], outside: &Outside) -> Wall {
    for (node, at) in sheet.points.iter_mut().enumerate() {
        *at = [node as f64, f64::from(outside::is_rim(at)), 0.0];
    }
    let columns: Vec<[Point; 2]> =
        inner.iter().zip(&outside.points).map(|(&inner, &outer)| [inner, outer]).collect();
    let septum = outside.septum.clone();
    let mut sides = vec![
        ("base", Box::new(|[_, rim, _]: [f64; 3]| rim == 1.0) as InSet),
        ("endocardium", side(2, 0.0)),
        ("epicardium", side(2, 1.0)),
    ];
    if septum.contains(&true) {
        sides.push(("septum", Box::new(move |at| at[2] == 1.0 && septum[at[0] as usize])));
    }
    Wall {
        sheet,
        layers,
        lift: |[node, rim, _], depth| [node, rim, depth],
        depth: |[_, _, depth]| depth,
        place: Box::new(move |[node, _, depth]| {
            let [inner, outer] = columns[node as usize];
            std::array::from_fn(|i| between([inner[i], outer[i]], depth))
        }),
        sides,
        nodes: vec![],
    }
}

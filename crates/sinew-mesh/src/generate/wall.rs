//! Walls: layers over a curved surface of quadrilaterals.

use super::{grid, grid_coordinate};
use crate::{Field, HexMesh, Mesh, QuadraticTetMesh, TetMesh, boundary_facets, repair_orientation};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::fmt;

/// Decides whether a point of the reference body is in a set.
pub(super) type InSet = Box<dyn Fn([f64; 3]) -> bool + Send + Sync>;

/// The points of the reference body with one coordinate at a level.
pub(super) fn side(axis: usize, level: f64) -> InSet {
    Box::new(move |at| at[axis] == level)
}

/// Puts a point of the reference body into its place.
pub(super) type Placement = Box<dyn Fn([f64; 3]) -> [f64; 3] + Send + Sync>;

/// A thick wall made of layers, ready to be meshed with any solid cell. All nodes of a mesh, the
/// middle nodes of quadratic cells included, lie exactly on the surfaces of the body.
///
/// Its sides are node sets and facet sets of every mesh, and the point field `depth` goes from 0 on
/// the inner surface to 1 on the outer one. [`crate::TruncatedEllipsoid`] makes one; others are made of their parts.
///
/// ```
/// use sinew_mesh::{Sheet, Wall};
/// use std::f64::consts::FRAC_PI_2;
///
/// // A quarter of a tube of radii 1 and 2: eight cells around, one along its axis and four layers.
/// let mut sheet = Sheet::default();
/// sheet.patch([8, 1], |[i, j]| ([i, j, 0], [i as f64 / 8.0, j as f64, 0.0]));
/// let tube = Wall {
///     sheet,
///     layers: 4,
///     lift: |[turn, up, _], depth| [turn, up, depth],
///     depth: |[_, _, depth]| depth,
///     place: Box::new(|[turn, up, depth]| {
///         let (sin, cos) = (FRAC_PI_2 * turn).sin_cos();
///         [(1.0 + depth) * cos, (1.0 + depth) * sin, up]
///     }),
///     sides: vec![("inner", Box::new(|at| at[2] == 0.0)), ("outer", Box::new(|at| at[2] == 1.0))],
///     nodes: vec![],
/// };
/// assert_eq!(tube.hexahedra().facet_sets["inner"].len(), 8);
/// ```
pub struct Wall {
    /// Quadrilaterals of the inner surface, in a plane or wherever [`Wall::lift`] takes them from.
    pub sheet: Sheet,
    /// Number of layers.
    pub layers: usize,
    /// The point of the reference body, whose sides are plane, above a point of the sheet at a depth.
    pub lift: fn([f64; 3], f64) -> [f64; 3],
    /// The depth of a point of the reference body.
    pub depth: fn([f64; 3]) -> f64,
    /// The place of a point of the reference body.
    pub place: Placement,
    /// Names of sides, and whether a point of the reference body is on them.
    pub sides: Vec<(&'static str, InSet)>,
    /// Names of other node sets.
    pub nodes: Vec<(&'static str, InSet)>,
}

/// The value between those inside and outside at a depth; exact at both ends.
pub(super) fn between([inner, outer]: [f64; 2], depth: f64) -> f64 {
    (1.0 - depth) * inner + depth * outer
}

impl fmt::Debug for Wall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self.sides.iter().chain(&self.nodes).map(|(name, _)| *name).collect();
        f.debug_struct("Wall")
            .field("cells_per_layer", &self.sheet.quads.len())
            .field("layers", &self.layers)
            .field("sets", &names)
            .finish_non_exhaustive()
    }
}

/// Quadrilaterals in a surface; neighbouring patches share nodes by their keys.
#[derive(Default)]
pub struct Sheet {
    /// Places of the nodes.
    pub points: Vec<[f64; 3]>,
    /// Nodes of the quadrilaterals.
    pub quads: Vec<[usize; 4]>,
    by_key: HashMap<[i64; 3], usize>,
}

impl Sheet {
    /// Adds a quadrilateral by the keys and places of its nodes, which are made where they are met first.
    pub fn quad(&mut self, corners: [([i64; 3], [f64; 3]); 4]) {
        let quad = corners.map(|(key, point)| {
            *self.by_key.entry(key).or_insert_with(|| {
                self.points.push(point);
                self.points.len() - 1
            })
        });
        self.quads.push(quad);
    }

    /// Adds a grid of quadrilaterals, with the keys and places of its nodes.
    pub fn patch(&mut self, cells: [usize; 2], node: impl Fn([i64; 2]) -> ([i64; 3], [f64; 3])) {
        for [i, j] in grid(cells).map(|at| at.map(|k| k as i64)) {
            self.quad([[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(&node));
        }
    }
}

impl Wall {
    /// The wall as trilinear hexahedra; the layers follow each other from the inside.
    ///
    /// # Panics
    /// Without layers, and where a quadrilateral names a point that is not there.
    pub fn hexahedra(&self) -> HexMesh {
        let mut mesh = HexMesh { points: self.reference_points(), ..HexMesh::default() };
        let step = self.sheet.points.len();
        for layer in 0..self.layers {
            for quad in &self.sheet.quads {
                let [a, b, c, d] = quad.map(|node| node + layer * step);
                mesh.cells.push([a, b, c, d, a + step, b + step, c + step, d + step]);
            }
        }
        self.placed(self.named(mesh))
    }

    /// The wall as linear tetrahedra: the hexahedra are cut along the shorter diagonals of the inner
    /// surface into two prisms, and each prism into three tetrahedra.
    ///
    /// # Panics
    /// As [`Wall::hexahedra`].
    pub fn tetrahedra(&self) -> TetMesh {
        self.placed(self.named(self.reference_tetrahedra()))
    }

    /// The wall as quadratic tetrahedra with the corners of [`Wall::tetrahedra`].
    pub fn quadratic_tetrahedra(&self) -> QuadraticTetMesh {
        self.placed(self.named(self.reference_tetrahedra()).quadratic())
    }

    fn reference_points(&self) -> Vec<[f64; 3]> {
        let count = self.sheet.points.len();
        assert!(self.layers > 0, "a wall has at least one layer");
        assert!(
            self.sheet.quads.iter().flatten().all(|&node| node < count),
            "quadrilaterals name points that are there"
        );
        let depths = (0..=self.layers).map(|layer| grid_coordinate(layer, self.layers, 1.0));
        depths.flat_map(|t| self.sheet.points.iter().map(move |&at| (self.lift)(at, t))).collect()
    }

    fn reference_tetrahedra(&self) -> TetMesh {
        let mut mesh = TetMesh { points: self.reference_points(), ..TetMesh::default() };
        let step = self.sheet.points.len();
        for layer in 0..self.layers {
            for triangle in self.sheet.quads.iter().flat_map(|&quad| self.triangles(quad)) {
                // Neighbours agree on the diagonals between them, which all rise with the node number.
                let mut low = triangle.map(|node| node + layer * step);
                low.sort_unstable();
                let ([a, b, c], [d, e, f]) = (low, low.map(|node| node + step));
                mesh.cells.extend([[a, b, c, f], [a, b, e, f], [a, d, e, f]]);
            }
        }
        mesh
    }

    /// Two triangles along the shorter diagonal, as seen on the inner surface.
    fn triangles(&self, [a, b, c, d]: [usize; 4]) -> [[usize; 3]; 2] {
        let place =
            |node: usize| Vector3::from((self.place)((self.lift)(self.sheet.points[node], 0.0)));
        let length = |a: usize, b: usize| (place(a) - place(b)).norm();
        // Diagonals of equal length must not be told apart by their rounding.
        if length(a, c) <= length(b, d) * (1.0 + 1e-9) {
            [[a, b, c], [a, c, d]]
        } else {
            [[b, c, d], [b, d, a]]
        }
    }

    /// Gives a mesh of the reference body its sets and its field.
    fn named<const N: usize>(&self, mut mesh: Mesh<N>) -> Mesh<N> {
        let boundary = boundary_facets(&mesh);
        for (name, in_set) in &self.sides {
            mesh.name_side(&boundary, name, in_set);
        }
        for (name, in_set) in &self.nodes {
            mesh.name_nodes(name, in_set);
        }
        let depth = mesh.points.iter().map(|&at| (self.depth)(at)).collect();
        mesh.point_fields.insert("depth".into(), Field::scalars(depth));
        mesh
    }

    /// Puts a mesh of the reference body into its place.
    fn placed<const N: usize>(&self, mut mesh: Mesh<N>) -> Mesh<N> {
        mesh.map_points(&self.place);
        repair_orientation(&mut mesh);
        mesh
    }
}

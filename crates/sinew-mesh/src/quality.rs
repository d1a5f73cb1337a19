//! Quality of tetrahedra.

use crate::TetMesh;
use std::fmt;

/// Minimum dihedral angle in degrees below which the summary calls a tetrahedron a sliver; a
/// regular one has 70.5. Cheng, Dey & Shewchuk, "Delaunay Mesh Generation" (2012) find the
/// errors and the conditioning of elements to suffer from angles of a few degrees.
pub const SLIVER_ANGLE: f64 = 5.0;

/// The six edges as vertices `[i, j]` with the opposite edge `[k, l]`.
const EDGES: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];

/// The smallest of a tetrahedron's six dihedral angles in degrees: 70.5 in a regular one, 0 in
/// a flat one.
///
/// ```
/// let cube = sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]);
/// assert!((sinew_mesh::min_dihedral_angle(&cube, 0) - 45.0).abs() < 1e-12);
/// ```
pub fn min_dihedral_angle(mesh: &TetMesh, cell: usize) -> f64 {
    let corners = mesh.corners(cell);
    let angle = |[i, j, k, l]: [usize; 4]| {
        let edge = corners[j] - corners[i];
        let towards_k = edge.cross(&(corners[k] - corners[i]));
        let towards_l = edge.cross(&(corners[l] - corners[i]));
        // The angle of the two sides at the edge; atan2 stays exact for small angles.
        let opening = towards_k.cross(&towards_l).norm();
        opening.atan2(towards_k.dot(&towards_l)).to_degrees()
    };
    EDGES.into_iter().map(angle).fold(f64::INFINITY, f64::min)
}

/// A tetrahedron's volume over that of the regular one with the same root mean square edge
/// length: 6√2 V / l³, from 1 (regular) to 0 (flat), negative with the volume (Parthasarathy,
/// Graichen & Hathaway, Finite Elements in Analysis and Design 15, 1994).
pub fn volume_ratio(mesh: &TetMesh, cell: usize) -> f64 {
    let corners = mesh.corners(cell);
    let squares = EDGES.map(|[i, j, ..]| (corners[j] - corners[i]).norm_squared());
    let length = (squares.iter().sum::<f64>() / 6.0).sqrt();
    // A cell whose nodes coincide is as flat as can be.
    if length == 0.0 { 0.0 } else { 6.0 * 2f64.sqrt() * mesh.cell_volume(cell) / length.powi(3) }
}

/// Smallest, middle and largest of some numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The smallest.
    pub min: f64,
    /// The median; of an even count the upper of the two in the middle.
    pub median: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// `None` without numbers.
    pub(crate) fn of(mut numbers: Vec<f64>) -> Option<Self> {
        numbers.sort_by(f64::total_cmp);
        let (&min, &max) = (numbers.first()?, numbers.last()?);
        Some(Spread { min, median: numbers[numbers.len() / 2], max })
    }
}

/// Quality of the tetrahedra of a mesh; its `Display` is a small table.
#[derive(Clone, Debug, PartialEq)]
pub struct QualitySummary {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tetrahedra.
    pub cells: usize,
    /// Volume of all tetrahedra [length unit cubed].
    pub total_volume: f64,
    /// Volumes of the tetrahedra [length unit cubed].
    pub volume: Spread,
    /// [`min_dihedral_angle`] of the tetrahedra in degrees.
    pub dihedral: Spread,
    /// [`volume_ratio`] of the tetrahedra.
    pub ratio: Spread,
    /// The tetrahedron with the smallest dihedral angle.
    pub worst_cell: usize,
    /// Tetrahedra with a dihedral angle below [`SLIVER_ANGLE`], ascending.
    pub slivers: Vec<usize>,
}

/// The quality of all tetrahedra, or `None` without tetrahedra.
pub fn quality(mesh: &TetMesh) -> Option<QualitySummary> {
    let cells = 0..mesh.cells.len();
    let volumes: Vec<f64> = cells.clone().map(|cell| mesh.cell_volume(cell)).collect();
    let angles: Vec<f64> = cells.clone().map(|cell| min_dihedral_angle(mesh, cell)).collect();
    let ratios = cells.clone().map(|cell| volume_ratio(mesh, cell)).collect();
    Some(QualitySummary {
        nodes: mesh.points.len(),
        cells: mesh.cells.len(),
        total_volume: volumes.iter().sum(),
        worst_cell: cells.clone().min_by(|&a, &b| angles[a].total_cmp(&angles[b]))?,
        slivers: cells.filter(|&cell| angles[cell] < SLIVER_ANGLE).collect(),
        volume: Spread::of(volumes)?,
        dihedral: Spread::of(angles)?,
        ratio: Spread::of(ratios)?,
    })
}

impl fmt::Display for QualitySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let QualitySummary { nodes, cells, total_volume, worst_cell, .. } = self;
        writeln!(f, "{nodes} nodes, {cells} tetrahedra, volume {total_volume:.6}")?;
        writeln!(f, "{:<24}{:>12}{:>12}{:>12}", "", "smallest", "median", "largest")?;
        for (name, spread) in [
            ("volume", self.volume),
            ("min dihedral angle [deg]", self.dihedral),
            ("volume ratio", self.ratio),
        ] {
            let Spread { min, median, max } = spread;
            writeln!(f, "{name:<24}{min:>12.4}{median:>12.4}{max:>12.4}")?;
        }
        let count = self.slivers.len();
        write!(f, "slivers below {SLIVER_ANGLE} deg: {count}; worst tetrahedron: {worst_cell}")
    }
}

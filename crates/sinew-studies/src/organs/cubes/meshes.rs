//! The thesis' meshes of the cube, and how long networks on them train.

/// Name on the command line.
pub(crate) const KEY: &str = "cube-meshes";
/// Training time by default \[min\]: every network on every mesh.
pub(crate) fn minutes() -> f64 {
    let networks = |(index, mesh): (usize, &Mesh)| {
        f64::from(u8::from(index > 0) + u8::from(mesh.own || index == 0))
    };
    MESHES.iter().enumerate().map(|pair| networks(pair) * pair.1.minutes).sum()
}

/// A mesh of Table 3.2.
pub(super) struct Mesh {
    /// Cells along an edge.
    pub(super) cells: usize,
    /// Cases that errors are measured on.
    pub(super) cases: usize,
    /// Minutes of training, once from the mesh before and once from scratch.
    pub(super) minutes: f64,
    /// Whether a network starts from scratch too.
    pub(super) own: bool,
    /// Mean error in the slice that the thesis prints \[mm\], and its prediction times \[s\] on a GPU.
    pub(super) thesis: [f64; 3],
}

pub(super) const MESHES: [Mesh; 5] = [
    Mesh { cells: 6, cases: 50, minutes: 1.0, own: true, thesis: [1.3e-3, 1.7e-3, 2.1e-4] },
    Mesh { cells: 9, cases: 50, minutes: 1.0, own: true, thesis: [1.1e-3, 1.9e-3, 2.2e-4] },
    Mesh { cells: 15, cases: 20, minutes: 1.5, own: true, thesis: [1.2e-3, 4.1e-3, 2.4e-4] },
    Mesh { cells: 23, cases: 10, minutes: 3.0, own: false, thesis: [1.1e-3, 1.1e-2, 5.0e-4] },
    Mesh { cells: 27, cases: 10, minutes: 5.0, own: false, thesis: [1.7e-3, 1.6e-2, 5.9e-4] },
];

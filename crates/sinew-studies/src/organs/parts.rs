//! Studies beyond one scene: what they run, and how long.

use sinew::case::{EllipsoidMesh, Exactly};

/// A study beyond one scene.
pub(crate) struct Part {
    /// Name on the command line and of its folder.
    pub key: &'static str,
    /// Training time by default \[min\].
    pub minutes: fn() -> f64,
}

/// All of them, after the scenes: one starts from the network of another.
pub(crate) const PARTS: [Part; 3] = [
    Part { key: CUBES, minutes: minutes_of_cubes },
    Part { key: NEWCOMERS, minutes: || 2.0 * NEWCOMER_S * SHAPES.len() as f64 / 60.0 },
    Part { key: RATES, minutes: minutes_of_rates },
];

/// One network on the thesis' meshes of the cube.
pub(crate) const CUBES: &str = "cube-meshes";

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

/// Every network on every mesh: none goes on to the first.
fn minutes_of_cubes() -> f64 {
    let networks = |index: usize, mesh: &Mesh| f64::from(u8::from(index > 0) + u8::from(mesh.own));
    MESHES.iter().enumerate().map(|(index, mesh)| networks(index, mesh) * mesh.minutes).sum()
}

/// One ventricle's network on others.
pub(crate) const NEWCOMERS: &str = "new-ventricle";
/// The thesis' time to learn a new ventricle, which each shape takes with a network that was trained before and with one that was
/// not \[s\].
pub(super) const NEWCOMER_S: f64 = 90.0;

/// A shape that no training has seen.
pub(super) struct Shape {
    pub(super) name: &'static str,
    pub(super) mesh: Source,
}

#[derive(Clone, Copy)]
pub(super) enum Source {
    /// Between two ellipsoids \[mm\].
    Ellipsoids(EllipsoidMesh),
    /// Between the surfaces of a person's heart: the frame of the beat, and about how many nodes.
    Heart(&'static str, usize),
}

/// Slender, everyday and round, of different resolution; and a real one, of a beat the least and the most filled frame.
pub(super) const SHAPES: [Shape; 5] = [
    shape("slender", [19.0, 30.0], [62.0, 76.0], [2, 24, 14]),
    shape("everyday", [24.0, 36.0], [61.0, 75.0], [2, 32, 14]),
    shape("round", [27.0, 38.0], [52.0, 66.0], [3, 32, 16]),
    Shape { name: "heart-008", mesh: Source::Heart("008", 1500) },
    Shape { name: "heart-000", mesh: Source::Heart("000", 2500) },
];

const fn shape(name: &'static str, short: [f64; 2], long: [f64; 2], cells: [usize; 3]) -> Shape {
    let [short, long] = [Exactly(short), Exactly(long)];
    let mesh = EllipsoidMesh { short, long, base: 0.0, cells: Exactly(cells) };
    Shape { name, mesh: Source::Ellipsoids(mesh) }
}

/// Beams trained at several learning rates.
pub(crate) const RATES: &str = "learning-rates";
/// Time of one network \[s\].
pub(super) const RATE_S: f64 = 20.0;
pub(super) const BEAMS: [&str; 4] =
    ["OnceClampedBeam", "TwiceClampedBeam", "TractionBeamHO", "TractionBeamGuccione"];
/// Rates of Adam, kept to the end; with the last the thesis' trainings diverged.
pub(super) const THESIS: [f64; 4] = [1e-5, 5e-5, 1e-4, 5e-4];
/// Peaks of Muon's rates, about the default.
pub(super) const OURS: [f64; 3] = [2e-3, 8e-3, 3.2e-2];

fn minutes_of_rates() -> f64 {
    RATE_S / 60.0 * (BEAMS.len() * (THESIS.len() + OURS.len())) as f64
}

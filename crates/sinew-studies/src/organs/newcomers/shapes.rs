//! Shapes that no training has seen, and how long networks learn them.

use sinew::case::{EllipsoidMesh, Exactly};

/// Name on the command line.
pub(crate) const KEY: &str = "new-ventricle";
/// Training time by default \[min\]: every shape with a network that was trained before and with one that was not.
pub(crate) const MINUTES: f64 = 2.0 * SECONDS * SHAPES.len() as f64 / 60.0;
/// The thesis' time to learn a new ventricle \[s\].
pub(super) const SECONDS: f64 = 90.0;

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

pub(super) const fn shape(
    name: &'static str,
    short: [f64; 2],
    long: [f64; 2],
    cells: [usize; 3],
) -> Shape {
    let [short, long] = [Exactly(short), Exactly(long)];
    let mesh = EllipsoidMesh { short, long, base: 0.0, cells: Exactly(cells) };
    Shape { name, mesh: Source::Ellipsoids(mesh) }
}

//! The thesis' two gravity beams (§3.3.1), and what the thesis reached on them.

use crate::published::Published;

/// A beam.
#[derive(Debug)]
pub struct Beam {
    /// Short name for files, those of `fixtures/beam` too, and the command line.
    pub name: &'static str,
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// Medians that the thesis prints.
    pub(crate) thesis: Published,
}

/// Both.
pub static BEAMS: [Beam; 2] = [
    Beam {
        name: "once",
        scene: "OnceClampedBeam",
        thesis: Published {
            source: "the thesis’",
            errors: &[
                ("dd", printed([6.5e-3, 0.18, 0.11, 1.7])),
                ("pi", printed([2.0e-2, 8.7e-2, 2.0e-2, 6.6e-2])),
            ],
            displacement: Some([15.7, 50.1]),
        },
    },
    Beam {
        name: "twice",
        scene: "TwiceClampedBeam",
        thesis: Published {
            source: "the thesis’",
            errors: &[
                ("dd", printed([1.1e-2, 0.80, 0.10, 5.3])),
                ("pi", printed([9.6e-3, 3.8e-3, 7.9e-4, 1.6e-3])),
            ],
            displacement: Some([2.3, 6.0]),
        },
    },
];

const fn printed([err_u, err_f, err_i1, err_pi]: [f64; 4]) -> [Option<f64>; 5] {
    [Some(err_u), Some(err_f), Some(err_i1), Some(err_pi), None]
}

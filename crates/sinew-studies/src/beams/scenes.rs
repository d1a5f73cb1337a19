//! The thesis' two gravity beams (§3.3.1): what the thesis reached on them, and solutions by an independent program.

use crate::published::Published;

/// A beam.
#[derive(Debug)]
pub struct Beam {
    /// Short name for files and the command line.
    pub name: &'static str,
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// Medians that the thesis prints.
    pub thesis: Published,
    /// Solutions by an independent program.
    pub fixture: Fixture,
}

/// Files of `fixtures/beam`, made by FEniCS on the same mesh.
#[derive(Clone, Copy, Debug)]
pub struct Fixture {
    /// Parameters (μ, λ) \[kPa\], npy.
    pub theta: &'static [u8],
    /// Nodal displacements \[mm\], npy.
    pub displacement: &'static [u8],
    /// Displacements of a quadratic solution at the same nodes, μ = λ = 75 kPa \[mm\], npy.
    pub quadratic: &'static [u8],
}

macro_rules! fixture {
    ($folder:literal) => {
        Fixture {
            theta: fixture!($folder, "theta"),
            displacement: fixture!($folder, "displacement"),
            quadratic: fixture!($folder, "p2_displacement"),
        }
    };
    ($folder:literal, $array:literal) => {
        include_bytes!(concat!("../../../../fixtures/beam/", $folder, "/", $array, ".npy"))
    };
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
        fixture: fixture!("once"),
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
        fixture: fixture!("twice"),
    },
];

const fn printed([err_u, err_f, err_i1, err_pi]: [f64; 4]) -> [Option<f64>; 5] {
    [Some(err_u), Some(err_f), Some(err_i1), Some(err_pi), None]
}

//! The scenes, and what the thesis prints about them.

use crate::published::Published;

/// A scene of the thesis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Organ {
    /// Name on the command line and of its folder.
    pub key: &'static str,
    /// Name of the built-in scene.
    pub scene: &'static str,
    /// File of its mesh, where that is published and not made.
    pub mesh: Option<&'static str>,
    /// Built-in scene in its place where the file is absent.
    pub stand_in: Option<&'static str>,
    /// Cases that errors are measured on.
    pub test: usize,
    /// Simulations that a regression learns from.
    pub simulations: usize,
    /// Training time of a network by default \[min\].
    pub minutes: f64,
    /// Printed figures of the thesis: medians of err_u \[mm\], err_F, err_I1, err_Π and err_V [%], and displacements.
    pub thesis: Published,
    /// Notes beside the numbers.
    pub note: &'static str,
}

const BASE: Organ = Organ {
    key: "",
    scene: "",
    mesh: None,
    stand_in: None,
    test: 100,
    simulations: 100,
    minutes: 10.0,
    thesis: Published { source: "thesis", errors: &[], displacement: None },
    note: "",
};

/// All of them, in the order of the thesis.
pub(crate) const ORGANS: &[Organ] = &[
    Organ {
        key: "twisting-cube",
        scene: "TwistingCube",
        test: 50,
        simulations: 50,
        minutes: 2.0,
        thesis: printed(&[("", [Some(8.5e-4), None, Some(1.2e-2), None, None])], [1.1, 3.5]),
        ..BASE
    },
    Organ {
        key: "liver",
        scene: "Liver",
        mesh: Some("liver.vtk"),
        stand_in: Some("IdealLiver"),
        minutes: 3.0,
        thesis: printed(&[("", [Some(8.8e-3), None, Some(1.9e-2), None, None])], [7.9, 58.5]),
        ..BASE
    },
    Organ {
        key: "ventricle",
        scene: "LeftVentricle",
        mesh: Some("left_ventricle.vtk"),
        stand_in: Some("IdealVentricle"),
        minutes: 8.0,
        thesis: VENTRICLE,
        note: "Under the true follower pressure of the cavity; the thesis' figures are for its stand-in, which moves the nodes \
               40 % further. The fibres are the published ones, of which 28 % are off because signs disagreed when they were \
               averaged.",
        ..BASE
    },
    Organ {
        key: "ventricle-thesis",
        scene: "LeftVentricleThesis",
        mesh: Some("left_ventricle.vtk"),
        minutes: 6.0,
        thesis: VENTRICLE,
        note: "The thesis' own variants of law and pressure. Its stand-in for the pressure moves soft walls so far that what outputs \
               follow has an error of 5 %, which the network learns slowly: half of the error for three times the steps.",
        ..BASE
    },
    Organ {
        key: "biventricle",
        scene: "Biventricle",
        minutes: 4.0,
        note: "The thesis prints a mean err_u of 0.048 mm for one case on a shape of its own; ours is made here.",
        ..BASE
    },
];

const VENTRICLE: Published =
    printed(&[("", [Some(2.8e-2), Some(0.19), Some(4.7e-2), None, Some(3.7e-2)])], [6.8, 26.3]);

const fn printed(
    errors: &'static [(&'static str, [Option<f64>; 5])],
    displacement: [f64; 2],
) -> Published {
    Published { source: "thesis", errors, displacement: Some(displacement) }
}

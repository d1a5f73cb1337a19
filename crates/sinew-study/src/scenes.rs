//! The thesis' two gravity beams (§3.3.1), and what the thesis reached on them.

use crate::report::ThesisReference;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_mesh::box_tetrahedra;

/// Weight of a density of 1 g/cm³ at g = 9.8 m/s² [kPa/mm].
const GRAVITY: f64 = 9.8e-3;
/// Cells of both beams along x, y and z; each is split into six tetrahedra.
const CELLS: [usize; 3] = [12, 4, 5];

/// A beam with what a report says about it.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Short name for files and the command line.
    pub name: &'static str,
    /// Name in the thesis.
    pub title: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    /// Mesh, law, load, supports and parameter range.
    pub scene: Scene<NeoHookean, 0>,
    /// Medians that the thesis prints.
    pub thesis: ThesisReference,
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
        include_bytes!(concat!("../../../fixtures/beam/", $folder, "/", $array, ".npy"))
    };
}

/// OnceClampedBeam: 100 × 10 × 10 mm, clamped at x = 0, hanging under its weight.
pub fn once_clamped() -> Beam {
    Beam {
        name: "once",
        title: "OnceClampedBeam",
        description: "neo-Hookean beam of 100 × 10 × 10 mm, clamped at one end, under its own weight",
        scene: beam("OnceClampedBeam", [100.0, 10.0, 10.0], &["x_min"]),
        thesis: ThesisReference {
            dd: [6.5e-3, 0.18, 0.11, 1.7],
            pi: [2.0e-2, 8.7e-2, 2.0e-2, 6.6e-2],
            displacement_mm: [15.7, 50.1],
        },
        fixture: fixture!("once"),
    }
}

/// TwiceClampedBeam: 150 × 10 × 2 mm, clamped at both ends, sagging under its weight.
pub fn twice_clamped() -> Beam {
    Beam {
        name: "twice",
        title: "TwiceClampedBeam",
        description: "neo-Hookean strip of 150 × 10 × 2 mm, clamped at both ends, under its own weight",
        scene: beam("TwiceClampedBeam", [150.0, 10.0, 2.0], &["x_min", "x_max"]),
        thesis: ThesisReference {
            dd: [1.1e-2, 0.80, 0.10, 5.3],
            pi: [9.6e-3, 3.8e-3, 7.9e-4, 1.6e-3],
            displacement_mm: [2.3, 6.0],
        },
        fixture: fixture!("twice"),
    }
}

fn beam(name: &str, extent: [f64; 3], clamped: &[&str]) -> Scene<NeoHookean, 0> {
    let scene = Scene::new(box_tetrahedra(extent, CELLS), NeoHookean)
        .named(name)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -GRAVITY]));
    clamped.iter().fold(scene, |scene, side| scene.support(Support::clamped(*side)))
}

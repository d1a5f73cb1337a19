//! Scenes that come with the program, as case files to run or to start from.

use std::path::Path;

/// A built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Name; upper and lower case are the same.
    pub name: &'static str,
    /// Text of the case file.
    pub text: &'static str,
}

macro_rules! scenes {
    ($($name:literal: $file:literal),* $(,)?) => {
        &[$(BuiltIn { name: $name, text: include_str!(concat!("../scenes/", $file)) }),*]
    };
}

/// All of them: those of the thesis, with their names there, organs that need no mesh file, and the benchmarks of Land et al. (2015).
pub const SCENES: &[BuiltIn] = scenes! {
    "OnceClampedBeam": "once_clamped_beam.toml",
    "TwiceClampedBeam": "twice_clamped_beam.toml",
    "RefinedBeam": "refined_beam.toml",
    "TwistingCube": "twisting_cube.toml",
    "TractionBeamHO": "traction_beam_ho.toml",
    "TractionBeamGuccione": "traction_beam_guccione.toml",
    "Biventricle": "biventricle.toml",
    "IdealVentricle": "ideal_ventricle.toml",
    "LeftVentricle": "left_ventricle.toml",
    "LeftVentricleThesis": "left_ventricle_thesis.toml",
    "LeftVentricleNeoHookean": "left_ventricle_neo_hookean.toml",
    "Liver": "liver.toml",
    "Land1": "land_1.toml",
    "Land2": "land_2.toml",
    "Land3": "land_3.toml",
};

/// The scene of a name, in upper or lower case.
pub fn find(name: &Path) -> Option<&'static BuiltIn> {
    let name = name.to_str()?;
    SCENES.iter().find(|scene| scene.name.eq_ignore_ascii_case(name))
}

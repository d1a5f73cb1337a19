//! Two scenes and a part with the times of the study.

#[path = "../../../src/organs/cubes/meshes.rs"]
#[allow(dead_code)]
mod meshes;

pub(crate) struct Organ {
    pub(crate) key: &'static str,
    pub(crate) minutes: f64,
}

pub(crate) const ORGANS: &[Organ] =
    &[Organ { key: "twisting-cube", minutes: 2.0 }, Organ { key: "liver", minutes: 3.0 }];

pub(crate) struct Part {
    pub(crate) key: &'static str,
    pub(crate) minutes: fn() -> f64,
}

pub(crate) const PARTS: [Part; 1] = [Part { key: meshes::KEY, minutes: meshes::minutes }];

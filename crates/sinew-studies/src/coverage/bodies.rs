//! Bodies with wide ranges, limit points and buckling, for which no estimate was tuned.

use crate::shapes::BeamShape;
use crate::ventricle_shape::VentricleShape;
use anyhow::{Context, Result};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew::{Body, Case};
use std::path::Path;

/// Case file of ventricles, also of those of random shape.
const VENTRICLE: &str = include_str!("bodies/ventricle.toml");

/// Case file of a body by its name.
pub(super) const CASES: [(&str, &str); 14] = [
    ("soft block", include_str!("bodies/soft-block.toml")),
    ("hanging block", include_str!("bodies/hanging-block.toml")),
    ("block over a decade", include_str!("bodies/block-over-a-decade.toml")),
    ("quadratic block", include_str!("bodies/quadratic-block.toml")),
    ("averaged block", include_str!("bodies/averaged-block.toml")),
    ("beam over a decade", include_str!("bodies/beam-over-a-decade.toml")),
    ("column that buckles", include_str!("bodies/column-that-buckles.toml")),
    ("twisted cube", include_str!("bodies/twisted-cube.toml")),
    ("slab on springs", include_str!("bodies/slab-on-springs.toml")),
    ("ventricle", VENTRICLE),
    ("ventricle over a decade", include_str!("bodies/ventricle-over-a-decade.toml")),
    ("Guccione ventricle", include_str!("bodies/guccione-ventricle.toml")),
    ("balloon beyond its limit", include_str!("bodies/balloon-beyond-its-limit.toml")),
    ("biventricle", include_str!("bodies/biventricle.toml")),
];

/// Shape numbers of beams of random shape.
pub(super) const SHAPES: [[f64; 3]; 2] = [[0.8, -0.6, 0.9], [-0.7, 0.9, -0.8]];

/// Published meshes with a newcomer's case, where there are such.
const PUBLISHED: [(&str, &str); 2] =
    [("liver", "liver.vtk"), ("left ventricle", "left_ventricle.vtk")];

/// All bodies with their names; published ones where the folder has their mesh.
pub(super) fn all(meshes: &Path) -> Result<Vec<(String, Body)>> {
    let mut found = Vec::new();
    for (name, text) in CASES {
        let case = Case::parse(text, name).with_context(|| name.to_string())?;
        found.push((name.to_string(), case.body().with_context(|| name.to_string())?));
    }
    for (number, shape) in SHAPES.iter().enumerate() {
        found.push((format!("beam of shape {number}"), beam(shape)?));
    }
    for (name, file) in PUBLISHED {
        let path = meshes.join(file);
        if !path.exists() {
            eprintln!("{name} is left out: there is no {} (--meshes)", path.display());
            continue;
        }
        let case = match name {
            "liver" => Case::parse(include_str!("bodies/liver.toml"), name)?,
            _ => Case::read(Path::new("LeftVentricle"))?,
        };
        found.push((name.to_string(), case.with_mesh(path).body()?));
    }
    Ok(found)
}

/// A beam under its weight, over a decade of stiffness.
fn beam(numbers: &[f64]) -> Result<Body> {
    let mesh = BeamShape::new(numbers)?.tetrahedra([8, 2, 2])?;
    Ok(Case::parse(include_str!("bodies/beams.toml"), "beams")?.body_on(mesh.into())?)
}

/// Populations of bodies of random shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shapes {
    Beams,
    Ventricles,
}

impl Shapes {
    pub(super) const ALL: [Self; 2] = [Self::Beams, Self::Ventricles];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Beams => "beams of random shape",
            Self::Ventricles => "ventricles of random shape",
        }
    }

    /// The body of a number, the same for the same; the mean one for `None`.
    pub(super) fn body(self, number: Option<u64>) -> Result<Body> {
        let Some(number) = number else {
            return self.of(&[])?.context("the mean shape has a mesh");
        };
        let mut random = ChaCha8Rng::seed_from_u64(number);
        loop {
            let numbers: Vec<f64> = (0..self.numbers()).map(|_| normal(&mut random)).collect();
            // Some numbers make no mesh.
            if let Some(body) = self.of(&numbers)? {
                return Ok(body);
            }
        }
    }

    fn numbers(self) -> usize {
        match self {
            Self::Beams => BeamShape::NUMBERS,
            Self::Ventricles => VentricleShape::NUMBERS,
        }
    }

    fn of(self, numbers: &[f64]) -> Result<Option<Body>> {
        match self {
            Self::Beams => Ok(beam(numbers).ok()),
            Self::Ventricles => {
                let mesh =
                    VentricleShape::new(numbers).and_then(|shape| shape.tetrahedra([1, 16, 6]));
                let Ok(mesh) = mesh else { return Ok(None) };
                Ok(Some(Case::parse(VENTRICLE, "ventricle")?.body_on(mesh.into())?))
            }
        }
    }
}

/// A number of standard normal distribution by the sum of twelve uniform ones: bounded, as shapes have to be.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

//! Bodies with wide ranges, limit points and buckling, for which no estimate was tuned.

use crate::shapes::BeamShape;
use anyhow::{Context, Result};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew::{Body, Case};
use sinew_mesh::VentricleShape;
use std::path::Path;

/// Case file of a body by its name.
pub(super) const CASES: [(&str, &str); 14] = [
    ("soft block", SOFT_BLOCK),
    ("hanging block", HANGING_BLOCK),
    ("block over a decade", WIDE_BLOCK),
    ("quadratic block", QUADRATIC_BLOCK),
    ("averaged block", AVERAGED_BLOCK),
    ("beam over a decade", WIDE_BEAM),
    ("column that buckles", COLUMN),
    ("twisted cube", TWISTED_CUBE),
    ("slab on springs", SLAB),
    ("ventricle", VENTRICLE),
    ("ventricle over a decade", WIDE_VENTRICLE),
    ("Guccione ventricle", GUCCIONE),
    ("balloon beyond its limit", BALLOON),
    ("biventricle", BIVENTRICLE),
];

/// Shape numbers of beams of random shape.
pub(super) const SHAPES: [[f64; 3]; 2] = [[0.8, -0.6, 0.9], [-0.7, 0.9, -0.8]];

/// Published meshes with a newcomer's case, where there are such.
const PUBLISHED: [(&str, &str); 2] =
    [("liver", "liver.vtk"), ("left ventricle", "left_ventricle.vtk")];

const SOFT_BLOCK: &str = r#"
law = "neo-hookean-young"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [90.0, 60.0, 40.0], cells = [6, 4, 3] } }
parameters = { E = [1.0, 6.0], nu = [0.3, 0.45] }
"#;

const HANGING_BLOCK: &str = r#"
law = "neo-hookean-young"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "z_max" }]
mesh = { box = { extent = [60.0, 60.0, 120.0], cells = [3, 3, 7] } }
parameters = { E = [1.0, 6.0], nu = [0.3, 0.45] }
"#;

const WIDE_BLOCK: &str = r#"
law = "neo-hookean-young"
loads = [{ body_force = [3e-3, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [60.0, 50.0, 30.0], cells = [6, 4, 3] } }
parameters = { E = [1.0, 10.0], nu = [0.1, 0.49] }
"#;

const QUADRATIC_BLOCK: &str = r#"
law = "neo-hookean-young"
formulation = "quadratic"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [60.0, 30.0, 30.0], cells = [4, 2, 2] } }
parameters = { E = [1.0, 8.0], nu = [0.2, 0.45] }
"#;

const AVERAGED_BLOCK: &str = r#"
law = "neo-hookean-young"
formulation = "averaged"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [60.0, 30.0, 30.0], cells = [6, 3, 3] } }
parameters = { E = [2.0, 10.0], nu = [0.4, 0.49] }
"#;

const WIDE_BEAM: &str = r#"
law = "neo-hookean"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [100.0, 10.0, 10.0], cells = [12, 2, 2] } }
parameters = { mu = [10.0, 100.0], lambda = [10.0, 1000.0] }
"#;

const COLUMN: &str = r#"
law = "neo-hookean"
loads = [{ body_force = [2e-5, 1e-5, -9.8e-3] }]
supports = [{ clamped = "z_min" }]
mesh = { box = { extent = [10.0, 10.0, 100.0], cells = [2, 2, 12] } }
parameters = { mu = [20.0, 200.0], lambda = [20.0, 200.0] }
"#;

const TWISTED_CUBE: &str = r#"
law = "neo-hookean-young"
supports = [
    { clamped = "x_min" },
    { nodes = "x_max", axis = [1.0, 0.0, 0.0], point = [0.0, 5.0, 5.0], turn = { degrees = 60.0, share = 0.5 } },
]
mesh = { box = { extent = [10.0, 10.0, 10.0], cells = [5, 5, 5] } }
parameters = { E = [1.0, 25.0], nu = [0.1, 0.49] }
"#;

const SLAB: &str = r#"
law = "neo-hookean"
loads = [
    { pressure = "p", facets = "z_max" },
    { foundation = { normal = 0.2, tangential = 0.05 }, facets = "z_min" },
]
supports = [{ clamped = "x_min" }, { clamped = "x_max" }, { clamped = "y_min" }, { clamped = "y_max" }]
mesh = { box = { extent = [80.0, 80.0, 10.0], cells = [6, 6, 2] } }
parameters = { mu = [2.0, 20.0], lambda = [2.0, 50.0], p = [0.5, 5.0] }
"#;

const VENTRICLE: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
fibres = { rule = { endocardium = "endo", epicardium = "epi", base = "base", angles = [60.0, -60.0] } }
[mesh]
ellipsoid = { short = [22.0, 36.0], long = [58.0, 74.0], base = 0.0, cells = [2, 16, 6] }
[parameters]
a = [0.1, 0.26]
b = [1.0, 4.2]
a_f = [1.5, 5.18]
b_f = [1.0, 4.46]
p = { range = [4.0, 10.0], unit = "mmHg" }
"#;

const WIDE_VENTRICLE: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
fibres = { rule = { endocardium = "endo", epicardium = "epi", base = "base", angles = [60.0, -60.0] } }
[mesh]
ellipsoid = { short = [22.0, 34.0], long = [58.0, 70.0], base = 10.0, cells = [1, 16, 8] }
[parameters]
a = [0.1, 1.0]
b = [1.0, 10.0]
a_f = [0.5, 5.0]
b_f = [1.0, 10.0]
p = { range = [2.0, 20.0], unit = "mmHg" }
"#;

const GUCCIONE: &str = r#"
law = { name = "guccione", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
fibres = { rule = { endocardium = "endo", epicardium = "epi", base = "base", angles = [60.0, -60.0] } }
[mesh]
ellipsoid = { short = [22.0, 34.0], long = [50.0, 62.0], base = 0.0, cells = [1, 16, 8] }
[parameters]
C = [0.2, 2.0]
b_f = [4.0, 30.0]
b_t = [2.0, 10.0]
b_fs = [2.0, 10.0]
p = { range = [2.0, 15.0], unit = "mmHg" }
"#;

const BALLOON: &str = r#"
law = "neo-hookean"
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
[mesh]
ellipsoid = { short = [20.0, 24.0], long = [24.0, 28.0], base = 10.0, cells = [1, 16, 8] }
[parameters]
mu = [5.0, 20.0]
lambda = [20.0, 100.0]
p = [0.5, 5.0]
"#;

const BIVENTRICLE: &str = r#"
law = "neo-hookean"
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
[mesh]
biventricle = { radius = 16.0, depth = 30.0, wall = 8.0, septum = 8.0, edge = 4.4 }
[parameters]
mu = [3.0, 30.0]
lambda = [3.0, 60.0]
p = [0.2, 1.5]
"#;

/// Case of beams of random shape.
const BEAMS: &str = r#"
law = "neo-hookean"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]
mesh = { box = { extent = [100.0, 10.0, 10.0], cells = [8, 2, 2] } }
parameters = { mu = [20.0, 200.0], lambda = [20.0, 200.0] }
"#;

/// A liver as a newcomer writes it.
const LIVER: &str = r#"
law = "neo-hookean-young"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "clamped" }]
mesh = { file = "liver.vtk" }
parameters = { E = [1.0, 6.0], nu = [0.3, 0.45] }
"#;

/// All bodies with their names; published ones where the folder has their mesh.
///
/// # Errors
/// A case or a shape that cannot be made.
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
            "liver" => Case::parse(LIVER, name)?,
            _ => Case::read(Path::new("LeftVentricle"))?,
        };
        found.push((name.to_string(), case.with_mesh(path).body()?));
    }
    Ok(found)
}

/// A beam under its weight, over a decade of stiffness.
///
/// # Errors
/// Shape numbers that make no mesh.
fn beam(numbers: &[f64]) -> Result<Body> {
    let mesh = BeamShape::new(numbers)?.tetrahedra([8, 2, 2])?;
    Ok(Case::parse(BEAMS, "beams")?.body_on(mesh.into())?)
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
    ///
    /// # Errors
    /// A case that cannot be lowered.
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

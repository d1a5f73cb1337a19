//! The laws by name: the one table of them.
//!
//! Their stresses and tangents are compiled here, at the level of this crate, whatever that of the program that names one.

use crate::laws::{
    ActiveTension, ByYoungPoisson, Compressible, Guccione, HolzapfelOgden, HolzapfelOgden2009,
    HolzapfelOgdenCompressible, LinearElastic, NeoHookean, NeoHookeanShape,
};
use crate::{Law, Material, NearlyIncompressible, ShapeEnergy, Solid, Strain, VolumeEnergy};
use std::sync::Arc;

/// A law that has a name in case files.
///
/// ```
/// use sinew_energy::laws::{LAWS, LawConstants};
///
/// let law = LAWS.iter().find(|law| law.name == "neo-hookean").expect("a law of the table");
/// let material = law.material(LawConstants::default());
/// assert_eq!(material.parameters(), ["mu", "lambda"]);
///
/// let law = LAWS.iter().find(|law| law.bulk_modulus).expect("a law with a bulk modulus");
/// let incomplete = law.material(LawConstants::default());
/// assert_eq!(incomplete.energy(0, &[1.0], &sinew_num::Mat3::ZERO, None), f64::INFINITY);
/// ```
#[derive(Debug)]
pub struct NamedLaw {
    /// Name of the law.
    pub name: &'static str,
    /// Description, with its source.
    pub about: &'static str,
    /// Parameters, in the order of θ.
    pub parameters: &'static [&'static str],
    /// Their units: `"kPa"`, or `"1"` for numbers.
    pub units: &'static [&'static str],
    /// Whether it needs a bulk modulus.
    pub bulk_modulus: bool,
    /// Material directions that it reads.
    pub directions: usize,
    /// Number of directions that matter. The others may be any perpendicular ones.
    pub needed: usize,
    material: fn(LawConstants) -> Arc<dyn Material>,
}

/// Name of the tension that `active = true` adds to θ.
pub const TENSION: &str = "T_a";

const STRESS: &str = "kPa";
const NUMBER: &str = "1";
/// Units of a stiffness and an exponent, of the tissue and of its fibres.
const FIBROUS: &[&str] = &[STRESS, NUMBER, STRESS, NUMBER];

/// All laws.
pub static LAWS: &[NamedLaw] = &[
    row::<NeoHookean, 0>("neo-hookean", &[STRESS, STRESS], |_| NeoHookean.along(vec![])),
    row::<ByYoungPoisson<NeoHookean>, 0>("neo-hookean-young", &[STRESS, NUMBER], |_| {
        ByYoungPoisson(NeoHookean).along(vec![])
    }),
    solid::<NearlyIncompressible<NeoHookeanShape>, 0>("neo-hookean-isochoric", &[STRESS], |own| {
        NeoHookeanShape.nearly_incompressible(own.bulk_modulus).along(vec![])
    }),
    solid::<NearlyIncompressible<HolzapfelOgden>, 1>("holzapfel-ogden", FIBROUS, |own| {
        own.solid(HolzapfelOgden.nearly_incompressible(own.bulk_modulus))
    }),
    solid::<Solid<HolzapfelOgdenCompressible, Compressible>, 1>(
        "holzapfel-ogden-thesis",
        FIBROUS,
        |own| {
            let volume = Compressible { kappa: own.bulk_modulus };
            own.solid(Solid::new(HolzapfelOgdenCompressible, volume))
        },
    ),
    solid::<NearlyIncompressible<HolzapfelOgden2009>, 2>(
        "holzapfel-ogden-orthotropic",
        &[STRESS, NUMBER, STRESS, NUMBER, STRESS, NUMBER, STRESS, NUMBER],
        |own| own.solid(HolzapfelOgden2009.nearly_incompressible(own.bulk_modulus)),
    ),
    NamedLaw {
        // Independent of the directions across the first one.
        needed: 1,
        ..solid::<NearlyIncompressible<Guccione>, 3>(
            "guccione",
            &[STRESS, NUMBER, NUMBER, NUMBER],
            |own| own.solid(Guccione.nearly_incompressible(own.bulk_modulus)),
        )
    },
    row::<LinearElastic, 0>("linear-elastic", &[STRESS, STRESS], |_| LinearElastic.along(vec![])),
];

const fn row<L: Law<D>, const D: usize>(
    name: &'static str,
    units: &'static [&'static str],
    material: fn(LawConstants) -> Arc<dyn Material>,
) -> NamedLaw {
    NamedLaw {
        name,
        about: L::NAME,
        parameters: L::PARAMETERS,
        units,
        bulk_modulus: false,
        directions: D,
        needed: D,
        material,
    }
}

/// A law with a bulk modulus.
const fn solid<L: Law<D>, const D: usize>(
    name: &'static str,
    units: &'static [&'static str],
    material: fn(LawConstants) -> Arc<dyn Material>,
) -> NamedLaw {
    NamedLaw { bulk_modulus: true, ..row::<L, D>(name, units, material) }
}

impl NamedLaw {
    /// Whether it is put together from shape energy, volume response and fibres, so that it can contract.
    pub const fn is_fibrous_solid(&self) -> bool {
        self.bulk_modulus && self.directions > 0
    }

    /// The material, whose directions are still to be given. Without the bulk modulus that the law needs its energy is infinite.
    pub fn material(&self, constants: LawConstants) -> Arc<dyn Material> {
        (self.material)(constants)
    }
}

/// Constants of a [`NamedLaw`]; those that it does not read are ignored.
#[derive(Clone, Copy, Debug)]
pub struct LawConstants {
    /// Penalty on changes of volume \[stress\]; NaN where there is none.
    pub bulk_modulus: f64,
    /// Strain that solids with fibres resist.
    pub strain: Strain,
    /// Whether the solid contracts along its fibres.
    pub active: bool,
}

impl Default for LawConstants {
    fn default() -> Self {
        Self { bulk_modulus: f64::NAN, strain: Strain::default(), active: false }
    }
}

impl LawConstants {
    /// A solid of three parts.
    fn solid<M: ShapeEnergy<D>, V: VolumeEnergy, const D: usize>(
        self,
        solid: Solid<M, V>,
    ) -> Arc<dyn Material> {
        let solid = Solid { strain: self.strain, ..solid };
        match self.active {
            true => solid.with_active(ActiveTension).along(vec![]),
            false => solid.along(vec![]),
        }
    }
}

//! The laws that a case file can name: the one table of them.

use super::CaseError;
use super::source::{Source, advise};
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor, value::MapAccessDeserializer};
use sinew_energy::laws::{
    ActiveTension, ByYoungPoisson, Compressible, Guccione, HolzapfelOgden, HolzapfelOgden2009,
    HolzapfelOgdenCompressible, LinearElastic, NeoHookean, NeoHookeanShape, PlaneStress,
};
use sinew_energy::{
    ActiveStress, Law as _, Material, NearlyIncompressible, ShapeEnergy, Solid, Strain,
    VolumeEnergy,
};
use std::fmt;
use std::sync::Arc;

/// A law by name, with its constants.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct Law {
    /// Name, one of [`LAWS`].
    pub name: String,
    /// Penalty on changes of volume \[kPa\], for laws that have one.
    pub bulk_modulus: Option<f64>,
    /// Strain measure of its shape energy; the isochoric one by default.
    pub strain: Option<Strain>,
}

/// A law that a case file can name.
#[derive(Debug)]
pub struct Row {
    /// Name of the law.
    pub name: &'static str,
    /// Description, with its source.
    pub about: &'static str,
    /// Parameters, in the order of θ.
    pub parameters: &'static [&'static str],
    /// Their units: `"kPa"`, or `"1"` for numbers.
    pub units: &'static [&'static str],
    /// Whether it needs a `bulk_modulus` \[kPa\].
    pub bulk_modulus: bool,
    /// Material directions that it reads.
    pub directions: usize,
    /// Number of directions that matter. The others may be any perpendicular ones.
    pub needed: usize,
    material: fn(Constants) -> Arc<dyn Material>,
}

/// Name of the tension that `active = true` adds to θ.
pub const TENSION: &str = "T_a";

const STRESS: &str = "kPa";
const NUMBER: &str = "1";

/// All laws.
pub static LAWS: &[Row] = &[
    row::<NeoHookean, 0>("neo-hookean", &[STRESS, STRESS], |_| NeoHookean.along(vec![])),
    row::<ByYoungPoisson<NeoHookean>, 0>("neo-hookean-young", &[STRESS, NUMBER], |_| {
        ByYoungPoisson(NeoHookean).along(vec![])
    }),
    row::<NearlyIncompressible<NeoHookeanShape>, 0>("neo-hookean-isochoric", &[STRESS], |own| {
        NeoHookeanShape.nearly_incompressible(own.bulk_modulus).along(vec![])
    })
    .with_bulk_modulus(),
    row::<NearlyIncompressible<HolzapfelOgden>, 1>(
        "holzapfel-ogden",
        &[STRESS, NUMBER, STRESS, NUMBER],
        |own| own.solid(HolzapfelOgden.nearly_incompressible(own.bulk_modulus)),
    )
    .with_bulk_modulus(),
    row::<Solid<HolzapfelOgdenCompressible, Compressible>, 1>(
        "holzapfel-ogden-thesis",
        &[STRESS, NUMBER, STRESS, NUMBER],
        |own| {
            let kappa = own.bulk_modulus;
            own.solid(Solid::new(HolzapfelOgdenCompressible, Compressible { kappa }))
        },
    )
    .with_bulk_modulus(),
    row::<NearlyIncompressible<HolzapfelOgden2009>, 2>(
        "holzapfel-ogden-orthotropic",
        &[STRESS, NUMBER, STRESS, NUMBER, STRESS, NUMBER, STRESS, NUMBER],
        |own| own.solid(HolzapfelOgden2009.nearly_incompressible(own.bulk_modulus)),
    )
    .with_bulk_modulus(),
    row::<NearlyIncompressible<Guccione>, 3>(
        "guccione",
        &[STRESS, NUMBER, NUMBER, NUMBER],
        |own| own.solid(Guccione.nearly_incompressible(own.bulk_modulus)),
    )
    .with_bulk_modulus()
    .about_one_axis(),
    row::<LinearElastic, 0>("linear-elastic", &[STRESS, STRESS], |_| LinearElastic.along(vec![])),
    row::<PlaneStress, 0>("linear-elastic-plane-stress", &[STRESS, STRESS], |_| {
        PlaneStress(LinearElastic).along(vec![])
    }),
];

const fn row<L: sinew_energy::Law<D>, const D: usize>(
    name: &'static str,
    units: &'static [&'static str],
    material: fn(Constants) -> Arc<dyn Material>,
) -> Row {
    let (about, parameters) = (L::NAME, L::PARAMETERS);
    Row { name, about, parameters, units, bulk_modulus: false, directions: D, needed: D, material }
}

impl Row {
    const fn with_bulk_modulus(self) -> Self {
        Self { bulk_modulus: true, ..self }
    }

    /// Whether it is put together from shape energy, volume response and fibres, so that it can contract.
    pub(super) const fn is_fibrous_solid(&self) -> bool {
        self.bulk_modulus && self.directions > 0
    }

    /// Transversely isotropic: independent of the directions across the first one.
    const fn about_one_axis(self) -> Self {
        Self { needed: 1, ..self }
    }
}

impl Law {
    /// The row of the table.
    pub(super) fn row(&self, source: &Source) -> Result<&'static Row, CaseError> {
        let Some(row) = LAWS.iter().find(|row| row.name == self.name) else {
            let advice = advise(&self.name, LAWS.iter().map(|row| row.name), "laws");
            return Err(source.error(&["law"], format!("there is no law `{}`{advice}", self.name)));
        };
        let (name, given) = (row.name, self.bulk_modulus.is_some());
        source.refuse_if(row.bulk_modulus && !given, &["law"], || {
            format!("`bulk_modulus` [kPa], the penalty on changes of volume, is missing; write law = {{ name = \"{name}\", bulk_modulus = 25.0 }}")
        })?;
        source.refuse_if(given && !row.bulk_modulus, &["law", "bulk_modulus"], || {
            format!("`{name}` has no bulk modulus of its own; leave it out")
        })?;
        let wrong = self.strain.is_some() && !row.is_fibrous_solid();
        source.refuse_if(wrong, &["law", "strain"], || {
            format!("`{name}` reads one strain only; leave it out")
        })?;
        Ok(row)
    }

    /// The material, whose directions are still to be given.
    pub(super) fn material(&self, row: &Row, active: bool) -> Arc<dyn Material> {
        let bulk_modulus = self.bulk_modulus.unwrap_or(f64::NAN);
        (row.material)(Constants { bulk_modulus, strain: self.strain.unwrap_or_default(), active })
    }
}

/// Constants of a law.
#[derive(Clone, Copy)]
struct Constants {
    bulk_modulus: f64,
    /// Strain that solids resist.
    strain: Strain,
    /// Whether it contracts along its fibres.
    active: bool,
}

impl Constants {
    /// A solid of three parts.
    fn solid<M: ShapeEnergy<D>, V: VolumeEnergy, const D: usize>(
        self,
        solid: Solid<M, V>,
    ) -> Arc<dyn Material>
    where
        ActiveTension: ActiveStress<D>,
    {
        let solid = Solid { strain: self.strain, ..solid };
        match self.active {
            true => solid.with_active(ActiveTension).along(vec![]),
            false => solid.along(vec![]),
        }
    }
}

/// A law is its name, or a table with name and constants.
impl<'de> Deserialize<'de> for Law {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Law;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a law, or a table { name = \"…\", bulk_modulus = … }")
            }
            fn visit_str<E>(self, name: &str) -> Result<Law, E> {
                Ok(Law { name: name.into(), bulk_modulus: None, strain: None })
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Law, A::Error> {
                // The derived one.
                Law::deserialize(MapAccessDeserializer::new(map))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

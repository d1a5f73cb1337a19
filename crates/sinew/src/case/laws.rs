//! The law of a case file.

use super::CaseError;
use super::source::{Source, advise};
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor, value::MapAccessDeserializer};
use sinew_energy::laws::{LAWS, LawConstants, NamedLaw};
use sinew_energy::{Material, Strain};
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

impl Law {
    /// The row of the table.
    pub(super) fn row(&self, source: &Source) -> Result<&'static NamedLaw, CaseError> {
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
    pub(super) fn material(&self, row: &NamedLaw, active: bool) -> Arc<dyn Material> {
        let bulk_modulus = self.bulk_modulus.unwrap_or(f64::NAN);
        let strain = self.strain.unwrap_or_default();
        row.material(LawConstants { bulk_modulus, strain, active })
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

//! The law of a case file, and the ranges of its parameters.

use super::Case;
use super::source::{Exactly, Result, Source, advise};
use super::units::stress;
use crate::theta::required;
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use sinew_energy::laws::{LAWS, LawConstants, NamedLaw, TENSION};
use sinew_energy::{Body, Material, Parameter, Sampling, Strain, Unit};
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
    pub(super) fn row(&self, source: &Source) -> Result<&'static NamedLaw> {
        let Some(row) = LAWS.iter().find(|row| row.name == self.name) else {
            let advice = advise(&self.name, LAWS.iter().map(|row| row.name), "laws");
            return Err(source.error(&["law"], format!("there is no law `{}`{advice}", self.name)));
        };
        let (name, given) = (row.name, self.bulk_modulus.is_some());
        source.refuse_if(row.bulk_modulus && !given, &["law"], || {
            format!("`bulk_modulus` [kPa], the penalty on changes of volume, is missing; write law = {{ name = \"{name}\", bulk_modulus = 25.0 }}")
        })?;
        let reason = || format!("`{name}` has no bulk modulus of its own; leave it out");
        source.refuse_if(given && !row.bulk_modulus, &["law", "bulk_modulus"], reason)?;
        let wrong = self.strain.is_some() && !row.is_fibrous_solid();
        let reason = || format!("`{name}` reads one strain only; leave it out");
        source.refuse_if(wrong, &["law", "strain"], reason)?;
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

/// Range of a parameter, or its value where that is known, so that θ does not list it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct Range {
    /// Smallest and largest value, in `unit`.
    pub range: Option<Exactly<f64, 2>>,
    /// Instead, the known value, in `unit`.
    pub value: Option<f64>,
    /// Unit of them; by default the law's.
    pub unit: Option<String>,
    /// Distribution of samples; uniform in the logarithm by default.
    pub sampling: Option<Sampling>,
}

impl Case {
    /// Parameters of the law in its order with their units, and its tension if the body contracts.
    pub(super) fn law_parameters(
        &self,
        law: &NamedLaw,
    ) -> impl Iterator<Item = (&'static str, &'static str)> + use<> {
        let passive = law.parameters.iter().copied().zip(law.units.iter().copied());
        passive.chain(self.active.is_some().then_some((TENSION, "kPa")))
    }

    /// θ: the law's parameters in its order, then those of the loads.
    pub(super) fn lower_parameters(&self, law: &NamedLaw) -> Result<Vec<Parameter>> {
        let mut expected: Vec<(&str, &str)> = self.law_parameters(law).collect();
        expected.extend(self.load_parameters().into_iter().map(|name| (name, "kPa")));
        let known = || expected.iter().map(|(name, _)| *name);
        if let Some(name) = self.parameters.keys().find(|name| known().all(|known| known != *name))
        {
            let what = format!("`{}` and the loads read", law.name);
            let advice = advise(name, known(), &what);
            let active = if name == TENSION && law.is_fibrous_solid() {
                "; if the body contracts, write active = true"
            } else {
                &advice
            };
            let reason = format!("nothing reads it{active}");
            return Err(self.source.error(&["parameters", name], reason));
        }
        // Of tables and command lines.
        if let Some(name) = known().find(|name| name.contains(['[', ']', ',', '='])) {
            let reason = "a name has none of the signs [ ] , =";
            return Err(self.source.error(&["parameters", name], reason.into()));
        }
        let parameter = |&(name, unit): &(&str, &str)| {
            let range = self.parameters.get(name).ok_or_else(|| {
                let reason = format!(
                    "`{name}` is missing; add {name} = [smallest, largest], or the known value, in {}",
                    spoken(unit)
                );
                self.source.error(&["parameters"], reason)
            })?;
            self.lower_range(name, unit, range)
        };
        expected.iter().map(parameter).collect()
    }

    fn lower_range(&self, name: &str, unit: &str, range: &Range) -> Result<Parameter> {
        let error = |key: &str, reason| Err(self.source.error(&["parameters", name, key], reason));
        let unit = match (unit, range.unit.as_deref().unwrap_or(unit)) {
            ("kPa", given) => match stress(given) {
                Ok(unit) => unit,
                Err(reason) => return error("unit", reason),
            },
            (own, given) if own == given => Unit::from(own),
            (own, given) => {
                let reason = format!("{name} is {}, not in {given}; leave it out", spoken(own));
                return error("unit", reason);
            }
        };
        let ([low, high], sampling) = match (range.range, range.value) {
            (Some(Exactly(ends)), None) => (ends, range.sampling.unwrap_or(Sampling::Log)),
            (None, Some(_)) if range.sampling.is_some() => {
                return error("sampling", "a known value is not sampled; leave it out".into());
            }
            (None, Some(value)) => ([value; 2], Sampling::Linear),
            _ => return error("range", "give one of `range` and `value`".into()),
        };
        let shown = unit.suffix();
        let reason = if !(low.is_finite() && high.is_finite()) {
            format!("it goes from {low} to {high}{shown}; give finite numbers")
        } else if low == high && range.value.is_none() {
            format!(
                "both ends are {low}{shown}, which leaves nothing to sample; write {name} = {low} if it is known"
            )
        } else if low > high {
            format!(
                "it goes from {low} to {high}{shown}; write the smaller number first: [{high}, {low}]"
            )
        } else if sampling == Sampling::Log && low <= 0.0 {
            format!(
                "it begins at {low}{shown}, which has no logarithm; write {{ range = [{low}, {high}], sampling = \"linear\" }}"
            )
        } else {
            return Ok(Parameter {
                name: name.into(),
                range: [low, high].map(|value| unit.in_scene(value)),
                unit,
                sampling,
            });
        };
        error("range", reason)
    }

    /// Requires that the law makes sense in all of the ranges.
    pub(super) fn check_bounds(&self, body: &Body) -> Result<()> {
        for (index, parameter) in
            body.parameters.iter().enumerate().take(body.material.parameters().len())
        {
            let bounds = body.material.bounds(index);
            for value in parameter.range {
                let wrong = !bounds.contains(&value);
                self.source.refuse_if(wrong, &["parameters", &parameter.name], || {
                    let required = required(parameter, &body.units, &bounds, value);
                    let value = parameter.unit.format(value);
                    format!("{value} makes no sense for this law; it must be {required}")
                })?;
            }
        }
        Ok(())
    }
}

fn spoken(unit: &str) -> &str {
    if unit == "1" { "a number without unit" } else { unit }
}

/// A range is `[smallest, largest]`, one number, or a table.
impl<'de> Deserialize<'de> for Range {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Range;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "[smallest, largest], a known value, or a table { range = [smallest, largest], unit = \"…\" }",
                )
            }
            fn visit_f64<E>(self, value: f64) -> Result<Range, E> {
                Ok(Range { value: Some(value), ..Range::default() })
            }
            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Range, E> {
                self.visit_f64(value as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Range, A::Error> {
                let range = Some(Exactly::deserialize(SeqAccessDeserializer::new(seq))?);
                Ok(Range { range, ..Range::default() })
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Range, A::Error> {
                // The derived one.
                Range::deserialize(MapAccessDeserializer::new(map))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

//! Loads, and cases without a potential: mixed elements, and pressures whose rim moves freely.

use super::Case;
use super::mesh::by_place;
use super::source::{Exactly, Result, Source, advise};
use super::units::quantity;
use serde::Deserialize;
use serde::de::{Deserializer, Visitor};
use sinew_energy::{Body, Magnitude};
use sinew_mesh::AnyMesh;
use std::fmt;

/// A load: one of the first five keys, and the facets that it acts on.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Load {
    /// Force per reference volume [kPa/mm].
    pub body_force: Option<Exactly<f64, 3>>,
    /// Dead force per reference area \[kPa\].
    pub traction: Option<Exactly<f64, 3>>,
    /// Pressure against the solid that follows the surface.
    pub pressure: Option<Pressure>,
    /// The thesis' stand-in for it, to reproduce its numbers only.
    pub thesis_pressure: Option<Pressure>,
    /// Springs against motion.
    pub foundation: Option<FoundationLoad>,
    /// Facet set, for all but a body force.
    pub facets: Option<String>,
    /// Rim of a pressure's facets that moves.
    pub rim: Option<Rim>,
}

/// Rim of the surface that a pressure acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rim {
    /// Rim that may move freely, so that the pressure has no potential.
    Loose,
    /// Rim with a lid that moves with it and bears the pressure too.
    Closed,
}

/// An elastic foundation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FoundationLoad {
    /// Stiffness against motion along the normal [kPa/mm].
    pub normal: f64,
    /// Stiffness against motion in the surface [kPa/mm].
    #[serde(default)]
    pub tangential: f64,
}

/// Magnitude of a pressure.
#[derive(Clone, Debug, PartialEq)]
pub enum Pressure {
    /// Constant value \[kPa\].
    Fixed(f64),
    /// An entry of θ, by name.
    Parameter(String),
}

impl Load {
    /// Whether a pressure says that its rim moves freely.
    pub(super) fn is_loose(&self) -> bool {
        self.rim == Some(Rim::Loose)
    }

    /// Name of the parameter that it reads.
    pub(super) fn parameter(&self) -> Option<&str> {
        match self.pressure.as_ref().or(self.thesis_pressure.as_ref())? {
            Pressure::Parameter(name) => Some(name),
            Pressure::Fixed(_) => None,
        }
    }

    /// Load `number` of the case; `index` gives the entry of θ of a name.
    pub(super) fn lower(
        &self,
        number: usize,
        mesh: &AnyMesh,
        index: impl Fn(&str) -> Magnitude,
        source: &Source,
    ) -> Result<sinew_energy::Load> {
        let at = number.to_string();
        let magnitude = |pressure: &Pressure| match pressure {
            Pressure::Fixed(kpa) => Magnitude::Fixed(*kpa),
            Pressure::Parameter(name) => index(name),
        };
        let facets = || self.facet_set(&at, mesh, source);
        let Self { body_force, traction, pressure, thesis_pressure, foundation, .. } = self;
        let misplaced = self.rim.is_some() && pressure.is_none();
        let reason = "only a `pressure` has a rim; leave it out";
        source.refuse_if(misplaced, &["loads", &at, "rim"], || reason)?;
        Ok(match (body_force, traction, pressure, thesis_pressure, foundation) {
            (Some(force), None, None, None, None) => {
                let reason = "a body force acts on all of the body; leave the facets out";
                source.refuse_if(self.facets.is_some(), &["loads", &at, "facets"], || reason)?;
                sinew_energy::Load::BodyForce(force.0)
            }
            (None, Some(value), None, None, None) => {
                sinew_energy::Load::Traction { facets: facets()?, value: value.0 }
            }
            (None, None, Some(p), None, None) => {
                let (facets, magnitude) = (facets()?, magnitude(p));
                match self.rim {
                    Some(Rim::Closed) => sinew_energy::Load::CavityPressure { facets, magnitude },
                    _ => sinew_energy::Load::Pressure { facets, magnitude },
                }
            }
            (None, None, None, Some(p), None) => {
                sinew_energy::Load::ThesisPressure { facets: facets()?, magnitude: magnitude(p) }
            }
            (None, None, None, None, &Some(FoundationLoad { normal, tangential })) => {
                sinew_energy::Load::Foundation { facets: facets()?, normal, tangential }
            }
            _ => {
                let reason = "write one of body_force, traction, pressure, thesis_pressure and foundation, each load in a table of its own".into();
                return Err(source.error(&["loads", &at], reason));
            }
        })
    }

    /// The facet set that is named, if the mesh has it.
    fn facet_set(&self, at: &str, mesh: &AnyMesh, source: &Source) -> Result<String> {
        let sets = mesh.facet_sets();
        let known = || sets.keys().map(String::as_str);
        let Some(name) = &self.facets else {
            let sets = known().collect::<Vec<_>>().join(", ");
            let places = by_place(mesh, "loaded");
            let reason =
                format!("name the facets that it acts on; facet sets of the mesh: {sets}{places}");
            return Err(source.error(&["loads", at], reason));
        };
        let at = ["loads", at, "facets"];
        source.refuse_if(!sets.contains_key(name), &at, || {
            let advice = advise(name, known(), "facet sets of the mesh");
            format!("the mesh has no facet set `{name}`{advice}{}", by_place(mesh, name))
        })?;
        // Of a selection inside the body, or of single nodes.
        let nodes = mesh.node_sets().get(name).map_or(0, Vec::len);
        source.refuse_if(sets[name].is_empty() && nodes > 0, &at, || {
            format!(
                "`{name}` has {nodes} nodes but no facet of the boundary, which needs all its nodes in the set; choose more of them"
            )
        })?;
        Ok(name.clone())
    }
}

/// A pressure is a number \[kPa\], a number with its unit ("8 mmHg") or the name of a parameter.
impl<'de> Deserialize<'de> for Pressure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl Visitor<'_> for Either {
            type Value = Pressure;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a pressure in kPa, one with its unit (\"8 mmHg\"), or the name of a parameter",
                )
            }
            fn visit_f64<E>(self, kpa: f64) -> Result<Pressure, E> {
                Ok(Pressure::Fixed(kpa))
            }
            fn visit_i64<E>(self, kpa: i64) -> Result<Pressure, E> {
                Ok(Pressure::Fixed(kpa as f64))
            }
            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Pressure, E> {
                match quantity(text) {
                    None => Ok(Pressure::Parameter(text.into())),
                    Some(Ok(kpa)) => Ok(Pressure::Fixed(kpa)),
                    Some(Err(reason)) => Err(E::custom(reason)),
                }
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl Case {
    /// The body, if it has a potential.
    pub(super) fn potential(&self, body: Body) -> Result<Body> {
        if body.has_potential() {
            return Ok(body);
        }
        let solve = "`sinew solve` and `sinew sample --solve` take it as it is";
        if body.pressure_field.is_some() {
            let reason = format!(
                "mixed elements have no potential, by which emulators learn and answers are refined; {solve}; for other commands \
                 write formulation = \"averaged\" or \"quadratic\""
            );
            return Err(self.source.error(&["formulation"], reason));
        }
        let number = self.loads.iter().position(Load::is_loose).unwrap_or_default();
        let reason = format!(
            "a pressure whose rim moves freely has no potential, by which emulators learn and answers are refined; {solve}; for \
             other commands hold the rim, or write rim = \"closed\" for a lid that moves with it"
        );
        Err(self.source.error(&["loads", &number.to_string(), "rim"], reason))
    }

    /// Advice about a pressure whose rim moves freely, behind an error about it.
    pub(super) fn advice_on_rims(&self) -> String {
        format!("; to do so, {LOOSE}")
    }

    /// Refuses pressures without a potential whose loads do not say that their rim is loose.
    pub(super) fn check_rims(&self, body: &Body) -> Result<()> {
        let mesh = &body.mesh;
        for (number, load) in self.loads.iter().enumerate() {
            let (None, Some(_), Some(name)) = (load.rim, &load.pressure, &load.facets) else {
                continue;
            };
            let facets = mesh.facet_sets().get(name).into_iter().flatten();
            let nodes: Vec<usize> = facets.flat_map(|&f| mesh.nodes_of_facet(f)).collect();
            let is_loose = body.followers.iter().any(|follower| follower.nodes == nodes);
            let reason = || format!("the rim of `{name}` moves freely; hold it, or {LOOSE}");
            self.source.refuse_if(is_loose, &["loads", &number.to_string()], reason)?;
        }
        Ok(())
    }
}

const LOOSE: &str = "write rim = \"closed\" beside the pressure for a lid that moves with it, or rim = \"loose\": the \
                     body is then solved by a balance of forces, and no emulator is trained on it";

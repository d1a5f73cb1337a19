//! Factors from place to place: a stiffness that differs, and where muscle contracts.

use super::Case;
use super::fibres::field_of;
use super::source::{Result, Source, advise};
use super::supports::add_node_set;
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor, value::MapAccessDeserializer};
use sinew_energy::laws::{LAWS, NamedLaw, TENSION};
use sinew_energy::{Body, SceneError};
use sinew_mesh::AnyMesh;
use std::fmt;

/// Factors of cells: a field of the mesh, or one factor for the nodes of a set.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Factors {
    /// Cell or point field with one factor each.
    pub field: Option<String>,
    /// Instead, a set of nodes.
    pub nodes: Option<String>,
    /// Instead, a set of cells, or a label such as `region:3`.
    pub cells: Option<String>,
    /// The factor there; it is 1 elsewhere.
    pub factor: Option<f64>,
}

impl Factors {
    /// Checks that the factors name either a field or a set, and that the mesh has it.
    pub(super) fn prepare(&self, key: &str, mesh: &mut AnyMesh, source: &Source) -> Result<()> {
        match (&self.field, &self.nodes, &self.cells, self.factor) {
            (Some(_), None, None, None) => Ok(()),
            (None, Some(nodes), None, Some(_)) => {
                let hint = mesh.cells_of(nodes).map_or(String::new(), |_| {
                    format!("; `{nodes}` is a set of cells: write {key} = {{ cells = … }}")
                });
                add_node_set(mesh, nodes)
                    .map_err(|reason| source.error(&[key, "nodes"], reason + &hint))
            }
            (None, None, Some(name), Some(_)) => {
                source.refuse_if(mesh.cells_of(name).is_none(), &[key, "cells"], || {
                    let known = mesh.names_of_cells();
                    let advice = advise(name, known.iter().map(String::as_str), "sets of cells");
                    format!("the mesh has no set of cells `{name}`{advice}")
                })
            }
            _ => Err(source.error(&[key], INCOMPLETE.into())),
        }
    }

    /// One factor per cell of the body, above zero or not below it.
    fn of_cells(
        &self,
        key: &str,
        positive: bool,
        body: &Body,
        source: &Source,
    ) -> Result<Vec<f64>> {
        let required = if positive { "above zero" } else { "zero or more" };
        let fits =
            |factor: f64| factor.is_finite() && (factor > 0.0 || (factor == 0.0 && !positive));
        let mesh = &*body.mesh;
        let Some(name) = &self.field else {
            let factor = self.factor.unwrap_or(1.0);
            let reason = || format!("{factor} is not a factor; give a finite number {required}");
            source.refuse_if(!fits(factor), &[key, "factor"], reason)?;
            if let Some(cells) = self.cells.as_ref().and_then(|name| mesh.cells_of(name)) {
                let mut of_cells = vec![1.0; mesh.cell_count()];
                cells.into_iter().for_each(|cell| of_cells[cell] = factor);
                return Ok(of_cells);
            }
            let mut of_nodes = vec![1.0; body.nodes];
            let set = self.nodes.as_ref().and_then(|nodes| mesh.node_sets().get(nodes));
            set.into_iter().flatten().for_each(|&node| of_nodes[node] = factor);
            return means(key, body, &of_nodes, source);
        };
        let error = |reason| source.error(&[key, "field"], reason);
        let (field, of_cells) = field_of(mesh, name).map_err(error)?;
        if field.components != 1 {
            let (components, values) = (field.components, "a factor is one number");
            return Err(error(format!("the field `{name}` has {components} components, {values}")));
        }
        let values = field.to_f64();
        if let Some(at) = values.iter().position(|&factor| !fits(factor)) {
            let (place, value) = (if of_cells { "cell" } else { "node" }, values[at]);
            let reason =
                format!("`{name}` is {value} at {place} {at}; give finite numbers {required}");
            return Err(error(reason));
        }
        if of_cells { Ok(values.into_owned()) } else { means(key, body, &values, source) }
    }
}

/// Means of nodal factors over the nodes of each cell.
fn means(key: &str, body: &Body, of_nodes: &[f64], source: &Source) -> Result<Vec<f64>> {
    body.cell_factors(of_nodes).map_err(|error| source.error(&[key], error.to_string()))
}

const INCOMPLETE: &str = "give the `field` of the mesh with the factors, or `nodes` or `cells` of a set and their `factor`";
const STIFFNESS: &str = "stiffness";
const ACTIVE: &str = "active";

impl Case {
    /// Refuses a contraction that the law cannot do.
    pub(super) fn check_active(&self, law: &NamedLaw) -> Result<()> {
        let wrong = self.active.is_some() && !law.is_fibrous_solid();
        self.source.refuse_if(wrong, &[ACTIVE], || {
            let able = LAWS.iter().filter(|row| row.is_fibrous_solid()).map(|row| row.name);
            let able = able.collect::<Vec<_>>().join(", ");
            let name = law.name;
            format!("a tension acts along fibres, and `{name}` reads none; leave it out, or take one of {able}")
        })
    }

    /// Factors with their keys.
    pub(super) fn factors(&self) -> impl Iterator<Item = (&'static str, &Factors)> {
        let stiffness = self.stiffness.iter().map(|factors| (STIFFNESS, factors));
        stiffness.chain(self.of_tension().map(|factors| (ACTIVE, factors)))
    }

    /// Factors of the tension, where they differ from 1.
    fn of_tension(&self) -> Option<&Factors> {
        self.active.as_ref().filter(|factors| **factors != Factors::default())
    }

    /// The body with its field of stiffness, which leaves the tension as it is, and with factors of the tension.
    pub(super) fn with_factors(&self, body: Body) -> Result<Body> {
        let error = |key: &str, error: SceneError| self.source.error(&[key], error.to_string());
        let of = |key, positive, factors: Option<&Factors>| {
            factors.map(|factors| factors.of_cells(key, positive, &body, &self.source)).transpose()
        };
        let stiffness = of(STIFFNESS, true, self.stiffness.as_ref())?;
        let tension = of(ACTIVE, false, self.of_tension())?;
        // The stiffness multiplies the whole energy, so the tension is divided by it.
        let divisors = stiffness.as_ref().filter(|_| self.active.is_some());
        let mut tension = tension.or_else(|| Some(vec![1.0; divisors?.len()]));
        let factors = tension.iter_mut().flatten();
        factors.zip(divisors.into_iter().flatten()).for_each(|(c, f)| *c /= f);
        let body = match tension {
            Some(tension) => body.with_parameter_field(TENSION, &tension),
            None => Ok(body),
        };
        let body = body.map_err(|e| error(ACTIVE, e))?;
        match stiffness {
            Some(stiffness) => body.stiffened_cells(&stiffness).map_err(|e| error(STIFFNESS, e)),
            None => Ok(body),
        }
    }
}

/// Contraction: `true` everywhere alike, which are factors by default, `false`, or a table of factors of the tension.
pub(super) fn active<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Factors>, D::Error> {
    struct Either;
    impl<'de> Visitor<'de> for Either {
        type Value = Option<Factors>;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(
                "true, false, or a table { field = \"…\" }, { nodes = \"…\", factor = … } or { cells = \"…\", factor = … }",
            )
        }
        fn visit_bool<E>(self, contracts: bool) -> Result<Self::Value, E> {
            Ok(contracts.then(Factors::default))
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            match Factors::deserialize(MapAccessDeserializer::new(map))? {
                none if none == Factors::default() => Err(Error::custom(INCOMPLETE)),
                factors => Ok(Some(factors)),
            }
        }
    }
    deserializer.deserialize_any(Either)
}

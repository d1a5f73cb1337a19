//! Sets of nodes and facets by where they are.

use super::source::{Exactly, Result, advise, cell_name, meant};
use super::supports::check_one_kind;
use super::units::size;
use super::{Case, FibreRule};
use serde::Deserialize;
use sinew_mesh::{AnyMesh, ReadReport, Selection, TriangleMesh, read_mesh};
use sinew_report::format::trimmed;
use std::path::{Path, PathBuf};

/// Conditions on nodes and facets, all of which hold (docs/case-file.md). Lengths are in mm.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Select {
    plane: Option<Plane>,
    beyond: Option<Side>,
    #[serde(rename = "box")]
    cuboid: Option<Cuboid>,
    sphere: Option<Ball>,
    facing: Option<Facing>,
    near: Option<Near>,
    nearest: Option<Exactly<f64, 3>>,
    set: Option<String>,
    between: Option<Exactly<toml::Value, 2>>,
    any: Option<Vec<Select>>,
    not: Option<Box<Select>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Plane {
    point: Exactly<f64, 3>,
    normal: Exactly<f64, 3>,
    #[serde(default)]
    within: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Side {
    point: Exactly<f64, 3>,
    normal: Exactly<f64, 3>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cuboid {
    min: Exactly<f64, 3>,
    max: Exactly<f64, 3>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ball {
    centre: Exactly<f64, 3>,
    radius: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Facing {
    direction: Exactly<f64, 3>,
    degrees: f64,
}

/// Files of surfaces are relative to the case file and in the unit of the mesh.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Near {
    surface: PathBuf,
    within: Option<f64>,
    #[serde(default)]
    rather_than: Vec<PathBuf>,
}

/// The factor of the lengths of a surface that was read, or why it is none of the mesh.
type Scale<'s> = &'s dyn Fn(&TriangleMesh, &ReadReport) -> Result<f64, String>;

/// Largest ratio of the sizes of mesh and surface that are in one unit.
const MOST_APART: f64 = 200.0;

impl Select {
    /// Files of surfaces, also of the selections within it.
    pub(super) fn files(&mut self) -> Vec<&mut PathBuf> {
        let near = self.near.iter_mut();
        let own =
            near.flat_map(|near| std::iter::once(&mut near.surface).chain(&mut near.rather_than));
        let inner = self.any.iter_mut().flatten().chain(self.not.as_deref_mut());
        own.chain(inner.flat_map(Self::files)).collect()
    }

    /// Sets that it and all selections within it name.
    fn sets(&self) -> Vec<&str> {
        let inner = self.any.iter().flatten().chain(self.not.as_deref());
        self.set.as_deref().into_iter().chain(inner.flat_map(Self::sets)).collect()
    }

    /// The selection; files of surfaces are scaled to mm.
    fn selection(&self, scale: Scale<'_>) -> Result<Selection, String> {
        let Self { plane, beyond, cuboid, sphere, facing, near, nearest, set, between, any, not } =
            self;
        let mut all: Vec<Selection> = Vec::new();
        all.extend(plane.map(|p| Selection::Plane(p.point.0, p.normal.0, p.within)));
        all.extend(beyond.map(|p| Selection::HalfSpace(p.point.0, p.normal.0)));
        all.extend(cuboid.map(|b| Selection::Box(b.min.0, b.max.0)));
        all.extend(sphere.map(|s| Selection::Sphere(s.centre.0, s.radius)));
        all.extend(facing.map(|f| Selection::Facing(f.direction.0, f.degrees)));
        all.extend(nearest.map(|point| Selection::Nearest(point.0)));
        all.extend(set.clone().map(Selection::set));
        let regions = between.as_ref().map(|Exactly(regions)| regions.each_ref().map(cell_name));
        all.extend(regions.map(|[a, b]| Selection::between(a, b)));
        if let Some(near) = near {
            all.extend(near.selections(scale)?);
        }
        if let Some(any) = any {
            let any = any.iter().map(|one| one.selection(scale)).collect::<Result<Vec<_>, _>>()?;
            all.push(Selection::Any(any));
        }
        if let Some(not) = not {
            all.push(Selection::Not(Box::new(not.selection(scale)?)));
        }
        all.into_iter().reduce(Selection::and).ok_or_else(|| {
            "give at least one of plane, beyond, box, sphere, facing, near, nearest, set, between, any and not".into()
        })
    }
}

impl Near {
    fn selections(&self, scale: Scale<'_>) -> Result<Vec<Selection>, String> {
        let surface = surface(&self.surface, scale)?;
        let others = self.rather_than.iter().map(|file| self::surface(file, scale));
        let others = others.collect::<Result<Vec<_>, _>>()?;
        if self.within.is_none() && others.is_empty() {
            return Err("near: give `within` (the largest distance, mm), `rather_than` (other surfaces), or both".into());
        }
        let within = self.within.map(|within| Selection::near(&surface, within));
        let nearer = (!others.is_empty()).then(|| Selection::nearer(&surface, &others));
        Ok(within.into_iter().chain(nearer).collect())
    }
}

fn surface(file: &Path, scale: Scale<'_>) -> Result<TriangleMesh, String> {
    let (mut surface, report) = read_mesh::<3>(file).map_err(|error| error.to_string())?;
    let scale = scale(&surface, &report).map_err(|why| format!("{}: {why}", file.display()))?;
    surface.points.iter_mut().flatten().for_each(|x| *x *= scale);
    Ok(surface)
}

impl Case {
    /// Refuses selections that nothing reads: a misspelt name, mostly.
    pub(super) fn check_selections(&self) -> Result<()> {
        let named = self.sets_named();
        let mut read: Vec<&str> = named.iter().map(|(_, set)| *set).collect();
        read.extend(self.select.values().flat_map(Select::sets));
        let Some(name) = self.select.keys().find(|name| !read.contains(&name.as_str())) else {
            return Ok(());
        };
        let is_meant = |set: &str| !self.select.contains_key(set) && meant(set, &[name]).is_some();
        if let Some((keys, set)) = named.iter().find(|(_, set)| is_meant(set)) {
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            let reason = format!(
                "there is no selection `{set}`, and nothing reads the selection `{name}`; did you mean `{name}`?"
            );
            return Err(self.source.error(&keys, reason));
        }
        let advice = advise(name, read, "supports, loads, fibres and factors name");
        let reason = format!("nothing reads this selection{advice}");
        Err(self.source.error(&["select", name], reason))
    }

    /// Sets that supports, loads, fibres and factors name, with their keys.
    fn sets_named(&self) -> Vec<(Vec<String>, &str)> {
        let supports = self.supports.iter().enumerate().flat_map(|(at, support)| {
            let sets = [("clamped", &support.clamped), ("nodes", &support.nodes)];
            let keys = move |key: &str| vec!["supports".into(), at.to_string(), key.into()];
            sets.into_iter().filter_map(move |(key, set)| Some((keys(key), set.as_deref()?)))
        });
        let loads = self.loads.iter().enumerate().filter_map(|(at, load)| {
            let keys = vec!["loads".into(), at.to_string(), "facets".into()];
            Some((keys, load.facets.as_deref()?))
        });
        let rule = self.fibres.iter().filter_map(|fibres| fibres.rule.as_ref());
        let rule = rule.flat_map(|FibreRule { endocardium, epicardium, base, .. }| {
            let sets = [("endocardium", endocardium), ("epicardium", epicardium), ("base", base)];
            sets.map(|(key, set)| (vec!["fibres".into(), "rule".into(), key.into()], set.as_str()))
        });
        let factors = self.factors().filter_map(|(key, factors)| {
            Some((vec![key.into(), "nodes".into()], factors.nodes.as_deref()?))
        });
        supports.chain(loads).chain(rule).chain(factors).collect()
    }

    /// Sets of nodes, which fields may mark, with their keys.
    pub(super) fn sets_of_nodes(&self) -> impl Iterator<Item = (Vec<String>, &str)> {
        let named = self.sets_named().into_iter();
        let of_facets = ["loads", "fibres"];
        named.filter(move |(keys, _)| !of_facets.contains(&keys[0].as_str()))
    }

    /// Refuses names of sets of the mesh that are of several kinds; a selection is in place of them.
    pub(super) fn check_kinds(&self, mesh: &AnyMesh) -> Result<()> {
        let mut read = self.sets_of_nodes().filter(|(_, set)| !self.select.contains_key(*set));
        read.try_for_each(|(keys, set)| {
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            check_one_kind(mesh, set).map_err(|reason| self.source.error(&keys, reason))
        })
    }

    /// Adds the selections to the mesh, those first that others name.
    pub(super) fn lower_selections(&self, mesh: &mut AnyMesh) -> Result<()> {
        let (scale, own) = (self.mesh.scale(&self.source)?, size(mesh.points()));
        let scale = |surface: &TriangleMesh, report: &ReadReport| {
            let factor = self.mesh.factor(scale, report);
            let theirs = factor * size(&surface.points);
            let fits = own.max(theirs) <= MOST_APART * own.min(theirs);
            fits.then_some(factor).ok_or_else(|| {
                let [theirs, own] = [theirs, own].map(|size| trimmed(size, 3));
                format!("the surface is {theirs} mm in size and the mesh {own} mm; write both in the unit of the mesh")
            })
        };
        let mut left: Vec<&str> = self.select.keys().map(String::as_str).collect();
        while !left.is_empty() {
            let is_ready =
                |name: &&str| !self.select[*name].sets().iter().any(|set| left.contains(set));
            let Some(place) = left.iter().position(is_ready) else {
                let reason = "it names a selection that names this one in turn; give one of them by other conditions";
                return Err(self.source.error(&["select", left[0]], reason.into()));
            };
            let name = left.remove(place);
            let error = |reason| self.source.error(&["select", name], reason);
            let selection = self.select[name].selection(&scale).map_err(error)?;
            mesh.select(name, &selection)
                .map_err(|reason| error(format!("{reason} (lengths in mm)")))?;
        }
        Ok(())
    }
}

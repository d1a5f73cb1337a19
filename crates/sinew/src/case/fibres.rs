//! Directions of fibres.

use super::CaseError;
use super::ellipsoid_fibres::EllipsoidRule;
use super::laws::Row;
use super::source::{Source, advise, exactly, exactly_if_any};
use nalgebra::Vector3;
use serde::Deserialize;
use sinew_energy::Body;
use sinew_fem::fibres::{
    Depth, FibreRule as Angles, Surfaces, VentricleCoordinates, cells_of_mixed_signs,
};
use sinew_mesh::{AnyMesh, Field};
use std::f64::consts::TAU;

/// Source of directions: a field of the mesh, one direction for all of it, or a rule.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fibres {
    /// Cell or point field with the fibres; need not be of unit length. Those of points are turned to agree in sign within a
    /// cell; those of cells are taken as they are.
    pub field: Option<String>,
    /// Cell or point field with the sheets, for laws that read them.
    pub sheets: Option<String>,
    /// One direction everywhere.
    #[serde(deserialize_with = "exactly_if_any")]
    pub direction: Option<[f64; 3]>,
    /// A rule for ventricles.
    pub rule: Option<FibreRule>,
    /// A rule in closed form, for walls that `mesh.ellipsoid` makes.
    pub ellipsoid: Option<EllipsoidRule>,
}

/// Fibres that turn linearly through the wall of a ventricle.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FibreRule {
    /// Facet set of the inner surface.
    pub endocardium: String,
    /// Facet set of the outer surface.
    pub epicardium: String,
    /// Facet set of the base.
    pub base: String,
    /// Angles to the circumferential direction at the inner and outer surface, positive towards the base \[degrees\].
    #[serde(deserialize_with = "exactly")]
    pub angles: [f64; 2],
    /// Angles of the sheets to the outward direction \[degrees\].
    #[serde(default)]
    #[serde(deserialize_with = "exactly")]
    pub sheet_angles: [f64; 2],
}

/// Largest angle of a fibre in radians, a right angle in two digits.
const LARGEST_RADIANS: f64 = 1.6;

/// Fields that directions by rule and from one direction are written to.
const WRITTEN: [&str; 3] = ["fibre", "sheet", "normal"];

impl Fibres {
    /// Writes directions that no field holds into the mesh.
    pub(super) fn lay(&self, mesh: &mut AnyMesh, source: &Source) -> Result<(), CaseError> {
        let Self { field, direction, rule, ellipsoid, .. } = self;
        let rows: Vec<[[f64; 3]; 3]> = match (field, direction, rule, ellipsoid) {
            // At quadrature points, which are not known yet.
            (Some(_), None, None, None) | (None, None, None, Some(_)) => return Ok(()),
            (None, Some(direction), None, None) => {
                let frame = completed(&[*direction])
                    .map_err(|reason| source.error(&["fibres", "direction"], reason.to_string()))?;
                vec![frame; mesh.cell_count()]
            }
            (None, None, Some(rule), None) => {
                let frames = rule.frames(mesh);
                frames.map_err(|reason| source.error(&["fibres", "rule"], reason))?
            }
            _ => {
                let reason = "give one of `field`, `direction`, `rule` and `ellipsoid`".into();
                return Err(source.error(&["fibres"], reason));
            }
        };
        write(&rows, mesh);
        Ok(())
    }

    /// Warnings about nodal fibres of opposite sign in a cell, and about angles that may be radians.
    pub(super) fn warnings(&self, body: &Body) -> impl Iterator<Item = String> {
        self.mixed_signs(body).into_iter().chain(self.radians())
    }

    fn radians(&self) -> Option<String> {
        let by_rule = self.rule.as_ref().map(|rule| rule.angles);
        let angles = by_rule.or(self.ellipsoid.map(|rule| rule.angles))?;
        let [inner, outer] = angles.map(f64::abs);
        let largest = inner.max(outer);
        let small = largest <= LARGEST_RADIANS || (inner == outer && largest <= TAU);
        (small && largest > 0.0).then(|| {
            let [inner, outer] = angles.map(|angle| angle.to_degrees().round());
            format!(
                "the angles of the fibres, {} and {}, are read in degrees; are they radians? Then give [{inner:?}, {outer:?}]",
                angles[0], angles[1]
            )
        })
    }

    /// Nodes are aligned here, but an average taken elsewhere without alignment is wrong.
    fn mixed_signs(&self, body: &Body) -> Option<String> {
        let name = self.field.as_ref()?;
        if body.mesh.cell_fields().contains_key(name) {
            return None;
        }
        let directions = body.mesh.point_fields().get(name)?.to_vectors::<3>()?;
        let mixed = cells_of_mixed_signs(body.cell_nodes(), &directions);
        (mixed > 0).then(|| {
            format!(
                "the nodal fibres `{name}` disagree in sign in {mixed} of {} cells. They are turned to agree here; a file in which \
                 they were averaged as they are has wrong fibres in these cells: lay them by a rule ([fibres.rule]) there",
                body.cell_count()
            )
        })
    }

    /// Fields of the first directions, as far as they are known.
    fn fields(&self) -> Vec<&str> {
        match &self.field {
            None => WRITTEN.to_vec(),
            Some(fibres) => {
                std::iter::once(fibres.as_str()).chain(self.sheets.as_deref()).collect()
            }
        }
    }
}

impl FibreRule {
    /// Writes fibres, sheets and normals into the cells of a tetrahedral mesh with the rule's facet sets.
    ///
    /// # Errors
    /// Why no fibres can be laid, in words.
    pub(crate) fn lay(&self, mesh: &mut AnyMesh) -> Result<(), String> {
        write(&self.frames(mesh)?, mesh);
        Ok(())
    }

    /// Fibre, sheet and normal at each node of a tetrahedral mesh.
    ///
    /// # Errors
    /// Why no fibres can be laid, in words.
    pub fn at_nodes(&self, mesh: &AnyMesh) -> Result<Vec<[[f64; 3]; 3]>, String> {
        let (wall, rule) = self.wall(mesh)?;
        Ok(wall.node_frames(&rule, Depth::Thickness))
    }

    fn frames(&self, mesh: &AnyMesh) -> Result<Vec<[[f64; 3]; 3]>, String> {
        let (wall, rule) = self.wall(mesh)?;
        Ok(wall.cell_frames(&rule, Depth::Thickness))
    }

    fn wall(&self, mesh: &AnyMesh) -> Result<(VentricleCoordinates, Angles), String> {
        let AnyMesh::Tetrahedra(mesh) = mesh else {
            return Err(format!("the rule needs linear tetrahedra, not {}", mesh.element().name));
        };
        let Self { endocardium, epicardium, base, angles, sheet_angles } = self;
        let surfaces = Surfaces { endocardium, epicardium, base };
        let rule = Angles::new(angles[0], angles[1])
            .and_then(|rule| rule.with_sheets(sheet_angles[0], sheet_angles[1]));
        let wall = rule.and_then(|rule| Ok((VentricleCoordinates::new(mesh, &surfaces)?, rule)));
        wall.map_err(|error| error.to_string())
    }
}

/// Writes directions of cells into the mesh.
fn write(rows: &[[[f64; 3]; 3]], mesh: &mut AnyMesh) {
    for (index, name) in WRITTEN.iter().enumerate() {
        let rows: Vec<_> = rows.iter().map(|frame| frame[index]).collect();
        mesh.cell_fields_mut().insert((*name).into(), Field::vectors(&rows));
    }
}

/// Unit directions per cell or node, as many as the law reads, one after the other.
pub(super) fn directions(
    fibres: Option<&Fibres>,
    law: &Row,
    mesh: &AnyMesh,
    source: &Source,
) -> Result<Vec<[f64; 3]>, CaseError> {
    if law.directions == 0 {
        return Ok(Vec::new());
    }
    let error = |key: &str, reason| source.error(&["fibres", key], reason);
    let Some(fibres) = fibres else {
        let reason =
            format!("`{}` reads fibres; add [fibres] with field, direction or rule", law.name);
        return Err(source.error(&["law"], reason));
    };
    let names = fibres.fields();
    if names.len() < law.needed {
        let reason =
            format!("`{}` reads {} directions; name the field of the sheets", law.name, law.needed);
        return Err(error("sheets", reason));
    }
    let keys = ["field", "sheets", "normal"];
    let read = |(name, key): (&&str, &str)| {
        let field = mesh.cell_fields().get(*name).or_else(|| mesh.point_fields().get(*name));
        let Some(field) = field else {
            let known = mesh.cell_fields().keys().chain(mesh.point_fields().keys());
            let advice = advise(name, known.map(String::as_str), "fields of the mesh");
            return Err(error(key, format!("the mesh has no field `{name}`{advice}")));
        };
        field.to_vectors::<3>().ok_or_else(|| {
            error(
                key,
                format!(
                    "the field `{name}` has {} components, a direction has 3",
                    field.components
                ),
            )
        })
    };
    let columns = names.iter().zip(keys).take(law.directions).map(read);
    let columns: Vec<Vec<[f64; 3]>> = columns.collect::<Result<_, _>>()?;
    if columns.iter().any(|column| column.len() != columns[0].len()) {
        return Err(error(
            "sheets",
            "fibres and sheets must both be fields of cells, or both of nodes".into(),
        ));
    }
    let mut directions = Vec::with_capacity(law.directions * columns[0].len());
    for index in 0..columns[0].len() {
        let given: Vec<_> = columns.iter().map(|column| column[index]).collect();
        let frame = completed(&given);
        let frame = frame.map_err(|reason| error("field", format!("row {index}: {reason}")))?;
        directions.extend_from_slice(&frame[..law.directions]);
    }
    Ok(directions)
}

const NO_DIRECTION: &str = "a direction without length, or along the one before; give three finite numbers, one of them not 0, or cut cells without fibres away by `keep` under [mesh]";

/// Unit vectors along the given directions, made perpendicular in their order, and others that complete the frame.
fn completed(given: &[[f64; 3]]) -> Result<[[f64; 3]; 3], &'static str> {
    let mut frame: Vec<Vector3<f64>> = Vec::with_capacity(3);
    for direction in given.iter().map(|direction| Vector3::from(*direction)) {
        let length = direction.norm();
        let unit = across(direction, &frame).filter(|_| length > 0.0 && length.is_finite());
        frame.push(unit.ok_or(NO_DIRECTION)?);
    }
    while frame.len() < 3 {
        let along = |axis: &Vector3<f64>| frame.iter().map(|d| d.dot(axis).powi(2)).sum::<f64>();
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let axis = axes.into_iter().min_by(|a, b| along(a).total_cmp(&along(b)));
        let unit = axis.and_then(|axis| across(axis, &frame));
        frame.push(unit.ok_or("directions from which no frame can be made")?);
    }
    Ok([frame[0], frame[1], frame[2]].map(Into::into))
}

/// Unit vector along the part of a direction perpendicular to others; `None` if that part nearly vanishes.
fn across(direction: Vector3<f64>, others: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let rest = others.iter().fold(direction, |rest, other| rest - other * rest.dot(other));
    (rest.norm() > 1e-3 * direction.norm()).then(|| rest / rest.norm())
}

//! Directions of fibres.

use super::fibre_rule::{EllipsoidRule, FibreRule};
use super::source::{Exactly, Result, Source, advise};
use super::units::size;
use nalgebra::Vector3;
use serde::Deserialize;
use sinew_energy::laws::NamedLaw;
use sinew_energy::{Body, Scene};
use sinew_fem::fibres::cells_of_mixed_signs;
use sinew_mesh::{AnyMesh, Field};
use std::collections::{BTreeSet, HashMap};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Source of directions: a field of the mesh, one direction for all of it, or a rule.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fibres {
    /// Cell or point field with the fibres; need not be of unit length. Those of points are turned to agree in sign within a
    /// cell; those of cells are taken as they are.
    pub field: Option<String>,
    /// File with the same mesh that holds these fields, relative to the case file.
    pub file: Option<PathBuf>,
    /// Cell or point field with the sheets, for laws that read them.
    pub sheets: Option<String>,
    /// One direction everywhere.
    pub direction: Option<Exactly<f64, 3>>,
    /// A rule for ventricles.
    pub rule: Option<FibreRule>,
    /// A rule in closed form, for walls that `mesh.ellipsoid` makes.
    pub ellipsoid: Option<EllipsoidRule>,
}

/// Largest difference of two nodes \[relative to the size of the mesh\] that are the same to the digits of files.
const SAME_PLACE: f64 = 1e-4;
/// Cosine of a right angle to the digits of files.
const RIGHT_ANGLE: f64 = 1e-5;
/// Largest angle of a fibre in radians, a right angle in two digits.
const LARGEST_RADIANS: f64 = 1.6;

/// Fields that directions by rule and from one direction are written to.
const WRITTEN: [&str; 3] = ["fibre", "sheet", "normal"];

impl Fibres {
    /// Writes directions that no field holds into the mesh.
    pub(super) fn lay(&self, mesh: &mut AnyMesh, source: &Source) -> Result<()> {
        let Self { file, field, direction, rule, ellipsoid, .. } = self;
        if self.sheets.is_some() && field.is_none() {
            let reason = "sheets are a field beside that of the fibres: give `field` too; a rule or one direction has sheets of its own";
            return Err(source.error(&["fibres", "sheets"], reason.into()));
        }
        if let Some(file) = file {
            self.copy(file, mesh).map_err(|reason| source.error(&["fibres", "file"], reason))?;
        }
        let rows: Vec<[[f64; 3]; 3]> = match (field, direction, rule, ellipsoid) {
            // At quadrature points, which are not known yet.
            (Some(_), None, None, None) | (None, None, None, Some(_)) => return Ok(()),
            (None, Some(direction), None, None) => {
                let frame = completed(&[direction.0])
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

    /// Gives middle nodes the mean direction of both ends of their edge, in place of the mean vector of directions that differ in length or sign.
    /// Between two at right angles it is NaN.
    pub(super) fn raise(&self, mesh: &mut AnyMesh) {
        let element = mesh.element();
        let cells = mesh.cells().chunks_exact(element.nodes.len());
        let edges =
            cells.flat_map(|cell| element.edges.iter().map(|e| [0, 1, 2].map(|k| cell[e[k]])));
        let edges: Vec<[usize; 3]> = edges.collect();
        for name in self.fields() {
            let Some(field) = mesh.point_fields_mut().get_mut(name) else { continue };
            let Some(mut rows) = field.to_vectors::<3>() else { continue };
            for &[a, b, middle] in &edges {
                let unit = |node: usize| Vector3::from(rows[node]).try_normalize(0.0);
                let [a, b] = [a, b].map(|node| unit(node).unwrap_or_default());
                let (along, are_two) = (a.dot(&b), a != Vector3::zeros() && b != Vector3::zeros());
                let across = are_two && along.abs() < RIGHT_ANGLE;
                let sign = if across { f64::NAN } else { 1f64.copysign(along) };
                rows[middle] = (a + b * sign).into();
            }
            *field = Field::vectors(&rows);
        }
    }

    /// Copies the named fields from another file with the same mesh, in any unit of length.
    fn copy(&self, file: &Path, mesh: &mut AnyMesh) -> Result<(), String> {
        if self.field.is_none() {
            return Err("it belongs to a `field`, which names the fibres in the file".into());
        }
        let (other, _) = sinew_mesh::read(file).map_err(|error| error.to_string())?;
        let [ours, theirs] = [&*mesh, &other].map(|mesh| [mesh.points().len(), mesh.cell_count()]);
        let [own, apart] = [mesh.points(), other.points()].map(relative);
        let same =
            |(a, b): (&[f64; 3], &[f64; 3])| (0..3).all(|i| (a[i] - b[i]).abs() <= SAME_PLACE);
        if ours != theirs || !own.iter().zip(&apart).all(same) {
            let ([nodes, cells], [own_nodes, own_cells]) = (theirs, ours);
            return Err(format!(
                "{} has another mesh, of {nodes} nodes and {cells} cells; the body has {own_nodes} and {own_cells}, and both must have the same nodes in the same order and places",
                file.display()
            ));
        }
        let rows = same_cells(mesh, &other).ok_or_else(|| {
            format!("the cells of {} have other nodes than those of the body", file.display())
        })?;
        for name in self.fields() {
            let of_file = |reason| format!("{}: {reason}", file.display());
            let (field, of_cells) = field_of(&other, name).map_err(of_file)?;
            let field = if of_cells { field.select(&rows) } else { field.clone() };
            put(mesh, name, field, of_cells);
        }
        Ok(())
    }

    /// Warnings about nodal fibres of opposite sign in a cell, and about angles that may be radians.
    pub(super) fn warnings(&self, body: &Body) -> impl Iterator<Item = String> {
        let doubts = [self.mixed_signs(body), self.radians(), self.absent(body)];
        doubts.into_iter().flatten()
    }

    /// Nodes without a direction in a file.
    fn absent(&self, body: &Body) -> Option<String> {
        let name = self.field.as_ref()?;
        let directions = body.mesh.point_fields().get(name)?.to_vectors::<3>()?;
        let count = directions.iter().filter(|d| **d == [0.0; 3]).count();
        (count > 0).then(|| format!("the nodal fibres `{name}` are zero at {count} nodes, which take those of the other nodes of their cells"))
    }

    fn radians(&self) -> Option<String> {
        let by_rule = self.rule.as_ref().map(|rule| rule.angles);
        let angles = by_rule.or(self.ellipsoid.map(|rule| rule.angles))?.0;
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
        let given: Vec<_> = self.field.iter().chain(&self.sheets).map(String::as_str).collect();
        if given.is_empty() { WRITTEN.to_vec() } else { given }
    }
}

/// The cell of another mesh with the nodes of each cell; `None` where one has no such cell.
fn same_cells(mesh: &AnyMesh, other: &AnyMesh) -> Option<Vec<usize>> {
    let sorted = |mesh: &AnyMesh| -> Vec<BTreeSet<usize>> {
        let cells = mesh.cells().chunks_exact(mesh.element().nodes.len());
        cells.map(|cell| cell.iter().copied().collect()).collect()
    };
    if mesh.cells() == other.cells() {
        return Some((0..mesh.cell_count()).collect());
    }
    let (own, theirs) = (sorted(mesh), sorted(other));
    let places: HashMap<_, _> = theirs.iter().zip(0..).collect();
    own.iter().map(|cell| places.get(cell).copied()).collect()
}

/// Points from the corner of their box, relative to its longest edge.
fn relative(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let least = [0, 1, 2].map(|i| points.iter().map(|x| x[i]).fold(f64::INFINITY, f64::min));
    let size = size(points);
    points.iter().map(|x| [0, 1, 2].map(|i| (x[i] - least[i]) / size)).collect()
}

/// Writes directions of cells into the mesh, or of its nodes.
pub(super) fn write(rows: &[[[f64; 3]; 3]], mesh: &mut AnyMesh) {
    for (index, name) in WRITTEN.iter().enumerate() {
        let rows: Vec<_> = rows.iter().map(|frame| frame[index]).collect();
        put(mesh, name, Field::vectors(&rows), rows.len() == mesh.cell_count());
    }
}

/// A field of the mesh, and whether it is one of cells.
pub(super) fn field_of<'m>(mesh: &'m AnyMesh, name: &str) -> Result<(&'m Field, bool), String> {
    let (of_cells, of_nodes) = (mesh.cell_fields().get(name), mesh.point_fields().get(name));
    if of_cells.and(of_nodes).is_some() {
        return Err(format!(
            "the mesh has a field `{name}` of cells and one of nodes; rename or remove one of them in its file"
        ));
    }
    let field = of_cells.or(of_nodes).ok_or_else(|| {
        let known = mesh.cell_fields().keys().chain(mesh.point_fields().keys());
        let advice = advise(name, known.map(String::as_str), "fields of the mesh");
        format!("the mesh has no field `{name}`{advice}")
    })?;
    Ok((field, of_cells.is_some()))
}

/// Puts a field of cells, or of nodes, in the place of both that have its name.
fn put(mesh: &mut AnyMesh, name: &str, field: Field, of_cells: bool) {
    mesh.cell_fields_mut().remove(name);
    mesh.point_fields_mut().remove(name);
    let fields = if of_cells { mesh.cell_fields_mut() } else { mesh.point_fields_mut() };
    fields.insert(name.into(), field);
}

/// Unit directions per cell or node, as many as the law reads, one after the other.
pub(super) fn directions(
    fibres: Option<&Fibres>,
    law: &NamedLaw,
    scene: &Scene,
    source: &Source,
) -> Result<Vec<[f64; 3]>> {
    let mesh = &scene.mesh;
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
    source.refuse_if(names.len() < law.needed, &["fibres", "sheets"], || {
        format!("`{}` reads {} directions; name the field of the sheets", law.name, law.needed)
    })?;
    let keys = ["field", "sheets", "normal"];
    let read = |(name, key): (&&str, &str)| {
        let (field, of_cells) = field_of(mesh, name).map_err(|reason| error(key, reason))?;
        let rows = field.to_vectors::<3>().ok_or_else(|| {
            let count = field.components;
            error(key, format!("the field `{name}` has {count} components, a direction has 3"))
        })?;
        Ok((rows, of_cells))
    };
    let columns = names.iter().zip(keys).take(law.directions).map(read);
    let (columns, of_cells): (Vec<Vec<[f64; 3]>>, Vec<_>) =
        columns.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
    let differ = of_cells.iter().any(|own| *own != of_cells[0]);
    let reason = "fibres and sheets must both be fields of cells, or both of nodes";
    source.refuse_if(differ, &["fibres", "sheets"], || reason)?;
    let rows = columns[0].len();
    let others = || [mesh.cell_count(), scene.quadrature_points().len()];
    let alike = !of_cells[0] && others().contains(&rows);
    source.refuse_if(alike, &["fibres", "field"], || {
        format!("the mesh has {rows} nodes, and as many cells or quadrature points; give fibres of cells, or take other cells")
    })?;
    let mut directions = Vec::with_capacity(law.directions * rows);
    for index in 0..rows {
        let given: Vec<_> = columns.iter().map(|column| column[index]).collect();
        // Nodes without a direction take part in no interpolation.
        let is_absent = !of_cells[0] && given.iter().flatten().all(|x| *x == 0.0);
        let frame = if is_absent { Ok(Default::default()) } else { completed(&given) };
        let frame = frame.map_err(|reason| error("field", format!("row {index}: {reason}")))?;
        directions.extend_from_slice(&frame[..law.directions]);
    }
    Ok(directions)
}

const NO_DIRECTION: &str = "a direction without length, along the one before, or in the middle of an edge between two at right angles; give three finite numbers, one of them not 0, or cut cells without fibres away by `keep` under [mesh]";

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

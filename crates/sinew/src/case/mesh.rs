//! Meshes: from a file, or made.

use super::source::{CaseError, Exactly, Result, Source, cell_name};
use super::units::LENGTH;
use serde::Deserialize;
use sinew_energy::listed;
use sinew_mesh::{
    AnyMesh, Biventricle, MeshError, ReadReport, TruncatedEllipsoid, box_hexahedra, box_tetrahedra,
};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Source of a mesh: one of the first five keys.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshSource {
    /// A VTK, VTU, gmsh, Abaqus or CARP file, relative to the case file.
    pub file: Option<PathBuf>,
    /// A box.
    #[serde(rename = "box")]
    pub cuboid: Option<BoxMesh>,
    /// The wall between two ellipsoids: an idealised ventricle.
    pub ellipsoid: Option<EllipsoidMesh>,
    /// Two such ventricles in one wall.
    pub biventricle: Option<BiventricleMesh>,
    /// Cells of what is made.
    pub element: Option<Element>,
    /// Unit of length of the numbers above and in the file; mm by default, µm of CARP files.
    pub unit: Option<String>,
    /// Sets and labels of the cells that are not cut away.
    pub keep: Option<Vec<toml::Value>>,
    /// Whether nodes at the same place in the file become one.
    pub merge: bool,
    /// Changes of the file's mesh by its reader, once a body was made of it.
    #[serde(skip)]
    pub report: OnceLock<ReadReport>,
    /// Instead of the first five keys, a mesh in memory, in that unit ([`Case::on`](super::Case::on)).
    #[serde(skip)]
    pub given: Option<Arc<AnyMesh>>,
    /// Instead of all keys, the mesh that they have made \[mm\] ([`Case::revived`](super::Case::revived)).
    #[serde(skip)]
    pub made: Option<Arc<AnyMesh>>,
    /// Whether the file stands in the place of the case's own mesh ([`Case::with_mesh`](super::Case::with_mesh)).
    #[serde(skip)]
    pub is_other: bool,
}

/// A box from the origin, with sets `x_min` to `z_max`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxMesh {
    /// Edge lengths.
    pub extent: Exactly<f64, 3>,
    /// Cells along each edge; six tetrahedra each.
    pub cells: Exactly<usize, 3>,
}

/// See [`TruncatedEllipsoid`]; with sets `endo`, `epi` and `base`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidMesh {
    /// Inner and outer semi-axis across.
    pub short: Exactly<f64, 2>,
    /// Inner and outer semi-axis along z.
    pub long: Exactly<f64, 2>,
    /// Height z of the plane of the base.
    pub base: f64,
    /// Layers, cells around (a multiple of 8) and from apex to base.
    pub cells: Exactly<usize, 3>,
}

/// See [`Biventricle`]; with sets `base`, `endo_left`, `endo_right`, both together `endo`, and `epi`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BiventricleMesh {
    /// Radius of a cavity at the base.
    pub radius: f64,
    /// Depth of a cavity.
    pub depth: f64,
    /// Thickness of the free walls.
    pub wall: f64,
    /// Thickness of the septum.
    pub septum: f64,
    /// Length of an edge: from [`Biventricle::shortest_edge`] to [`Biventricle::longest_edge`].
    pub edge: f64,
}

/// Cells of a mesh that is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Element {
    /// Linear tetrahedra.
    #[default]
    Tetrahedra,
    /// Trilinear hexahedra.
    Hexahedra,
    /// Quadratic tetrahedra; the nodes in the middle of edges are on the curved surfaces.
    #[value(skip)]
    QuadraticTetrahedra,
}

/// Height of triangles along z from which on they are a surface in space rather than a plane body that is not quite plane
/// \[relative to their extent\].
const SURFACE_HEIGHT: f64 = 1e-3;

/// Micrometre, the unit of CARP files \[mm\].
pub(super) const MICROMETRE: f64 = 1e-3;

impl MeshSource {
    /// The unit of length \[mm\].
    pub(super) fn scale(&self, source: &Source) -> Result<f64> {
        let found = LENGTH.unit(self.unit.as_deref().unwrap_or("mm"));
        found.map(|(_, mm)| mm).map_err(|reason| source.error(&["mesh", "unit"], reason))
    }

    /// The factor of lengths that a reader returned.
    pub(super) fn factor(&self, scale: f64, report: &ReadReport) -> f64 {
        if report.in_micrometres && self.unit.is_some() { scale / MICROMETRE } else { scale }
    }

    /// Refuses a surface in the place of a body.
    pub(super) fn check_filled(&self, mesh: &AnyMesh, source: &Source) -> Result<()> {
        let [x, y, z] = sinew_mesh::extents(mesh.points());
        if mesh.element().dimension == 3 || z <= SURFACE_HEIGHT * x.max(y).max(z) {
            return Ok(());
        }
        let file = self.file.as_deref().unwrap_or(Path::new("the mesh"));
        let rim = mesh.boundary_facets().len();
        let advice = if x.min(y) <= SURFACE_HEIGHT * z {
            "a plane body lies in x–y; turn this one there in the program that made it".to_string()
        } else {
            format!(
                "fill it with tetrahedra first: between the surfaces of a ventricle by `sinew mesh ventricle`, others, which must be \
                 closed ({rim} edges of its rim are open), for example by gmsh, TetGen or fTetWild"
            )
        };
        let (file, count) = (file.display(), mesh.cell_count());
        let reason = format!("{file} is a surface of {count} triangles, not a body: {advice}");
        Err(self.file_error(source, reason))
    }

    /// An error of the file: at its key, unless it stands in the place of the case's own mesh.
    fn file_error(&self, source: &Source, reason: String) -> CaseError {
        match &self.file {
            Some(file) if self.is_other => {
                Source::new(&format!("--mesh {}", file.display()), "").error(&[], reason)
            }
            _ => source.error(&["mesh", "file"], reason),
        }
    }

    /// The mesh \[mm\].
    pub(super) fn make(&self, source: &Source) -> Result<AnyMesh> {
        if let Some(made) = &self.made {
            return Ok((**made).clone());
        }
        let scale = self.scale(source)?;
        source.refuse_if(self.merge && self.file.is_none(), &["mesh", "merge"], || {
            "nodes of a file are merged, not those of a mesh that is made or in memory; leave it out"
        })?;
        let (mut mesh, mut report) = match &self.given {
            Some(mesh) => ((**mesh).clone(), ReadReport::default()),
            None => self.read_or_made(source)?,
        };
        let scale = self.factor(scale, &report);
        report.in_micrometres &= self.unit.is_none();
        if scale != 1.0 {
            mesh.map_points(|x| x.map(|x| scale * x));
        }
        if let Some(keep) = &self.keep {
            let names: Vec<String> = keep.iter().map(cell_name).collect();
            let all = mesh.cell_count();
            mesh.keep(&names).map_err(|why| source.error(&["mesh", "keep"], why.to_string()))?;
            let gone = all - mesh.cell_count();
            report.left_out.push(format!("{gone} of {all} cells, which `keep` does not name,"));
        }
        if self.file.is_some() {
            // The first reading stands for all.
            let _ = self.report.set(report);
        }
        Ok(mesh)
    }

    /// The mesh of the file or of the numbers, in its unit, and what its reader changed.
    fn read_or_made(&self, source: &Source) -> Result<(AnyMesh, ReadReport)> {
        let element = self.element.unwrap_or_default();
        let made = (&self.cuboid, &self.ellipsoid, &self.biventricle);
        let mesh = match (&self.file, made) {
            (Some(file), (None, None, None)) => {
                let reason = "a file holds its own kind of cell; leave it out";
                source.refuse_if(self.element.is_some(), &["mesh", "element"], || reason)?;
                let error = |reason| self.file_error(source, reason);
                let read = if self.merge { sinew_mesh::read_merged } else { sinew_mesh::read };
                return read(file).map_err(|reason| match reason {
                    MeshError::File { path, source } if source.kind() == ErrorKind::NotFound => {
                        error(format!(
                            "there is no file {}; put it there, or name another with --mesh FILE",
                            path.display()
                        ))
                    }
                    reason => error(reason.to_string()),
                });
            }
            (None, (Some(cuboid), None, None)) => cuboid.make(element, source)?,
            (None, (None, Some(ellipsoid), None)) => ellipsoid.make(element, source)?,
            (None, (None, None, Some(heart))) => heart.make(element, source)?,
            _ => {
                let reason = "give one of `file`, `box`, `ellipsoid` and `biventricle`".into();
                return Err(source.error(&["mesh"], reason));
            }
        };
        Ok((mesh, ReadReport::default()))
    }
}

impl BoxMesh {
    fn make(self, element: Element, source: &Source) -> Result<AnyMesh> {
        let Self { extent: Exactly(extent), cells: Exactly(cells) } = self;
        let reason = || format!("[{}] is not a size; give three positive lengths", listed(&extent));
        source.refuse_if(!extent.into_iter().all(is_length), &["mesh", "box", "extent"], reason)?;
        source.refuse_if(cells.contains(&0), &["mesh", "box", "cells"], || {
            format!("[{}] leaves no cell along an edge; give at least 1 each", listed(&cells))
        })?;
        few_enough(cells, &["mesh", "box", "cells"], source)?;
        Ok(match element {
            Element::Tetrahedra => box_tetrahedra(extent, cells).into(),
            Element::Hexahedra => box_hexahedra(extent, cells).into(),
            Element::QuadraticTetrahedra => box_tetrahedra(extent, cells).quadratic().into(),
        })
    }
}

impl EllipsoidMesh {
    /// The wall in a unit of length \[mm\].
    pub(super) fn shape(self, scale: f64) -> TruncatedEllipsoid {
        let Self { short, long, base, .. } = self;
        let [short, long] = [short, long].map(|axes| axes.0.map(|axis| scale * axis));
        TruncatedEllipsoid { short, long, base: scale * base }
    }

    fn make(self, element: Element, source: &Source) -> Result<AnyMesh> {
        let Self { short: Exactly(short), long: Exactly(long), base, cells: Exactly(cells) } = self;
        let at = |key| ["mesh", "ellipsoid", key];
        for (key, [inner, outer]) in [("short", short), ("long", long)] {
            let wrong = !(inner > 0.0 && inner < outer && outer.is_finite());
            source.refuse_if(wrong, &at(key), || {
                format!(
                    "{inner} and {outer} do not bound a wall; give the inner, then a larger outer semi-axis"
                )
            })?;
        }
        let reason = || format!("the plane z = {base} cuts no ellipsoid of semi-axis {}", long[0]);
        source.refuse_if(base.is_nan() || base.abs() >= long[0], &at("base"), reason)?;
        few_enough(cells, &at("cells"), source)?;
        let [_, around, along] = cells;
        let wrong = cells.contains(&0) || around % 8 != 0 || around >= 8 * along;
        source.refuse_if(wrong, &at("cells"), || {
            format!(
                "[{}]: give layers, cells around (a multiple of 8 and less than 8 times those along) and cells from apex to base",
                listed(&cells)
            )
        })?;
        let wall = self.shape(1.0).wall(cells);
        Ok(match element {
            Element::Tetrahedra => wall.tetrahedra().into(),
            Element::Hexahedra => wall.hexahedra().into(),
            Element::QuadraticTetrahedra => wall.quadratic_tetrahedra().into(),
        })
    }
}

impl BiventricleMesh {
    fn make(self, element: Element, source: &Source) -> Result<AnyMesh> {
        let Self { radius, depth, wall, septum, edge } = self;
        let at = |key| ["mesh", "biventricle", key];
        let names = ["radius", "depth", "wall", "septum", "edge"];
        for (key, size) in names.into_iter().zip([radius, depth, wall, septum, edge]) {
            let reason = || format!("{size} is not a length; give a positive one");
            source.refuse_if(!is_length(size), &at(key), reason)?;
        }
        let heart = Biventricle { radius, depth, wall, septum };
        let (shortest, longest) = (heart.shortest_edge(), heart.longest_edge());
        source.refuse_if(shortest > longest, &["mesh", "biventricle"], || {
            let thinnest = wall.min(septum);
            format!(
                "a wall of {thinnest} is too thin beside the heart's size for a grid of cells; give a thicker `wall` and `septum`"
            )
        })?;
        source.refuse_if(edge > longest, &at("edge"), || {
            format!("an edge of {edge} reaches through the thinnest wall; give at most {longest}")
        })?;
        source.refuse_if(edge < shortest, &at("edge"), || {
            format!("an edge of {edge} makes more cells than can be held; give at least {shortest}")
        })?;
        let reason = "two ventricles are made of tetrahedra only; leave it out";
        source.refuse_if(element != Element::Tetrahedra, &["mesh", "element"], || reason)?;
        Ok(heart.tetrahedra(edge).into())
    }
}

fn is_length(size: f64) -> bool {
    size > 0.0 && size.is_finite()
}

/// Most boxes of a mesh that is made: the factor of so many needs hundreds of gigabytes already.
const MOST_BOXES: usize = 2_000_000;

fn few_enough(cells: [usize; 3], key: &[&str], source: &Source) -> Result<()> {
    let product = cells.iter().fold(1usize, |product, &count| product.saturating_mul(count));
    source.refuse_if(product > MOST_BOXES, key, || {
        let cells = listed(&cells);
        format!("[{cells}] makes more cells than can be solved for; give a product of at most {MOST_BOXES}")
    })
}

/// Quadratic cells with the corners of a linear mesh.
pub(super) fn quadratic(mesh: AnyMesh) -> Result<AnyMesh, &'static str> {
    match mesh {
        AnyMesh::Tetrahedra(mesh) => Ok(mesh.quadratic().into()),
        AnyMesh::Triangles(mesh) => Ok(mesh.quadratic().into()),
        AnyMesh::Hexahedra(_) => Err("hexahedra"),
        already => Ok(already),
    }
}

/// Advice where a facet set is one of nodes, or a mesh has no sets at all.
pub(super) fn by_place(mesh: &AnyMesh, name: &str) -> String {
    if mesh.node_sets().contains_key(name) {
        format!("; it is a set of nodes: [select.NAME] with set = \"{name}\" has its facets")
    } else if mesh.facet_sets().is_empty() && mesh.node_sets().is_empty() {
        format!(
            "; choose it by where it is: [select.\"{name}\"] with a plane, box, sphere, direction or surface"
        )
    } else {
        String::new()
    }
}

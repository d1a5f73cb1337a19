//! Errors of fibre rules, with numbers and advice.

use sinew_energy::listed;
use sinew_mesh::Defect;
use thiserror::Error;

/// A wall or a rule that gives no fibres.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FibreError {
    /// The mesh breaks a rule of every mesh.
    #[error(transparent)]
    Mesh(#[from] Defect),
    /// The mesh has no cell.
    #[error("the mesh has no tetrahedra")]
    EmptyMesh,
    /// No facet set has this name.
    #[error("the mesh has no facet set `{name}`; it has {}", listed(known))]
    UnknownSurface { name: String, known: Vec<String> },
    /// A surface without facets.
    #[error("the facet set `{name}` is empty; put the facets of that surface into it")]
    EmptySurface { name: String },
    /// A cell without positive volume \[length³\].
    #[error("cell {cell} has the volume {volume:e}; run repair_orientation, or remove flat cells")]
    FlatCell { cell: usize, volume: f64 },
    /// Endocardium and epicardium share nodes, so the wall has no thickness there.
    #[error(
        "endocardium and epicardium share {count} nodes, the first is node {node}; \
         facets of the base belong to a set of their own"
    )]
    Touching { node: usize, count: usize },
    /// A connected part that does not reach one of the surfaces.
    #[error(
        "the part of the mesh with node {node} ({nodes} nodes) has no node on `{surface}`; \
         remove it, see remove_unused_nodes, or mesh the ventricle in one piece"
    )]
    Disconnected { node: usize, nodes: usize, surface: String },
    /// Each node of the epicardium belongs to the base.
    #[error(
        "there is no apex: all {nodes} nodes of the epicardium are on the base; \
         keep the outer facets out of the base"
    )]
    NoApex { nodes: usize },
    /// The gradient of the depth vanishes around a cell.
    #[error(
        "cell {cell} and its neighbours have all their nodes on one surface of the wall; \
         refine the mesh across the wall"
    )]
    NoDepth { cell: usize },
    /// An angle that is not finite.
    #[error("the {what} angle is {degrees} degrees; give a finite one")]
    Angle { what: &'static str, degrees: f64 },
    /// Semi-axes \[length\] that enclose no wall.
    #[error(
        "the {which} semi-axes ({}) must be positive, finite and ascending from endocardium to epicardium",
        listed(axes)
    )]
    SemiAxes { which: &'static str, axes: [f64; 2] },
    /// A base that does not cut the wall \[length\].
    #[error("the base at z = {base} does not cut the inner ellipsoid of half-height {height}")]
    Base { base: f64, height: f64 },
    /// A point that is farther from the wall than this fraction of its thickness.
    #[error(
        "({}, {}, {}) is farther from the wall than {slack:.2e} of its thickness; \
         allow more slack where facets cut corners",
        point[0], point[1], point[2]
    )]
    Outside { point: [f64; 3], slack: f64 },
    /// The equations of a potential could not be solved.
    #[error(
        "no memory for the factor of {unknowns} unknowns, or cells too flat; coarsen or repair the mesh"
    )]
    Factor { unknowns: usize },
}

//! Meshes: linear and quadratic tetrahedra and triangles and hexahedra with named sets and fields,
//! their quality and surfaces, and the files they come from and go to.
//!
//! ```
//! use sinew_mesh::{box_tetrahedra, enclosed_volume, boundary_facets, Field, quality};
//! use sinew_mesh::{parse_mesh, to_vtu};
//!
//! // A beam of 2 x 1 x 1 grid cells, six tetrahedra each, with a field on its nodes.
//! let mut beam = box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]);
//! let sag = beam.points.iter().map(|[x, _, _]| [0.0, 0.0, -0.1 * x * x]).collect::<Vec<_>>();
//! beam.point_fields.insert("displacement".into(), Field::vectors(&sag));
//!
//! let summary = quality(&beam).expect("the beam has cells");
//! assert!((summary.dihedral.min - 45.0).abs() < 1e-9);
//! assert!((enclosed_volume(&beam, &boundary_facets(&beam)) - 2.0).abs() < 1e-12);
//!
//! // Files keep everything bit for bit, named sets included.
//! let (again, report) = parse_mesh::<4>("beam.vtu", &to_vtu(&beam)?)?;
//! assert_eq!(again, beam);
//! assert_eq!(report.repaired_cells, 0);
//! # Ok::<(), sinew_mesh::MeshError>(())
//! ```
//!
//! # Kinds of cells
//!
//! [`Mesh`] is one type for all of them; the number of nodes of a cell tells its kind, and
//! [`Mesh::ELEMENT`] describes it. Quadratic meshes are made of linear ones:
//!
//! ```
//! use sinew_mesh::{HexMesh, QuadraticTetMesh, TruncatedEllipsoid, box_tetrahedra};
//!
//! let beam: QuadraticTetMesh = box_tetrahedra([10.0, 1.0, 1.0], [12, 4, 5]).quadratic();
//! assert_eq!(beam.points.len(), 25 * 9 * 11);
//!
//! // A ventricle, whose middle nodes lie on the curved surfaces.
//! let wall = TruncatedEllipsoid::LAND.wall([2, 16, 8]);
//! let (tets, hexes): (QuadraticTetMesh, HexMesh) = (wall.quadratic_tetrahedra(), wall.hexahedra());
//! assert_eq!((tets.check(), hexes.check()), (Ok(()), Ok(())));
//! ```
//!
//! # Files
//!
//! | format | read | written |
//! |---|---|---|
//! | legacy VTK, text and binary | grids and surfaces (POLYDATA); 2.0 to 4.2, 5.1 | |
//! | VTU, VTP | text, base64, appended raw or base64; plain or zlib | VTU by [`write_vtu`]: base64 |
//! | STL, text and binary | corners at the same place become one node | |
//! | PVD | | [`write_pvd`] |
//! | gmsh MSH, text and binary | 2.2, 4.1, with parametric nodes or in partitions | |
//! | Abaqus and CalculiX input (inp) | one body, flat or as one part with one instance, either with the mesh | |
//! | CARP of openCARP (`.pts` in µm, `.elem`, `.lon`, `.surf`, `.vtx`) | by any of the first three or the name without ending | |
//! | NumPy npy | floats, integers, booleans; both byte orders | [`to_npy`] |
//!
//! [`read`] and [`read_mesh`] tell the format by the content; both
//! read quadratic cells and hexahedra too. Solid cells with negative volume are repaired and counted
//! in the [`ReadReport`], as are nodes of no cell, which are left out, and nodes at the place of another, which [`read_merged`]
//! makes one. Triangles among tetrahedra (quadrilaterals among hexahedra) become facet
//! sets: named by gmsh's physical groups, or by the values of cell fields of whole numbers
//! (`region:1`), or `facets`. A field that marks nodes becomes a set with
//! [`Mesh::nodes_where_nonzero`]. The sets and surfaces of an Abaqus file keep their names: `*NSET` names nodes, `*ELSET` cells (or
//! facets, of shells on a solid), `*SURFACE` facets; keywords that make nodes or bring them from other files are refused. Where
//! a file has no sets, a [`Selection`] names them by place, or between two regions; [`Mesh::keep`] cuts regions out. Polygons and
//! strips of surfaces are read as triangles, voxels as hexahedra, Lagrange cells of first and second order as the cells that they equal. Arrays of text and bits, element data of
//! the boundary alone, masses, springs, reference points and elements of an Abaqus assembly are left out; the report names
//! them. Other cells, and cells folded over, are refused with advice; so are XDMF, FEBio, DOLFIN XML, Nastran, LS-DYNA, MEDIT,
//! OBJ, PLY, OFF, HDF5, Exodus, Netgen, I-DEAS universal, SU2 and Tecplot files, by name.
//!
//! CARP files are told by their names, not by their content. Coordinates become mm, as [`ReadReport::in_micrometres`] says; labels are
//! the cell field `region`, directions the cell fields `fibre` and `sheet`, zero where an element has none. `.surf` files in the folder
//! are facet sets and `.vtx` files node sets: `base` of `heart.base.surf` and, beside a single mesh, of `base.surf`.
//!
//! ## Sets in VTK files
//!
//! VTK has no named sets, so they are written as integer fields with one component:
//! `node_set:NAME` is 1 at the nodes of the set, `cell_set:NAME` is 1 at its cells, and bit `i`
//! of `facet_set:NAME` is 1 when facet `i` of the cell (in simplices the one opposite to corner
//! `i`) belongs to the set. Reading turns them back into the same sets, ascending and without repetition.
//!
//! ## Damaged and hostile files
//!
//! Every declared size is compared with the bytes that are left before memory is taken, and
//! compressed blocks are held to the size they declare and to what deflate can reach. Every
//! error names the file, the line (in text) or byte, what was expected and what to do.

mod any;
mod check;
mod element;
mod error;
mod generate;
mod geometry;
mod io;
mod mesh;
mod quadratic;
mod quality;
mod regions;
mod selection;
mod simplices;
mod topology;
mod tree;

pub use any::AnyMesh;
pub use element::{Element, QuadraturePoint};
pub use error::{MeshError, Place, Refusal};
pub use generate::{
    Biventricle, Chamber, ChamberReport, ChamberWall, Sheet, Size, Trim, TruncatedEllipsoid, Wall,
    WallOptions, box_hexahedra, box_tetrahedra, rectangle_triangles,
};
pub use geometry::{
    SELECTION_TOLERANCE, enclosed_volume, extents, extract_surface, repair_orientation,
};
pub use io::{
    DISPLACEMENT, MixedMesh, NpyArray, ReadReport, parse, parse_mesh, parse_npy, read, read_merged,
    read_mesh, read_npy, text_of, to_npy, to_npy_of, to_vtu, write_pvd, write_vtu,
};
pub use mesh::{
    Facet, Field, FieldValues, HexMesh, Mesh, QuadraticTetMesh, QuadraticTriangleMesh, TetMesh,
    TriangleMesh,
};
pub use quality::{
    QualitySummary, SLIVER_ANGLE, Spread, min_dihedral_angle, quality, volume_ratio,
};
pub use selection::{Selected, Selection};
pub use topology::{boundary_facets, edges, folded_facets, remove_unused_nodes};
pub use tree::self_intersections;

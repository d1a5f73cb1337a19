//! Files of eight writers (`fixtures/writers/generate.py`): each is read to its known size and sets, or refused by the name of what it
//! holds.

use sinew_mesh::{AnyMesh, Facet, extents, read, with_cells};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The answer to a file.
enum Answer {
    /// Kind of cell, its volume (area), and names with theirs: volumes of cells, areas (lengths) of facets, numbers of nodes.
    Read(&'static str, f64, &'static [(&'static str, f64)]),
    /// Words of the message.
    Refused(&'static [&'static str]),
}

use Answer::{Read, Refused};

const TETS: &str = "tetrahedron";
const TRIANGLES: &str = "triangle";
const HALVES: &[(&str, f64)] =
    &[("left half", 1.0), ("right half", 1.0), ("side", 1.0), ("middle", 1.0)];
const REGIONS: &[(&str, f64)] = &[("region:1", 1.0), ("region:2", 1.0), ("1", 1.0)];
const LABELS: &[(&str, f64)] = &[("region:1", 1.0), ("region:2", 1.0), ("region:7", 1.0)];
const BY_FIELD: &[(&str, f64)] = &[("region:1", 1.0), ("region:7", 1.0), ("facets", 1.0)];
const CARP: &[(&str, f64)] = &[("region:1", 1.0), ("2", 1.0), ("side", 1.0), ("corner", 1.0)];

#[rustfmt::skip]
const FILES: [(&str, Answer); 55] = [
    ("abaqus_hexahedron.inp", Read("hexahedron", 2.0, &[("EALL", 2.0), ("TOP", 2.0)])),
    ("abaqus_include.inp", Refused(&["line 2", "`*INCLUDE`"])),
    ("abaqus_ngen.inp", Refused(&["line 4", "`*NGEN`"])),
    ("abaqus_one_instance.inp", Read(TETS, 2.0, &[("left", 1.0), ("tip", 2.0)])),
    ("abaqus_plane.inp", Read(TRIANGLES, 2.0, &[("PLATE", 2.0)])),
    ("abaqus_plane_xz.inp", Read(TRIANGLES, 2.0, &[("PLATE", 2.0)])),
    ("abaqus_small_letters.inp", Read(TETS, 2.0, &[("left", 1.0), ("both", 2.0), ("the bar", 2.0), ("side", 1.0), ("ends", 4.0)])),
    ("abaqus_two_instances.inp", Refused(&["line 34", "a second `*INSTANCE`", "the body alone"])),
    ("abaqus_two_parts.inp", Refused(&["line 31", "a second `*PART`", "the body alone"])),
    ("abaqus_wedge.inp", Refused(&["line 10", "cell 0 is a wedge"])),
    ("carp_bar.elem", Read(TETS, 2.0, CARP)),
    ("carp_bar.lon", Read(TETS, 2.0, CARP)),
    ("carp_bar.pts", Read(TETS, 2.0, CARP)),
    ("carp_bar", Read(TETS, 2.0, CARP)),
    ("carp_hexahedron", Read("hexahedron", 2.0, &[("region:4", 2.0)])),
    ("dolfinx.pvd", Refused(&["VTK XML file type `Collection`", ".vtu"])),
    ("dolfinx.pvtu", Refused(&["VTK XML file type `PUnstructuredGrid`", ".vtu"])),
    ("dolfinx.xdmf", Refused(&["`XDMF`", "`VTKFile`"])),
    ("dolfinx_p0_000000.vtu", Read(TETS, 2.0, &[("mesh_tags:1", 1.0), ("mesh_tags:2", 1.0)])),
    ("felupe_hexahedra.vtk", Read("hexahedron", 2.0, &[])),
    ("felupe_hexahedra.vtu", Read("hexahedron", 2.0, &[])),
    ("felupe_quads.vtu", Refused(&["cell 0 is a quadrilateral", "split"])),
    ("felupe_tetrahedra.vtk", Read(TETS, 2.0, &[])),
    ("gmsh_halves.bdf", Refused(&["`Nastran bulk data`"])),
    ("gmsh_halves.inp", Read(TETS, 2.0, &[("left_half", 1.0), ("right_half", 1.0), ("side", 1.0), ("middle", 1.0)])),
    ("gmsh_halves.mesh", Refused(&["`MEDIT (.mesh)`"])),
    ("gmsh_halves_22.msh", Read(TETS, 2.0, HALVES)),
    ("gmsh_halves_40.msh", Refused(&["line 2", "MSH version `4`", "msh41"])),
    ("gmsh_halves_41.msh", Read(TETS, 2.0, HALVES)),
    ("gmsh_hexahedra.msh", Read("hexahedron", 1.0, &[("block", 1.0), ("bottom", 1.0)])),
    ("gmsh_no_groups_41.msh", Read(TETS, 2.0, &[("facets", 11.0)])),
    ("gmsh_plane_xz.msh", Read(TRIANGLES, 2.0, &[("plate", 2.0)])),
    ("gmsh_plane_xz.unv", Refused(&["`I-DEAS universal (.unv)`", ".msh"])),
    ("gmsh_prisms.msh", Refused(&["is a wedge", "split"])),
    ("gmsh_saved_as.vtk", Read(TETS, 2.0, &[("facets", 11.0)])),
    ("meshio.su2", Refused(&["`SU2`", "meshio convert"])),
    ("meshio_dolfin.xml", Refused(&["`DOLFIN XML`"])),
    ("meshio_labels.vtk", Read(TETS, 2.0, LABELS)),
    ("meshio_sets.inp", Read(TETS, 2.0, &[("left_half", 1.0), ("corner", 1.0), ("facets", 1.0)])),
    ("meshio_sets_as_data.vtu", Read(TETS, 2.0, &[("left_half:0", 1.0), ("left_half:-1", 1.0), ("region:7", 1.0)])),
    ("meshio_surface.off", Refused(&["`OFF`", ".stl"])),
    ("meshio_tecplot.dat", Refused(&["`Tecplot`"])),
    ("meshio_xml.xdmf", Refused(&["`XDMF`"])),
    ("pyvista_grid.vtk", Read(TETS, 2.0, REGIONS)),
    ("pyvista_grid.vtu", Read(TETS, 2.0, REGIONS)),
    ("pyvista_plane_xz.vtu", Read(TRIANGLES, 2.0, &[])),
    ("pyvista_surface.ply", Refused(&["`PLY`"])),
    ("pyvista_surface.stl", Read(TRIANGLES, 10.0, &[])),
    ("pyvista_surface.vtp", Read(TRIANGLES, 10.0, &[])),
    ("vtk_blocks.vtm", Refused(&["`vtkMultiBlockDataSet`", ".vtu"])),
    ("vtk_float_labels.vtu", Read(TETS, 2.0, BY_FIELD)),
    ("vtk_image.vti", Refused(&["`ImageData`", ".vtu"])),
    ("vtk_labels_and_numbers.vtu", Read(TETS, 2.0, LABELS)),
    ("vtk_polyhedron.vtu", Refused(&["cell 0 is a polyhedron"])),
    ("vtk_quadratic_hexahedron.vtu", Refused(&["cell 0 is a quadratic hexahedron", "first-order"])),
];

/// Files of the folder that belong to others, and those with a test of their own.
const OTHERS: [&str; 9] = [
    "PROVENANCE.md",
    "generate.py",
    ".gitattributes",
    "carp_bar.side.surf",
    "carp_bar.corner.vtx",
    "carp_hexahedron.pts",
    "carp_hexahedron.elem",
    "carp_hexahedron.lon",
    "vtk_seventy_labels.vtu",
];

fn fixture(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "../../fixtures/writers", name].iter().collect()
}

fn volume(mesh: &AnyMesh, cells: impl IntoIterator<Item = usize>) -> f64 {
    with_cells!(mesh, mesh => cells.into_iter().map(|cell| mesh.cell_volume(cell)).sum())
}

/// Area of a plane facet by a fan of triangles.
fn area(mesh: &AnyMesh, facet: &Facet) -> f64 {
    let corners = mesh.nodes_of_facet(*facet).into_iter().take(mesh.element().facet_corners);
    let x: Vec<[f64; 3]> = corners.map(|node| mesh.points()[node]).collect();
    let along = |a: usize, b: usize| [0, 1, 2].map(|axis| x[b][axis] - x[a][axis]);
    let fan = (2..x.len()).map(|k| {
        let ([a, b, c], [d, e, f]) = (along(0, k - 1), along(0, k));
        0.5 * ((b * f - c * e).powi(2) + (c * d - a * f).powi(2) + (a * e - b * d).powi(2)).sqrt()
    });
    fan.sum()
}

fn size_of(mesh: &AnyMesh, name: &str) -> Option<f64> {
    if let Some(cells) = mesh.cells_of(name) {
        return Some(volume(mesh, cells));
    }
    let facets = |facets: &Vec<Facet>| facets.iter().map(|facet| area(mesh, facet)).sum();
    let of_facets = mesh.facet_sets().get(name).map(facets);
    of_facets.or_else(|| mesh.node_sets().get(name).map(|nodes| nodes.len() as f64))
}

#[test]
fn files_are_read_to_their_sets_or_refused_by_name() {
    let mut wrong = Vec::new();
    for (name, answer) in &FILES {
        match (read(fixture(name)), answer) {
            (Ok((mesh, report)), Read(kind, size, sets)) => {
                let found = (mesh.element().name, volume(&mesh, 0..mesh.cell_count()));
                if found.0 != *kind || (found.1 - size).abs() > 1e-6 {
                    wrong.push(format!("{name}: {found:?} in place of {kind} of {size}"));
                }
                if report.repaired_cells > 0 || !report.warnings().is_empty() {
                    wrong.push(format!("{name}: {report:?}"));
                }
                for (set, size) in *sets {
                    let found = size_of(&mesh, set);
                    if found.is_none_or(|found| (found - size).abs() > 1e-6) {
                        wrong.push(format!("{name}, {set}: {found:?} in place of {size}"));
                    }
                }
            }
            (Err(error), Refused(words)) => {
                let error = error.to_string();
                if !words.iter().all(|word| error.contains(word)) {
                    wrong.push(error);
                }
            }
            (Ok(_), Refused(_)) => wrong.push(format!("{name} is read")),
            (Err(error), Read(..)) => wrong.push(error.to_string()),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let known: BTreeSet<&str> = FILES.iter().map(|(name, _)| *name).chain(OTHERS).collect();
    for file in std::fs::read_dir(fixture("")).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        assert!(known.contains(name.as_str()), "no test reads {name}");
    }
}

#[test]
fn more_labels_than_a_heart_has_are_labels_where_they_repeat() {
    let (mesh, report) = read(fixture("vtk_seventy_labels.vtu")).unwrap();
    assert_eq!(mesh.facet_sets().len(), 70);
    for label in [101, 170] {
        assert_eq!(size_of(&mesh, &format!("segment:{label}")), Some(2.0));
    }
    let told = "facet sets by the field `number`, a numbering of 280 values, left out";
    assert_eq!(report.changes(), [told]);
    assert!(mesh.names_of_cells().len() == 1 && mesh.cells_of("number:3").is_some());
}

#[test]
fn fields_of_writers_are_there() {
    let (mesh, _) = read(fixture("pyvista_grid.vtk")).unwrap();
    assert_eq!(mesh.cell_fields()["fibre"].components, 3);
    assert_eq!(mesh.nodes_where_nonzero("held").unwrap().len(), 4);
    let (mesh, report) = read(fixture("carp_bar.pts")).unwrap();
    assert_eq!(extents(mesh.points()), [2.0, 1.0, 1.0]);
    assert_eq!(report.left_out, ["fibres of 6 of 12 elements, which are zero,"]);
    assert_eq!(mesh.cell_fields()["sheet"].to_vectors::<3>().unwrap()[0], [0.0, 1.0, 0.0]);
    let (mesh, _) = read(fixture("vtk_labels_and_numbers.vtu")).unwrap();
    assert_eq!(mesh.cell_fields()["stiffness"].to_f64()[0], 0.25);
}

//! Formats that are recognised and not read, with the way out.

/// Beginnings of files, words one of which stands among their first bytes (any, where there are none), name, and how to convert
/// such a file.
type Foreign = (&'static [&'static [u8]], &'static [&'static [u8]], &'static str, &'static str);

const BY_MESHIO: &str = "write it as .vtu with `meshio convert`";
const FROM_DOLFINX: &str = "write it as .vtu with `meshio convert`, or from DOLFINx with `VTKFile`";
const FROM_PREPOST: &str = "save the mesh from LS-PrePost as Abaqus input";
const AS_STL: &str = "save the surface as .stl";
const NASTRAN: &[&[u8]] = &[b"$", b"SOL ", b"CEND", b"BEGIN", b"GRID"];
const PACKED: &[&[u8]] = &[b"\x1f\x8b", b"PK\x03\x04", b"BZh", b"\xfd7zXZ", b"7z\xbc\xaf"];
const HTML: &[&[u8]] = &[b"<!DOCTYPE html", b"<!doctype html", b"<html"];

// Comments of Blender, CAD programs, MeshLab, Open3D and VTK stand first, but not "# vtk".
const OBJ: &[&[u8]] =
    &[b"v ", b"o ", b"mtllib", b"# B", b"# E", b"# O", b"# W", b"# w", b"#\n", b"##"];
const IMAGES: &[&[u8]] = &[b"NRRD0", b"ObjectType = Image", b"\x5c\x01\0\0", b"\0\0\x01\x5c"];

const FORMATS: [Foreign; 21] = [
    (PACKED, &[], "archive or compressed file", "unpack it"),
    (HTML, &[], "HTML", "it is a page in the place of the file: download that itself"),
    (&[b"version https://git-lfs"], &[], "pointer of Git LFS", "get the file by `git lfs pull`"),
    (
        IMAGES,
        &[],
        "image (NRRD, MetaImage or NIfTI)",
        "segment it, and fill the surfaces with cells",
    ),
    (&[b"FORMAT"], &[b"ensight"], "EnSight", "save it from ParaView as .vtu"),
    (&[b"$NOD"], &[], "gmsh MSH 1", "convert it with `gmsh -save -format msh41`"),
    (&[b"<"], &[b"<Xdmf"], "XDMF", FROM_DOLFINX),
    (&[b"<"], &[b"<febio_spec"], "FEBio (.feb)", "save the mesh from FEBio Studio as .vtk or .inp"),
    (&[b"<"], &[b"<dolfin"], "DOLFIN XML", BY_MESHIO),
    (&[b"$", b"*KEYWORD"], &[b"*KEYWORD"], "LS-DYNA keyword", FROM_PREPOST),
    (NASTRAN, &[b"BEGIN BULK", b"GRID "], "Nastran bulk data", BY_MESHIO),
    (&[b"MeshVersionFormatted"], &[], "MEDIT (.mesh)", BY_MESHIO),
    (&[b"ply\n", b"ply\r"], &[], "PLY", AS_STL),
    (OBJ, &[b"\nv "], "OBJ", AS_STL),
    (&[b"\x89HDF"], &[], "HDF5 (MED, CGNS or the data of XDMF)", BY_MESHIO),
    (&[b"CDF\x01", b"CDF\x02"], &[], "Exodus", BY_MESHIO),
    (&[b"-1"], &[b"2411", b"2420"], "I-DEAS universal (.unv)", "save it as .msh"),
    (&[b"NDIME="], &[], "SU2", BY_MESHIO),
    (&[b"TITLE", b"VARIABLES"], &[b"ZONE"], "Tecplot", BY_MESHIO),
    (&[b"OFF\n", b"OFF\r"], &[], "OFF", AS_STL),
    (&[b"mesh3d", b"dimension"], &[b"volumeelements"], "Netgen (.vol)", "export it as gmsh2"),
];

/// Bytes in which the words of a format are looked for.
const HEAD: usize = 4096;

/// The format of a file that is not read, and the way out.
pub(super) fn format(content: &[u8]) -> Option<(&'static str, &'static str)> {
    let head = &content[..content.len().min(HEAD)];
    let has = |word: &&[u8]| head.windows(word.len()).any(|part| part == *word);
    let known = FORMATS.iter().find(|(starts, words, ..)| {
        starts.iter().any(|start| content.starts_with(start))
            && (words.is_empty() || words.iter().any(has))
    });
    known.map(|&(.., name, advice)| (name, advice))
}

//! Simplex meshes: named sets and fields, quality, generators, VTK, VTU and gmsh files

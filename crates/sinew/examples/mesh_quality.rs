//! Reads a mesh (VTK, VTU or gmsh) and prints the quality of its tetrahedra:
//!
//! ```text
//! cargo run -p sinew --example mesh_quality -- organ.vtk
//! ```
//!
//! Without a path it reads a small box that gmsh has meshed.

use sinew_mesh::{
    MeshError, boundary_facets, enclosed_volume, extract_surface, min_dihedral_angle, quality,
    read_mesh,
};
use std::path::PathBuf;

fn main() -> Result<(), MeshError> {
    let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/mesh/gmsh_41_binary.msh");
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from(bundled), PathBuf::from);

    let (mesh, report) = read_mesh::<4>(&path)?;
    println!("{}", path.display());
    println!("{} tetrahedra had negative volume and were repaired", report.repaired_cells);

    if let Some(summary) = quality(&mesh) {
        println!("{summary}");
        for &cell in &summary.slivers {
            println!("  sliver {cell}: {:.3} deg", min_dihedral_angle(&mesh, cell));
        }
    }

    let boundary = boundary_facets(&mesh);
    let surface = extract_surface(&mesh, &boundary);
    println!(
        "boundary: {} triangles on {} nodes enclose {:.6}",
        surface.mesh.cells.len(),
        surface.nodes.len(),
        enclosed_volume(&mesh, &boundary),
    );
    for (name, facets) in &mesh.facet_sets {
        println!("facet set {name:?}: {} facets", facets.len());
    }
    for (name, nodes) in &mesh.node_sets {
        println!("node set {name:?}: {} nodes", nodes.len());
    }
    for (name, cells) in &mesh.cell_sets {
        println!("cell set {name:?}: {} cells", cells.len());
    }
    Ok(())
}

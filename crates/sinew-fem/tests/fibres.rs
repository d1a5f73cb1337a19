//! Rule-based fibres against closed forms, symmetry and a published field.

use nalgebra::{Rotation3, Vector3};
use sinew_fem::fibres::*;
use sinew_mesh::{TetMesh, boundary_facets, repair_orientation};
use std::f64::consts::PI;

const SURFACES: Surfaces<'static> =
    Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };

/// The truncated ellipsoid of Land et al. in `layers` × `along` × `around` grid cells, six tetrahedra each, of
/// which those at the apex collapse to three.
fn ellipsoid(layers: usize, along: usize, around: usize) -> TetMesh {
    let mut index = std::collections::HashMap::new();
    let mut mesh = TetMesh::default();
    let mut node = |i: usize, j: usize, k: usize| {
        let j = if i == 0 { 0 } else { j % around };
        *index.entry([i, j, k]).or_insert_with(|| {
            let t = k as f64 / layers as f64;
            let (short, long) = (7.0 + 3.0 * t, 17.0 + 3.0 * t);
            let end = PI - (5.0_f64 / long).acos();
            let (polar, v) = (end * i as f64 / along as f64, 2.0 * PI * j as f64 / around as f64);
            let radius = short * polar.sin();
            mesh.points.push([radius * v.cos(), radius * v.sin(), -long * polar.cos()]);
            mesh.points.len() - 1
        })
    };
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut cells = Vec::new();
    for i in 0..along {
        for j in 0..around {
            for k in 0..layers {
                for order in orders {
                    let mut at = [i, j, k];
                    let mut cell = [node(i, j, k); 4];
                    for (step, axis) in order.into_iter().enumerate() {
                        at[axis] += 1;
                        cell[step + 1] = node(at[0], at[1], at[2]);
                    }
                    let distinct = (0..4).all(|a| !cell[..a].contains(&cell[a]));
                    if distinct {
                        cells.push(cell);
                    }
                }
            }
        }
    }
    let side = |i: usize, k: usize| match (i, k) {
        (i, _) if i == along => Some("base"),
        _ => None,
    };
    let _ = side;
    let mut height = vec![[0usize; 2]; mesh.points.len()];
    index.iter().for_each(|(key, &node)| height[node] = [key[0], key[2]]);
    mesh.cells = cells;
    repair_orientation(&mut mesh);
    for facet in boundary_facets(&mesh) {
        let nodes = mesh.facet_nodes(facet);
        let all = |axis: usize, level: usize| nodes.iter().all(|&n| height[n][axis] == level);
        let name = if all(0, along) {
            "base"
        } else if all(1, 0) {
            "endo"
        } else {
            "epi"
        };
        mesh.facet_sets.entry(name.into()).or_default().push(facet);
    }
    mesh
}

fn centre(mesh: &TetMesh, cell: usize) -> Vector3<f64> {
    mesh.corners(cell).iter().sum::<Vector3<f64>>() / 4.0
}

/// Angle [degrees] between two lines.
fn between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (Vector3::from(a), Vector3::from(b));
    a.cross(&b).norm().atan2(a.dot(&b).abs()).to_degrees()
}

fn quantiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [0.5, 0.95, 1.0].map(|q| values[(q * (values.len() - 1) as f64) as usize])
}

#[test]
fn experiment() {
    for (l, a, r) in [(3, 16, 24), (6, 32, 48)] {
        let mesh = ellipsoid(l, a, r);
        for variant in [Depth::Potential, Depth::Thickness] {
            
            let start = std::time::Instant::now();
            let field = VentricleCoordinates::new(&mesh, &SURFACES).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            let frames = field.cell_frames(&FibreRule::SIXTY, variant);
            let mut err = vec![];
            let mut errapex = vec![];
            let mut errnormal = vec![];
            for cell in 0..mesh.cells.len() {
                let x = centre(&mesh, cell);
                let exact = EllipsoidWall::LAND.frame(x.into(), &FibreRule::SIXTY, 0.1).unwrap();
                let e = between(frames[cell][0], exact[0]);
                if x.x.hypot(x.y) > 2.0 { err.push(e); errnormal.push(between(frames[cell][1], exact[1])); } else { errapex.push(e) }
            }
            println!("{l} {a} {r} cells {} variant {variant:?}: {:.2?} apex {:.2?} sheet {:.2?} {seconds:.3} s", mesh.cells.len(), quantiles(err), quantiles(errapex), quantiles(errnormal));
            let frames = field.node_frames(&FibreRule::SIXTY, variant);
            let mut err = vec![];
            let mut errapex = vec![];
            for (node, &x) in mesh.points.iter().enumerate() {
                let exact = EllipsoidWall::LAND.frame(x, &FibreRule::SIXTY, 0.0).unwrap();
                let e = between(frames[node][0], exact[0]);
                if x[0].hypot(x[1]) > 2.0 { err.push(e) } else { errapex.push(e) }
            }
            println!("   nodes {:.2?} apex {:.2?}", quantiles(err), quantiles(errapex));
        }
    }
}

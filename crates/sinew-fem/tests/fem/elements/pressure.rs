//! Follower pressures on loose rims.

use crate::elements::scene::{node_at, scene, wobble};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Support, SurfaceResponse};
use sinew_fem::{Options, Solver};
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra};

const PRESSURE: f64 = 0.02;
/// Shares of forces in rounding and in what Newton's method leaves.
const BALANCE: f64 = 1e-8;

/// A plate strip clamped at one end under a pressure from below. Whatever the interior does, the support bears
/// p times the area vector that the deformed rim spans, `½ ∮ x × dx`.
fn check_strip(mesh: impl Into<AnyMesh>) {
    let load = Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(PRESSURE) };
    let strip = scene(NeoHookean, mesh, vec![load], vec![Support::clamped("x_min")]);
    assert!(strip.lower().is_err(), "a loose rim has no potential");
    let strip = strip.loose_rims();
    let body = strip.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let solution = solver.solve(&[5.0, 5.0], &Options::default()).unwrap();
    let u = &solution.displacement;
    let tip = node_at(strip.mesh.points(), [4.0, 1.0, 0.5]);
    assert!(u[3 * tip + 2] > 0.5, "the strip bends far up: {}", u[3 * tip + 2]);

    let mut unbalanced = vec![0.0; u.len()];
    body.value_and_gradient(u, &[5.0, 5.0], &mut unbalanced);
    let follower = &body.followers[0];
    let mut response = SurfaceResponse::default();
    let mut total = [0.0; 3];
    for facet in 0..follower.facets() {
        follower.facet_force(facet, u, &mut response);
        for (slot, force) in response.gradient.iter().enumerate() {
            let node = follower.facet_nodes(facet)[slot / 3];
            unbalanced[3 * node + slot % 3] += PRESSURE * force;
            total[slot % 3] += PRESSURE * force;
        }
    }
    let reaction = |i: usize| -> f64 {
        strip.mesh.node_sets()["x_min"].iter().map(|&node| unbalanced[3 * node + i]).sum()
    };
    let area = rim_area(&strip.mesh, u);
    let (size, cells) = (PRESSURE * 4.0, strip.mesh.element().plural);
    for i in 0..3 {
        assert!(
            (total[i] - PRESSURE * area[i]).abs() < 1e-13 * size,
            "{cells}: {total:?} {area:?}"
        );
        assert!((reaction(i) - PRESSURE * area[i]).abs() < BALANCE * size, "{cells} {i}");
    }
    for i in body.free_degrees_of_freedom() {
        assert!(unbalanced[i].abs() < BALANCE * size, "{cells} {i}: {:e}", unbalanced[i]);
    }
}

/// `½ ∮ x × dx` around the bottom of a box, outward, from the positions of the nodes along it.
fn rim_area(mesh: &AnyMesh, u: &[f64]) -> [f64; 3] {
    let (bottom, points) = (&mesh.node_sets()["z_min"], mesh.points());
    let extent: [f64; 2] =
        [0, 1].map(|i| bottom.iter().fold(0.0, |m: f64, &node| m.max(points[node][i])));
    // Sides in the order that looks counterclockwise from below, each along its own axis.
    let mut path: Vec<usize> = Vec::new();
    for (across, level, along, sign) in
        [(0, 0.0, 1, 1.0), (1, extent[1], 0, 1.0), (0, extent[0], 1, -1.0), (1, 0.0, 0, -1.0)]
    {
        let mut side: Vec<usize> =
            bottom.iter().copied().filter(|&node| points[node][across] == level).collect();
        side.sort_by(|&a, &b| (sign * points[a][along]).total_cmp(&(sign * points[b][along])));
        path.extend(&side[..side.len() - 1]);
    }
    let x = |at: usize| -> [f64; 3] {
        let node = path[at % path.len()];
        std::array::from_fn(|i| points[node][i] + u[3 * node + i])
    };
    let mut area = [0.0; 3];
    let mut add = |a: [f64; 3], b: [f64; 3], weight: f64| {
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            area[i] += 0.5 * weight * (a[j] * b[k] - a[k] * b[j]);
        }
    };
    if !mesh.element().is_quadratic() {
        (0..path.len()).for_each(|at| add(x(at), x(at + 1), 1.0));
        return area;
    }
    // Parabolas a, m, b: ∫ x × dx = (4 a × m + 4 m × b − a × b)/3.
    for at in (0..path.len()).step_by(2) {
        let [a, m, b] = [x(at), x(at + 1), x(at + 2)];
        add(a, m, 4.0 / 3.0);
        add(m, b, 4.0 / 3.0);
        add(a, b, -1.0 / 3.0);
    }
    area
}

#[test]
fn the_support_bears_the_pressure_on_the_deformed_area() {
    let extent = [4.0, 1.0, 0.5];
    check_strip(box_tetrahedra(extent, [8, 2, 3]));
    check_strip(box_tetrahedra(extent, [4, 1, 1]).quadratic());
    check_strip(box_hexahedra(extent, [8, 2, 3]));
}

/// The tangent of a loose follower is that of its forces, symmetric or not.
#[test]
fn the_tangent_of_a_loose_follower_agrees_with_differences() {
    fn check(mesh: impl Into<AnyMesh>) {
        let load = Load::Pressure { facets: "y_max".into(), magnitude: Magnitude::Fixed(1.0) };
        let support = Support::clamped("x_min");
        let body = scene(NeoHookean, mesh, vec![load], vec![support]).loose_rims().lower().unwrap();
        let (follower, cells) = (&body.followers[0], body.element().plural);
        let u = wobble(body.prescribed.len(), 0.1);
        let mut centre = SurfaceResponse::default();
        follower.facet_force(0, &u, &mut centre);
        let size = centre.gradient.len();
        let largest = centre.hessian.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let mut asymmetry: f64 = 0.0;
        for column in 0..size {
            let entry = 3 * follower.facet_nodes(0)[column / 3] + column % 3;
            // Forces are quadratic in u, so central differences are exact but for rounding.
            let [up, down] = [1e-3, -1e-3].map(|by| {
                let mut moved = u.clone();
                moved[entry] += by;
                let mut response = SurfaceResponse::default();
                follower.facet_force(0, &moved, &mut response);
                response.gradient
            });
            for row in 0..size {
                let difference = (up[row] - down[row]) / 2e-3;
                let tangent = centre.hessian[row * size + column];
                assert!((tangent - difference).abs() < 1e-11 * largest, "{cells} {row} {column}");
                asymmetry = asymmetry.max((tangent - centre.hessian[column * size + row]).abs());
            }
        }
        assert!(asymmetry > 0.1 * largest, "{cells}: a loose facet has no potential");
    }
    check(box_tetrahedra([1.0; 3], [1; 3]));
    check(box_tetrahedra([1.0; 3], [1; 3]).quadratic());
    check(box_hexahedra([1.0; 3], [1; 3]));
    check(sinew_mesh::rectangle_triangles([1.0; 2], [2, 2]));
    check(sinew_mesh::rectangle_triangles([1.0; 2], [2, 2]).quadratic());
}

//! Volumes of cavities against closed forms, rigid motions and differences.

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Parameter, Prescribed, Scene, Support};
use sinew_mesh::{
    AnyMesh, Biventricle, HexMesh, Mesh, TetMesh, TruncatedEllipsoid, boundary_facets,
    box_tetrahedra,
};
use std::f64::consts::{PI, TAU};

/// Rounding of sums over some hundred triangles [relative].
const CLOSED: f64 = 1e-10;
/// Rounding of one volume at two places [relative].
const RIGID: f64 = 1e-12;
/// Truncation of central differences with steps of 1e-4 in a body of some 60, and their rounding.
const DIFFERENCE: f64 = 1e-6;

/// A body under pressures in cavities, held by springs where supports do not hold it.
fn body(mesh: impl Into<AnyMesh>, cavities: &[&str], supports: Vec<Support>) -> Body {
    let pressure = |facets: &&str| Load::Pressure {
        facets: facets.to_string(),
        magnitude: Magnitude::Fixed(1.0),
    };
    let pressures = cavities.iter().map(pressure).collect();
    scene_of(mesh, pressures, supports).loose_rims().lower().unwrap()
}

/// A scene of such a body.
pub(crate) fn scene_of(
    mesh: impl Into<AnyMesh>,
    pressures: Vec<Load>,
    supports: Vec<Support>,
) -> Scene {
    let scene = Scene::new(mesh, NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0));
    let facets = |load: &Load| match load {
        Load::Pressure { facets, .. } | Load::CavityPressure { facets, .. } => facets.clone(),
        other => panic!("{other:?} is no pressure"),
    };
    let spring = |facets| Load::Foundation { facets, normal: 1.0, tangential: 1.0 };
    let springs: Vec<_> = pressures.iter().map(facets).map(spring).collect();
    Scene { loads: [springs, pressures].concat(), supports, ..scene }
}

/// Wall of a sector of a tube about z, from a polygon with corners at `inner` to one twice as large, between the heights that `ends`
/// give at a place across. Its sets are `inner`, `first` and `last` (ends of the sector), `low` and `high`.
pub(crate) fn tube(inner: &[[f64; 2]], is_whole: bool, ends: [fn([f64; 2]) -> f64; 2]) -> HexMesh {
    const LAYERS: usize = 3;
    let (around, cells) = (inner.len(), inner.len() - usize::from(!is_whole));
    let index = |i: usize, j: usize, k: usize| i + 2 * (j % around + around * k);
    let mut mesh = HexMesh::default();
    for k in 0..=LAYERS {
        for [x, y] in inner {
            for scale in [1.0, 2.0] {
                let at = [scale * x, scale * y];
                let [low, high] = ends.map(|end| end(at));
                mesh.points.push([at[0], at[1], low + (high - low) * k as f64 / LAYERS as f64]);
            }
        }
    }
    for k in 0..LAYERS {
        for j in 0..cells {
            let corner = |c: usize| index((c + 1) >> 1 & 1, j + (c >> 1 & 1), k + (c >> 2));
            mesh.cells.push(std::array::from_fn(corner));
        }
    }
    let set = |keep: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..mesh.points.len()).filter(|&node| keep(node)).collect()
    };
    let sets = [
        ("first", set(&|node| node / 2 % around == 0)),
        ("last", set(&|node| node / 2 % around == around - 1)),
        ("low", set(&|node| node / 2 / around == 0)),
        ("high", set(&|node| node / 2 / around == LAYERS)),
    ];
    mesh.node_sets.extend(sets.map(|(name, nodes)| (name.to_string(), nodes)));
    let is_inner =
        |facet: &sinew_mesh::Facet| mesh.nodes_of_facet(*facet).all(|node| node % 2 == 0);
    let inner: Vec<_> = boundary_facets(&mesh).into_iter().filter(is_inner).collect();
    mesh.facet_sets.insert("inner".into(), inner);
    mesh
}

/// Corners of a polygon between two angles.
pub(crate) fn polygon(corners: usize, from: f64, to: f64, radius: fn(f64) -> f64) -> Vec<[f64; 2]> {
    let corner = |j: usize| {
        let angle = from + (to - from) * j as f64 / (corners - 1) as f64;
        [radius(angle) * angle.cos(), radius(angle) * angle.sin()]
    };
    (0..corners).map(corner).collect()
}

/// Area of a polygon with the axis as a further corner, and its first moments.
fn moments(corners: &[[f64; 2]], is_whole: bool) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for j in 0..corners.len() - usize::from(!is_whole) {
        let ([a, b], [c, d]) = (corners[j], corners[(j + 1) % corners.len()]);
        let area = 0.5 * (a * d - b * c);
        let parts = [area, area * (a + c) / 3.0, area * (b + d) / 3.0];
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    }
    sums
}

/// A roller along one axis.
pub(crate) fn roller(nodes: &str, axis: usize) -> Support {
    let row = std::array::from_fn(|i| (i == axis).then_some(0.0));
    Support { nodes: nodes.into(), displacement: Prescribed::Uniform(row) }
}

fn roller_along(nodes: &str, direction: [f64; 3]) -> Support {
    let displacement = Prescribed::Along { direction, displacement: 0.0 };
    Support { nodes: nodes.into(), displacement }
}

fn at_rest(body: &Body) -> f64 {
    body.cavity_volumes(&vec![0.0; 3 * body.nodes])[0]
}

fn assert_volume(body: &Body, expected: f64) {
    let found = at_rest(body);
    assert!((found / expected - 1.0).abs() < CLOSED, "{found} is not {expected}");
    assert_slopes(body);
}

/// The derivatives are those of the volume, whatever the displacement.
fn assert_slopes(body: &Body) {
    let wave = |k: usize, step: f64| {
        (0..3 * body.nodes).map(|i| step * ((k * i + 1) as f64).sin()).collect::<Vec<_>>()
    };
    let size = 0.005 * body.positions.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let (u, along) = (wave(1, size), wave(3, 1.0));
    let moved = |step: f64| {
        body.cavity_volumes(&u.iter().zip(&along).map(|(u, v)| u + step * v).collect::<Vec<_>>())
    };
    let (before, after) = (moved(-1e-4), moved(1e-4));
    for (index, gradient) in body.cavity_volume_gradients(&u).iter().enumerate() {
        let slope = (after[index] - before[index]) / 2e-4;
        let exact: f64 = gradient.iter().zip(&along).map(|(g, v)| g * v).sum();
        assert!((slope - exact).abs() < DIFFERENCE * exact.abs(), "{slope} is not {exact}");
    }
}

fn uneven(angle: f64) -> f64 {
    2.0 + 0.3 * (2.0 * angle).cos() + 0.2 * (3.0 * angle).sin()
}

pub(crate) fn round(_: f64) -> f64 {
    3.0
}

pub(crate) const FLAT: [fn([f64; 2]) -> f64; 2] = [|_| -1.0, |_| 4.0];

/// An uneven tube whose ends are tilted, and its volume.
pub(crate) fn tilted() -> (HexMesh, f64) {
    let mut corners = polygon(10, 0.0, TAU, uneven);
    corners.pop();
    let [area, x, y] = moments(&corners, true);
    let mesh = tube(&corners, true, [|[x, y]| 0.2 * x - 0.1 * y, |[x, y]| 5.0 - 0.4 * x + 0.3 * y]);
    (mesh, 5.0 * area - 0.6 * x + 0.4 * y)
}

#[test]
fn a_tube_with_two_tilted_rims_encloses_the_prism_between_them() {
    let (mesh, volume) = tilted();
    let held = vec![Support::clamped("low"), Support::clamped("high")];
    for supports in [Vec::new(), held, vec![roller("low", 2)]] {
        let body = body(mesh.clone(), &["inner"], supports);
        assert_eq!(body.cavities[0].parts[0].lids.len(), 2);
        assert_volume(&body, volume);
        // A stretch along the axes scales it.
        let stretched = body.positions.iter().flat_map(|x| [0.2 * x[0], -0.1 * x[1], 0.4 * x[2]]);
        let ratio = body.cavity_volumes(&stretched.collect::<Vec<_>>())[0] / volume;
        assert!((ratio / (1.2 * 0.9 * 1.4) - 1.0).abs() < CLOSED, "{ratio}");
    }
}

#[test]
fn a_rigid_motion_changes_no_volume() {
    let ellipsoid = TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra();
    let tube = body(tilted().0, &["inner"], Vec::new());
    for body in [tube, body(ellipsoid, &["endo"], vec![Support::clamped("base")])] {
        let uneven: Vec<f64> = (0..3 * body.nodes).map(|i| 0.1 * ((i + 1) as f64).sin()).collect();
        let (c, s, d, e) = (0.8, 0.6, 5.0 / 13.0, 12.0 / 13.0);
        let turned = |[x, y, z]: [f64; 3]| {
            let [x, y] = [c * x - s * y, s * x + c * y];
            [x + 30.0, d * y - e * z - 8.0, e * y + d * z + 0.3]
        };
        let moved = body.positions.iter().zip(uneven.as_chunks::<3>().0).flat_map(|(x, u)| {
            let place = turned(std::array::from_fn(|i| x[i] + u[i]));
            [0, 1, 2].map(|i| place[i] - x[i])
        });
        let moved: Vec<f64> = moved.collect();
        let ratio = body.cavity_volumes(&moved)[0] / body.cavity_volumes(&uneven)[0];
        assert!((ratio - 1.0).abs() < RIGID, "{ratio}");
    }
}

#[test]
fn an_octant_is_closed_by_its_symmetry_planes() {
    // The corner of an octahedron, and the wall to one twice as large.
    let corners = [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]];
    let mut mesh = TetMesh {
        points: corners.into_iter().chain(corners.map(|x| x.map(|x| 2.0 * x))).collect(),
        cells: vec![[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]],
        ..TetMesh::default()
    };
    let inner = boundary_facets(&mesh).into_iter();
    let inner =
        inner.filter(|&facet| mesh.facet_nodes(facet).iter().all(|&node| node < 3)).collect();
    mesh.facet_sets.insert("inner".into(), inner);
    for (name, axis) in [("x", 0), ("y", 1), ("z", 2)] {
        let nodes = (0..6).filter(|&node| mesh.points[node][axis] == 0.0).collect();
        mesh.node_sets.insert(name.into(), nodes);
    }
    let planes = || vec![roller("x", 0), roller("y", 1), roller("z", 2)];
    assert_volume(&body(mesh.clone(), &["inner"], planes()), 5.0);
    // Away from the origin too.
    mesh.points.iter_mut().for_each(|x| *x = [x[0] + 7.0, x[1] - 90.0, x[2] + 0.1]);
    assert_volume(&body(mesh, &["inner"], planes()), 5.0);
}

#[test]
fn sectors_of_a_tube_are_closed_by_their_symmetry_planes() {
    let sector = |angle: f64, ends| {
        let corners = polygon(6, 0.0, angle, round);
        (tube(&corners, false, ends), moments(&corners, false))
    };
    // Half a tube with ends tilted within the plane.
    let (half, [area, x, _]) = sector(PI, [|[x, _]| 0.3 * x, |[x, _]| 4.0 + 0.1 * x]);
    let half = body(half, &["inner"], vec![roller("first", 1), roller("last", 1)]);
    assert_volume(&half, 4.0 * area - 0.2 * x);
    assert_eq!(half.cavities[0].parts[0].lids.len(), 2);
    // A quarter, open, and between two walls.
    let (quarter, [area, ..]) = sector(0.5 * PI, FLAT);
    let planes = || vec![roller("first", 1), roller("last", 0)];
    assert_volume(&body(quarter.clone(), &["inner"], planes()), 5.0 * area);
    let walls = || [roller("low", 2), roller("high", 2)];
    assert_volume(
        &body(quarter.clone(), &["inner"], planes().into_iter().chain(walls()).collect()),
        5.0 * area,
    );
    let all = Support { nodes: "all".into(), ..roller("low", 2) };
    let mut flat = quarter;
    flat.node_sets.insert("all".into(), (0..flat.points.len()).collect());
    assert_volume(&body(flat, &["inner"], planes().into_iter().chain([all]).collect()), 5.0 * area);
    // A sixth, whose planes are not along the axes.
    let (sixth, [area, ..]) = sector(PI / 3.0, FLAT);
    let across = [-(PI / 3.0).sin(), (PI / 3.0).cos(), 0.0];
    let planes = vec![roller("first", 1), roller_along("last", across)];
    assert_volume(&body(sixth, &["inner"], planes), 5.0 * area);
}

#[test]
fn a_face_between_walls_has_a_lid() {
    let rollers = ["y_min", "y_max", "z_min", "z_max"]
        .map(|nodes| roller(nodes, usize::from(nodes.starts_with('z')) + 1));
    let block = || box_tetrahedra([3.0, 2.0, 1.0], [3, 2, 2]);
    for walls in [
        rollers.to_vec(),
        vec![roller("y_min", 1), roller("y_max", 1)],
        vec![roller("z_min", 2), roller("y_max", 1)],
    ] {
        let body = body(block(), &["x_max"], walls);
        assert!(at_rest(&body) < CLOSED, "{}", at_rest(&body));
    }
}

/// Pressed from all sides, so that its cavity is the body itself.
fn volume_inside<const N: usize>(mut mesh: Mesh<N>) -> Body
where
    AnyMesh: From<Mesh<N>>,
{
    mesh.facet_sets.insert("all".into(), boundary_facets(&mesh));
    body(mesh, &["all"], vec![])
}

#[test]
fn curved_facets_enclose_what_their_cells_fill() {
    // A top that rises as a parabola, along edges in the sides too: 3 · 2 · 1 and ∫ (0.3 x + 0.2 x y − 0.1 y²) over [0, 3] × [0, 2].
    let mut block = box_tetrahedra([3.0, 2.0, 1.0], [2, 2, 1]).quadratic();
    block.map_points(|[x, y, z]| [x, y, z * (1.0 + 0.3 * x + 0.2 * x * y - 0.1 * y * y)]);
    assert_volume(&volume_inside(block), 6.0 + 2.7 + 1.8 - 0.8);
    // Bilinear facets, whatever corner their cells begin with.
    let mut block = sinew_mesh::box_hexahedra([3.0, 2.0, 1.0], [3, 2, 2]);
    block.map_points(|[x, y, z]| {
        [x + 0.3 * (y + z).sin(), y + 0.2 * (2.0 * x).cos(), z + 0.2 * x * y]
    });
    let inside = (0..block.cells.len()).map(|cell| block.cell_volume(cell)).sum();
    assert_volume(&volume_inside(block.clone()), inside);
    // A third of a turn about the diagonal, and a quarter of one about an axis.
    for turned in [[0, 3, 7, 4, 1, 2, 6, 5], [1, 2, 3, 0, 5, 6, 7, 4]] {
        let other = block.cells.iter().map(|cell| turned.map(|k| cell[k])).collect();
        assert_volume(&volume_inside(HexMesh { cells: other, ..block.clone() }), inside);
    }
}

#[test]
fn planes_without_a_field_leave_no_volume() {
    let corners = polygon(6, 0.0, 0.5 * PI, round);
    let mut mesh = tube(&corners, false, FLAT);
    mesh.points.iter_mut().for_each(|x| x[0] += 0.3 * x[2]);
    let supports = vec![
        roller("first", 1),
        roller_along("last", [1.0, 0.0, -0.3]),
        roller("low", 2),
        roller("high", 2),
    ];
    assert!(body(mesh, &["inner"], supports).cavities.is_empty());
}

#[test]
fn gradients_of_volumes_are_their_derivatives() {
    let base = || vec![Support::clamped("base")];
    let heart = Biventricle { radius: 20.0, depth: 50.0, wall: 10.0, septum: 10.0 };
    let heart = body(heart.tetrahedra(5.5), &["endo_left", "endo_right"], base());
    assert_eq!(heart.cavities.len(), 2);
    assert_slopes(&heart);
    let wall = TruncatedEllipsoid::LAND.wall([1, 16, 8]);
    assert_slopes(&body(wall.hexahedra(), &["endo"], base()));
    assert_slopes(&body(wall.quadratic_tetrahedra(), &["endo"], base()));
}

#[test]
fn a_volume_that_passes_through_zero_changes_its_sign() {
    // The lower side of a block, flat at rest, and moved to a pyramid either way.
    let body = body(box_tetrahedra([2.0, 2.0, 1.0], [2, 2, 1]), &["z_min"], vec![]);
    let middle = body.positions.iter().position(|x| *x == [1.0, 1.0, 0.0]).unwrap();
    let moved = |by: f64| {
        let mut u = vec![0.0; 3 * body.nodes];
        u[3 * middle + 2] = by;
        u
    };
    for by in [-0.3, 0.0, 0.3] {
        // A pressure pushes the side up, into the block. The base of the pyramid is an octagon with its corners at the nodes.
        let volume = body.cavity_volumes(&moved(by))[0];
        assert!((volume - by * volume_of_unit(&body, &moved(1.0))).abs() < 1e-12, "{by} {volume}");
        let slope = body.cavity_volume_gradients(&moved(by))[0][3 * middle + 2];
        assert!((slope - volume_of_unit(&body, &moved(1.0))).abs() < 1e-12, "{by} {slope}");
    }
}

fn volume_of_unit(body: &Body, raised: &[f64]) -> f64 {
    let volume = body.cavity_volumes(raised)[0];
    assert!(volume > 0.0);
    volume
}

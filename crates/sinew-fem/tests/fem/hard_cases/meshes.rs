//! Meshes that are damaged, degenerate or oddly made.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Scene, SceneError, Support};
use sinew_fem::{SolveError, Solver};
use sinew_mesh::{
    Facet, MeshError, TetMesh, box_tetrahedra, parse_mesh, quality, remove_unused_nodes,
    repair_orientation, to_vtu,
};

/// Lowers a neo-Hookean body that is clamped at `x_min`.
#[track_caller]
fn refused(mesh: TetMesh) -> SceneError {
    let error = scene(NeoHookean, mesh).lower().unwrap_err();
    println!("{error}");
    error
}

#[test]
fn a_mesh_without_cells_is_refused() {
    assert_eq!(
        refused(TetMesh::default()),
        SceneError::Body("the mesh has no cells; read or generate one that has".into())
    );
}

#[test]
fn one_tetrahedron_follows_its_closed_form() {
    let supports =
        vec![Support::clamped("base"), Support::uniform("tip", [Some(0.5), Some(0.0), None])];
    let body = lower(NeoHookean, one_tetrahedron(), vec![], supports);
    let solution = solve(&body, &[1.0, 1.0]).unwrap();
    assert_eq!(solution.displacement[3], 0.5);
    assert_sound(&body, &solution);

    // No unknown at all: the solution is what is prescribed.
    let supports =
        vec![Support::clamped("base"), Support::uniform("tip", [Some(0.5), Some(0.0), Some(0.0)])];
    let held = lower(NeoHookean, one_tetrahedron(), vec![], supports);
    let solution = solve(&held, &[1.0, 1.0]).unwrap();
    assert_eq!(solution.displacement[3..6], [0.5, 0.0, 0.0]);
    // ψ = ½(ln 1.5)² − ln 1.5 + ½(1.5² − 1), volume 1/6.
    let log = 1.5_f64.ln();
    let density = 0.5 * log * log - log + 0.5 * (1.5 * 1.5 - 1.0);
    assert!((solution.energy - density / 6.0).abs() < 1e-15);
}

#[test]
fn an_inverted_tetrahedron_is_refused_and_solved_after_repair() {
    let good = box_tetrahedra([2.0, 1.0, 1.0], [4, 2, 2]);
    let loads = vec![traction("x_max", [0.1, 0.2, 0.3])];
    let mut bad = good.clone();
    bad.cells[17].swap(1, 2);
    let swapped = |facet: &mut Facet| {
        if facet.cell == 17 {
            facet.opposite = [0, 2, 1, 3][facet.opposite];
        }
    };
    bad.facet_sets.values_mut().flatten().for_each(swapped);
    let text = refused(bad.clone()).to_string();
    let volume = text.strip_prefix("cell 17 has the volume ").and_then(|s| s.split_once(','));
    assert_close(volume.expect("a volume").0.parse().unwrap(), -1.0 / 48.0, 1e-12);
    assert_eq!(repair_orientation(&mut bad), 1);
    let solved = [good, bad].map(|mesh| {
        let beam = Scene { loads: loads.clone(), ..scene(NeoHookean, mesh) }.lower().unwrap();
        solve(&beam, &[1.0, 1.0]).unwrap().displacement
    });
    assert!(difference(&solved[0], &solved[1]) < 1e-12);
}

#[test]
fn a_flat_tetrahedron_with_its_zero_area_side_is_refused() {
    // Three corners on a line: the side through them has no area.
    let mut mesh = one_tetrahedron();
    mesh.points[2] = [0.5, 0.0, 0.0];
    mesh.node_sets.insert("x_min".into(), vec![0, 3]);
    assert_eq!(
        refused(mesh),
        SceneError::Body(
            "cell 0 has the volume 0.0, which must be positive; turn inverted cells over, and mesh a body with flat ones anew"
                .into()
        )
    );
}

#[test]
fn coordinates_whose_volume_overflows_or_underflows_are_refused() {
    for scale in [1e150, 1e-150] {
        let mut mesh = cube(1);
        mesh.points.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
        assert!(refused(mesh).to_string().starts_with("cell 0 has the volume "));
    }
}

#[test]
fn coordinates_that_are_no_numbers_are_refused_with_their_node() {
    for x in [f64::NAN, f64::INFINITY] {
        let mut mesh = cube(1);
        mesh.points[5][2] = x;
        let expected = format!("node 5 lies at (1, 0, {x}); give it finite coordinates");
        assert_eq!(refused(mesh).to_string(), expected);
    }
}

#[test]
fn a_cell_that_names_a_missing_node_or_one_twice_is_refused() {
    let mut mesh = cube(1);
    mesh.cells[3][1] = 8;
    let expected = "cell 3 names node 8, but nodes run from 0 to 7 (nodes: 8); renumber its nodes";
    assert_eq!(refused(mesh).to_string(), expected);
    let mut mesh = cube(1);
    mesh.cells[3][1] = mesh.cells[3][0];
    let node = mesh.cells[3][0];
    let expected = format!("cell 3 names node {node} twice; ");
    assert!(refused(mesh).to_string().starts_with(&expected));
}

#[test]
fn a_tetrahedron_listed_twice_is_refused_with_both_cells() {
    // It would count twice, silently.
    let mut mesh = cube(1);
    let [a, b, c, d] = mesh.cells[2];
    mesh.cells.push([b, c, a, d]);
    let text = refused(mesh).to_string();
    let facet = text.strip_prefix("cells 2 and 6 lie on the same side of the facet with nodes ");
    let (facet, advice) = facet.and_then(|rest| rest.split_once("; ")).expect("a facet");
    assert!(facet.split(", ").all(|node| [a, b, c, d].contains(&node.parse().unwrap())));
    assert_eq!(advice, "they are one cell listed twice: remove one");
}

#[test]
fn a_cell_folded_over_its_neighbour_is_refused() {
    // Two positive tetrahedra on the same side of the facet they share.
    let mut mesh = one_tetrahedron();
    mesh.points.push([0.2, 0.1, 0.5]);
    mesh.cells.push([0, 1, 2, 4]);
    mesh.node_sets.insert("x_min".into(), vec![0, 2, 3]);
    let expected = SceneError::Body(
        "cells 0 and 1 lie on the same side of the facet with nodes 0, 1, 2; one is folded over the other, the mesh is tangled there: move their nodes apart, or mesh the body anew"
            .into(),
    );
    assert_eq!(refused(mesh), expected);
}

/// Two grids side by side along x, each with its own nodes at x = 1; `glued` of them are shared.
fn two_blocks(glued: impl Fn([f64; 3]) -> bool) -> TetMesh {
    let mut mesh = box_tetrahedra([1.0; 3], [2; 3]);
    let right = box_tetrahedra([1.0; 3], [2; 3]);
    let mut index = Vec::new();
    for &[x, y, z] in &right.points {
        let place = [x + 1.0, y, z];
        let same = mesh.points.iter().position(|&p| p == place && glued(place));
        index.push(same.unwrap_or_else(|| {
            mesh.points.push(place);
            mesh.points.len() - 1
        }));
    }
    let offset = mesh.cells.len();
    mesh.cells.extend(right.cells.iter().map(|cell| cell.map(|node| index[node])));
    let end = right.facet_sets["x_max"].iter();
    let end = end.map(|f| Facet { cell: f.cell + offset, ..*f }).collect();
    mesh.facet_sets.insert("x_max".into(), end);
    mesh
}

#[test]
fn duplicate_nodes_that_cut_a_body_in_two_are_reported_as_a_free_part() {
    let loads = vec![traction("x_max", [0.1, 0.0, 0.0])];
    let scene = Scene { loads, ..scene(NeoHookean, two_blocks(|_| false)) };
    match refusal(&scene.lower().unwrap()) {
        SolveError::FreeToMove { node: 27, nodes: 27, modes } => assert_eq!(modes.len(), 6),
        other => panic!("{other}"),
    }
}

#[test]
fn duplicate_nodes_along_part_of_a_plane_act_as_a_slit() {
    // The same mesh glued everywhere, and with a slit over its upper half.
    let energies = [1.0, 0.5].map(|height| {
        let loads = vec![traction("x_max", [0.2, 0.0, 0.0])];
        let body = Scene { loads, ..scene(NeoHookean, two_blocks(|p| p[2] <= height)) };
        let body = body.lower().unwrap();
        let solution = solve(&body, &[1.0, 1.0]).unwrap();
        assert_sound(&body, &solution);
        solution.energy
    });
    // A slit is one constraint less: the potential of a dead load falls, and visibly.
    assert!(energies[1] < 1.05 * energies[0], "{energies:?}");
}

#[test]
fn a_hanging_node_that_holds_a_part_alone_leaves_it_free_to_turn() {
    // A tetrahedron whose corner lies on a side of the clamped one, at no node of it: it hangs on nothing.
    let mut mesh = one_tetrahedron();
    let first = mesh.points.len();
    mesh.points.extend([[0.25, 0.25, 0.0], [0.5, 0.25, -1.0], [0.25, 0.5, -1.0], [0.0, 0.0, -1.0]]);
    mesh.cells.push([first, first + 2, first + 1, first + 3]);
    repair_orientation(&mut mesh);
    let held = |mesh: &TetMesh| {
        let supports = vec![Support::clamped("base")];
        Scene { supports, ..scene(NeoHookean, mesh.clone()) }.lower().unwrap()
    };
    match refusal(&held(&mesh)) {
        SolveError::FreeToMove { node: 4, nodes: 4, modes } => assert_eq!(modes.len(), 6),
        other => panic!("{other}"),
    }
    // At a node it hangs like a ball joint: three turns are left.
    mesh.cells[1] = mesh.cells[1].map(|node| if node == first { 1 } else { node });
    repair_orientation(&mut mesh);
    assert_eq!(remove_unused_nodes(&mut mesh), 1);
    match Solver::new(&held(&mesh)).map(|_| ()) {
        Err(SolveError::FreeToMove { modes, .. }) => {
            assert_eq!(modes.len(), 3);
            assert!(modes.iter().all(|m| norm(&m.rotation) > 0.1));
        }
        other => panic!("expected a ball joint, got {other:?}"),
    }
}

#[test]
fn a_disconnected_part_is_named() {
    let mut mesh = box_tetrahedra([10.0; 3], [1; 3]);
    let part = cube(1);
    let first = mesh.points.len();
    mesh.points.extend(part.points.iter().map(|p| p.map(|x| x + 20.0)));
    mesh.cells.extend(part.cells.iter().map(|cell| cell.map(|node| node + first)));
    let body = lower(NeoHookean, mesh, vec![], vec![Support::clamped("x_min")]);
    match refusal(&body) {
        SolveError::FreeToMove { node: 8, nodes: 8, modes } => assert_eq!(modes.len(), 6),
        other => panic!("{other}"),
    }
}

#[test]
fn an_isolated_node_is_named_and_one_that_is_held_does_no_harm() {
    let mut mesh = cube(2);
    mesh.points.push([5.0; 3]);
    assert_eq!(refused(mesh.clone()), SceneError::Supports("1 nodes belong to no cell (first: node 27) and are not held; remove them from the mesh".into()));

    mesh.node_sets.get_mut("x_min").unwrap().push(27);
    let with = |mesh| {
        let loads = vec![traction("x_max", [0.3, 0.1, 0.0])];
        let body = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap();
        solve(&body, &[1.0, 1.0]).unwrap()
    };
    let (odd, plain) = (with(mesh), with(cube(2)));
    assert_eq!(odd.displacement[81..], [0.0; 3]);
    assert!(difference(&odd.displacement[..81], &plain.displacement) < 1e-12);
}

#[test]
fn nodes_and_cells_in_reverse_order_give_the_same_displacements() {
    let plain = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
    let (nodes, cells) = (plain.points.len(), plain.cells.len());
    let mut reversed = plain.clone();
    reversed.points.reverse();
    reversed.cells.reverse();
    reversed.cells.as_flattened_mut().iter_mut().for_each(|n| *n = nodes - 1 - *n);
    reversed.node_sets.values_mut().flatten().for_each(|n| *n = nodes - 1 - *n);
    let mirrored = |facet: &mut Facet| facet.cell = cells - 1 - facet.cell;
    reversed.facet_sets.values_mut().flatten().for_each(mirrored);
    let solved = [plain, reversed].map(|mesh| {
        let loads = vec![Load::BodyForce([0.0, 0.0, -0.02])];
        let beam = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap();
        solve(&beam, &[1.0, 2.0]).unwrap().displacement
    });
    let back: Vec<_> = solved[1].as_chunks::<3>().0.iter().rev().flatten().copied().collect();
    assert!(difference(&back, &solved[0]) < 1e-11);
}

#[test]
fn a_body_a_million_lengths_from_the_origin_deforms_as_at_home() {
    let solved = [0.0, 1e6].map(|offset| {
        let mut mesh = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
        mesh.points.as_flattened_mut().iter_mut().for_each(|x| *x += offset);
        let supports = vec![Support::clamped("x_min")];
        let mut loads = vec![Load::BodyForce([0.0, 0.0, -0.02])];
        // A closed surface, so that the pressure has a potential.
        let sides = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];
        let skin = sides.iter().flat_map(|side| mesh.facet_sets[*side].clone()).collect();
        mesh.facet_sets.insert("skin".into(), skin);
        loads.push(Load::Pressure { facets: "skin".into(), magnitude: Magnitude::Fixed(0.1) });
        let beam = lower(NeoHookean, mesh, loads, supports);
        let solution = solve(&beam, &[1.0, 2.0]).unwrap();
        assert!(solution.is_stable());
        solution
    });
    // The coordinates themselves are rounded to 1e-10 of a length.
    assert!(difference(&solved[1].displacement, &solved[0].displacement) < 1e-8);
    assert!(solved[1].iterations() <= solved[0].iterations() + 1);
}

/// A cube with one layer of cells squeezed to this part of its thickness, pulled obliquely.
fn squeezed_layer(thickness: f64) -> (TetMesh, Scene) {
    let mut mesh = box_tetrahedra([10.0; 3], [4; 3]);
    for point in &mut mesh.points {
        if point[0] == 5.0 {
            point[0] = 7.5 - 2.5 * thickness;
        }
    }
    let loads = vec![traction("x_max", [3.0, 0.0, 2.0])];
    (mesh.clone(), Scene { loads, ..scene(NeoHookean, mesh) })
}

#[test]
fn a_layer_of_slivers_a_thousandth_thick_is_solved() {
    let (_, scene) = squeezed_layer(1e-3);
    let block = scene.lower().unwrap();
    let solution = solve(&block, &[10.0, 20.0]).unwrap();
    assert_sound(&block, &solution);
}

#[test]
fn slivers_of_quality_1e_minus_8_are_solved_as_if_they_were_not_there() {
    let (mesh, scene) = squeezed_layer(1e-8);
    assert!(quality(&mesh).unwrap().ratio.min < 1e-4);
    let block = scene.lower().unwrap();
    let solution = solve(&block, &[10.0, 20.0]).unwrap();
    assert_sound(&block, &solution);
    // In the limit the layer is a surface: a layer a hundred times as thick gives the same.
    let thicker = squeezed_layer(1e-6).1.lower().unwrap();
    let twin = solve(&thicker, &[10.0, 20.0]).unwrap();
    assert!(difference(&solution.displacement, &twin.displacement) < 1e-5);
}

#[test]
fn one_needle_and_one_cap_in_a_body_do_no_harm() {
    // A node is moved to within 1e-8 of an opposite side: flat cells, of volume ratio 1e-8, beside good ones.
    let mut mesh = cube(2);
    let centre = mesh.points.iter().position(|&p| p == [0.5; 3]).unwrap();
    let least = |mesh: &TetMesh| quality(mesh).unwrap().ratio.min;
    mesh.points[centre] = [0.5, 0.5, 1e-8];
    let (slivers, good) = (least(&mesh), least(&cube(2)));
    assert!(slivers > 0.0 && slivers < 1e-7 && good > 0.1, "{slivers:e} {good:e}");
    let loads = vec![traction("x_max", [0.3, 0.1, 0.0])];
    let body = Scene { loads, ..scene(NeoHookean, mesh) }.lower().unwrap();
    let solution = solve(&body, &[1.0, 1.0]).unwrap();
    assert_sound(&body, &solution);
}

fn vtk(points: &str, cells: &str, types: &str) -> String {
    let count = cells.lines().count();
    let size = cells.split_whitespace().count();
    format!(
        "# vtk DataFile Version 2.0\nhard\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n{points}\n\
         CELLS {count} {size}\n{cells}\nCELL_TYPES {count}\n{types}\n"
    )
}

#[track_caller]
fn problem(bytes: &[u8]) -> String {
    match parse_mesh::<4>("hard.vtk", bytes) {
        Err(MeshError::Content { file, problem, place }) => {
            println!("{file}, {place}: {problem}");
            problem.to_string()
        }
        other => panic!("expected a problem, got {other:?}"),
    }
}

#[test]
fn a_file_with_a_coordinate_that_is_no_number_is_refused() {
    let text = vtk("0 0 0  1 0 0  0 nan 0  0 0 1", "4 0 1 2 3", "10");
    let found = problem(text.as_bytes());
    assert_eq!(found, "node 2 lies at (0, NaN, 0); give it finite coordinates");
}

#[test]
fn a_file_of_hexahedra_is_refused_with_advice() {
    let text = vtk("0 0 0  1 0 0  0 1 0  0 0 1", "8 0 1 2 3 0 1 2 3", "12");
    let found = problem(text.as_bytes());
    assert!(found.starts_with("cell 0 is a ") && found.contains("split such cells"), "{found}");
}

#[test]
fn a_file_with_an_inverted_cell_is_repaired_and_solved() {
    let text = vtk("0 0 0  1 0 0  0 1 0  0 0 1", "4 0 2 1 3", "10");
    let (mut mesh, report) = parse_mesh::<4>("hard.vtk", text.as_bytes()).unwrap();
    assert_eq!(report.repaired_cells, 1);
    mesh.node_sets.insert("x_min".into(), vec![0, 2, 3]);
    let body = Scene { loads: vec![Load::BodyForce([0.3, 0.0, 0.0])], ..scene(NeoHookean, mesh) };
    let body = body.lower().unwrap();
    assert_sound(&body, &solve(&body, &[1.0, 1.0]).unwrap());
}

#[test]
fn a_file_cut_off_anywhere_is_refused_or_complete() {
    let bytes = to_vtu(&cube(1)).unwrap();
    for end in (0..bytes.len()).step_by(7) {
        let _typed: Result<_, MeshError> = parse_mesh::<4>("cut.vtu", &bytes[..end]);
    }
    assert!(matches!(
        parse_mesh::<4>("cut.vtu", &bytes[..bytes.len() / 2]),
        Err(MeshError::Content { .. })
    ));
}

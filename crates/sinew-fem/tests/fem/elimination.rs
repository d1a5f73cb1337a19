//! Orders of elimination: that of the rows of a stiffness is by the graph of the nodes.

use crate::support::parameters;
use faer::Side;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{SymmetricOrdering, factorize_symbolic_cholesky};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Scene, Support};
use sinew_fem::{History, Solution, Solver};
use sinew_mesh::{AnyMesh, HexMesh, TetMesh, TruncatedEllipsoid, box_hexahedra};
use std::collections::BTreeSet;

/// Graphs of more vertices are cut in two, those of fewer are ordered by minimum degree.
const MOST_BY_DEGREE: usize = 1_500;

/// Neighbours of each free node, ascending.
type Graph = Vec<Vec<usize>>;

fn scene(mesh: impl Into<AnyMesh>) -> Scene {
    Scene { parameters: parameters(&["mu", "lambda"]), ..Scene::new(mesh, NeoHookean) }
}

/// A body on springs, so that all its nodes are free.
fn sprung(mesh: impl Into<AnyMesh>, facets: &str) -> Scene {
    scene(mesh).load(Load::Foundation { facets: facets.into(), normal: 1.0, tangential: 1.0 })
}

/// A grid of so many nodes, each of which is joined to those next to it, diagonally too.
fn grid(nodes: [usize; 3]) -> HexMesh {
    let cells = nodes.map(|n| n - 1);
    box_hexahedra(cells.map(|n| n as f64), cells)
}

fn at_rest(body: &Body) -> Solution {
    Solution {
        displacement: vec![0.0; 3 * body.nodes],
        pressure: Vec::new(),
        energy: 0.0,
        has_potential: true,
        theta: vec![1.0; body.theta_len()],
        load_factor: 1.0,
        residual: 0.0,
        iteration_error: None,
        volume_residual: 0.0,
        force_scale: 0.0,
        least_volume_ratio: 1.0,
        negative_pivots: 0,
        counted: true,
        load_steps: 0,
        jumped: false,
        linear_iterations: 0,
        history: History::default(),
        seconds: 0.0,
    }
}

/// The free nodes of a body, ascending.
fn free(body: &Body) -> Vec<usize> {
    (0..body.nodes).filter(|n| body.prescribed[3 * n..3 * n + 3].contains(&None)).collect()
}

/// Free nodes in the order of their elimination, by their places among all of them.
fn ordered(body: &Body) -> Vec<usize> {
    let stiffness = Solver::new(body).unwrap().stiffness(&at_rest(body)).unwrap();
    let mut nodes: Vec<_> = stiffness.degree_of_freedom.iter().map(|dof| dof / 3).collect();
    nodes.dedup();
    let free = free(body);
    let order: Vec<_> = nodes.iter().map(|node| free.binary_search(node).unwrap()).collect();
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..free.len()), "each node comes once");
    order
}

fn graph(body: &Body) -> Graph {
    let free = free(body);
    let mut neighbours = vec![BTreeSet::new(); free.len()];
    for cell in body.cell_nodes() {
        let places: Vec<_> = cell.iter().filter_map(|node| free.binary_search(node).ok()).collect();
        for &a in &places {
            neighbours[a].extend(places.iter().filter(|&&b| b != a));
        }
    }
    neighbours.into_iter().map(|near| near.into_iter().collect()).collect()
}

/// The upper half of a matrix with this graph, in some order of its vertices.
fn upper_half(graph: &Graph, order: &[usize], with_diagonal: bool) -> SymbolicSparseColMat<usize> {
    let mut place = vec![0; graph.len()];
    order.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = at);
    let (mut starts, mut rows) = (vec![0], Vec::new());
    for (column, &vertex) in order.iter().enumerate() {
        let above = graph[vertex].iter().map(|&n| place[n]).filter(|&row| row < column);
        let first = rows.len();
        rows.extend(above);
        rows[first..].sort_unstable();
        rows.extend(with_diagonal.then_some(column));
        starts.push(rows.len());
    }
    SymbolicSparseColMat::new_checked(graph.len(), graph.len(), starts, None, rows)
}

/// Entries of the factor of a matrix with this graph.
fn entries(graph: &Graph, order: &[usize]) -> usize {
    let upper = upper_half(graph, order, true);
    let order = SymmetricOrdering::Identity;
    factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, order, Default::default())
        .unwrap()
        .len_val()
}

fn by_minimum_degree(graph: &Graph) -> Vec<usize> {
    let all: Vec<_> = (0..graph.len()).collect();
    let upper = upper_half(graph, &all, false);
    let (mut order, mut inverse) = (vec![0; graph.len()], vec![0; graph.len()]);
    let scratch = amd::order_scratch::<usize>(graph.len(), upper.row_idx().len());
    let mut memory = MemBuffer::new(scratch);
    let (control, memory) = (amd::Control::default(), MemStack::new(&mut memory));
    amd::order(&mut order, &mut inverse, upper.as_ref(), control, memory).unwrap();
    order
}

#[test]
fn a_large_grid_fills_less_than_by_minimum_degree() {
    let body = sprung(grid([18, 18, 18]), "z_min").lower().unwrap();
    let graph = graph(&body);
    let ours = entries(&graph, &ordered(&body));
    let amd = entries(&graph, &by_minimum_degree(&graph));
    assert!(10 * ours < 9 * amd, "{ours} entries against {amd}");
}

#[test]
fn an_order_does_not_depend_on_the_number_of_threads() {
    let body = sprung(grid([40, 12, 12]), "z_min").lower().unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ordered(&body))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_bar_is_cut_across_in_the_middle() {
    let body = sprung(grid([60, 8, 8]), "x_min").lower().unwrap();
    let order = ordered(&body);
    // The nodes between both halves come last.
    let places: BTreeSet<_> =
        order[order.len() - 64..].iter().map(|&node| body.positions[node][0] as usize).collect();
    let [place] = places.into_iter().collect::<Vec<_>>()[..] else { panic!("no plane") };
    assert!((24..36).contains(&place), "{place}");
}

/// Tetrahedra without a common side of which the second node is free, and the first where all share it.
fn loose(count: usize, centre: bool) -> TetMesh {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (mut mesh, mut held) = (TetMesh::default(), Vec::new());
    for cell in 0..count {
        // Every other one is turned by half about x: held nodes on one line would leave a rotation about it.
        let turned = if centre && cell % 2 == 1 { -1.0 } else { 1.0 };
        let corners = corners.map(|[x, y, z]| [x, turned * y, turned * z]);
        let shared = centre && !mesh.points.is_empty();
        let next = mesh.points.len();
        let [first, second] = if shared { [0, next] } else { [next, next + 1] };
        mesh.points.extend(&corners[usize::from(shared)..]);
        mesh.cells.push([first, second, second + 1, second + 2]);
        held.extend((!centre).then_some(first));
        held.extend([second + 1, second + 2]);
    }
    mesh.node_sets.insert("held".into(), held);
    mesh
}

#[test]
fn strange_graphs_have_orders_too() {
    const SIZE: usize = MOST_BY_DEGREE + 10;
    let held = |mesh: TetMesh| scene(mesh).support(Support::clamped("held")).lower().unwrap();
    // No node beside another one.
    assert_eq!(ordered(&held(loose(SIZE, false))).len(), SIZE);
    let star = held(loose(SIZE - 1, true));
    let fill = entries(&graph(&star), &ordered(&star));
    assert!(fill < 4 * SIZE, "the centre comes late");
    // Two blocks apart.
    let mut blocks = grid([15, 15, 8]);
    let (nodes, cells) = (blocks.points.len(), blocks.cells.len());
    blocks.points.extend_from_within(..);
    blocks.points[nodes..].iter_mut().for_each(|x| x[0] += 100.0);
    blocks.cells.extend_from_within(..);
    blocks.cells[cells..].as_flattened_mut().iter_mut().for_each(|node| *node += nodes);
    let bottom = blocks.facet_sets.get_mut("z_min").unwrap();
    let sides = bottom.len();
    bottom.extend_from_within(..);
    bottom[sides..].iter_mut().for_each(|facet| facet.cell += cells);
    ordered(&sprung(blocks, "z_min").lower().unwrap());
    // A lid joins all nodes of its rim.
    let wall = TruncatedEllipsoid::LAND.wall([1, 64, 18]).tetrahedra();
    assert!(wall.points.len() > MOST_BY_DEGREE);
    let pressure = Load::CavityPressure { facets: "endo".into(), magnitude: Magnitude::Fixed(0.1) };
    let lidded = sprung(wall, "epi").load(pressure).lower().unwrap();
    assert_eq!(lidded.pressures[0].lids[0].nodes.len(), 64);
    ordered(&lidded);
}

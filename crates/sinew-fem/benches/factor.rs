//! Time, memory and error of the direct linear solver on beams of linear tetrahedra; `cholmod.py` beside it measures
//! CHOLMOD with METIS on the same matrices.
//!
//! `SIZES=1` leaves out the large ones. On a busy machine wall times mean little: with `RAYON_NUM_THREADS=1` compare the
//! seconds of processor time that are printed.

use criterion::{Criterion, criterion_group, criterion_main};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Sampling, Scene, Support, Units};
use sinew_fem::measured::{Cholesky, fill_reducing_order};
use sinew_fem::{History, LinearSolver, Solution, Solver, Stiffness};
use sinew_mesh::box_tetrahedra;
use std::hint::black_box;
use std::time::Duration;

/// Boxes along the beam of 1080, 30 240 and 98 280 unknowns.
const SIZES: [[usize; 3]; 3] = [[12, 4, 5], [40, 13, 17], [60, 20, 25]];
const THETA: [f64; 2] = [75.0, 75.0];

fn beam(cells: [usize; 3]) -> Body {
    let stiffness = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [50.0, 100.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "beam".into(),
        units: Units::mm_kpa(),
        mesh: box_tetrahedra([100.0, 10.0, 10.0], cells),
        law: NeoHookean,
        directions: vec![],
        parameters: vec![stiffness("mu"), stiffness("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])],
        supports: vec![Support::clamped("x_min")],
    };
    scene.lower().expect("the beam is well formed")
}

/// The unloaded state, where CHOLMOD's matrix is taken too.
fn rest(potential: &Body) -> Solution {
    Solution {
        displacement: vec![0.0; 3 * potential.nodes],
        energy: 0.0,
        theta: THETA.to_vec(),
        residual: 0.0,
        force_scale: 0.0,
        least_volume_ratio: 1.0,
        negative_pivots: 0,
        load_steps: 0,
        history: History::default(),
        seconds: 0.0,
    }
}

/// Starts and neighbours of the graph of free nodes.
fn node_graph(stiffness: &Stiffness, nodes: usize) -> (Vec<usize>, Vec<usize>) {
    let node = |unknown: usize| stiffness.degree_of_freedom[unknown] / 3;
    let mut neighbours = vec![Vec::new(); nodes];
    for column in 0..stiffness.degree_of_freedom.len() {
        let entries = stiffness.column_starts[column]..stiffness.column_starts[column + 1];
        for &row in &stiffness.rows[entries] {
            if node(row) != node(column) {
                neighbours[node(row)].push(node(column));
                neighbours[node(column)].push(node(row));
            }
        }
    }
    let mut starts = vec![0];
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
        starts.push(starts[starts.len() - 1] + list.len());
    }
    (starts, neighbours.concat())
}

/// Residual of a solution relative to the right-hand side, in the largest norm.
fn residual(stiffness: &Stiffness, factor: &mut Cholesky) -> f64 {
    let size = stiffness.degree_of_freedom.len();
    let times = |x: &[f64]| {
        let mut y = vec![0.0; size];
        for column in 0..size {
            for at in stiffness.column_starts[column]..stiffness.column_starts[column + 1] {
                let (row, value) = (stiffness.rows[at], stiffness.values[at]);
                y[row] += value * x[column];
                if row != column {
                    y[column] += value * x[row];
                }
            }
        }
        y
    };
    let right = times(&(0..size).map(|i| (i % 11) as f64 - 4.5).collect::<Vec<_>>());
    let mut solution = right.clone();
    factor.solve(&mut solution);
    let largest = right.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let off = times(&solution);
    off.iter().zip(&right).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest
}

/// Processor time of this process so far \[s\]; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    // User and system time are fields 14 and 15, in hundredths; the name in field 2 may contain spaces.
    let status = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = status.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|text| text.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Least processor time of three runs.
fn least_seconds(mut action: impl FnMut()) -> f64 {
    let mut once = || {
        let start = processor_seconds();
        action();
        processor_seconds() - start
    };
    (0..3).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn factors(criterion: &mut Criterion) {
    let sizes = std::env::var("SIZES").ok().and_then(|text| text.parse().ok());
    for cells in SIZES.into_iter().take(sizes.unwrap_or(SIZES.len())) {
        let potential = beam(cells);
        let state = rest(&potential);
        let mut solver =
            Solver::with_linear_solver(&potential, LinearSolver::Direct).expect("the beam is held");
        let stiffness = solver.stiffness(&state).expect("the state fits the body");
        let Stiffness { column_starts, rows, values, .. } = &stiffness;
        let (starts, neighbours) = node_graph(&stiffness, potential.nodes);
        let analysed = || Cholesky::new(column_starts, rows).expect("the factor fits in memory");
        let mut factor = analysed();
        assert!(factor.factorise(values), "a body at rest is stable");
        println!(
            "{} unknowns: residual {:.1e} of the right-hand side, factor {:.2} M entries, workspace {:.2} of that",
            factor.unknowns(),
            residual(&stiffness, &mut factor),
            factor.entries() as f64 / 1e6,
            factor.workspace_entries() as f64 / factor.entries() as f64,
        );
        let slope = vec![1.0; 3 * potential.nodes];
        let ones = vec![1.0; factor.unknowns()];
        let mut right = ones.clone();
        println!(
            "processor time: factorise {:.2} s, assemble, factorise and solve {:.2} s",
            least_seconds(|| assert!(factor.factorise(values))),
            least_seconds(|| assert!(solver.adjoint_sensitivity(&state, &slope).is_ok())),
        );
        let mut group = criterion.benchmark_group(format!("factor_{}", factor.unknowns()));
        group.sample_size(10).warm_up_time(Duration::from_millis(500));
        group.measurement_time(Duration::from_secs(2));
        group.bench_function("order", |b| {
            b.iter(|| fill_reducing_order(&starts, black_box(&neighbours)))
        });
        group.bench_function("analyse", |b| b.iter(analysed));
        group.bench_function("factorise", |b| b.iter(|| factor.factorise(black_box(values))));
        group.bench_function("solve", |b| {
            b.iter(|| {
                right.copy_from_slice(black_box(&ones));
                factor.solve(&mut right);
            })
        });
        drop(factor);
        // A Newton step but for its line search; the two derivatives in θ are extra.
        group.bench_function("assemble_factorise_solve", |b| {
            b.iter(|| solver.adjoint_sensitivity(black_box(&state), &slope))
        });
        group.finish();
    }
}

criterion_group!(benches, factors);
criterion_main!(benches);

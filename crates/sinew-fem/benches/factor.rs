//! Time, memory and error of faer's supernodal factors on beams of linear tetrahedra, in our order and in its own;
//! `cholmod.py` beside it measures CHOLMOD with METIS on the same matrices.
//!
//! `RAYON_NUM_THREADS=1 cargo bench --profile dev -p sinew-fem --bench factor -- 0 degree` (0, 1 or 2 for 1080, 30 240 or 98 280
//! unknowns; `dissection` or `degree`). Least times of three runs.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt::factor::LdltRegularization, llt::factor::LltRegularization};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Scene, Support};
use sinew_fem::{History, Solution, Solver, Stiffness};
use sinew_mesh::box_tetrahedra;
use std::time::Instant;

const SIZES: [[usize; 3]; 3] = [[12, 4, 5], [40, 13, 17], [60, 20, 25]];
const THETA: [f64; 2] = [75.0, 75.0];

fn beam(cells: [usize; 3]) -> Body {
    let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], cells), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"));
    scene.lower().expect("the beam is well formed")
}

/// The unloaded state, where CHOLMOD's matrix is taken too.
fn rest(potential: &Body) -> Solution {
    Solution {
        displacement: vec![0.0; 3 * potential.nodes],
        pressure: Vec::new(),
        has_potential: true,
        iteration_error: Some(0.0),
        volume_residual: 0.0,
        linear_iterations: 0,
        energy: 0.0,
        theta: THETA.to_vec(),
        load_factor: 1.0,
        residual: 0.0,
        force_scale: 0.0,
        least_volume_ratio: 1.0,
        negative_pivots: 0,
        counted: true,
        load_steps: 0,
        jumped: false,
        history: History::default(),
        seconds: 0.0,
    }
}

/// Residual of a solve relative to the right-hand side, in the largest norm.
fn residual(stiffness: &Stiffness, solve: impl FnOnce(&mut [f64])) -> f64 {
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
    solve(&mut solution);
    let largest = right.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let off = times(&solution);
    off.iter().zip(&right).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest
}

/// Least time of three runs \[ms\], with the result of the last.
fn least<T>(mut action: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let start = Instant::now();
        let result = action();
        (1e3 * start.elapsed().as_secs_f64(), result)
    };
    let (a, _) = once();
    let (b, _) = once();
    let (c, result) = once();
    (a.min(b).min(c), result)
}

fn factors(stiffness: &Stiffness, ordering: SymmetricOrdering<'_, usize>) {
    let size = stiffness.degree_of_freedom.len();
    let par = if rayon::current_num_threads() == 1 { Par::Seq } else { Par::rayon(0) };
    let (starts, rows) = (&stiffness.column_starts, &stiffness.rows);
    // A symmetric ordering reads the upper half: that is the lower one by rows.
    let lower = SymbolicSparseColMatRef::new_checked(size, size, starts, None, rows);
    let upper = lower.transpose().to_col_major().expect("the pattern fits in memory");
    let parameters = || CholeskySymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    let (analyse, symbolic) = least(|| {
        factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, ordering, parameters())
            .expect("the factor fits in memory")
    });
    let matrix = SparseColMatRef::new(lower, &stiffness.values);
    let mut entries = vec![0.0; symbolic.len_val()];
    let scratch = symbolic
        .factorize_numeric_llt_scratch::<f64>(par, Default::default())
        .or(symbolic.factorize_numeric_ldlt_scratch::<f64>(par, Default::default()))
        .or(symbolic.solve_in_place_scratch::<f64>(1, par));
    let mut memory = MemBuffer::new(scratch);
    let none = LdltRegularization::default();
    let (signed, _) = least(|| {
        symbolic
            .factorize_numeric_ldlt(
                &mut entries,
                matrix,
                Side::Lower,
                none,
                par,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map(|_: LdltRef<'_, usize, f64>| ())
            .expect("no pivot vanishes")
    });
    let (plain, ()) = least(|| {
        symbolic
            .factorize_numeric_llt(
                &mut entries,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                par,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map(|_| ())
            .expect("a body at rest is stable")
    });
    let factor = LltRef::<usize, f64>::new(&symbolic, &entries);
    let (solve, left) = least(|| {
        residual(stiffness, |right| {
            let right = MatMut::from_column_major_slice_mut(right, size, 1);
            factor.solve_in_place_with_conj(Conj::No, right, par, MemStack::new(&mut memory));
        })
    });
    let (stored, more) =
        (entries.len() as f64 / 1e6, scratch.unaligned_bytes_required() as f64 / 8e6);
    println!(
        "analysis {analyse:.2}, LLt {plain:.2}, LDLt {signed:.2}, solve {solve:.2} ms; {stored:.2} M entries, {more:.2} M more; residual {left:.1e}"
    );
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let size = arguments.first().and_then(|text| text.parse::<usize>().ok()).unwrap_or(0);
    let (which, order) = match arguments.get(1).map(String::as_str) {
        Some("degree") => ("minimum degree", SymmetricOrdering::Amd),
        _ => ("our order", SymmetricOrdering::Identity),
    };
    let potential = beam(SIZES[size]);
    let start = Instant::now();
    let mut solver = Solver::new(&potential).expect("the beam is held");
    let prepared = 1e3 * start.elapsed().as_secs_f64();
    let stiffness = solver.stiffness(&rest(&potential)).expect("the state fits the body");
    print!(
        "{} unknowns, {which}, {} threads: solver prepared in {prepared:.2} ms, ",
        solver.unknowns(),
        rayon::current_num_threads()
    );
    drop(solver);
    factors(&stiffness, order);
}

#[path = "support/mod.rs"]
mod support;
#[path = "hard_cases/bodies.rs"]
mod bodies;
use bodies::*;
use sinew_energy::laws::*;
use sinew_energy::*;
use sinew_fem::*;
use sinew_mesh::box_tetrahedra;

#[test]
fn ho() {
    let law = HolzapfelOgden { bulk_modulus: 25.0 };
    for (kind, s, b) in [(1, 3.3, 150.0), (1, 3.3, 160.0),(1, 3.3, 200.0), (2, 2.0, 160.0), (2, 2.0, 250.0)] {
            let supports = match kind {
                1 => vec![Support::clamped("x_min"), Support::uniform("x_max", [Some(s - 1.0), None, None])],
                _ => vec![Support::clamped("x_min"), Support::uniform("x_max", [Some(s - 1.0), Some(0.0), Some(0.0)])],
            };
            let bar = Scene { supports, ..with_directions(law, cube(2), [[1.0, 0.0, 0.0]]) }.lower().unwrap();
            match Solver::new(&bar).unwrap().solve(&[1.0, b, 1.0, b], &Options::default()) {
                Ok(x) => println!("{kind} {s} {b} res {:e} {:e} E {:e} neg {} it {}", x.residual, x.force_scale, x.energy, x.negative_pivots, x.history.iterations.len()),
                Err(e) => println!("{kind} {s} {b} {e}"),
            }
    }
}

#[test]
fn guccione() {
    let bulk: f64 = std::env::var("P").ok().and_then(|p| p.parse().ok()).unwrap_or(25.0);
    let law = Guccione { bulk_modulus: bulk };
    let mesh = box_tetrahedra([100.0, 10.0, 10.0], [10, 3, 3]);
    let mk = |p: f64| Scene { loads: vec![Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(p) }],
        ..with_directions(law, mesh.clone(), Guccione::frame([1.0, 0.0, 0.0])) }.lower_follower().unwrap();
    for p in [0.149, 0.15, 0.151] {
        let body = mk(p);
        match BalanceSolver::new(&body).unwrap().solve(&[2.5, 3.0, 2.0, 2.25], &Options::default()) {
            Ok(x) => { for i in &x.history.iterations { println!("   {:.4} {:.2e} J {:.3} step {:.3} shift {:.1e}", i.load_factor, i.residual, i.least_volume_ratio, i.step, i.shift) } println!("{p} res {:e} {:e} steps {} it {} uz {:?}", x.residual, x.force_scale, x.load_steps, x.history.iterations.len(), x.displacement.iter().fold(0.0f64, |m, u| m.max(u.abs()))) }
            Err(e) => println!("{p} {e}"),
        }
    }
    let body = mk(0.15);
    let (mut bogus, mut refused, mut total) = (0, 0, vec![]);
    let mut solver = BalanceSolver::new(&body).unwrap();
    let t = std::time::Instant::now();
    for i in 0..30 {
        let g = [0.8566748838545029, 0.733891856627126, 0.6287067210378087, 0.5385972572236101];
        let theta: Vec<f64> = g.iter().map(|g| 1.75 + 1.75 * ((0.5 + g * (i + 1) as f64) % 1.0)).collect();
        match solver.solve(&theta, &Options::default()) {
            Ok(x) => {
                total.push(x.history.iterations.len());
                let r = x.residual / x.force_scale;
                if !(r < 1e-6) { bogus += 1; println!("bogus {theta:?} {r:e} {:e}", x.force_scale); }
                if x.load_steps > 20 || total.last() > Some(&100) { println!("{theta:.3?} steps {} it {}", x.load_steps, x.history.iterations.len()); }
            }
            Err(SolveError::NotConverged(e)) => { refused += 1; println!("refused {theta:?} {} {} it {}", e.load_factor, e.advice, e.history.iterations.len()) }
            Err(e) => { refused += 1; println!("{e}") }
        }
    }
    total.sort();
    println!("bogus {bogus} refused {refused} it {:?} {:?}", total, t.elapsed());
}

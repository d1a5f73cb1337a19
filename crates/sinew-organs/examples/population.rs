//! scratch
use anyhow::Result;
use sinew_emulate::*;
use sinew_fem::{Options, Solver};
use sinew_organs::populations::stage::Stage;
use std::time::Instant;

fn relative(a: &[f64], b: &[f64]) -> f64 {
    let n = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    n(&mut a.iter().zip(b).map(|(a, b)| a - b)) / n(&mut b.iter().copied())
}
fn q(mut v: Vec<f64>) -> String {
    v.sort_by(f64::total_cmp);
    let at = |p: f64| v[((v.len() - 1) as f64 * p).round() as usize];
    format!("{:.3e} (90 % {:.3e}, max {:.3e})", at(0.5), at(0.9), at(1.0))
}

fn main() -> Result<()> {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let stage = Stage::new(&a[1], false)?;
    let n: u64 = a[2].parse()?;
    let mut test = Vec::new();
    let (mut draw_s, mut solve_s, mut its) = (0.0, 0.0, 0);
    for i in 0..n {
        let t = Instant::now();
        let x = stage.draw(77, i)?;
        draw_s += t.elapsed().as_secs_f64();
        let t = Instant::now();
        match Solver::new(&x.body)?.solve(&x.theta, &Options::default()) {
            Ok(s) => {
                its += s.history.iterations.len();
                test.push((x, s.displacement))
            }
            Err(e) => println!("{i}: {e}"),
        }
        solve_s += t.elapsed().as_secs_f64();
    }
    println!(
        "{} nodes, draw {:.1} ms, solve {:.1} ms, {:.1} its",
        test[0].0.body.nodes,
        1e3 * draw_s / n as f64,
        1e3 * solve_s / n as f64,
        its as f64 / n as f64
    );
    if a[0] == "prior" {
        for newton_steps in 0..5 {
            let p = Population { newton_steps, ..Population::default() };
            let em = p.prepare(&|i| stage.body_of_stream(5, i), 1)?;
            let t = Instant::now();
            let mut e = Vec::new();
            let mut c = Vec::new();
            for (x, u) in &test {
                match em.followed(&x.body, &[x.theta.clone()]) {
                    Ok(f) => {
                        e.push(relative(&f[0], u));
                        if let Ok(s) = Solver::new(&x.body)?.newton_step(&f[0], &x.theta) {
                            c.push(relative(&s.displacement, u));
                        }
                    }
                    Err(er) => println!("{er}"),
                }
            }
            println!(
                "{newton_steps} steps: {} after one {}  {:.1} ms",
                q(e),
                q(c),
                1e3 * t.elapsed().as_secs_f64() / n as f64
            );
        }
        return Ok(());
    }
    if a[0] == "rivals" {
        for count in a[3..].iter().map(|n| n.parse::<usize>()) {
            let r = sinew_organs::populations::rivals::Rivals::new(&stage, 23, count?)?;
            println!(
                "{}: simulations {:.1} CPU-s, with fit {:.1}",
                r.about, r.cpu_s[0], r.cpu_s[1]
            );
            for (name, which) in [("mean", 0), ("nearest", 1), ("POD + GP", 2)] {
                let (mut e, mut c) = (Vec::new(), Vec::new());
                for (x, u) in &test {
                    let f = match which {
                        0 => r.mean(),
                        1 => r.nearest(x),
                        _ => r.predict(x)?,
                    };
                    e.push(relative(&f, u));
                    let s = Solver::new(&x.body)?.newton_step(&f, &x.theta);
                    c.push(s.map_or(1.0, |s| relative(&s.displacement, u)));
                }
                println!("{name}: {}, after one step {}", q(e), q(c));
            }
        }
        return Ok(());
    }
    let f = |i: usize, d: f64| a.get(i).and_then(|s| s.parse().ok()).unwrap_or(d);
    let mut p = Population {
        newton_steps: f(3, 2.0) as usize,
        bodies: f(5, 2.0) as usize,
        ..Population::default()
    };
    p.training.budget = sinew_gnn::Budget::Steps(f(4, 1000.0) as usize);
    p.training.batch = f(6, 8.0) as usize;
    p.training.learning_rate = f(7, 8e-3);
    p.training.evaluations = 8;
    let cpu = || -> f64 {
        let s = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
        let w: Vec<&str> = s.rsplit(')').next().unwrap_or("").split_whitespace().collect();
        (w[11].parse::<f64>().unwrap_or(0.0) + w[12].parse::<f64>().unwrap_or(0.0)) / 100.0
    };
    let start = cpu();
    let coarse = stage.clone().with_cells([2, 16, 8]);
    let every = f(8, 1.0) as u64;
    p.train(
        &|i| if i % every == 0 { stage.body_of_stream(5, i) } else { coarse.body_of_stream(5, i) },
        1,
        &mut |g, e| {
            let spent = cpu() - start;
            let mut v = Vec::new();
            let mut c = Vec::new();
            let mut w = vec![Vec::new(); 3];
            for (x, u) in &test {
                let m = e.meet(&x.body)?;
                let f = m.predict(&[x.theta.clone()])?.displacement;
                v.push(relative(&f, u));
                if g.share >= 1.0 {
                    for k in 0..3 {
                        w[k].push(relative(&e.carried(&x.body, &[x.theta.clone()], k)?[0], u));
                    }
                    if let Ok(s) = Solver::new(&x.body)?.newton_step(&f, &x.theta) {
                        c.push(relative(&s.displacement, u));
                    }
                }
            }
            println!(
                "{:5} steps {:6.1} s, cpu {:6.1}: loss {:+.6} {}",
                g.step,
                g.seconds,
                spent,
                g.loss,
                q(v)
            );
            if g.share >= 1.0 {
                println!("after one step {}", q(c));
                for w in w {
                    println!("carried {}", q(w));
                }
            }
            Ok(std::ops::ControlFlow::Continue(()))
        },
    )?;
    Ok(())
}

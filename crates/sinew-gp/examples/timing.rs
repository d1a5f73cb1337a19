use std::f64::consts::PI;
use std::time::Instant;
use sinew_gp::*;
fn main() {
    let domain = Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])]).unwrap();
    let [dx, dt] = domain.derivatives();
    let theta = Parameter::new("theta", [0.02, 50.0]).unwrap();
    let end = |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
    let problem = Problem::new(domain.clone(), dt - &theta * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, end(-1.0)))
            .and_then(|p| p.condition("x", Side::Upper, end(1.0)))
            .and_then(|p| p.condition("t", Side::Lower, Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin())))).unwrap();
    for n in [50, 100, 300, 600, 1200] {
        for evidence in [Evidence::Joint, Evidence::Conditional] {
        let pu = domain.sample(n / 2, 1).unwrap();
        let y: Vec<f64> = pu.iter().map(|p| p[0].sin() * (-p[1]).exp()).collect();
        let pf = domain.sample(n / 2, 2).unwrap();
        let data = Data::new().values(&pu, &y, Noise::Learned).equation(&pf, &vec![0.0; n / 2], Noise::Exact);
        let model = Model::new(Prior::constrained(&problem, &SquaredExponential::new()).unwrap(), data, evidence).unwrap();
        let at: Vec<f64> = model.parameters().iter().map(|p| p.to_scale((p.start[0] * p.start[1]).sqrt())).collect();
        let reps = (40_000_000 / (n * n * n).max(200000)).max(3);
        let mut best = [f64::INFINITY; 2];
        for _ in 0..reps {
            let t = Instant::now();
            let e = model.evaluate(&at).unwrap();
            best[0] = best[0].min(t.elapsed().as_secs_f64() * 1e3);
            std::hint::black_box(&e);
            let t = Instant::now();
            std::hint::black_box(model.log_evidence(&at).unwrap());
            best[1] = best[1].min(t.elapsed().as_secs_f64() * 1e3);
        }
        println!("N {n} {evidence:?}: evidence+gradient {:.3} ms, evidence {:.3} ms", best[0], best[1]);
        }
    }
}

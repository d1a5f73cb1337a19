//! The evidence in a graph of Burn against the same written in tensors.

#![cfg(feature = "burn")]

use burn::tensor::{DType, Device, Tensor, TensorData};
use sinew_gp::{
    Data, Domain, Evidence, Model, Noise, Parameter, Prior, Problem, SquaredExponential,
    log_evidence_tensor,
};

const VALUES: [[f64; 2]; 3] = [[0.1, 0.2], [0.6, 0.9], [0.9, 0.4]];
const EQUATION: [[f64; 2]; 2] = [[0.3, 0.7], [0.5, 0.1]];
const NOISE: f64 = 0.1;
const MEASURED: [f64; 5] = [0.3, -0.2, 0.5, 0.1, -0.4];

fn model(evidence: Evidence) -> Model<2> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]).unwrap();
    let [dx, dt] = domain.derivatives();
    let theta = Parameter::new("theta", [0.1, 10.0]).unwrap();
    let problem = Problem::new(domain, dt - &theta * dx * dx).unwrap();
    let data = Data::new().equation(&EQUATION, &MEASURED[..2], Noise::Known(NOISE)).values(
        &VALUES,
        &MEASURED[2..],
        Noise::Known(NOISE),
    );
    let prior = Prior::unconstrained(&problem, &SquaredExponential::new()).unwrap();
    Model::new(prior, data, evidence).unwrap()
}

/// One entry of the covariance in tensors of one number, for u_t − θ u_xx of a squared exponential.
fn entry(i: usize, j: usize, p: &[Tensor<1>; 4]) -> Tensor<1> {
    let place = |k: usize| if k < 2 { EQUATION[k] } else { VALUES[k - 2] };
    let [amplitude, length, time, theta] = p;
    let (r, s) = (place(i)[0] - place(j)[0], place(i)[1] - place(j)[1]);
    let (u, v) = (length.clone().recip() * r, time.clone().recip() * s);
    let square = u.clone() * u.clone() + v.clone() * v.clone();
    let k = amplitude.clone() * amplitude.clone() * (square * -0.5).exp();
    let by_x = (u.clone() * u.clone() - 1.0) / (length.clone() * length.clone());
    let by_t = v.clone() / time.clone();
    let fourth =
        (u.clone().powi_scalar(4) - u.powi_scalar(2) * 6.0 + 3.0) / length.clone().powi_scalar(4);
    match (i < 2, j < 2) {
        (false, false) => k,
        // ∂/∂t′ and ∂²/∂x′² are s/λ² and (u² − 1)/λ² times k; ∂/∂t changes sign.
        (false, true) => k * (by_t - theta.clone() * by_x),
        (true, false) => k * (by_t * -1.0 - theta.clone() * by_x),
        (true, true) => {
            let second = (v.clone() * v - 1.0) / (time.clone() * time.clone());
            k * (theta.clone() * theta.clone() * fourth - second)
        }
    }
}

/// Cholesky's algorithm on tensors of one number.
fn reference(scaled: &Tensor<1>, imposed: usize) -> Tensor<1> {
    let p: [Tensor<1>; 4] = std::array::from_fn(|k| scaled.clone().narrow(0, k, 1).exp());
    let mut rows: Vec<Vec<Tensor<1>>> = Vec::new();
    let mut whitened: Vec<Tensor<1>> = Vec::new();
    let mut sum = p[0].clone() * 0.0;
    for i in 0..5 {
        let mut row: Vec<Tensor<1>> = Vec::new();
        for j in 0..=i {
            let mut a = entry(i, j, &p);
            if i == j {
                // The relative jitter of the library.
                a = a * (1.0 + 1e-10) + NOISE * NOISE;
            }
            let other = if i == j { &row } else { &rows[j] };
            for (l, m) in row.iter().zip(other).take(j) {
                a = a - l.clone() * m.clone();
            }
            row.push(if i == j { a.sqrt() } else { a / rows[j][j].clone() });
        }
        let known = row.iter().zip(&whitened);
        let rest =
            known.fold(p[0].clone() * 0.0 + MEASURED[i], |sum, (l, z)| sum - l.clone() * z.clone());
        let z = rest / row[i].clone();
        // All imposed rows together count for one.
        let weight = if i < imposed { 1.0 / imposed as f64 } else { 1.0 };
        let log_two_pi = (2.0 * std::f64::consts::PI).ln();
        let own = z.clone() * z.clone() * 0.5 + row[i].clone().log() + 0.5 * log_two_pi;
        sum = sum - own * weight;
        whitened.push(z);
        rows.push(row);
    }
    sum
}

#[test]
fn agrees_with_tensors_all_the_way() {
    let device = Device::flex().autodiff();
    let at = vec![0.2, -0.4, 0.1, 0.3];
    let leaf = || {
        let data = TensorData::new(at.clone(), [4]);
        Tensor::<1>::from_data(data, (&device, DType::F64)).require_grad()
    };
    let list = |t: Tensor<1>| t.into_data().try_to_vec::<f64>().unwrap();
    for (evidence, imposed) in [(Evidence::Joint, 1), (Evidence::UnitInformation, 2)] {
        let (ours, plain) = (leaf(), leaf());
        let value = log_evidence_tensor(&model(evidence), ours.clone()).unwrap();
        let expected = reference(&plain, imposed);
        // Two paths through the same arithmetic in double precision.
        const TOLERANCE: f64 = 1e-10;
        assert!((list(value.clone())[0] - list(expected.clone())[0]).abs() < TOLERANCE);
        // What comes before the evidence in the graph is differentiated too.
        let a = list(ours.grad(&(value * 3.0).backward()).unwrap());
        let b = list(plain.grad(&(expected * 3.0).backward()).unwrap());
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() < TOLERANCE * 10.0, "{a} {b}");
        }
    }
}

#[test]
fn single_precision_is_refused() {
    let parameters = Tensor::<1>::from_floats([0.0, 0.0, 0.0, 0.0], &Device::flex());
    let refused = log_evidence_tensor(&model(Evidence::Joint), parameters).unwrap_err();
    assert!(refused.to_string().contains("double precision"), "{refused}");
}

//! The book's third page: a law of one's own, from its energy to a stretched specimen.
//!
//! `cargo run -p sinew --example book_law`

use sinew::{Options, Parameter, Scene, Solver, Support};
use sinew_energy::conformance::{Claims, check_law};
use sinew_energy::{Guard, Law, Mat3, Response, Scalar};
use sinew_mesh::box_tetrahedra;
use std::error::Error;

/// H. Demiray, "A note on the elasticity of soft biological tissues", J. Biomech. 5 (1972), compressible:
/// `Ψ = a/(2b) (exp(b(I₁ − 3)) − 1) − a ln J + ½λ(ln J)²`; θ = (a, b, λ), a and λ \[stress\].
#[derive(Clone, Copy, Debug)]
struct Demiray;

impl Law<0> for Demiray {
    const NAME: &'static str = "Demiray (1972)";
    const PARAMETERS: &'static [&'static str] = &["a", "b", "lambda"];

    fn density<S: Scalar, G: Guard>(
        &self,
        theta: &[S],
        h: &Mat3<S>,
        _: &[[S; 3]; 0],
        guard: &G,
    ) -> S {
        let [a, b, lambda] = [0, 1, 2].map(|entry| theta[entry].clone());
        // From H = F − I, so that small strains keep their digits.
        let i1_minus_3 = guard.first_invariant(h.first_invariant_minus_three());
        let ln_j = guard.volume_change(h.volume_change()).ln_1p();
        let exponential = guard.exponent(b.clone() * i1_minus_3).exp_m1();
        a.clone() / b * exponential * 0.5 - a * ln_j.clone() + lambda * ln_j.squared() * 0.5
    }

    fn response(&self, theta: &[f64], h: &Mat3<f64>, _: &[[f64; 3]; 0]) -> Response {
        let ([a, b, lambda], j) = ([theta[0], theta[1], theta[2]], 1.0 + h.volume_change());
        let admissible = j > 0.0; // NaN is not
        if !admissible {
            return Response::INADMISSIBLE;
        }
        let delta = |i, k| if i == k { 1.0 } else { 0.0 };
        let f = Mat3::from_fn(|i, k| h[i][k] + delta(i, k));
        let g = Mat3::from_fn(|i, k| f.cofactor(i, k) / j); // F⁻ᵀ
        let (ln_j, exponent) = (h.volume_change().ln_1p(), b * h.first_invariant_minus_three());
        let s = a * exponent.exp();
        let q = lambda * ln_j - a;
        let energy = 0.5 * a / b * exponent.exp_m1() - a * ln_j + 0.5 * lambda * ln_j * ln_j;
        let response = Response {
            energy,
            stress: Mat3::from_fn(|i, j| s * f[i][j] + q * g[i][j]),
            tangent: std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    let ([i, j], [k, l]) = ([row / 3, row % 3], [column / 3, column % 3]);
                    s * delta(i, k) * delta(j, l)
                        + 2.0 * b * s * f[i][j] * f[k][l]
                        + lambda * g[i][j] * g[k][l]
                        - q * g[i][l] * g[k][j]
                })
            }),
        };
        let mut entries = response.tangent.as_flattened().iter();
        let overflow = !energy.is_finite() || entries.any(|entry| entry.is_nan());
        if overflow { Response::INADMISSIBLE } else { response }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // Derivatives against automatic differentiation and differences, rest, rotations, guards, J → 0, overflow.
    let seed = 1;
    if let Err(failures) = check_law(&Demiray, &[2.0, 1.5, 40.0], &[], Claims::default(), seed) {
        return Err(format!("{} checks fail, such as: {}", failures.len(), failures[0]).into());
    }

    // A specimen of 1 × 1 × 1 mm, stretched to 1.4 times its length between plates that it slides on.
    let stretch = 1.4;
    let mesh = box_tetrahedra([1.0; 3], [3; 3]);
    let plate = mesh.node_sets["x_max"].clone();
    let slides = |side: &str, axis: usize, by: f64| {
        Support::uniform(side, std::array::from_fn(|i| (i == axis).then_some(by)))
    };
    let body = Scene::new(mesh, Demiray)
        .parameter(Parameter::log("a", "kPa", 1.0..=4.0))
        .parameter(Parameter::log("b", "1", 0.5..=3.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=1e6))
        .support(slides("x_min", 0, 0.0))
        .support(slides("y_min", 1, 0.0))
        .support(slides("z_min", 2, 0.0))
        .support(slides("x_max", 0, stretch - 1.0))
        .lower()?;
    let (a, b, lambda) = (2.0, 1.5, 1e5);
    let theta = [a, b, lambda];
    let solution = Solver::new(&body)?.solve(&theta, &Options::default())?;

    // The force on the moved plate: what the gradient of the potential leaves at its nodes [kPa mm²].
    let mut gradient = vec![0.0; 3 * body.nodes];
    body.value_and_gradient(&solution.displacement, &theta, &mut gradient);
    let force: f64 = plate.iter().map(|node| gradient[3 * node]).sum();

    // Incompressible, in closed form: P₁₁ = a (t − t⁻²) exp(b(t² + 2/t − 3)), on an area of 1 mm².
    let i1_minus_3 = stretch * stretch + 2.0 / stretch - 3.0;
    let closed_form = a * (stretch - stretch.powi(-2)) * f64::exp(b * i1_minus_3);
    let difference = force / closed_form - 1.0;
    println!("force {force:.6} kPa mm², closed form {closed_form:.6}, difference {difference:.1e}");
    assert!(difference.abs() < 1e-4, "λ = 5 · 10⁴ a leaves a compressibility of about a/λ");
    Ok(())
}

#[test]
fn the_numbers_of_book_law_hold() -> Result<(), Box<dyn Error>> {
    main()
}

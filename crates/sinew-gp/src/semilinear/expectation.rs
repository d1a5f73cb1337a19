//! Means of the squared residual of an equation over normally distributed arguments.

use super::Term;
use crate::quadrature::{gauss_hermite, tensor_product};
use faer::Mat;
use sinew_num::Series;

/// Nodes along each argument: exact for terms that are polynomials of degree five.
const NODES: usize = 6;
/// Share of a variance below which what is left of it once other arguments are known is rounding.
const ROUNDING: f64 = 1e-14;

/// The residual r = d₀ + g(d₁, …, d_M) − f of an equation at one point.
pub(crate) struct Residual<'a, const M: usize> {
    pub term: &'a Term<M>,
    pub load: f64,
}

/// Means over a normal distribution of (d₀, …, d_M), derivatives taken in these.
pub(crate) struct Expected {
    /// E r²
    pub square: f64,
    /// E r ∇r = ½ ∇ E r²
    pub slope: Vec<f64>,
    /// E (∇r ∇rᵀ + r ∇²r) = ½ ∇² E r²
    pub curvature: Mat<f64>,
}

/// The rule of Gauss and Hermite for M independent standard normal variables.
pub(crate) fn standard_rule<const M: usize>() -> Vec<([f64; M], f64)> {
    tensor_product(&std::array::from_fn(|_| gauss_hermite(NODES)))
}

impl<const M: usize> Residual<'_, M> {
    /// Over the distribution with `mean` and `covariance` of (d₀, …, d_M); none where the term is
    /// not finite.
    pub fn expected(
        &self,
        rule: &[([f64; M], f64)],
        mean: &[f64],
        covariance: &Mat<f64>,
    ) -> Option<Expected> {
        let root = triangular_root::<M>(covariance);
        let (arguments, linear) = root.split_at(M);
        let left = covariance[(0, 0)] - linear[0].iter().map(|l| l * l).sum::<f64>();
        let mut expected = Expected {
            square: left.max(0.0),
            slope: vec![0.0; M + 1],
            curvature: Mat::zeros(M + 1, M + 1),
        };
        let along =
            |row: &[f64; M], z: &[f64; M]| row.iter().zip(z).map(|(l, z)| l * z).sum::<f64>();
        for (z, weight) in rule {
            let at: [f64; M] = std::array::from_fn(|j| mean[j + 1] + along(&arguments[j], z));
            let variables = Series::variables(at, [2; M]);
            let g = variables[0].constant(0.0) + (self.term)(variables, &[]);
            // Of d₀ given the arguments.
            let residual = mean[0] + along(&linear[0], z) + g.value() - self.load;
            let gradient: Vec<f64> = std::iter::once(1.0)
                .chain((0..M).map(|j| g.derivative(&unit::<M>(&[j]))))
                .collect();
            expected.square += weight * residual * residual;
            for (row, slope) in gradient.iter().enumerate() {
                expected.slope[row] += weight * residual * slope;
                for (column, other) in gradient.iter().enumerate() {
                    let second = match (row, column) {
                        (0, _) | (_, 0) => 0.0,
                        (j, k) => residual * g.derivative(&unit::<M>(&[j - 1, k - 1])),
                    };
                    expected.curvature[(row, column)] += weight * (slope * other + second);
                }
            }
        }
        let finite = expected.square.is_finite()
            && expected.slope.iter().all(|s| s.is_finite())
            && expected.curvature.norm_max().is_finite();
        finite.then_some(expected)
    }
}

/// Orders of a derivative taken once for each number in the list.
fn unit<const M: usize>(arguments: &[usize]) -> [usize; M] {
    let mut orders = [0; M];
    arguments.iter().for_each(|argument| orders[*argument] += 1);
    orders
}

/// Rows of a triangular factor of the covariance of (d₁, …, d_M), and then that of d₀: what each is of
/// M independent variables. Arguments that others determine get none of their own.
fn triangular_root<const M: usize>(covariance: &Mat<f64>) -> Vec<[f64; M]> {
    let mut rows: Vec<[f64; M]> = Vec::with_capacity(M + 1);
    for number in (1..=M).chain([0]) {
        let mut row = [0.0; M];
        let own = covariance[(number, number)].max(0.0);
        for (k, known) in rows.iter().enumerate() {
            let before: f64 = row[..k].iter().zip(known).map(|(a, b)| a * b).sum();
            if known[k] > 0.0 {
                row[k] = (covariance[(number, k + 1)] - before) / known[k];
            }
        }
        let k = rows.len();
        if k < M {
            let left = own - row.iter().map(|l| l * l).sum::<f64>();
            row[k] = if left > ROUNDING * own { left.sqrt() } else { 0.0 };
        }
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// r = d₀ + d₁³ − d₁ d₂ − 0.3 with moments by hand.
    #[test]
    fn moments_of_polynomials_are_exact() {
        let term = |[u, v]: [Series; 2], _: &[Series]| u.powi(3) - u * v;
        let residual = Residual::<2> { term: &term, load: 0.3 };
        let rule = standard_rule::<2>();
        let covariance =
            Mat::from_fn(3, 3, |i, j| [[0.5, 0.2, -0.1], [0.2, 0.3, 0.1], [-0.1, 0.1, 0.4]][i][j]);
        let mean = [0.1, -0.4, 0.7];
        let found = residual.expected(&rule, &mean, &covariance).unwrap();
        // Differences of E r² in the mean; means of polynomials are polynomials of low degree.
        const STEP: f64 = 1e-4;
        let square = |moved: [f64; 3], covariance: &Mat<f64>| {
            residual.expected(&rule, &moved, covariance).unwrap().square
        };
        for row in 0..3 {
            let at = |step: f64| {
                let mut moved = mean;
                moved[row] += step;
                square(moved, &covariance)
            };
            let slope = (at(STEP) - at(-STEP)) / (4.0 * STEP);
            assert!((found.slope[row] - slope).abs() < 1e-7, "{row}");
            // ∂/∂S of a mean is half its second derivative in the mean.
            let with = |step: f64| {
                let mut moved = covariance.clone();
                moved[(row, row)] += step;
                square(mean, &moved)
            };
            let curvature = (with(STEP) - with(-STEP)) / (2.0 * STEP);
            assert!((found.curvature[(row, row)] - curvature).abs() < 1e-6, "{row}");
        }
        // Without spread it is the value.
        let point = residual.expected(&rule, &mean, &Mat::zeros(3, 3)).unwrap();
        let value: f64 = 0.1 + (-0.4_f64).powi(3) + 0.4 * 0.7 - 0.3;
        assert!((point.square - value * value).abs() < 1e-15);
    }

    #[test]
    fn terms_without_a_value_give_none() {
        let term = |[u]: [Series; 1], _: &[Series]| u.ln();
        let residual = Residual::<1> { term: &term, load: 0.0 };
        let covariance = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 0.0 });
        assert!(residual.expected(&standard_rule(), &[0.0, 0.5], &covariance).is_none());
    }
}

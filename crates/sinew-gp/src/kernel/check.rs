//! What every kernel must satisfy, for those of this crate and of its users.

use super::table::from_formula;
use super::{Hyperparameter, Kernel, Measure, Orders, Request};
use crate::error::{GpError, place};
use crate::series::Series;
use faer::{Mat, Side as Triangle};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Checks what is said of the hyperparameters, symmetry, positive definiteness, the table of derivatives against Taylor series of the
/// formula and against finite differences, and the gradient in the hyperparameters against
/// differences of the table, on random points between `lower` and `upper`; definiteness also on a
/// regular grid, where kernels that are not definite show it at other lengths than at random; and the
/// variance of slopes, which formulas with a case of their own for x = x′ are apt to lose.
///
/// Derivatives are taken up to order two in either argument, as far as the kernel is smooth.
/// Covariances that are singular but for rounding, as those of very long lengthscales, pass.
///
/// # Errors
/// [`GpError::Kernel`] with the first fault found.
pub fn check_kernel<const D: usize>(
    kernel: &dyn Kernel<D>,
    hyperparameters: &[f64],
    lower: [f64; D],
    upper: [f64; D],
    seed: u64,
) -> Result<(), GpError> {
    check_declarations(kernel, hyperparameters)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let extents: [f64; D] = std::array::from_fn(|d| upper[d] - lower[d]);
    let mut draw = || std::array::from_fn(|d| lower[d] + extents[d] * random.random::<f64>());
    let points: Vec<[f64; D]> = (0..COVARIANCE_POINTS).map(|_| draw()).collect();
    let (pairs, others) = points.split_at(PAIR_POINTS);
    let second = farthest(others, pairs, extents);
    let checked = Checked { kernel, hyperparameters, points: pairs, second, extents };
    checked.symmetry()?;
    checked.definiteness(&points)?;
    checked.definiteness(&grid(lower, extents))?;
    checked.derivatives()?;
    checked.slopes()?;
    checked.gradient()
}

/// Names, measures and values of the hyperparameters.
fn check_declarations<const D: usize>(
    kernel: &dyn Kernel<D>,
    values: &[f64],
) -> Result<(), GpError> {
    let declared = kernel.hyperparameters();
    if values.len() != declared.len() {
        return fault(format!(
            "{} hyperparameter values for a kernel that names {}",
            values.len(),
            declared.len()
        ));
    }
    for (number, (hyperparameter, value)) in declared.iter().zip(values).enumerate() {
        let usable = *value > 0.0 && value.is_finite();
        let value = (!usable).then_some("try it at a finite value above 0");
        if let Some(problem) = unusable::<D>(hyperparameter).or(value) {
            return fault(format!("hyperparameter {number} ({}): {problem}", hyperparameter.name));
        }
    }
    Ok(())
}

/// Reason for which a hyperparameter cannot be adjusted, if there is one.
pub(crate) fn unusable<const D: usize>(hyperparameter: &Hyperparameter) -> Option<&'static str> {
    match hyperparameter.measure {
        Measure::Length { axis } => (axis >= D).then_some("its axis is not one of the domain's"),
        Measure::Number { lower, upper } => {
            let ordered = 0.0 < lower && lower < upper && upper.is_finite();
            (!ordered).then_some("give it finite bounds above 0 in ascending order")
        }
    }
}

/// At most [`COVARIANCE_POINTS`] points, as many along each axis.
fn grid<const D: usize>(lower: [f64; D], extents: [f64; D]) -> Vec<[f64; D]> {
    let along = (1..=COVARIANCE_POINTS)
        .take_while(|n| n.checked_pow(D as u32).is_some_and(|all| all <= COVARIANCE_POINTS))
        .last()
        .unwrap_or(1);
    let place = |number: usize, d: usize| {
        let step = number / along.pow(d as u32) % along;
        lower[d] + extents[d] * step as f64 / (along - 1).max(1) as f64
    };
    (0..along.pow(D as u32)).map(|number| std::array::from_fn(|d| place(number, d))).collect()
}

/// The candidate that along every axis is farthest from all `points`: near them, rough kernels
/// have Taylor series of which rounding leaves little, and on them none.
fn farthest<const D: usize>(
    candidates: &[[f64; D]],
    points: &[[f64; D]],
    extents: [f64; D],
) -> [f64; D] {
    let distance = |candidate: &[f64; D]| {
        let along = |point: &[f64; D], d: usize| ((candidate[d] - point[d]) / extents[d]).abs();
        let all = points.iter().flat_map(|point| (0..D).map(move |d| along(point, d)));
        all.fold(f64::INFINITY, f64::min)
    };
    let farthest = candidates.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
    *farthest.expect("there are candidates")
}

struct Checked<'a, const D: usize> {
    kernel: &'a dyn Kernel<D>,
    hyperparameters: &'a [f64],
    /// First points of pairs, and a second one away from them.
    points: &'a [[f64; D]],
    second: [f64; D],
    extents: [f64; D],
}

/// Points of a covariance matrix whose eigenvalues are looked at, and of tables of derivatives.
const COVARIANCE_POINTS: usize = 64;
const PAIR_POINTS: usize = 12;
/// Error of a kernel's value in units of the variance: a formula of some thirty roundings.
const VALUE_ERROR: f64 = 32.0 * f64::EPSILON;

/// Between closed forms and Taylor series, relative to the largest entry.
const TAYLOR_TOLERANCE: f64 = 1e-11;
/// Between analytic derivatives and central differences, of a step in units of the extent, or of
/// a hyperparameter.
const DIFFERENCE_TOLERANCE: f64 = 1e-6;
const STEP: f64 = 1e-5;
/// Tolerance of second differences about x = x′, whose truncation is of first order for rough kernels: half a per cent where the
/// lengthscale is a twentieth of the extent.
const WIDE_STEP: f64 = 1e-4;
const SLOPE_TOLERANCE: f64 = 0.02;

fn close(a: f64, b: f64, scale: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * scale.max(1.0)
}

impl<const D: usize> Checked<'_, D> {
    fn value(&self, x: [f64; D], y: [f64; D]) -> f64 {
        let hyperparameters: Vec<Series> =
            self.hyperparameters.iter().map(|h| Series::number(*h)).collect();
        self.kernel.formula(&hyperparameters, &Series::plain(x), &Series::plain(y)).value()
    }

    fn symmetry(&self) -> Result<(), GpError> {
        for pair in self.points.windows(2) {
            let (forward, backward) = (self.value(pair[0], pair[1]), self.value(pair[1], pair[0]));
            check_finite(forward, pair[0], pair[1])?;
            if !close(forward, backward, forward.abs(), TAYLOR_TOLERANCE) {
                return fault(format!(
                    "not symmetric: k(x, x') = {forward}, k(x', x) = {backward}"
                ));
            }
        }
        Ok(())
    }

    /// Test of definiteness by the smallest eigenvalue, which moves by no more than the norm of what rounding adds to
    /// the matrix (Weyl): at most the error of an entry for each point. Elimination would not do,
    /// because rounding grows with every tiny pivot that it passes.
    fn definiteness(&self, points: &[[f64; D]]) -> Result<(), GpError> {
        let count = points.len();
        let mut covariance = Mat::zeros(count, count);
        for (i, j) in (0..count).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let value = self.value(points[i], points[j]);
            check_finite(value, points[i], points[j])?;
            covariance[(i, j)] = value;
        }
        let variance = covariance.norm_max().max(f64::MIN_POSITIVE);
        let eigenvalues = covariance.self_adjoint_eigenvalues(Triangle::Lower);
        // The iteration converges for finite symmetric matrices; otherwise no eigenvalue is known.
        let smallest = eigenvalues.map_or(f64::NAN, |all| all.into_iter().fold(f64::MAX, f64::min));
        let eigenvalue = smallest / variance;
        if eigenvalue >= -VALUE_ERROR * count as f64 {
            return Ok(());
        }
        fault(format!(
            "the covariance of {count} points has the eigenvalue {eigenvalue:e} in units of the variance"
        ))
    }

    /// All orders up to two in each argument, one axis at a time and mixed.
    fn orders(&self) -> Vec<Orders<D>> {
        let most = self.kernel.smoothness().unwrap_or(2).min(2);
        let mut orders = vec![Orders { first: [0; D], second: [0; D] }];
        for d in 0..D {
            for (m, n) in [(1, 0), (0, 1), (1, 1), (2, 0), (2, 1), (0, 2), (2, 2)] {
                if m <= most && n <= most {
                    let mut order = Orders { first: [0; D], second: [0; D] };
                    order.first[d] = m;
                    order.second[(d + 1) % D] = n;
                    orders.push(order);
                }
            }
        }
        if self.kernel.is_stationary() {
            for order in &mut orders {
                *order = Orders { first: order.sums(), second: [0; D] };
            }
        }
        orders
    }

    /// Factor of a derivative so that it is one along the unit of the extents.
    fn unit(&self, order: &Orders<D>) -> f64 {
        std::iter::zip(self.extents, order.sums())
            .map(|(extent, n)| extent.powi(n as i32))
            .product()
    }

    /// Hands over what is asked of the pairs of all points with `second`.
    fn ask<T>(
        &self,
        hyperparameters: &[f64],
        second: [f64; D],
        orders: &[Orders<D>],
        answer: impl FnOnce(&Request<'_, D>, &mut [f64]) -> T,
    ) -> (Vec<f64>, T) {
        let axes: [Vec<f64>; D] =
            std::array::from_fn(|d| self.points.iter().map(|p| p[d]).collect());
        let first = axes.each_ref().map(Vec::as_slice);
        let request = Request { hyperparameters, first, second, orders };
        let mut table = vec![0.0; orders.len() * request.count()];
        let answer = answer(&request, &mut table);
        (table, answer)
    }

    fn table(&self, hyperparameters: &[f64], second: [f64; D], orders: &[Orders<D>]) -> Vec<f64> {
        let fill = |request: &Request<'_, D>, table: &mut [f64]| {
            self.kernel.derivatives(request, table);
        };
        self.ask(hyperparameters, second, orders, fill).0
    }

    fn derivatives(&self) -> Result<(), GpError> {
        let orders = self.orders();
        let n = self.points.len();
        let second = self.second;
        let table = self.table(self.hyperparameters, second, &orders);
        let (series, ()) = self.ask(self.hyperparameters, second, &orders, |request, table| {
            from_formula(self.kernel, request, table);
        });
        for (entry, order) in orders.iter().enumerate() {
            let rows = entry * n..(entry + 1) * n;
            let unit = self.unit(order);
            let scale = series[rows.clone()].iter().fold(0.0_f64, |m, s| m.max((s * unit).abs()));
            for (given, expected) in table[rows.clone()].iter().zip(&series[rows]) {
                if !close(given * unit, expected * unit, scale, TAYLOR_TOLERANCE) {
                    return wrong(order, *given, *expected, "Taylor series");
                }
            }
        }
        self.differences(second)
    }

    /// First derivatives in either argument against differences of the formula.
    fn differences(&self, second: [f64; D]) -> Result<(), GpError> {
        for d in 0..D {
            let mut first_order = Orders { first: [0; D], second: [0; D] };
            first_order.first[d] = 1;
            let table = self.table(self.hyperparameters, second, &[first_order]);
            for (point, given) in self.points.iter().zip(&table) {
                let at = |step: f64| {
                    let mut moved = *point;
                    moved[d] += step * self.extents[d];
                    self.value(moved, second)
                };
                let (given, expected) =
                    (given * self.extents[d], (at(STEP) - at(-STEP)) / (2.0 * STEP));
                if !close(given, expected, expected.abs(), DIFFERENCE_TOLERANCE) {
                    let [given, expected] = [given, expected].map(|slope| slope / self.extents[d]);
                    return wrong(&first_order, given, expected, "central differences");
                }
            }
        }
        Ok(())
    }

    /// ∂∂′k of a point with itself against differences of the formula.
    fn slopes(&self) -> Result<(), GpError> {
        let (point, steps) = (self.points[0], [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]);
        for d in (0..D).filter(|_| self.kernel.smoothness() != Some(0)) {
            let mut orders = Orders { first: [0; D], second: [0; D] };
            (orders.first[d], orders.second[d]) = (1, 1);
            let (asked, sign) = match self.kernel.is_stationary() {
                true => (Orders { first: orders.sums(), second: [0; D] }, -1.0),
                false => (orders, 1.0),
            };
            let given = sign * self.table(self.hyperparameters, point, &[asked])[0];
            let moved = |steps: f64| {
                let mut moved = point;
                moved[d] += steps * WIDE_STEP * self.extents[d];
                moved
            };
            let terms = steps.map(|(a, b)| a * b * self.value(moved(a), moved(b)));
            let expected = terms.iter().sum::<f64>() / (2.0 * WIDE_STEP * self.extents[d]).powi(2);
            let unit = self.extents[d].powi(2);
            if !close(given * unit, expected * unit, expected.abs() * unit, SLOPE_TOLERANCE) {
                return wrong(&orders, given, expected, "central differences where x' = x");
            }
        }
        Ok(())
    }

    fn gradient(&self) -> Result<(), GpError> {
        let orders = self.orders();
        // One of the points is the second one: what happens on the diagonal counts too.
        let second = self.points[0];
        let n = self.points.len();
        let weights: Vec<f64> = (0..orders.len() * n)
            .map(|k| (((k * 7 + 3) % 11) as f64 / 11.0 - 0.4) * self.unit(&orders[k / n]))
            .collect();
        let (_, gradient) = self.ask(self.hyperparameters, second, &orders, |request, _| {
            let mut gradient = vec![0.0; self.hyperparameters.len()];
            self.kernel.pull_back(request, &weights, &mut gradient);
            gradient
        });
        let sum = |number: usize, step: f64| -> f64 {
            let mut moved = self.hyperparameters.to_vec();
            moved[number] *= step.exp();
            self.table(&moved, second, &orders).iter().zip(&weights).map(|(t, w)| t * w).sum()
        };
        for (number, given) in gradient.iter().enumerate() {
            let expected = (sum(number, STEP) - sum(number, -STEP)) / (2.0 * STEP);
            let scale = expected.abs().max(sum(number, 0.0).abs());
            if !close(*given, expected, scale, DIFFERENCE_TOLERANCE) {
                return fault(format!(
                    "gradient in hyperparameter {number}: {given}, by differences {expected}"
                ));
            }
        }
        Ok(())
    }
}

fn fault(text: String) -> Result<(), GpError> {
    Err(GpError::Kernel(text))
}

fn check_finite<const D: usize>(value: f64, x: [f64; D], y: [f64; D]) -> Result<(), GpError> {
    if value.is_finite() {
        return Ok(());
    }
    fault(format!("k(x, x') = {value} at x = {}, x' = {}", place(&x), place(&y)))
}

/// A derivative that does not belong to the formula.
fn wrong<const D: usize>(
    orders: &Orders<D>,
    given: f64,
    expected: f64,
    method: &str,
) -> Result<(), GpError> {
    let [first, second] = [orders.first, orders.second].map(|n| place(&n.map(|n| n as f64)));
    fault(format!(
        "derivative {first} in x, {second} in x': {given} in the table, {expected} by {method}"
    ))
}

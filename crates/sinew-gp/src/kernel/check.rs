//! Checks that every kernel must pass, for those of this crate and of its users.

use super::{Formula, Hermites, Hyperparameter, Measure, Request};
use crate::error::{Result, place};
use crate::{Derivative, Domain, Operator, Series};
use nalgebra::DMatrix;

/// Checks what is said of the hyperparameters, symmetry, positive definiteness, and the covariance of slopes by Taylor series
/// against finite differences, on random points between `lower` and `upper`; definiteness also on a
/// regular grid, where kernels that are not definite show it at other lengths than at random; and slopes where x = x′, which
/// formulas with a case of their own there are apt to lose.
///
/// Covariances that are singular but for rounding, as those of very long lengthscales, pass.
///
/// # Errors
/// With the first fault found; and if an axis' ends are not in ascending order.
pub fn check_kernel<const D: usize>(
    kernel: &Formula<D>,
    hyperparameters: &[f64],
    lower: [f64; D],
    upper: [f64; D],
    seed: u64,
) -> Result<()> {
    kernel.check_declarations(hyperparameters)?;
    let names: [String; D] = std::array::from_fn(|d| d.to_string());
    let axis = |d: usize| (names[d].as_str(), [lower[d], upper[d]]);
    let domain = Domain::cuboid(std::array::from_fn(axis))?;
    let points = domain.sample(COVARIANCE_POINTS, seed)?;
    kernel.check_definiteness(hyperparameters, &points)?;
    // As many along each axis; roots are rounded.
    let along = (COVARIANCE_POINTS as f64).powf(1.0 / D as f64) + 1e-9;
    kernel.check_definiteness(hyperparameters, &domain.grid(along as usize))?;
    let slopes = |other| kernel.check_slopes(hyperparameters, &domain, [points[0], other]);
    points[..3].iter().copied().try_for_each(slopes)
}

impl<const D: usize> Formula<D> {
    /// Refuses operators that take more derivatives than its functions have.
    pub(crate) fn check_smoothness(&self, operator: &Operator<D>) -> Result<()> {
        let (needs, has) = (operator.order(), self.smoothness.unwrap_or(usize::MAX));
        ensure!(
            needs <= has,
            "the {} kernel has {has} derivatives, the operator takes {needs}; use a smoother kernel",
            self.name
        );
        Ok(())
    }

    /// Refuses kernels whose hyperparameters have no range to be adjusted in, and those along axes that there are not, of which a
    /// restriction to the domain's would leave a constant; also values that they cannot have.
    pub(crate) fn check_declarations(&self, values: &[f64]) -> Result<()> {
        let declared = self.hyperparameters();
        let (count, expected) = (values.len(), declared.len());
        ensure!(
            count == expected,
            "{count} hyperparameter values for a kernel that names {expected}"
        );
        for (Hyperparameter { name, measure }, value) in declared.into_iter().zip(values) {
            let own = format!("hyperparameter {name} of the {} kernel", self.name);
            if let Measure::Length { axis } | Measure::Width { axis, .. } = measure {
                ensure!(axis < D, "{own}: its axis is not one of the domain's");
            }
            if let Measure::Number { lower, upper } | Measure::Width { lower, upper, .. } = measure
            {
                let ordered = 0.0 < lower && lower < upper && upper.is_finite();
                ensure!(ordered, "{own}: give it finite bounds above 0 in ascending order");
            }
            let usable = *value > 0.0 && value.is_finite();
            ensure!(usable, "{own}: try it at a finite value above 0");
        }
        Ok(())
    }

    fn value(&self, hyperparameters: &[f64], x: [f64; D], y: [f64; D]) -> f64 {
        let known: Vec<_> = hyperparameters.iter().map(|h| Series::number(*h)).collect();
        self.formula(&known, &Series::plain(x), &Series::plain(y)).value()
    }

    /// Test of symmetry, and of definiteness by the smallest eigenvalue, which moves by no more than the norm of what rounding adds to
    /// the matrix (Weyl): at most the error of an entry for each point. Elimination would not do,
    /// because rounding grows with every tiny pivot that it passes.
    fn check_definiteness(&self, hyperparameters: &[f64], points: &[[f64; D]]) -> Result<()> {
        let count = points.len();
        let mut covariance = DMatrix::zeros(count, count);
        for (i, j) in (0..count).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let (x, y) = (points[i], points[j]);
            let [forward, backward] =
                [(x, y), (y, x)].map(|(x, y)| self.value(hyperparameters, x, y));
            let (at, other) = (place(&x), place(&y));
            ensure!(forward.is_finite(), "k(x, x') = {forward} at x = {at}, x' = {other}");
            ensure!(
                close(forward, backward, forward.abs(), SYMMETRY_TOLERANCE),
                "not symmetric: k(x, x') = {forward}, k(x', x) = {backward}"
            );
            (covariance[(i, j)], covariance[(j, i)]) = (forward, forward);
        }
        let variance = covariance.amax().max(f64::MIN_POSITIVE);
        let eigenvalue = covariance.symmetric_eigenvalues().min() / variance;
        ensure!(
            eigenvalue >= -VALUE_ERROR * count as f64,
            "the covariance of {count} points has the eigenvalue {eigenvalue:e} in units of the variance"
        );
        Ok(())
    }

    /// ∂∂′k of two points, or of one with itself, against differences of the formula.
    fn check_slopes(
        &self,
        hyperparameters: &[f64],
        domain: &Domain<D>,
        [x, y]: [[f64; D]; 2],
    ) -> Result<()> {
        let steps = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let axes = self.axes.iter().copied();
        for d in axes.filter(|_| self.smoothness != Some(0)) {
            let along = Derivative::along(d).orders;
            let (asked, sign) = self.entry([along, along]);
            let mut table = [0.0];
            let request = Request {
                kernel: self,
                hyperparameters,
                first: x.each_ref().map(std::slice::from_ref),
                second: y,
                orders: &[asked],
            };
            request.derivatives(&mut table, &mut Hermites::default(), 0);
            let given = sign * table[0];
            let step = STEP * domain.extents()[d];
            let moved = |mut point: [f64; D], steps: f64| {
                point[d] += steps * step;
                point
            };
            let value = |a, b| self.value(hyperparameters, moved(x, a), moved(y, b));
            let terms = steps.map(|(a, b)| a * b * value(a, b));
            let expected = terms.iter().sum::<f64>() / (2.0 * step).powi(2);
            let unit = domain.extents()[d].powi(2);
            let (along, at) = (d + 1, if x == y { " where x' = x" } else { "" });
            ensure!(
                close(given * unit, expected * unit, expected.abs() * unit, SLOPE_TOLERANCE),
                "second derivative along axis {along} of both arguments: {given} in the table, {expected} by central differences{at}"
            );
        }
        Ok(())
    }
}

/// Points of a covariance matrix whose eigenvalues are looked at.
const COVARIANCE_POINTS: usize = 64;
/// Error of a kernel's value in units of the variance: a formula of some thirty roundings.
const VALUE_ERROR: f64 = 32.0 * f64::EPSILON;
/// Difference between k(x, x′) and k(x′, x), relative to the larger of them and one.
const SYMMETRY_TOLERANCE: f64 = 1e-11;
/// Step of second differences in units of the extent. Their truncation is of first order for rough kernels where x = x′: half a
/// per cent where the lengthscale is a twentieth of the extent.
const STEP: f64 = 1e-4;
const SLOPE_TOLERANCE: f64 = 0.02;

fn close(a: f64, b: f64, scale: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * scale.max(1.0)
}

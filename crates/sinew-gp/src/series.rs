//! Taylor polynomials of several variables, of any order.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A Taylor polynomial in several variables, cut off at a degree of its own in each of them.
///
/// One evaluation of a formula over series gives all its partial derivatives up to those degrees:
/// what a differential operator of any order needs. Series that meet in one formula have the same
/// variables and degrees, or none ([`Series::plain`]).
///
/// ```
/// use sinew_gp::Series;
///
/// // ∂³/∂x²∂y of sin(x) eʸ at (0.3, 0.1)
/// let [x, y] = Series::variables([0.3, 0.1], [2, 1]);
/// let product = x.sin() * y.exp();
/// assert!((product.derivative(&[2, 1]) + 0.3_f64.sin() * 0.1_f64.exp()).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Highest power kept of each variable.
    degrees: Vec<usize>,
    /// Coefficient of x₀^i x₁^j … at the mixed-radix position (i, j, …), the last variable fastest.
    coefficients: Vec<f64>,
}

/// Number of coefficients of series with these degrees.
fn size(degrees: &[usize]) -> usize {
    degrees.iter().map(|degree| degree + 1).product()
}

/// `out += left · right` for the dense coefficient blocks of `degrees`, cut off.
fn multiply_into(out: &mut [f64], left: &[f64], right: &[f64], degrees: &[usize]) {
    match degrees {
        [] => out[0] += left[0] * right[0],
        [_] => {
            for (i, l) in left.iter().enumerate().filter(|(_, l)| **l != 0.0) {
                for (o, r) in out[i..].iter_mut().zip(right) {
                    *o += l * r;
                }
            }
        }
        [degree, rest @ ..] => {
            let block = out.len() / (degree + 1);
            for i in 0..=*degree {
                let left = &left[i * block..(i + 1) * block];
                // Most formulas start from differences and squares, of few terms.
                if left.iter().all(|l| *l == 0.0) {
                    continue;
                }
                for j in 0..=degree - i {
                    let out = &mut out[(i + j) * block..(i + j + 1) * block];
                    multiply_into(out, left, &right[j * block..(j + 1) * block], rest);
                }
            }
        }
    }
}

impl Series {
    /// The numbers `values` that depend on no variable.
    pub fn plain<const D: usize>(values: [f64; D]) -> [Self; D] {
        values.map(Self::number)
    }

    /// One such number.
    pub(crate) fn number(value: f64) -> Self {
        Self { degrees: Vec::new(), coefficients: vec![value] }
    }

    /// The variables themselves at `values`, each kept up to the power in `degrees`.
    pub fn variables<const D: usize>(values: [f64; D], degrees: [usize; D]) -> [Self; D] {
        std::array::from_fn(|d| Self::variable(values[d], d, &degrees))
    }

    /// Variable number `index` of `degrees.len()`, at `value`.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn variable(value: f64, index: usize, degrees: &[usize]) -> Self {
        assert!(index < degrees.len(), "variable {index} of {}", degrees.len());
        let mut coefficients = vec![0.0; size(degrees)];
        coefficients[0] = value;
        if degrees[index] > 0 {
            coefficients[size(&degrees[index + 1..])] = 1.0;
        }
        Self { degrees: degrees.to_vec(), coefficients }
    }

    /// The number `value`, shaped like this one.
    pub fn constant(&self, value: f64) -> Self {
        let mut coefficients = vec![0.0; self.coefficients.len()];
        coefficients[0] = value;
        Self { degrees: self.degrees.clone(), coefficients }
    }

    /// Value at the point of expansion.
    pub fn value(&self) -> f64 {
        self.coefficients[0]
    }

    /// Partial derivative of the given order in each variable.
    ///
    /// # Panics
    /// If an order exceeds the degree kept, or their number is not that of the variables.
    pub fn derivative(&self, orders: &[usize]) -> f64 {
        assert_eq!(orders.len(), self.degrees.len(), "one order for each variable");
        let position = orders.iter().zip(&self.degrees).fold(0, |position, (order, degree)| {
            assert!(order <= degree, "order {order} above the degree {degree}");
            position * (degree + 1) + order
        });
        let factorials: f64 = orders.iter().map(|n| factorial(*n)).product();
        self.coefficients[position] * factorials
    }

    /// The polynomial plus `slope` times one more, last variable.
    pub(crate) fn lifted(&self, degree: usize, slope: f64) -> Self {
        let degrees = [&self.degrees[..], &[degree]].concat();
        let mut coefficients = vec![0.0; size(&degrees)];
        for (lifted, c) in coefficients.chunks_mut(degree + 1).zip(&self.coefficients) {
            lifted[0] = *c;
        }
        coefficients[1] = slope;
        Self { degrees, coefficients }
    }

    /// The derivative of order `order` in the last variable, at its point of expansion, as a
    /// series in the others.
    ///
    /// # Panics
    /// If there is no variable, or the order exceeds the degree kept.
    pub(crate) fn last_derivative(&self, order: usize) -> Self {
        let (last, others) = self.degrees.split_last().expect("a series with a last variable");
        assert!(order <= *last, "order {order} above the degree {last}");
        let (factor, own) = (factorial(order), self.coefficients.iter().skip(order));
        let coefficients = own.step_by(last + 1).map(|c| c * factor).collect();
        Self { degrees: others.to_vec(), coefficients }
    }

    /// Powers of its part without a value vanish above this one.
    fn total(&self) -> usize {
        self.degrees.iter().sum()
    }

    /// Whether it has no variables.
    fn is_plain(&self) -> bool {
        self.degrees.is_empty()
    }

    /// `f(self)` from the Taylor coefficients `f⁽ᵏ⁾/k!` of `f` at the value, asked for one after the other.
    pub(crate) fn compose(&self, taylor: impl FnMut(usize) -> f64) -> Self {
        let taylor: Vec<f64> = (0..=self.total()).map(taylor).collect();
        let mut increment = self.clone();
        increment.coefficients[0] = 0.0;
        if increment.coefficients.iter().all(|c| *c == 0.0) {
            return self.constant(taylor[0]);
        }
        let (last, lower) = taylor.split_last().expect("at least the value");
        lower.iter().rev().fold(self.constant(*last), |mut sum, coefficient| {
            sum = increment.product(&sum);
            sum.coefficients[0] += coefficient;
            sum
        })
    }

    /// Exponential.
    pub fn exp(&self) -> Self {
        let e = self.coefficients[0].exp();
        self.compose(|k| e / factorial(k))
    }

    /// Natural logarithm; −∞ at zero and below.
    pub fn ln(&self) -> Self {
        let x = self.coefficients[0];
        let mut power = -1.0;
        self.compose(|k| match k {
            0 if x <= 0.0 => f64::NEG_INFINITY,
            0 => x.ln(),
            _ => {
                power /= -x;
                power / k as f64
            }
        })
    }

    /// Sine.
    pub fn sin(&self) -> Self {
        let (sin, cos) = self.coefficients[0].sin_cos();
        self.compose(|k| [sin, cos, -sin, -cos][k % 4] / factorial(k))
    }

    /// Cosine.
    pub fn cos(&self) -> Self {
        let (sin, cos) = self.coefficients[0].sin_cos();
        self.compose(|k| [cos, -sin, -cos, sin][k % 4] / factorial(k))
    }

    /// The angle of the point (`x`, `self`) from the first axis, between −π and π; at the origin it has no derivatives. About a
    /// corner, turn the plane so that the cut along the negative first axis lies outside of the domain.
    ///
    /// ```
    /// use sinew_gp::Series;
    ///
    /// // r^⅔ sin ⅔φ, harmonic about a corner of 270°.
    /// let [x, y] = Series::variables([0.3, 0.4], [2, 2]);
    /// let (r, angle) = ((x.squared() + y.squared()).sqrt(), y.atan2(&x));
    /// let u = r.powf(2.0 / 3.0) * (angle * (2.0 / 3.0)).sin();
    /// assert!((u.derivative(&[2, 0]) + u.derivative(&[0, 2])).abs() < 1e-14);
    /// ```
    pub fn atan2(&self, x: &Self) -> Self {
        let (y0, x0) = (self.value(), x.value());
        // In axes turned to the point the angle is atan t, with t = 0 there.
        let t = (self * x0 - x * y0) / (x * x0 + self * y0);
        t.compose(|k| match k % 4 {
            _ if k == 0 => y0.atan2(x0),
            1 => 1.0 / k as f64,
            3 => -1.0 / k as f64,
            _ => 0.0,
        })
    }

    /// Hyperbolic tangent.
    pub fn tanh(&self) -> Self {
        // t' = 1 − t² read as a recursion for the coefficients.
        let mut taylor = vec![self.coefficients[0].tanh()];
        for k in 0..self.total() {
            let square: f64 = (0..=k).map(|i| taylor[i] * taylor[k - i]).sum();
            taylor.push((f64::from(u8::from(k == 0)) - square) / (k as f64 + 1.0));
        }
        self.compose(|k| taylor[k])
    }

    /// Square root; its derivatives at zero are infinite.
    pub fn sqrt(&self) -> Self {
        self.powf(0.5)
    }

    /// A real power of a positive number.
    pub fn powf(&self, power: f64) -> Self {
        let x = self.coefficients[0];
        let mut binomial = 1.0;
        self.compose(|k| {
            let own = if binomial == 0.0 { 0.0 } else { binomial * x.powf(power - k as f64) };
            binomial *= (power - k as f64) / (k as f64 + 1.0);
            own
        })
    }

    /// A whole power, of any number.
    pub fn powi(&self, power: usize) -> Self {
        (0..power).fold(self.constant(1.0), |product, _| &product * self)
    }

    /// `self²`.
    pub fn squared(&self) -> Self {
        self * self
    }

    /// `1 / self`.
    pub fn recip(&self) -> Self {
        let x = self.coefficients[0];
        let mut power = -1.0;
        self.compose(|_| {
            power /= -x;
            power
        })
    }

    /// Plus a number.
    fn plus(&self, number: f64) -> Self {
        let mut sum = self.clone();
        sum.coefficients[0] += number;
        sum
    }

    /// `op` coefficient by coefficient.
    fn zip(&self, right: &Self, op: impl Fn(f64, f64) -> f64) -> Self {
        // Numbers take the shape of the other.
        match (self.is_plain(), right.is_plain()) {
            (true, false) => return right.constant(self.value()).zip(right, op),
            (false, true) => return self.zip(&self.constant(right.value()), op),
            _ => assert_eq!(self.degrees, right.degrees, "series of different shapes"),
        }
        let coefficients =
            self.coefficients.iter().zip(&right.coefficients).map(|(l, r)| op(*l, *r)).collect();
        Self { degrees: self.degrees.clone(), coefficients }
    }

    fn product(&self, right: &Self) -> Self {
        if right.is_plain() {
            return self.map(|l| l * right.coefficients[0]);
        }
        if self.is_plain() {
            return right.map(|r| self.coefficients[0] * r);
        }
        assert_eq!(self.degrees, right.degrees, "series of different shapes");
        let mut product = self.constant(0.0);
        let (left, right) = (&self.coefficients, &right.coefficients);
        multiply_into(&mut product.coefficients, left, right, &self.degrees);
        product
    }

    fn map(&self, op: impl Fn(f64) -> f64) -> Self {
        let coefficients = self.coefficients.iter().map(|c| op(*c)).collect();
        Self { degrees: self.degrees.clone(), coefficients }
    }
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|k| k as f64).product()
}

/// A binary operator on all combinations of values and references, of two series or of one and a number on either side.
macro_rules! operator {
    ($trait:ident, $method:ident, |$left:ident, $right:ident| $body:expr) => {
        operator!(@ $trait, $method, Series, Series, |$left, $right| $body);
        operator!(@ $trait, $method, Series, &Series, |$left, $right| $body);
        operator!(@ $trait, $method, &Series, Series, |$left, $right| $body);
        operator!(@ $trait, $method, &Series, &Series, |$left, $right| $body);
    };
    ($trait:ident, $method:ident, number |$a:ident, $b:ident| $after:expr, |$c:ident, $d:ident| $before:expr) => {
        operator!(@ $trait, $method, Series, f64, |$a, $b| $after);
        operator!(@ $trait, $method, &Series, f64, |$a, $b| $after);
        operator!(@ $trait, $method, f64, Series, |$c, $d| $before);
        operator!(@ $trait, $method, f64, &Series, |$c, $d| $before);
    };
    (@ $trait:ident, $method:ident, $Left:ty, $Right:ty, |$left:ident, $right:ident| $body:expr) => {
        impl $trait<$Right> for $Left {
            type Output = Series;
            fn $method(self, right: $Right) -> Series {
                let ($left, $right) = (&self, &right);
                $body
            }
        }
    };
}

operator!(Add, add, |l, r| l.zip(r, |a, b| a + b));
operator!(Sub, sub, |l, r| l.zip(r, |a, b| a - b));
operator!(Mul, mul, |l, r| l.product(r));
operator!(Div, div, |l, r| l.product(&r.recip()));
operator!(Add, add, number | l, r | l.plus(*r), |l, r| r.plus(*l));
operator!(Sub, sub, number | l, r | l.plus(-r), |l, r| r.map(|c| -c).plus(*l));
operator!(Mul, mul, number | l, r | l.map(|c| c * r), |l, r| r.map(|c| c * l));
operator!(Div, div, number | l, r | l.map(|c| c / r), |l, r| r.recip().map(|c| c * l));

impl Neg for &Series {
    type Output = Series;
    fn neg(self) -> Series {
        self.map(|c| -c)
    }
}

impl Neg for Series {
    type Output = Self;
    fn neg(self) -> Self {
        -&self
    }
}

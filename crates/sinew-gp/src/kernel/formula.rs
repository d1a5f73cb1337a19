//! Kernels by their formula alone.

use super::{Hyperparameter, Measure, Orders};
use crate::series::Series;
use std::fmt;
use std::ops::{Add, Mul};
use std::sync::Arc;

type Function<const D: usize> =
    dyn Fn(&[Series], &[Series; D], &[Series; D]) -> Series + Send + Sync;

/// A kernel of variance one (unless scaled), with positive hyperparameters, given by one formula over Taylor series: [`super::matern`]
/// and the like, and one of your own. Derivatives come from the formula, pair by pair; those of [`super::squared_exponential`] are in
/// closed form, which is faster by far. Sums of kernels are independent functions added, products as a periodic kernel in one axis
/// times a smooth one in another.
///
/// ```
/// use sinew_gp::{Formula, Series, Smoothness, check_kernel, matern, periodic, squared_exponential};
///
/// // 1 + x² x′²: functions of the form a + b x² along the first axis.
/// let even = Formula::<2>::new("even quadratic", Vec::new(), |_, x: &[Series; 2], y: &[Series; 2]| {
///     x[0].squared() * y[0].squared() + 1.0
/// });
/// check_kernel(&even, &[], [0.0, 0.0], [1.0, 1.0], 7)?;
///
/// let trend = squared_exponential();
/// let details = matern(Smoothness::Twice).scaled();
/// check_kernel(&(trend + details * periodic(0, 0.5)?), &[3.0, 3.0, 0.1, 0.5, 0.5, 1.0], [0.0; 2], [1.0; 2], 7)?;
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone)]
pub struct Formula<const D: usize> {
    /// Name, for messages.
    pub name: String,
    /// Hyperparameters of the formula, and whether it depends on them.
    pub(super) taken: Vec<(Hyperparameter, bool)>,
    /// Axes that it depends on.
    pub(crate) axes: Vec<usize>,
    /// Number of derivatives that its functions have in the mean-square sense; none for all.
    pub(crate) smoothness: Option<usize>,
    /// Whether it depends on x − x′ only; then derivatives in x suffice.
    pub(crate) stationary: bool,
    /// Whether it is the squared exponential, whose derivatives have a closed form.
    pub(crate) closed: bool,
    pub(super) function: Arc<Function<D>>,
}

impl<const D: usize> Formula<D> {
    /// A kernel of variance one on all axes by its name, hyperparameters and formula, with smooth functions and no more known of
    /// it; see [`Formula::smooth`] and [`Formula::stationary`].
    pub fn new(
        name: impl Into<String>,
        hyperparameters: Vec<Hyperparameter>,
        formula: impl Fn(&[Series], &[Series; D], &[Series; D]) -> Series + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            taken: hyperparameters.into_iter().map(|own| (own, true)).collect(),
            axes: (0..D).collect(),
            smoothness: None,
            stationary: false,
            closed: false,
            function: Arc::new(formula),
        }
    }

    /// Kernel whose functions have no more than these derivatives.
    pub fn smooth(self, derivatives: usize) -> Self {
        Self { smoothness: Some(derivatives), ..self }
    }

    /// Kernel that depends on x − x′ only, of which fewer derivatives are taken.
    pub fn stationary(self) -> Self {
        Self { stationary: true, ..self }
    }

    /// Kernel on the axes with these numbers only: along others points count as equal, at zero.
    pub fn along(mut self, axes: &[usize]) -> Self {
        self.axes.retain(|axis| axes.contains(axis));
        let kept = |h: &Hyperparameter| match h.measure {
            Measure::Length { axis } | Measure::Width { axis, .. } => self.axes.contains(&axis),
            Measure::Number { .. } => true,
        };
        self.taken.iter_mut().for_each(|(own, taken)| *taken &= kept(own));
        // A length scale that does not exist is an error.
        for axis in axes.iter().copied().filter(|axis| *axis >= D) {
            let measure = Measure::Length { axis };
            self.taken.push((Hyperparameter { name: "lengthscale", measure }, true));
        }
        self
    }

    /// The kernel times a variance, whose root is the first hyperparameter: a summand beside others.
    pub fn scaled(self) -> Self {
        let measure = Measure::Number { lower: 1e-3, upper: 1e3 };
        let amplitude = Hyperparameter { name: "amplitude", measure };
        let whole = [vec![amplitude], self.hyperparameters()].concat();
        let (name, smoothness, stationary) =
            (format!("scaled {}", self.name), self.smoothness, self.stationary);
        let scaled =
            Self::new(name, whole, move |h, x, y| h[0].squared() * self.formula(&h[1..], x, y));
        Self { smoothness, stationary, ..scaled }
    }

    /// The hyperparameters, in the order in which their values are handed over.
    pub fn hyperparameters(&self) -> Vec<Hyperparameter> {
        self.taken.iter().filter(|(_, taken)| *taken).map(|(own, _)| own.clone()).collect()
    }

    /// k(x, x′) over Taylor series, at positive `hyperparameters`.
    pub fn formula(&self, hyperparameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let mut given = hyperparameters.iter().cloned();
        let one = || Series::number(1.0);
        let each = self.taken.iter().map(|(_, taken)| taken.then(|| given.next()).flatten());
        let taken: Vec<Series> = each.map(|own| own.unwrap_or_else(one)).collect();
        let [mut x, mut y] = [x.clone(), y.clone()];
        for axis in (0..D).filter(|axis| !self.axes.contains(axis)) {
            (x[axis], y[axis]) = (x[axis].constant(0.0), y[axis].constant(0.0));
        }
        (self.function)(&taken, &x, &y)
    }

    /// Entry of a table that a derivative is read from, and its sign: those of a stationary kernel are all in x, as ∂/∂x′ is −∂/∂x.
    pub(crate) fn entry(&self, [first, second]: Orders<D>) -> (Orders<D>, f64) {
        if !self.stationary {
            return ([first, second], 1.0);
        }
        let sums = std::array::from_fn(|d| first[d] + second[d]);
        let odd = second.iter().sum::<usize>() % 2 == 1;
        ([sums, [0; D]], if odd { -1.0 } else { 1.0 })
    }

    fn combined(self, other: Self, sign: &str, of: fn(Series, Series) -> Series) -> Self {
        let own = self.hyperparameters();
        let (count, whole) = (own.len(), [own, other.hyperparameters()].concat());
        let name = format!("{} {sign} {}", self.name, other.name);
        let smoothness = self.smoothness.into_iter().chain(other.smoothness).min();
        let stationary = self.stationary && other.stationary;
        let combined = Self::new(name, whole, move |h, x, y| {
            let (first, second) = h.split_at(count);
            of(self.formula(first, x, y), other.formula(second, x, y))
        });
        Self { smoothness, stationary, ..combined }
    }
}

impl<const D: usize> Add for Formula<D> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.combined(other, "+", |a, b| a + b)
    }
}

impl<const D: usize> Mul for Formula<D> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.combined(other, "×", |a, b| a * b)
    }
}

impl<const D: usize> fmt::Debug for Formula<D> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.name)
    }
}

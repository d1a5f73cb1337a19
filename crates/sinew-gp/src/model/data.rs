//! Observed and imposed values.

use crate::error::{Result, check_lengths, place};
use crate::{Domain, Field, Functional, GpError, Operator};
use std::sync::Arc;

/// Standard deviation of the error of observations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// The values are exact.
    Exact,
    /// Known, in the unit of the values.
    Known(f64),
    /// Inferred along with the other parameters.
    Learned,
    /// Student's t with so many degrees of freedom (4 is a usual choice), its scale inferred: for values of which some are
    /// far off. Each value has a weight that divides the variance of its error, gamma distributed (Gelman et al. 2013, §17.2);
    /// a fit and [`crate::laplace`] take the most probable ones, [`crate::nuts`] draws them.
    StudentT(f64),
}

/// Part that a group of observations has in the evidence.
///
/// Their order is that of the rows of the covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    /// Part of the model.
    Imposed,
    /// Measured: the evidence says how well it is predicted.
    Observed,
}

/// Values of one linear functional of u at several points.
#[derive(Clone, Debug)]
pub(crate) struct Group<const D: usize> {
    /// `None` for the operator of the problem's equation.
    pub operator: Option<Operator<D>>,
    /// Points of each observation, which is the sum of the operator's values there times their factors: one of factor 1, two ends of
    /// a jump, or those of a quadrature.
    pub legs: Vec<(f64, Vec<[f64; D]>)>,
    pub values: Vec<f64>,
    pub noise: Noise,
    pub role: Role,
    /// Statistics of the averages, if each value is a mean of many.
    pub averages: Option<Averages<D>>,
}

impl<const D: usize> Group<D> {
    /// The first point of each observation.
    pub(crate) fn points(&self) -> &[[f64; D]] {
        &self.legs[0].1
    }

    /// Refuses noise-free values that differ by more than neighbours can: jitter would let them pass for their mean.
    fn check_contradictions(&self, whose: &str, domain: &Domain<D>) -> Result<()> {
        if self.legs.len() > 1 {
            return Ok(());
        }
        let most = largest(&self.values);
        // In the order of their first coordinate few come near enough to be compared.
        let mut order: Vec<usize> = (0..self.values.len()).collect();
        order.sort_by(|&a, &b| self.points()[a][0].total_cmp(&self.points()[b][0]).then(a.cmp(&b)));
        for (position, &one) in order.iter().enumerate() {
            for &two in &order[position + 1..] {
                let (first, second) = (one.min(two), one.max(two));
                let [here, there] = [first, second].map(|number| &self.points()[number]);
                let mut beside = *here;
                beside[0] = there[0];
                // No two values differ by more than twice the largest.
                if STEEPEST * domain.apart(here, &beside) > 2.0 {
                    break;
                }
                let difference = (self.values[second] - self.values[first]).abs();
                ensure!(
                    difference <= most * (STEEPEST * domain.apart(here, there)).max(SAME),
                    "values {first} and {second} of {whose} at {} and {} are noise-free and differ by {difference:e}, more than neighbours can; keep one, or give them noise",
                    place(here),
                    place(there)
                );
            }
        }
        Ok(())
    }
}

/// Statistics of values that were averaged.
#[derive(Clone, Debug)]
pub(crate) struct Averages<const D: usize> {
    /// Places of all values.
    pub places: Arc<[[f64; D]]>,
    /// Number of values of each mean.
    pub counts: Vec<f64>,
    /// Sum of squares of the residuals of the values about a linear function in each cell.
    pub squares: f64,
    /// Degrees of freedom of that sum.
    pub freedom: f64,
}

/// Observations of u, of the equation's right-hand side, and of other linear functionals of u.
///
/// ```
/// use sinew_gp::{Data, Noise};
///
/// let data = Data::new()
///     .values(&[[0.1, 0.2], [0.5, 0.9]], &[1.2, 0.3], Noise::Learned)
///     .equation(&[[0.5, 0.5]], &[0.0], Noise::Exact);
/// assert_eq!(data.count(), 3);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Data<const D: usize> {
    pub(crate) groups: Vec<Group<D>>,
    /// Right-hand side of an equation whose points the fit chooses.
    pub(crate) everywhere: Option<Field<D>>,
}

impl<const D: usize> Data<D> {
    /// Data without observations.
    pub fn new() -> Self {
        Self { groups: Vec::new(), everywhere: None }
    }

    /// Number of observations.
    pub fn count(&self) -> usize {
        self.groups.iter().map(|group| group.points().len()).sum()
    }

    /// Adds values of u, one for each point.
    pub fn values(self, points: &[[f64; D]], values: &[f64], noise: Noise) -> Self {
        self.functional(Operator::identity(), points, values, noise)
    }

    /// Adds values of the right-hand side f of the problem's equation at collocation points. One that is the same at ten exact points
    /// or more is taken to be the same in the box that they fill, where [`crate::Model::fit`] adds points ([`crate::FitOptions::most_points`]).
    pub fn equation(self, points: &[[f64; D]], values: &[f64], noise: Noise) -> Self {
        self.group(None, points, values, noise, Role::Imposed)
    }

    /// The problem's equation everywhere, without error: [`crate::Model::fit`] imposes it at as many points as it takes
    /// until it is off by next to nothing in between (15 for each dimension at first, [`crate::FitOptions::most_points`] at most).
    ///
    /// ```
    /// use sinew_gp::{Data, field};
    ///
    /// let data: Data<1> = Data::new().equation_everywhere(field(|[x]| x.sin()));
    /// assert_eq!(data.count(), 0, "the points are found by the fit");
    /// ```
    pub fn equation_everywhere(mut self, source: Field<D>) -> Self {
        self.everywhere = Some(source);
        self
    }

    /// Data with an equation that holds everywhere at these points.
    pub(crate) fn placed(&self, source: &Field<D>, points: &[[f64; D]]) -> Self {
        let f: Vec<f64> = points.iter().map(|x| source.value(*x)).collect();
        Self { everywhere: None, ..self.clone() }.equation(points, &f, Noise::Exact)
    }

    /// Adds measured values of any linear functional of u, as a flux on a boundary.
    pub fn functional(
        self,
        operator: impl Into<Operator<D>>,
        points: &[[f64; D]],
        values: &[f64],
        noise: Noise,
    ) -> Self {
        self.group(Some(operator.into()), points, values, noise, Role::Observed)
    }

    /// Adds imposed values of an operator on u. [`crate::Evidence`] counts them as it does collocation values. A condition with unknown parameters is imposed so, at points of its face.
    ///
    /// ```
    /// use sinew_gp::{Data, Derivative, Domain, Noise, Parameter, Side, field};
    ///
    /// // Through x = 1 heat leaves to air that warms up: u_x + h (u − t) = 0, with an unknown h.
    /// let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    /// let [dx, _] = domain.derivatives();
    /// let h = Parameter::new("h", [0.1, 10.0])?;
    /// let leaving = dx + &h * Derivative::identity() - &h * field(|[_, t]| t);
    /// let face = domain.on_face("x", Side::Upper, 12, 1)?;
    /// let data = Data::new().imposed(leaving, &face, &[0.0; 12], Noise::Exact);
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    pub fn imposed(
        self,
        operator: impl Into<Operator<D>>,
        points: &[[f64; D]],
        values: &[f64],
        noise: Noise,
    ) -> Self {
        self.group(Some(operator.into()), points, values, noise, Role::Imposed)
    }

    /// Adds a measured weighted sum, as the total amount of a solute.
    ///
    /// # Errors
    /// If there are no points, or not as many weights, or one is not finite or zero.
    pub fn integral(self, sum: &Functional<D>, value: f64, noise: Noise) -> Result<Self> {
        self.sum(sum, value, noise, Role::Observed)
    }

    /// Adds a weighted sum that is given rather than measured (see [`Data::imposed`]), as a mean that is known to be zero.
    ///
    /// # Errors
    /// As [`Data::integral`].
    pub fn imposed_integral(self, sum: &Functional<D>, value: f64, noise: Noise) -> Result<Self> {
        self.sum(sum, value, noise, Role::Imposed)
    }

    fn sum(self, functional: &Functional<D>, value: f64, noise: Noise, role: Role) -> Result<Self> {
        let Functional { operator, points, weights } = functional;
        check_lengths(points.len(), weights.len())?;
        ensure!(!points.is_empty(), "{NO_DATA}");
        if let Some(wrong) = weights.iter().find(|w| !w.is_finite() || **w == 0.0) {
            return Err(GpError::Invalid(format!(
                "a weighted sum has the weight {wrong}; leave points of no weight out, and give finite ones"
            )));
        }
        let mut data = self.group(Some(operator.clone()), &[], &[value], noise, role);
        let legs = weights.iter().zip(points).map(|(weight, point)| (*weight, vec![*point]));
        data.groups.last_mut().expect("a group was added").legs = legs.collect();
        Ok(data)
    }

    fn group(
        mut self,
        operator: Option<Operator<D>>,
        points: &[[f64; D]],
        values: &[f64],
        noise: Noise,
        role: Role,
    ) -> Self {
        let (legs, values) = (vec![(1.0, points.to_vec())], values.to_vec());
        self.groups.push(Group { operator, legs, values, noise, role, averages: None });
        self
    }
}

/// Refuses data that are not numbers or not of the domain, before anything is computed with them.
pub(crate) fn check<const D: usize>(groups: &[Group<D>], domain: &Domain<D>) -> Result<()> {
    let empty = |group: &Group<D>| group.points().is_empty() && group.values.is_empty();
    ensure!(!groups.iter().all(empty), "{NO_DATA}");
    for (index, group) in groups.iter().enumerate() {
        // As noises are numbered.
        let number = index + 1;
        check_lengths(group.points().len(), group.values.len())?;
        for (index, value) in group.values.iter().enumerate() {
            let points = || group.legs.iter().map(|(_, points)| &points[index]);
            let coordinates = points().flatten().map(|c| ("point", c));
            for (what, found) in coordinates.chain([("value", value)]) {
                ensure!(
                    found.is_finite(),
                    "{what} number {index} of observation group {number} is {found}; remove it from the data"
                );
            }
        }
        // Points that stand for many may lie anywhere.
        let places = match &group.averages {
            Some(averages) => vec![&averages.places[..]],
            None => group.legs.iter().map(|(_, points)| &points[..]).collect(),
        };
        for (index, point) in places.iter().flat_map(|points| points.iter().enumerate()) {
            // Rounding leaves points of the boundary next to it.
            ensure!(
                domain.contains_within(*point, 1e-9),
                "point {index} of observation group {number} {} lies outside the domain; check its unit, or remove it",
                place(point)
            );
        }
        if let Noise::Learned | Noise::StudentT(_) = group.noise {
            ensure!(
                !group.points().is_empty(),
                "observation group {number} has no points, so that its noise cannot be learned; leave it out"
            );
        }
        match group.noise {
            Noise::Exact if group.operator.is_some() => {
                group.check_contradictions(&format!("observation group {number}"), domain)?;
            }
            Noise::Exact | Noise::Learned => {}
            Noise::Known(sigma) => ensure!(
                (sigma * sigma).is_finite() && sigma > 0.0,
                "noise of standard deviation {sigma:e}; give one above 0 with a finite square, or `Noise::Exact`"
            ),
            Noise::StudentT(freedom) => ensure!(
                freedom.is_finite() && freedom >= 1.0,
                "Student's t with {freedom} degrees of freedom for {}; give 1 or more, as 4",
                noise_name(index)
            ),
        }
    }
    // All groups of the equation have one right-hand side.
    let equation = groups.iter().filter(|g| g.operator.is_none() && g.noise == Noise::Exact);
    let places: Vec<_> = equation.clone().flat_map(|group| group.points()).copied().collect();
    let values: Vec<f64> = equation.flat_map(|group| &group.values).copied().collect();
    let all = Data::new().equation(&places, &values, Noise::Exact);
    all.groups[0].check_contradictions("the equation", domain)
}

/// Name of the noise of a group of observations, by which messages call the group.
pub(crate) fn noise_name(group: usize) -> String {
    format!("noise {}", group + 1)
}

/// Empty data: nothing to condition on.
pub(crate) const NO_DATA: &str = "the model has no observations; add values or an equation";

/// Root of the mean square, also where squares are no numbers; 0 of nothing.
pub(crate) fn root_mean_square(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let of =
        |unit: f64| unit * (values.iter().map(|v| (v / unit).powi(2)).sum::<f64>() / count).sqrt();
    Some(of(1.0))
        .filter(|root| root.is_normal())
        .unwrap_or_else(|| of(largest(values).max(f64::MIN_POSITIVE)))
}

/// Largest magnitude.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Refuses numbers that are not finite, so many of each point.
pub(crate) fn check_finite(what: &str, numbers: &[f64], axes: usize) -> Result<()> {
    for (position, number) in numbers.iter().enumerate() {
        ensure!(
            number.is_finite(),
            "{what} number {} of the prediction is {number}; give a finite one",
            position / axes
        );
    }
    Ok(())
}

/// Relative difference up to which noise-free values of one point are the same.
const SAME: f64 = 1e-8;
/// Slope, in units of the largest value over the domain's size, that no function of a prior has: lengthscales are at least
/// 0.03 of the domain, and this is thirty times what they make of a function of that value.
const STEEPEST: f64 = 1e3;

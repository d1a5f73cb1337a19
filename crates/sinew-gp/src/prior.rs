//! Gaussian-process priors for a problem, with or without its boundary conditions.

pub(crate) mod coefficients;
pub(crate) mod constraint;
pub(crate) mod structure;

use crate::error::place;
use crate::model::data::Group;
use crate::prior::constraint::unconstrained;
use crate::prior::structure::AxisStructure;
use crate::{
    Constraints, Data, Domain, Feature, Field, Formula, Noise, Operator, Problem, Result, Series,
    Side, constraints,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// One summand σ² φ(x) φ(x′) k(x, x′) of a prior's covariance.
#[derive(Clone, Debug)]
pub(crate) struct Part<const D: usize> {
    pub feature: Feature<D>,
    pub kernel: Formula<D>,
}

/// An axis as kernels take it: stretched next to one end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    ends: [f64; 2],
    side: Side,
    width: f64,
}

impl Stretch {
    /// Coordinate that runs between the same ends.
    fn at(&self, x: &Series) -> Series {
        let (end, other) = (self.ends[self.side as usize], self.ends[1 - self.side as usize]);
        let arc = |distance: Series| {
            let sign = if distance.value() < 0.0 { -1.0 } else { 1.0 };
            let distance = distance * (sign / self.width);
            ((distance.squared() + 1.0).sqrt() + distance).ln() * sign
        };
        let whole = ((other - end) / self.width).asinh();
        arc(x - end) * ((other - end) / whole) + end
    }
}

/// A Gaussian-process prior over solutions: three ways to account for boundary conditions behind
/// one interface.
#[derive(Clone, Debug)]
pub struct Prior<const D: usize> {
    pub(crate) domain: Domain<D>,
    pub(crate) equation: Operator<D>,
    pub(crate) mean: Field<D>,
    pub(crate) parts: Vec<Part<D>>,
    pub(crate) boundary: Vec<Group<D>>,
    pub(crate) stretches: [Option<Stretch>; D],
}

/// The prior of a problem and a kernel, with the conditions or without.
type Built<const D: usize> = fn(&Problem<D>, &Formula<D>, bool) -> Result<Prior<D>>;

impl<const D: usize> Prior<D> {
    /// A prior all of whose functions satisfy the conditions exactly (HCGP, Definition 4.4.1 and
    /// §4.7). Traces on faces that the conditions leave free get `kernel` on the face's axes.
    ///
    /// # Errors
    /// If conditions conflict at a corner; if the kernel is too rough for the equation, is along an axis that there is not, or
    /// has a hyperparameter without a range.
    pub fn constrained(problem: &Problem<D>, kernel: &Formula<D>) -> Result<Self> {
        instance!(D, Prior::built, Built<D>)(problem, kernel, true)
    }

    /// A prior that ignores the conditions (UCGP).
    ///
    /// # Errors
    /// If the kernel is too rough for the equation, is along an axis that there is not, or has a hyperparameter without a range.
    pub fn unconstrained(problem: &Problem<D>, kernel: &Formula<D>) -> Result<Self> {
        instance!(D, Prior::built, Built<D>)(problem, kernel, false)
    }

    fn built(problem: &Problem<D>, kernel: &Formula<D>, constrained: bool) -> Result<Self> {
        let Constraints { mean, features } = match constrained {
            true => constraints(problem)?,
            false => unconstrained(),
        };
        kernel.check_declarations(&vec![1.0; kernel.hyperparameters().len()])?;
        kernel.check_smoothness(problem.equation())?;
        check_mean(problem.domain(), &mean)?;
        let (domain, equation) = (problem.domain().clone(), problem.equation().clone());
        let part =
            |feature: Feature<D>| Part { kernel: kernel.clone().along(&feature.axes), feature };
        let parts = features.into_iter().map(part).collect();
        Ok(Self { domain, equation, mean, parts, boundary: Vec::new(), stretches: [None; D] })
    }

    /// A prior whose functions vary within `width` (in the unit of the axis) of one end, and on lengths that grow with the
    /// distance from it farther away: the kernel takes asinh of that distance over `width`. [`crate::Model::fit`] does so by
    /// itself, with a fiftieth of an axis, where that halves the error of the equation.
    ///
    /// ```
    /// use sinew_gp::{Domain, Prior, Problem, Side, squared_exponential};
    ///
    /// let rod = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    /// let [dx, dt] = rod.derivatives();
    /// let prior = Prior::constrained(&Problem::new(rod, dt - dx * dx)?, &squared_exponential())?;
    /// let prior = prior.stretched("t", Side::Lower, 0.02)?; // a start that is soon forgotten
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    ///
    /// # Errors
    /// If there is no such axis, it belongs to a polygon, or the width is not finite and above 0.
    pub fn stretched(mut self, axis: &str, side: Side, width: f64) -> Result<Self> {
        let axis = self.domain.free_axis(axis, "one that does not")?;
        ensure!(
            width.is_finite() && width > 0.0,
            "a stretch of width {width}; give a finite one above 0, in the unit of the axis"
        );
        let ends = self.domain.ends[axis];
        self.stretches[axis] = Some(Stretch { ends, side, width });
        Ok(self)
    }

    /// A point as kernels take it.
    pub(crate) fn seen(&self, mut point: [f64; D]) -> [f64; D] {
        for (x, stretch) in point.iter_mut().zip(&self.stretches) {
            *x = stretch.map_or(*x, |stretch| stretch.at(&Series::number(*x)).value());
        }
        point
    }

    /// A derivative of a latent function as a sum of those in these coordinates, with their factors (Faà di Bruno's formula).
    pub(crate) fn turned(&self, orders: [usize; D], point: &[f64; D]) -> Vec<([usize; D], f64)> {
        let mut sum = vec![(orders, 1.0)];
        for (d, stretch) in self.stretches.iter().enumerate().filter(|(d, _)| orders[*d] > 0) {
            let Some(stretch) = stretch else { continue };
            let stretched = stretch.at(&Series::variable(point[d], 0, &[orders[d]]));
            let (step, mut power) = (&stretched - stretched.value(), stretched.constant(1.0));
            let mut factors = Vec::new();
            for order in 1..=orders[d] {
                power = power * &step / order as f64;
                factors.push((order, power.derivative(&[orders[d]])));
            }
            let each = |(mut orders, known): ([usize; D], f64)| {
                factors.clone().into_iter().map(move |(order, factor)| {
                    orders[d] = order;
                    (orders, known * factor)
                })
            };
            sum = sum.into_iter().flat_map(each).collect();
        }
        sum
    }

    /// The unconstrained prior with about `points` pseudo-observations of the conditions, spread
    /// at random over the faces (PCGP), of periodic axes by the jumps from their lower to their
    /// upper end. Their noise is learned, as in §4.8.2.
    ///
    /// # Errors
    /// As [`Prior::unconstrained`].
    pub fn penalised(
        problem: &Problem<D>,
        kernel: &Formula<D>,
        points: usize,
        seed: u64,
    ) -> Result<Self> {
        let prior = Self::unconstrained(problem, kernel)?;
        let data = Self::pseudo_observations(problem, points, seed)?;
        Ok(Self { boundary: data.groups, ..prior })
    }

    /// The conditions of all faces as observations, about `points` in all.
    fn pseudo_observations(problem: &Problem<D>, points: usize, seed: u64) -> Result<Data<D>> {
        let (domain, mut data) = (problem.domain(), Data::new());
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        if let Some((polygon, value)) = domain.cross_section().zip(problem.boundary.as_ref()) {
            let mut places = domain.sample(points, random.random())?;
            for point in &mut places {
                let edge = random.random_range(0..polygon.corners().len());
                (point[0], point[1]) = polygon.on_edge(edge, random.random_range(0.0..1.0)).into();
            }
            let values: Vec<f64> = places.iter().map(|point| value.value(*point)).collect();
            return Ok(data.imposed(Operator::identity(), &places, &values, Noise::Learned));
        }
        let faces: Vec<_> = (0..D).flat_map(|d| AxisStructure::new(problem, d).lifts).collect();
        let until = |number: usize| points * number / faces.len();
        for (number, lift) in faces.iter().enumerate() {
            let places = domain.sample(until(number + 1) - until(number), random.random())?;
            let to = |side: Side| {
                let mut moved = places.clone();
                moved.iter_mut().for_each(|x| x[lift.axis] = domain.ends[lift.axis][side as usize]);
                moved
            };
            let jump = lift.at.is_none().then(|| (-1.0, to(Side::Lower)));
            let places = to(lift.at.unwrap_or(Side::Upper));
            let values: Vec<f64> = places.iter().map(|point| lift.data.value(*point)).collect();
            data = data.imposed(lift.operator(), &places, &values, Noise::Learned);
            data.groups[number].legs.extend(jump);
        }
        Ok(data)
    }
}

/// Refuses conditions whose formulas are undefined in the domain: places enough to find any that are on a hundredth of it.
fn check_mean<const D: usize>(domain: &Domain<D>, mean: &Field<D>) -> Result<()> {
    const PLACES: usize = 300;
    if mean.is_zero() {
        return Ok(());
    }
    for x in domain.sample(PLACES, 0)? {
        ensure!(
            mean.value(x).is_finite(),
            "the conditions' formulas have no finite value at {}; conditions are continued into the domain, so give formulas that are defined all over it",
            place(&x)
        );
    }
    Ok(())
}

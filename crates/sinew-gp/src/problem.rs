//! A differential equation with its boundary conditions on faces.

pub(crate) mod domain;
pub(crate) mod field;
pub(crate) mod operator;

use crate::{Domain, Field, MOST_DERIVATIVES, Operator, Result, Series, Side, constant, field};

/// A domain, a linear equation on it, and conditions on parts of its boundary.
#[derive(Clone, Debug)]
pub struct Problem<const D: usize> {
    pub(crate) domain: Domain<D>,
    pub(crate) equation: Operator<D>,
    pub(crate) faces: [[Option<Condition<D>>; 2]; D],
    pub(crate) periodic: [Option<Periodicity>; D],
    /// Values on the polygon's edges.
    pub(crate) boundary: Option<Field<D>>,
}

impl<const D: usize> Problem<D> {
    /// The equation `equation` on `domain`, so far without conditions.
    ///
    /// # Errors
    /// If it takes more than [`crate::MOST_DERIVATIVES`] derivatives along an axis.
    pub fn new(domain: Domain<D>, equation: impl Into<Operator<D>>) -> Result<Self> {
        let equation = equation.into();
        equation.check_orders(&domain)?;
        Ok(Self {
            domain,
            equation,
            faces: std::array::from_fn(|_| [None, None]),
            periodic: [None; D],
            boundary: None,
        })
    }

    /// Adds a condition on the face at one end of an axis.
    ///
    /// # Errors
    /// If there is no such axis, it belongs to a polygon, the face has a condition already, a Robin condition has no slope or
    /// factors that are not finite, or derivatives are given twice or of too high an order.
    pub fn condition(mut self, axis: &str, side: Side, condition: Condition<D>) -> Result<Self> {
        let places = self.domain.on_face(axis, side, FACE_PLACES, 0);
        let axis = self.domain.free_axis(axis, ON_EDGES)?;
        let face = self.domain.face(axis, side);
        let place = &mut self.faces[axis][side as usize];
        ensure!(place.is_none() && self.periodic[axis].is_none(), "{face} {TAKEN}");
        *place = Some(condition.checked(&face, &places?)?);
        Ok(self)
    }

    /// Joins the two ends of an axis.
    ///
    /// # Errors
    /// If there is no such axis, it belongs to a polygon, or one of its faces has a condition.
    pub fn periodic(mut self, axis: &str, periodicity: Periodicity) -> Result<Self> {
        let axis = self.domain.free_axis(axis, ON_EDGES)?;
        let free = self.faces[axis].iter().all(Option::is_none) && self.periodic[axis].is_none();
        ensure!(free, "{} {TAKEN}", self.domain.face(axis, Side::Lower));
        self.periodic[axis] = Some(periodicity);
        Ok(self)
    }

    /// Prescribes u on all edges of the polygon, as a function defined on the whole domain: the mean is that function itself.
    ///
    /// Slopes on edges are not offered as conditions; they are imposed at points, without this condition:
    ///
    /// ```
    /// use sinew_gp::{Data, Derivative, Domain, Noise, Problem};
    ///
    /// // A membrane held on two sides of a triangle; ∂u/∂n = 0 on the third, its first edge.
    /// let domain = Domain::polygon(["x", "y"], &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])?;
    /// let [dx, dy] = domain.derivatives();
    /// let triangle = domain.cross_section().unwrap();
    /// let on = |edge: usize| (1..10).map(move |k| triangle.on_edge(edge, f64::from(k) / 10.0));
    /// let held: Vec<[f64; 2]> = on(1).chain(on(2)).collect();
    /// let data = Data::new()
    ///     .imposed(Derivative::identity(), &held, &[0.0; 18], Noise::Exact)
    ///     .imposed(-1.0 * dy, &on(0).collect::<Vec<_>>(), &[0.0; 9], Noise::Exact);
    /// let problem = Problem::new(domain.clone(), -(dx * dx) - dy * dy)?;
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    ///
    /// # Errors
    /// If the domain has no polygon, or its boundary has values already.
    pub fn boundary(mut self, value: Field<D>) -> Result<Self> {
        ensure!(
            self.domain.cross_section().is_some(),
            "the domain has no polygon; give conditions face by face with `Problem::condition`"
        );
        ensure!(self.boundary.is_none(), "the polygon {TAKEN}");
        self.boundary = Some(value);
        Ok(self)
    }

    /// The domain.
    pub fn domain(&self) -> &Domain<D> {
        &self.domain
    }

    /// The differential operator of the equation.
    pub fn equation(&self) -> &Operator<D> {
        &self.equation
    }
}

/// Edges of a polygon, in place of conditions on its axes.
const ON_EDGES: &str = "`Problem::boundary` for values on its edges, `Data::imposed` at points of `Polygon::on_edge` for slopes";

/// Places on a face where conditions are looked at.
const FACE_PLACES: usize = 20;

/// Refusal of a second condition.
const TAKEN: &str = "has a condition already; give value and slope together as a Cauchy condition";

/// A condition on one face of a box. Derivatives are taken along the outward normal n
/// everywhere: at the lower end of an axis ∂u/∂n = −∂u/∂x. Functions do not depend on the coordinate along the face's axis.
///
/// ```
/// use sinew_gp::{Condition, Domain, Problem, Side, constant, field};
///
/// // A strip under load, EI u'''' = q, clamped on the left and resting on a support on the right.
/// let strip = Domain::interval("x", [0.0, 1.0])?;
/// let [dx] = strip.derivatives();
/// let problem = Problem::new(strip.clone(), dx * dx * dx * dx)?
///     .condition("x", Side::Lower, Condition::clamped())?
///     .condition("x", Side::Upper, Condition::simply_supported())?;
///
/// // Heat that leaves through a face more easily above than below: ∂u/∂n + (1 + y) u = 0.
/// let plate = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
/// let [dx, dy] = plate.derivatives();
/// let cooled = Condition::Robin {
///     value_factor: field(|[_, y]| y + 1.0),
///     slope_factor: constant(1.0),
///     data: constant(0.0),
/// };
/// let problem = Problem::new(plate, dx * dx + dy * dy)?.condition("x", Side::Upper, cooled)?;
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone, Debug)]
pub enum Condition<const D: usize> {
    /// u = b (4.33).
    Dirichlet(Field<D>),
    /// ∂u/∂n = c (4.39).
    Neumann(Field<D>),
    /// u = b and ∂u/∂n = c (4.36).
    Cauchy {
        /// Value b.
        value: Field<D>,
        /// Slope c.
        slope: Field<D>,
    },
    /// a u + b ∂u/∂n = c (4.42), with factors that may vary along the face.
    Robin {
        /// Factor a of the value.
        value_factor: Field<D>,
        /// Factor b of the slope; nowhere zero.
        slope_factor: Field<D>,
        /// Right-hand side c.
        data: Field<D>,
    },
    /// Derivatives along n of orders 0 to 3, each once, as u = u″ = 0 at a simple support.
    Derivatives(Vec<(usize, Field<D>)>),
}

/// A functional of u that is given: the factor of u, the order of the derivative that it is the sum of, and its value.
pub(crate) type Imposed<const D: usize> = (Field<D>, usize, Field<D>);

impl<const D: usize> Condition<D> {
    /// Value and rate ∂u/∂t at the beginning of a time axis, that is, at its lower end.
    pub fn initial(value: Field<D>, rate: Field<D>) -> Self {
        let slope = if rate.is_zero() { rate } else { field(move |x| -rate.at(x)) };
        Self::Cauchy { value, slope }
    }

    /// A clamped end: u = u′ = 0.
    pub fn clamped() -> Self {
        Self::Cauchy { value: constant(0.0), slope: constant(0.0) }
    }

    /// A simply supported end: u = u″ = 0.
    pub fn simply_supported() -> Self {
        Self::Derivatives(vec![(0, constant(0.0)), (2, constant(0.0))])
    }

    /// The free end of a beam: u″ = u‴ = 0.
    pub fn free_end() -> Self {
        Self::Derivatives(vec![(2, constant(0.0)), (3, constant(0.0))])
    }

    /// A plane that the problem is symmetric about: u′ = u‴ = 0. Equation, right-hand side and other conditions must be as
    /// symmetric as that.
    pub fn symmetry() -> Self {
        Self::Derivatives(vec![(1, constant(0.0)), (3, constant(0.0))])
    }

    /// Each functional of u that is given, with derivatives along n.
    pub(crate) fn imposed(&self) -> Vec<Imposed<D>> {
        let plain = |order: usize, data: &Field<D>| (constant(0.0), order, data.clone());
        match self {
            Self::Dirichlet(value) => vec![plain(0, value)],
            Self::Neumann(slope) => vec![plain(1, slope)],
            Self::Cauchy { value, slope } => vec![plain(0, value), plain(1, slope)],
            Self::Derivatives(given) => given.iter().map(|(k, data)| plain(*k, data)).collect(),
            Self::Robin { value_factor, data, .. } => vec![(value_factor.clone(), 1, data.clone())],
        }
    }

    /// Number of derivatives, counting the value, that the features must have vanish on the face.
    pub(crate) fn contact(&self) -> usize {
        self.imposed().iter().map(|(_, order, _)| order + 1).max().unwrap_or(0)
    }

    /// The condition with a slope whose factor is one; `places` are some on the face. Refuses numbers that make no condition.
    pub(crate) fn checked(self, face: &str, places: &[[f64; D]]) -> Result<Self> {
        match &self {
            Self::Robin { value_factor: a, slope_factor: b, data } => {
                let first = places.first().map_or(1.0, |x| b.value(*x).signum());
                for (value, slope) in places.iter().map(|x| (a.value(*x), b.value(*x))) {
                    ensure!(
                        value.is_finite() && slope.is_finite() && slope * first > 0.0,
                        "the Robin condition on {face} has value factor {value} and slope factor {slope}; both must be finite, and the slope's nowhere 0 (use Dirichlet)"
                    );
                }
                let over = |part: &Field<D>| match (part.clone(), b.clone()) {
                    (part, _) if part.is_zero() => part,
                    (part, b) => field(move |x: [Series; D]| part.at(x.clone()) / b.at(x)),
                };
                let (value_factor, data) = (over(a), over(data));
                Ok(Self::Robin { value_factor, slope_factor: constant(1.0), data })
            }
            Self::Derivatives(given) => {
                let (most, mut known) = (MOST_DERIVATIVES - 1, Vec::new());
                let advice = format!("give orders from 0 to {most}, each once");
                ensure!(
                    !given.is_empty(),
                    "the derivatives given on {face} have no order; {advice}"
                );
                for (order, _) in given {
                    let new = *order <= most && !known.contains(order);
                    ensure!(new, "the derivatives given on {face} have order {order}; {advice}");
                    known.push(*order);
                }
                Ok(self)
            }
            Self::Dirichlet(_) | Self::Neumann(_) | Self::Cauchy { .. } => Ok(self),
        }
    }
}

/// Quantities that the two ends of a periodic axis share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Periodicity {
    /// Values only.
    Value = 1,
    /// Values and slopes.
    ValueAndSlope = 2,
}

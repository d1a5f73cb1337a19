//! A differential equation with its boundary conditions.

pub(crate) mod condition;
pub(crate) mod domain;
pub(crate) mod field;
pub(crate) mod functional;
pub(crate) mod operator;
pub(crate) mod polygon;

use crate::{Condition, Domain, Field, Operator, Periodicity, Result, Side};

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

//! A differential equation with its boundary conditions.

use crate::condition::{Condition, Periodicity};
use crate::domain::{Domain, Side, no_polygon};
use crate::error::{GpError, Result};
use crate::field::Field;
use crate::operator::Operator;

/// A domain, a linear equation on it, and conditions on parts of its boundary.
#[derive(Clone, Debug)]
pub struct Problem<const D: usize> {
    domain: Domain<D>,
    equation: Operator<D>,
    pub(crate) faces: [[Option<Condition<D>>; 2]; D],
    pub(crate) periodic: [Option<Periodicity>; D],
    /// Conditions on the polygon's edges; empty without any.
    pub(crate) edges: Vec<Option<Condition<D>>>,
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
            edges: Vec::new(),
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
        let place = &mut self.faces[axis][side.index()];
        if place.is_some() || self.periodic[axis].is_some() {
            return Err(over_determined(&face));
        }
        *place = Some(condition.checked(&face, &places?)?);
        Ok(self)
    }

    /// Joins the two ends of an axis.
    ///
    /// # Errors
    /// If there is no such axis, it belongs to a polygon, or one of its faces has a condition.
    pub fn periodic(mut self, axis: &str, periodicity: Periodicity) -> Result<Self> {
        let axis = self.domain.free_axis(axis, ON_EDGES)?;
        if self.faces[axis].iter().any(Option::is_some) || self.periodic[axis].is_some() {
            return Err(over_determined(&self.domain.face(axis, Side::Lower)));
        }
        self.periodic[axis] = Some(periodicity);
        Ok(self)
    }

    /// Prescribes u on all edges of the polygon, as a function defined on the whole domain. The mean
    /// is then that function itself, smoother than what [`Problem::edge`] blends from several.
    ///
    /// # Errors
    /// If the domain has no polygon, or its boundary has values already.
    pub fn boundary(mut self, value: Field<D>) -> Result<Self> {
        let edges = self.domain.cross_section().ok_or_else(no_polygon)?.corners().len();
        if !self.edges.is_empty() {
            return Err(over_determined("the polygon"));
        }
        self.edges = vec![Some(Condition::Dirichlet(value)); edges];
        Ok(self)
    }

    /// Adds a condition on one edge of the polygon. Edge i runs from corner i of
    /// [`crate::Polygon::corners`] to the next; derivatives are taken along its outward normal.
    /// Functions are defined on the whole domain and count on the edge.
    ///
    /// Conditions hold exactly everywhere but at corners. Operators of second and higher order have no limit at
    /// a corner, so keep collocation points off it.
    ///
    /// # Errors
    /// If the domain has no polygon or no such edge, the edge has a condition already, a Robin condition has no slope, factors
    /// that are not finite or one that varies along a third axis, or derivatives of higher order are given.
    pub fn edge(mut self, edge: usize, condition: Condition<D>) -> Result<Self> {
        let edges = self.domain.cross_section().ok_or_else(no_polygon)?.corners().len();
        if edge >= edges {
            return Err(GpError::Problem(format!(
                "there is no edge {edge}; the polygon has {edges}, numbered from 0"
            )));
        }
        let face = format!("edge {edge} of the polygon");
        self.edges.resize(edges, None);
        if self.edges[edge].is_some() {
            return Err(over_determined(&face));
        }
        self.edges[edge] = Some(self.on_edge(edge, condition, &face)?);
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

    /// These conditions on another equation.
    pub(crate) fn with_equation(&self, equation: Operator<D>) -> Result<Self> {
        equation.check_orders(&self.domain)?;
        Ok(Self { equation, ..self.clone() })
    }

    /// A condition on an edge, or the error of one that it cannot carry.
    fn on_edge(&self, edge: usize, condition: Condition<D>, face: &str) -> Result<Condition<D>> {
        if let Condition::Derivatives(_) = condition {
            return Err(GpError::Problem(format!(
                "{face} is given derivatives by their order; on edges of polygons use Dirichlet, Neumann, Cauchy or Robin"
            )));
        }
        let mut places = self.domain.sample(FACE_PLACES, 0)?;
        let polygon = self.domain.cross_section().ok_or_else(no_polygon)?;
        for (k, place) in places.iter_mut().enumerate() {
            let fraction = k as f64 / (FACE_PLACES - 1) as f64;
            (place[0], place[1]) = polygon.on_edge(edge, fraction).into();
        }
        let condition = condition.checked(face, &places)?;
        let Condition::Robin { value_factor, .. } = &condition else { return Ok(condition) };
        let varies = places.iter().any(|place| {
            let mut first = *place;
            first[2..].copy_from_slice(&self.domain.lower()[2..]);
            value_factor.value(*place) != value_factor.value(first)
        });
        match varies {
            false => Ok(condition),
            true => Err(GpError::Problem(format!(
                "the Robin condition on {face} has a factor that varies along the third axis; it may vary along the edge only"
            ))),
        }
    }
}

/// Edges of a polygon, in place of conditions on its axes.
const ON_EDGES: &str = "`Problem::boundary` for all of its edges, `Problem::edge` for one";

/// Places on a face where conditions are looked at.
const FACE_PLACES: usize = 20;

/// A second condition where there is one already.
fn over_determined(face: &str) -> GpError {
    GpError::Problem(format!(
        "{face} has a condition already; give value and slope together as a Cauchy condition"
    ))
}

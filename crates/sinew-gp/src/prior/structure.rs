//! One axis of a constrained prior: what is fixed at its ends, what vanishes there, what is free.

use crate::problem::Imposed;
use crate::{
    Condition, Derivative, Domain, Field, Operator, Problem, Series, Side, constant, field,
};
use nalgebra::DMatrix;

/// A polynomial along one axis, in the coordinate s that runs from 0 at one end to 1 at the other.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    start: f64,
    /// Negative from the upper end.
    length: f64,
    /// Coefficient of sᵏ at position k.
    coefficients: Vec<f64>,
}

impl Shape {
    pub(crate) fn at(&self, x: &Series) -> Series {
        let s = (x - self.start) / self.length;
        let (last, lower) = self.coefficients.split_last().expect("at least a constant");
        lower.iter().rev().fold(x.constant(*last), |sum, c| sum * &s + *c)
    }

    fn scaled(mut self, factor: f64) -> Self {
        self.coefficients.iter_mut().for_each(|c| *c *= factor);
        self
    }

    /// Scaled to largest magnitude one on the axis, by sampling.
    fn normalised(self) -> Self {
        const SAMPLES: usize = 100;
        let values = (0..=SAMPLES).map(|k| {
            let x = Series::number(self.start + self.length * k as f64 / SAMPLES as f64);
            self.at(&x).value().abs()
        });
        let most = values.fold(0.0, f64::max);
        self.scaled(1.0 / most)
    }
}

/// sᵖ (1 − s)^q, scaled to largest value one: a feature that vanishes to order p and q at the ends.
fn bubble<const D: usize>(axis: usize, [lower, upper]: [f64; 2], powers: [usize; 2]) -> Factor<D> {
    let whole = |n: usize| (n as f64).powi(n as i32);
    let largest = whole(powers[0]) * whole(powers[1]) / whole(powers[0] + powers[1]);
    let (length, scale) = (upper - lower, 1.0 / largest);
    let bubble = field(move |x: [Series; D]| {
        // Both factors are exact zeros at their ends.
        let (s, rest) = ((&x[axis] - lower) / length, (upper - &x[axis]) / length);
        s.powi(powers[0]) * rest.powi(powers[1]) * scale
    });
    Factor { field: bubble, free: true, varies: false }
}

/// A shape along an axis times a free function on the face.
fn trace<const D: usize>(axis: usize, shape: Shape) -> Factor<D> {
    let field = field(move |x: [Series; D]| shape.at(&x[axis]));
    Factor { field, free: false, varies: false }
}

/// Condition across one axis, at one end or as the difference between the upper and the lower end: `value` u + ∂ⁿu = `data`, with
/// the derivative of order n along the outward normal of the end, or else along the axis.
#[derive(Clone, Debug)]
pub(crate) struct Lift<const D: usize> {
    pub axis: usize,
    ends: [f64; 2],
    /// `None` for both ends.
    pub at: Option<Side>,
    pub value: Field<D>,
    pub order: usize,
    pub data: Field<D>,
    /// Function that carries the data: one under this functional, zero under the others of the axis.
    pub shape: Shape,
}

impl<const D: usize> Lift<D> {
    /// A side where it looks, to name corners.
    pub(crate) fn side(&self) -> Side {
        self.at.unwrap_or(Side::Lower)
    }

    /// The coordinate of that side.
    pub(crate) fn end(&self) -> f64 {
        self.ends[self.side() as usize]
    }

    /// The side in words.
    pub(crate) fn face(&self, domain: &Domain<D>) -> String {
        domain.face(self.axis, self.side())
    }

    /// `x` moved to a side.
    pub(crate) fn moved(&self, x: &[Series; D], side: Side) -> [Series; D] {
        let mut face = x.clone();
        face[self.axis] = x[self.axis].constant(self.ends[side as usize]);
        face
    }

    /// Sign of the derivative along the normal, in units of that along the axis.
    fn sign(&self) -> f64 {
        if self.at == Some(Side::Lower) { (-1.0_f64).powi(self.order as i32) } else { 1.0 }
    }

    /// The left-hand side as an operator.
    pub(crate) fn operator(&self) -> Operator<D> {
        let mut orders = [0; D];
        orders[self.axis] = self.order;
        let slope = self.sign() * Derivative { orders };
        match self.value.is_zero() {
            true => slope,
            false => self.value.clone() * Derivative::identity() + slope,
        }
    }

    /// Applied to `function`, as a function of the other coordinates of `x`.
    pub(crate) fn apply(&self, function: &Field<D>, x: &[Series; D]) -> Series {
        let on = |side: Side| {
            let x = self.moved(x, side);
            let slope = function.derivative_along(self.axis, self.order, &x) * self.sign();
            match self.value.is_zero() {
                true => slope,
                false => slope + function.at(x.clone()) * self.value.at(x),
            }
        };
        self.at.map_or_else(|| on(Side::Upper) - on(Side::Lower), on)
    }

    /// Whether it commutes with multiplication by `factor`: a function whose derivatives, as many as it takes, vanish there.
    pub(crate) fn lets_pass(&self, factor: &Field<D>, x: &[Series; D]) -> bool {
        let size = factor.at(x.clone()).value().abs();
        let [lower, upper] = self.ends;
        let first = if self.at.is_some() { 1 } else { 0 };
        (first..=self.order).all(|order| {
            let plain = Self { value: constant(0.0), order, ..self.clone() };
            let slope = plain.apply(factor, x).value();
            ((upper - lower).powi(order as i32) * slope).abs() <= 1e-10 * size
        })
    }
}

/// Factor of a free function: of all coordinates, or of those on a face.
pub(crate) struct Factor<const D: usize> {
    pub field: Field<D>,
    /// Whether the function varies along the axis.
    pub free: bool,
    /// Whether the factor's size is not one.
    pub varies: bool,
}

/// One axis: u(x) = known lifts + Σ trace shapes × free functions on the face + bubble × free function.
pub(crate) struct AxisStructure<const D: usize> {
    axis: usize,
    ends: [f64; 2],
    /// Number of derivatives, counting the value, up to which the bubble vanishes at each end.
    contacts: [usize; 2],
    /// The bubble, then the traces.
    pub factors: Vec<Factor<D>>,
    pub lifts: Vec<Lift<D>>,
}

/// Polynomials of a degree below `degrees` that all of the rows annihilate: a basis by ascending degree, each at right angles to
/// those before over [0, 1].
fn annihilated(mut rows: Vec<Vec<f64>>, degrees: usize) -> Vec<Vec<f64>> {
    const RANK: f64 = 1e-9;
    let mut found = Vec::new();
    for count in 1..=degrees {
        // Zero rows make it at least square, so that all right singular vectors are there.
        let entry = |i: usize, j: usize| rows.get(i).map_or(0.0, |row| row[j]);
        let svd = DMatrix::from_fn(rows.len().max(count), count, entry).svd(false, true);
        let (mode, least) = svd.singular_values.argmin();
        let Some(vectors) = svd.v_t.filter(|_| least < RANK) else { continue };
        let polynomial: Vec<f64> = vectors.row(mode).iter().copied().collect();
        let product = |power: usize| {
            polynomial.iter().enumerate().map(|(k, c)| c / (k + power + 1) as f64).sum()
        };
        rows.push((0..degrees).map(product).collect());
        found.push(polynomial);
    }
    found
}

impl<const D: usize> AxisStructure<D> {
    /// Structure of an axis, from the conditions at its two ends, or that they are joined.
    pub(crate) fn new(problem: &Problem<D>, axis: usize) -> Self {
        let ends = problem.domain().ends[axis];
        let conditions = &problem.faces[axis];
        let joined = problem.periodic[axis].map_or(0, |periodicity| periodicity as usize);
        let contacts = match joined {
            0 => conditions.each_ref().map(|c| c.as_ref().map_or(0, Condition::contact)),
            joined => [joined; 2],
        };
        let factors = vec![bubble(axis, ends, contacts)];
        let mut structure = Self { axis, ends, contacts, factors, lifts: Vec::new() };
        for side in Side::BOTH {
            let imposed = conditions[side as usize].iter().flat_map(Condition::imposed);
            imposed.for_each(|imposed| structure.add_lift(Some(side), imposed));
        }
        let equal = |order| (constant(0.0), order, constant(0.0));
        (0..joined).for_each(|order| structure.add_lift(None, equal(order)));
        let sprung = |own: &Option<Condition<D>>| matches!(own, Some(Condition::Robin { .. }));
        match conditions.iter().any(sprung) {
            true => structure.add_nodal_traces(conditions),
            false => structure.add_graded_traces(),
        }
        structure
    }

    fn shape(&self, from: Side, coefficients: Vec<f64>) -> Shape {
        let (start, end) = (self.ends[from as usize], self.ends[1 - from as usize]);
        Shape { start, length: end - start, coefficients }
    }

    /// Carries what is imposed at a side, or between the ends.
    fn add_lift(&mut self, at: Option<Side>, (value, order, data): Imposed<D>) {
        let shape = self.shape_of(at.unwrap_or(Side::Upper), order);
        let lift = Lift { axis: self.axis, ends: self.ends, at, value, order, data, shape };
        self.lifts.push(Lift { shape: lift.shape.clone().scaled(lift.sign()), ..lift });
    }

    /// The derivative of order j along the axis one at an end, other ones zero. Where the other end has conditions, Hermite's
    /// polynomials with the same contact m at both, s^j/j! (1 − s)^m Σ_{k<m−j} C(m − 1 + k, k) s^k: linear ones between two
    /// Dirichlet faces as in Algorithm 3, the cubic blends B⁻ and B⁺ (4.45) with slopes. Powers of s where it has none.
    fn shape_of(&self, side: Side, j: usize) -> Shape {
        let [here, other] = [side as usize, 1 - side as usize].map(|end| self.contacts[end]);
        let contact = if other == 0 { 0 } else { other.max(here) };
        // In the distance s from the end.
        let mut own = vec![0.0; j];
        let kept = if contact == 0 { 1 } else { contact - j };
        let factorial: f64 = (1..=j).map(|k| k as f64).product();
        let mut binomial = 1.0;
        for k in 0..kept {
            own.push(binomial / factorial);
            binomial *= (contact + k) as f64 / (k + 1) as f64;
        }
        for _ in 0..contact {
            own.push(0.0);
            (1..own.len()).rev().for_each(|k| own[k] -= own[k - 1]);
        }
        let shape = self.shape(side, own);
        let scale = shape.length.powi(j as i32);
        shape.scaled(scale)
    }

    /// Whether a factor of the value changes along another axis.
    pub(crate) fn varies(&self, domain: &Domain<D>) -> bool {
        self.lifts.iter().any(|lift| {
            let of = |point| lift.value.at(lift.moved(&Series::plain(point), lift.side())).value();
            let values: Vec<f64> = domain.grid(5).into_iter().map(of).collect();
            let size = values.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            values.iter().any(|a| (a - values[0]).abs() > 1e-12 * size)
        })
    }

    /// Traces of derivatives that conditions leave free: all polynomials of the degree of the blends that satisfy the conditions,
    /// those of low degree first and each at right angles to those before. Whatever a solution has on the faces, such a
    /// function has too, and the equation makes as little of it as can be; Hermite's polynomials for one free derivative each
    /// have derivatives hundreds of times as large, which the prior would have to cancel.
    fn add_graded_traces(&mut self) {
        let degrees = self.contacts[0] + self.contacts[1];
        let (axis, [start, end]) = (self.axis, self.ends);
        let extent = end - start;
        let of_power = |lift: &Lift<D>, power: usize| {
            let power = field(move |x: [Series; D]| ((&x[axis] - start) / extent).powi(power));
            let unit = extent.powi(lift.order as i32);
            unit * lift.apply(&power, &Series::plain([start; D])).value()
        };
        let row = |lift| (0..degrees).map(|power| of_power(lift, power)).collect();
        let conditions = self.lifts.iter().map(row).collect();
        for coefficients in annihilated(conditions, degrees) {
            let shape = self.shape(Side::Lower, coefficients).normalised();
            self.factors.push(trace(axis, shape));
        }
    }

    /// Traces where an end has a spring, one for each free derivative: the spring's factor may vary over the face.
    fn add_nodal_traces(&mut self, conditions: &[Option<Condition<D>>; 2]) {
        let axis = self.axis;
        for (side, condition) in Side::BOTH.into_iter().zip(conditions) {
            let Some(condition) = condition else { continue };
            if let Condition::Robin { value_factor, .. } = condition {
                let sign = if side == Side::Lower { 1.0 } else { -1.0 };
                let (plain, turned) = (self.shape_of(side, 0), self.shape_of(side, 1).scaled(sign));
                let factor = value_factor.clone();
                let trace = field(move |x: [Series; D]| {
                    plain.at(&x[axis]) + turned.at(&x[axis]) * factor.at(x)
                });
                self.factors.push(Factor { field: trace, free: false, varies: true });
                continue;
            }
            let given = condition.imposed();
            let free = |order: &usize| given.iter().all(|(_, known, _)| known != order);
            for order in (0..condition.contact()).filter(free) {
                let shape = self.shape_of(side, order).normalised();
                self.factors.push(trace(axis, shape));
            }
        }
    }
}

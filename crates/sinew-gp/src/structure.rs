//! One axis of a constrained prior: what is fixed at its ends, what vanishes there, what is free.

use crate::condition::{Condition, Periodicity};
use crate::domain::{Domain, Side};
use crate::field::{Field, field};
use crate::operator::{Derivative, Operator};
use crate::problem::Problem;
use crate::series::Series;

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
    let field = (powers != [0, 0]).then_some(bubble);
    Factor { field, free: true, varies: false }
}

/// A shape along an axis times a free function on the face.
fn trace<const D: usize>(axis: usize, shape: Shape) -> Factor<D> {
    let field = field(move |x: [Series; D]| shape.at(&x[axis]));
    Factor { field: Some(field), free: false, varies: false }
}

/// Functional held across one axis: `value` u + `factor` ∂u of some order along the axis at one end, or the difference of this
/// functional between the upper and the lower end.
#[derive(Clone, Debug)]
pub(crate) struct Lift<const D: usize> {
    pub axis: usize,
    ends: [f64; 2],
    /// `None` for both ends.
    pub at: Option<Side>,
    value: Field<D>,
    order: usize,
    factor: f64,
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
        self.ends[self.side().index()]
    }

    /// The side in words.
    pub(crate) fn face(&self, domain: &Domain<D>) -> String {
        domain.face(self.axis, self.side())
    }

    /// Factor of u, if it is not zero.
    pub(crate) fn value_factor(&self) -> Option<&Field<D>> {
        (!self.value.is_zero()).then_some(&self.value)
    }

    /// Operator on u at the end, or at either.
    pub(crate) fn operator(&self) -> Operator<D> {
        let mut derivative = Derivative::identity();
        derivative.orders[self.axis] = self.order;
        let slope = self.factor * derivative;
        match self.value_factor() {
            None => slope,
            Some(value) => value.clone() * Derivative::identity() + slope,
        }
    }

    /// Derivative of the powers of s below `degrees`.
    fn on_powers(&self, degrees: usize) -> Vec<f64> {
        let falling = |k: usize| (0..self.order).map(|j| k as f64 - j as f64).product::<f64>();
        let lower = |k: usize| if k == self.order { falling(k) } else { 0.0 };
        let of = |k: usize| match self.at {
            Some(Side::Lower) => lower(k),
            Some(Side::Upper) => falling(k),
            None => falling(k) - lower(k),
        };
        (0..degrees).map(of).collect()
    }

    /// Applied to `function`, as a function of the other coordinates of `x`.
    pub(crate) fn apply(&self, function: &Field<D>, x: &[Series; D]) -> Series {
        let on =
            |field: &Field<D>, end: f64, order: usize| on_face(field, self.axis, end, order, x);
        if self.at.is_none() {
            return on(function, self.ends[1], self.order) - on(function, self.ends[0], self.order);
        }
        let sum = on(function, self.end(), self.order) * self.factor;
        match self.value_factor() {
            None => sum,
            Some(value) => sum + on(function, self.end(), 0) * on(value, self.end(), 0),
        }
    }

    /// Whether it commutes with multiplication by `factor`: a function whose derivatives, as many as it takes, vanish there.
    pub(crate) fn lets_pass(&self, factor: &Field<D>, x: &[Series; D]) -> bool {
        let size = factor.at(x.clone()).value().abs();
        let none = |value: f64| value.abs() <= 1e-10 * size;
        let at = |end: f64, order: usize| on_face(factor, self.axis, end, order, x).value();
        let [lower, upper] = self.ends;
        match self.at {
            Some(_) => {
                (1..=self.order).all(|k| none((upper - lower).powi(k as i32) * at(self.end(), k)))
            }
            None => (0..=self.order).all(|k| none(at(upper, k) - at(lower, k))),
        }
    }
}

/// The derivative of order `order` along `axis` on the face where that coordinate is `end`.
fn on_face<const D: usize>(
    function: &Field<D>,
    axis: usize,
    end: f64,
    order: usize,
    x: &[Series; D],
) -> Series {
    if order == 0 {
        let mut face = x.clone();
        face[axis] = x[axis].constant(end);
        return function.at(face);
    }
    let mut face = x.each_ref().map(|coordinate| coordinate.lifted(order));
    face[axis] = face[axis].shifted_last_variable(end);
    function.at(face).last_derivative(order)
}

/// Factor of a free function: of all coordinates, or of those on a face.
#[derive(Clone, Debug)]
pub(crate) struct Factor<const D: usize> {
    /// `None` for one.
    pub field: Option<Field<D>>,
    /// Whether the function varies along the axis.
    pub free: bool,
    /// Whether the factor's size is not one.
    pub varies: bool,
}

/// One axis: u(x) = known lifts + Σ trace shapes × free functions on the face + bubble × free function.
#[derive(Clone, Debug)]
pub(crate) struct AxisStructure<const D: usize> {
    /// The bubble, then the traces.
    pub factors: Vec<Factor<D>>,
    pub lifts: Vec<Lift<D>>,
}

/// Shapes with value or slope one at one end of an axis and none at the other.
struct Basis {
    axis: usize,
    ends: [f64; 2],
    contacts: [usize; 2],
}

impl Basis {
    fn shape(&self, from: Side, coefficients: Vec<f64>) -> Shape {
        let [start, end] = match from {
            Side::Lower => self.ends,
            Side::Upper => [self.ends[1], self.ends[0]],
        };
        Shape { start, length: end - start, coefficients }
    }

    /// Functional of a derivative alone.
    fn lift<const D: usize>(&self, at: Option<Side>, order: usize, shape: Shape) -> Lift<D> {
        let (axis, ends, data) = (self.axis, self.ends, Field::zero());
        Lift { axis, ends, at, value: Field::zero(), order, factor: 1.0, data, shape }
    }

    /// The derivative of order j along the axis one at an end, other ones zero. Where the other end has conditions, Hermite's
    /// polynomials with the same contact m at both, s^j/j! (1 − s)^m Σ_{k<m−j} C(m − 1 + k, k) s^k: linear ones between two
    /// Dirichlet faces as in Algorithm 3, the cubic blends B⁻ and B⁺ (4.45) with slopes. Powers of s where it has none.
    fn shape_of(&self, side: Side, j: usize) -> Shape {
        let contact = match self.contacts[1 - side.index()] {
            0 => 0,
            other => other.max(self.contacts[side.index()]),
        };
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
}

/// Polynomials of a degree below `degrees` that all of the rows annihilate: a basis by ascending degree, each at right angles to
/// those before over [0, 1].
fn annihilated(mut rows: Vec<Vec<f64>>, degrees: usize) -> Vec<Vec<f64>> {
    // Reduced echelon form, the lowest power first; a power without a pivot is the leading one of a polynomial.
    let mut pivots: Vec<usize> = Vec::new();
    let mut found: Vec<Vec<f64>> = Vec::new();
    for power in 0..degrees {
        let size = |row: usize| rows[row][power].abs();
        let best = (pivots.len()..rows.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
        let Some(best) = best.filter(|row| size(*row) > 1e-9) else {
            let mut polynomial = vec![0.0; degrees];
            polynomial[power] = 1.0;
            for (row, pivot) in pivots.iter().enumerate() {
                polynomial[*pivot] = -rows[row][power];
            }
            found.push(polynomial);
            continue;
        };
        rows.swap(pivots.len(), best);
        let own = pivots.len();
        let scaled: Vec<f64> = rows[own].iter().map(|entry| entry / rows[own][power]).collect();
        for (number, row) in rows.iter_mut().enumerate() {
            let factor = if number == own { 0.0 } else { row[power] };
            row.iter_mut().zip(&scaled).for_each(|(entry, own)| *entry -= factor * own);
        }
        rows[own] = scaled;
        pivots.push(power);
    }
    let product = |a: &[f64], b: &[f64]| -> f64 {
        let of = |(i, a): (usize, &f64)| -> f64 {
            b.iter().enumerate().map(|(j, b)| a * b / (i + j + 1) as f64).sum()
        };
        a.iter().enumerate().map(of).sum()
    };
    for later in 1..found.len() {
        let (before, rest) = found.split_at_mut(later);
        for lower in before.iter() {
            let share = product(&rest[0], lower) / product(lower, lower);
            rest[0].iter_mut().zip(lower).for_each(|(own, lower)| *own -= share * lower);
        }
    }
    found
}

impl<const D: usize> AxisStructure<D> {
    /// Structure of an axis, from the conditions at its two ends, or that they are joined.
    pub(crate) fn new(problem: &Problem<D>, axis: usize) -> Self {
        let ends = problem.domain().ends(axis);
        let conditions = &problem.faces[axis];
        let contacts = match problem.periodic[axis] {
            None => conditions.each_ref().map(|c| c.as_ref().map_or(0, Condition::contact)),
            Some(Periodicity::Value) => [1, 1],
            Some(Periodicity::ValueAndSlope) => [2, 2],
        };
        let basis = Basis { axis, ends, contacts };
        let mut structure = Self { factors: vec![bubble(axis, ends, contacts)], lifts: Vec::new() };
        for (side, condition) in Side::BOTH.into_iter().zip(conditions) {
            if let Some(condition) = condition {
                structure.add(side, condition, &basis);
            }
        }
        if let Some(periodicity) = problem.periodic[axis] {
            structure.join(&basis, periodicity);
        }
        let sprung =
            |condition: &Option<Condition<D>>| matches!(condition, Some(Condition::Robin { .. }));
        match conditions.iter().any(sprung) {
            true => structure.add_nodal_traces(conditions, &basis),
            false => structure.add_graded_traces(&basis),
        }
        structure
    }

    /// Whether a factor of the value changes along another axis.
    pub(crate) fn varies(&self, domain: &Domain<D>) -> bool {
        self.lifts.iter().any(|lift| {
            let Some(value) = lift.value_factor() else { return false };
            let mut face = domain.grid(5);
            face.iter_mut().for_each(|point| point[lift.axis] = lift.end());
            let values: Vec<f64> = face.into_iter().map(|point| value.value(point)).collect();
            let size = values.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            values.iter().any(|a| (a - values[0]).abs() > 1e-12 * size)
        })
    }

    fn add(&mut self, side: Side, condition: &Condition<D>, basis: &Basis) {
        let outwards = |order: usize| match (side, order % 2) {
            (Side::Lower, 1) => -1.0,
            _ => 1.0,
        };
        // One under the derivative of this order along the outward normal.
        let shape = |order: usize| basis.shape_of(side, order).scaled(outwards(order));
        if let Condition::Robin { value_factor, data, .. } = condition {
            let (value, factor) = (value_factor.clone(), outwards(1));
            let lift = basis.lift(Some(side), 1, shape(1));
            self.lifts.push(Lift { value, factor, data: data.clone(), ..lift });
            return;
        }
        for (order, data) in condition.derivatives() {
            let lift = basis.lift(Some(side), order, shape(order));
            self.lifts.push(Lift { factor: outwards(order), data: data.clone(), ..lift });
        }
    }

    /// Traces of derivatives that conditions leave free: all polynomials of the degree of the blends that satisfy the conditions,
    /// those of low degree first and each at right angles to those before. Whatever a solution has on the faces, such a
    /// function has too, and the equation makes as little of it as can be; Hermite's polynomials for one free derivative each
    /// have derivatives hundreds of times as large, which the prior would have to cancel.
    fn add_graded_traces(&mut self, basis: &Basis) {
        let degrees = basis.contacts[0] + basis.contacts[1];
        let conditions = self.lifts.iter().map(|lift| lift.on_powers(degrees)).collect();
        for coefficients in annihilated(conditions, degrees) {
            self.factors
                .push(trace(basis.axis, basis.shape(Side::Lower, coefficients).normalised()));
        }
    }

    /// Traces where an end has a spring, one for each free derivative: the spring's factor may vary over the face.
    fn add_nodal_traces(&mut self, conditions: &[Option<Condition<D>>; 2], basis: &Basis) {
        for (side, condition) in Side::BOTH.into_iter().zip(conditions) {
            let Some(condition) = condition else { continue };
            if let Condition::Robin { value_factor, .. } = condition {
                let turned = if side == Side::Lower { 1.0 } else { -1.0 };
                let (plain, turned) =
                    (basis.shape_of(side, 0), basis.shape_of(side, 1).scaled(turned));
                let (axis, factor) = (basis.axis, value_factor.clone());
                let trace = field(move |x: [Series; D]| {
                    plain.at(&x[axis]) + turned.at(&x[axis]) * factor.at(x)
                });
                self.factors.push(Factor { field: Some(trace), free: false, varies: true });
                continue;
            }
            let given = condition.derivatives();
            let free = |order: &usize| given.iter().all(|(known, _)| known != order);
            for order in (0..condition.contact()).filter(free) {
                let shape = basis.shape_of(side, order).normalised();
                self.factors.push(trace(basis.axis, shape));
            }
        }
    }

    /// Structure of a periodic axis.
    fn join(&mut self, basis: &Basis, periodicity: Periodicity) {
        self.lifts.push(basis.lift(None, 0, basis.shape_of(Side::Upper, 0)));
        if periodicity == Periodicity::ValueAndSlope {
            self.lifts.push(basis.lift(None, 1, basis.shape_of(Side::Upper, 1)));
        }
    }
}

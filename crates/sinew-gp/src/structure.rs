//! One axis of a constrained prior: what is fixed at its ends, what vanishes there, what is free.

use crate::condition::{Condition, Periodicity};
use crate::domain::{Domain, Side};
use crate::field::Field;
use crate::series::Series;

/// A polynomial along one axis, in the coordinate s that runs from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    lower: f64,
    length: f64,
    /// Coefficient of sᵏ at position k.
    coefficients: Vec<f64>,
}

impl Shape {
    pub(crate) fn at(&self, x: &Series) -> Series {
        let s = (x - self.lower) / self.length;
        let (last, lower) = self.coefficients.split_last().expect("at least a constant");
        lower.iter().rev().fold(x.constant(*last), |sum, c| sum * &s + *c)
    }

    fn scaled(mut self, factor: f64) -> Self {
        self.coefficients.iter_mut().for_each(|c| *c *= factor);
        self
    }

    fn plus(mut self, other: &Self, factor: f64) -> Self {
        self.coefficients.resize(self.coefficients.len().max(other.coefficients.len()), 0.0);
        for (c, o) in self.coefficients.iter_mut().zip(&other.coefficients) {
            *c += factor * o;
        }
        self
    }

    /// Scaled to largest magnitude one on the axis, by sampling.
    fn normalised(self) -> Self {
        const SAMPLES: usize = 100;
        let values = (0..=SAMPLES).map(|k| {
            let [x] = Series::plain([self.lower + self.length * k as f64 / SAMPLES as f64]);
            self.at(&x).value().abs()
        });
        let most = values.fold(0.0, f64::max);
        self.scaled(1.0 / most)
    }
}

/// sᵖ (1 − s)^q, scaled to largest value one: a feature that vanishes to order p and q at the ends.
#[derive(Clone, Debug)]
pub(crate) struct Bubble {
    lower: f64,
    upper: f64,
    powers: [usize; 2],
    scale: f64,
}

impl Bubble {
    fn new([lower, upper]: [f64; 2], powers: [usize; 2]) -> Self {
        let whole = |n: usize| (n as f64).powi(n as i32);
        let largest = whole(powers[0]) * whole(powers[1]) / whole(powers[0] + powers[1]);
        Self { lower, upper, powers, scale: 1.0 / largest }
    }

    pub(crate) fn at(&self, x: &Series) -> Series {
        let length = self.upper - self.lower;
        // Both factors are exact zeros at their ends.
        let (s, rest) = ((x - self.lower) / length, (self.upper - x) / length);
        s.powi(self.powers[0]) * rest.powi(self.powers[1]) * self.scale
    }

    pub(crate) fn is_constant(&self) -> bool {
        self.powers == [0, 0]
    }
}

/// A linear functional of u across one axis.
#[derive(Clone, Debug)]
pub(crate) enum Functional<const D: usize> {
    /// `value` u + `factor` ∂u of the given order along the axis, at one end.
    End { side: Side, value: Field<D>, order: usize, factor: f64 },
    /// Difference between the ends, upper minus lower, of the derivative of this order.
    Jump { order: usize },
}

impl<const D: usize> Functional<D> {
    /// The derivative of some order along the outward normal.
    fn outwards(side: Side, value: Field<D>, order: usize, factor: f64) -> Self {
        let turned = side == Side::Lower && order % 2 == 1;
        Self::End { side, value, order, factor: if turned { -factor } else { factor } }
    }

    /// Applied to `function` along `axis`, as a function of the other coordinates of `x`.
    pub(crate) fn apply(
        &self,
        function: &Field<D>,
        axis: usize,
        ends: [f64; 2],
        x: &[Series; D],
    ) -> Series {
        match self {
            Self::End { side, value, order, factor } => {
                let end = ends[side.index()];
                let sum = on_face(function, axis, end, *order, x) * *factor;
                match value.is_zero() {
                    true => sum,
                    false => {
                        sum + on_face(function, axis, end, 0, x) * on_face(value, axis, end, 0, x)
                    }
                }
            }
            Self::Jump { order } => {
                on_face(function, axis, ends[1], *order, x)
                    - on_face(function, axis, ends[0], *order, x)
            }
        }
    }

    /// Whether it commutes with multiplication by `factor`: a function whose derivatives, as many as it takes, vanish there.
    pub(crate) fn lets_pass(
        &self,
        factor: &Field<D>,
        axis: usize,
        ends: [f64; 2],
        x: &[Series; D],
    ) -> bool {
        let size = factor.at(x.clone()).value().abs();
        let none = |value: f64| value.abs() <= 1e-10 * size;
        let at = |end: f64, order: usize| on_face(factor, axis, end, order, x).value();
        match self {
            Self::End { side, order, .. } => {
                let scale = |k: usize| (ends[1] - ends[0]).powi(k as i32);
                (1..=*order).all(|k| none(scale(k) * at(ends[side.index()], k)))
            }
            Self::Jump { order } => (0..=*order).all(|k| none(at(ends[1], k) - at(ends[0], k))),
        }
    }

    /// A side where it looks, to name corners.
    pub(crate) fn side(&self) -> Side {
        match self {
            Self::End { side, .. } => *side,
            Self::Jump { .. } => Side::Lower,
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
    let lifted = function.at(face);
    // A function that ignores all coordinates may come back as a plain constant.
    let lifted = x[axis].lifted(order).constant(0.0) + lifted;
    lifted.last_derivative(order)
}

/// A functional with prescribed value, and the shape that carries it: one under this functional,
/// zero under the others of the axis.
#[derive(Clone, Debug)]
pub(crate) struct Lift<const D: usize> {
    pub functional: Functional<D>,
    pub data: Field<D>,
    pub shape: Shape,
}

/// What multiplies a free function on a face: a shape along the axis, and where a Robin condition's factor varies, that
/// function of the other coordinates times another shape.
#[derive(Clone, Debug)]
pub(crate) struct Trace<const D: usize> {
    shape: Shape,
    varying: Option<(Field<D>, Shape)>,
}

impl<const D: usize> Trace<D> {
    fn plain(shape: Shape) -> Self {
        Self { shape, varying: None }
    }

    /// Whether its size is not one.
    pub(crate) fn is_varying(&self) -> bool {
        self.varying.is_some()
    }

    pub(crate) fn at(&self, axis: usize, x: &[Series; D]) -> Series {
        let plain = self.shape.at(&x[axis]);
        match &self.varying {
            None => plain,
            Some((factor, shape)) => plain + shape.at(&x[axis]) * factor.at(x.clone()),
        }
    }
}

/// One axis: u(x) = known lifts + Σ trace shapes × free functions on the face + bubble × free function.
#[derive(Clone, Debug)]
pub(crate) struct AxisStructure<const D: usize> {
    pub bubble: Bubble,
    pub traces: Vec<Trace<D>>,
    pub lifts: Vec<Lift<D>>,
}

/// Shapes with value or slope one at one end and none at the other.
struct Basis {
    lower: f64,
    length: f64,
    contacts: [usize; 2],
}

impl Basis {
    fn shape(&self, coefficients: &[f64]) -> Shape {
        Shape { lower: self.lower, length: self.length, coefficients: coefficients.to_vec() }
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
        let scale = self.length.powi(j as i32);
        match side {
            Side::Lower => self.shape(&own).scaled(scale),
            Side::Upper => {
                let turned = if j % 2 == 1 { -scale } else { scale };
                self.shape(&mirrored(&own)).scaled(turned)
            }
        }
    }
}

/// The coefficients of p(1 − s).
fn mirrored(coefficients: &[f64]) -> Vec<f64> {
    let (last, lower) = coefficients.split_last().expect("at least a constant");
    lower.iter().rev().fold(vec![*last], |mut sum, c| {
        // sum · (1 − s) + c
        sum.push(0.0);
        (1..sum.len()).rev().for_each(|k| sum[k] -= sum[k - 1]);
        sum[0] += c;
        sum
    })
}

impl<const D: usize> AxisStructure<D> {
    /// From the conditions at the two ends, or that they are joined.
    pub(crate) fn new(
        ends: [f64; 2],
        conditions: &[Option<Condition<D>>; 2],
        periodic: Option<Periodicity>,
    ) -> Self {
        if let Some(periodicity) = periodic {
            return Self::periodic(ends, periodicity);
        }
        let contacts = conditions.each_ref().map(|c| c.as_ref().map_or(0, Condition::contact));
        let basis = Basis { lower: ends[0], length: ends[1] - ends[0], contacts };
        let mut structure =
            Self { bubble: Bubble::new(ends, contacts), traces: Vec::new(), lifts: Vec::new() };
        for (side, condition) in Side::BOTH.into_iter().zip(conditions) {
            if let Some(condition) = condition {
                structure.add(side, condition, &basis);
            }
        }
        structure
    }

    /// Whether a factor of the value changes along another axis.
    pub(crate) fn varies(&self, domain: &Domain<D>, axis: usize) -> bool {
        self.lifts.iter().any(|lift| {
            let Functional::End { value, side, .. } = &lift.functional else { return false };
            let mut face = domain.grid(5);
            face.iter_mut().for_each(|point| point[axis] = domain.end(axis, *side));
            let values: Vec<f64> = face.into_iter().map(|point| value.value(point)).collect();
            let size = values.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            !value.is_zero() && values.iter().any(|a| (a - values[0]).abs() > 1e-12 * size)
        })
    }

    fn add(&mut self, side: Side, condition: &Condition<D>, basis: &Basis) {
        let outwards = |order: usize| match (side, order % 2) {
            (Side::Lower, 1) => -1.0,
            _ => 1.0,
        };
        // One under the derivative of this order along the outward normal.
        let shape = |order: usize| basis.shape_of(side, order).scaled(outwards(order));
        let mut lift = |order: usize, data: &Field<D>| {
            let functional = Functional::outwards(side, Field::zero(), order, 1.0);
            self.lifts.push(Lift { functional, data: data.clone(), shape: shape(order) });
        };
        match condition {
            Condition::Dirichlet(value) => lift(0, value),
            Condition::Cauchy { value, slope } => {
                lift(0, value);
                lift(1, slope);
            }
            Condition::Derivatives(given) => {
                given.iter().for_each(|(order, data)| lift(*order, data));
                let free = |order: &usize| given.iter().all(|(known, _)| known != order);
                let orders = (0..condition.contact()).filter(free);
                self.traces.extend(orders.map(|order| Trace::plain(shape(order).normalised())));
            }
            Condition::Neumann(slope) => {
                lift(1, slope);
                self.traces.push(Trace::plain(shape(0).normalised()));
            }
            Condition::Robin { value_factor, slope_factor, data } => {
                let functional = Functional::outwards(side, value_factor.clone(), 1, *slope_factor);
                let slope = shape(1).scaled(1.0 / slope_factor);
                self.traces.push(Trace {
                    shape: shape(0),
                    varying: Some((value_factor.clone(), slope.clone().scaled(-1.0))),
                });
                self.lifts.push(Lift { functional, data: data.clone(), shape: slope });
            }
        }
    }

    fn periodic(ends: [f64; 2], periodicity: Periodicity) -> Self {
        let contact = match periodicity {
            Periodicity::Value => 1,
            Periodicity::ValueAndSlope => 2,
        };
        let basis =
            Basis { lower: ends[0], length: ends[1] - ends[0], contacts: [contact, contact] };
        let lift = |order, shape| Lift {
            functional: Functional::Jump { order },
            data: Field::zero(),
            shape,
        };
        let mut structure = Self {
            bubble: Bubble::new(ends, [contact, contact]),
            traces: vec![Trace::plain(basis.shape(&[1.0]))],
            lifts: vec![lift(0, basis.shape_of(Side::Upper, 0))],
        };
        if periodicity == Periodicity::ValueAndSlope {
            let (lower, upper) = (basis.shape_of(Side::Lower, 1), basis.shape_of(Side::Upper, 1));
            structure.traces.push(Trace::plain(lower.plus(&upper, 1.0).normalised()));
            structure.lifts.push(lift(1, upper));
        }
        structure
    }
}

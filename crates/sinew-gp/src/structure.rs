//! One axis of a constrained prior: what is fixed at its ends, what vanishes there, what is free.

use sinew_num::Series;

use crate::condition::{Condition, Periodicity};
use crate::domain::Side;
use crate::field::Field;

/// A polynomial along one axis, in the coordinate s that runs from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    lower: f64,
    length: f64,
    /// Coefficient of sᵏ at position k.
    coefficients: Vec<f64>,
}

impl Shape {
    pub fn at(&self, x: &Series) -> Series {
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

    pub fn at(&self, x: &Series) -> Series {
        let length = self.upper - self.lower;
        // Both factors are exact zeros at their ends.
        let (s, rest) = ((x - self.lower) / length, (self.upper - x) / length);
        s.powi(self.powers[0]) * rest.powi(self.powers[1]) * self.scale
    }

    pub fn is_constant(&self) -> bool {
        self.powers == [0, 0]
    }
}

/// A linear functional of u across one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Functional {
    /// a u + b ∂u/∂x at one end.
    End { side: Side, value: f64, slope: f64 },
    /// Difference between the ends, upper minus lower, of the derivative of this order.
    Jump { order: usize },
}

impl Functional {
    /// Applied to `function` along `axis`, as a function of the other coordinates of `x`.
    pub fn apply<const D: usize>(
        self,
        function: &Field<D>,
        axis: usize,
        ends: [f64; 2],
        x: &[Series; D],
    ) -> Series {
        match self {
            Self::End { side, value, slope } => {
                let end = ends[side.index()];
                let mut sum = x[axis].constant(0.0);
                if value != 0.0 {
                    sum = sum + on_face(function, axis, end, 0, x) * value;
                }
                if slope != 0.0 {
                    sum = sum + on_face(function, axis, end, 1, x) * slope;
                }
                sum
            }
            Self::Jump { order } => {
                on_face(function, axis, ends[1], order, x)
                    - on_face(function, axis, ends[0], order, x)
            }
        }
    }

    /// A side where it looks, to name corners.
    pub fn side(self) -> Side {
        match self {
            Self::End { side, .. } => side,
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
    pub functional: Functional,
    pub data: Field<D>,
    pub shape: Shape,
}

/// One axis: u(x) = known lifts + Σ trace shapes × free functions on the face + bubble × free function.
#[derive(Clone, Debug)]
pub(crate) struct AxisStructure<const D: usize> {
    pub bubble: Bubble,
    pub traces: Vec<Shape>,
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

    /// Value one: the cubic blends B⁻ and B⁺ (4.45), linear ones between two Dirichlet faces as in
    /// Algorithm 3, and a constant where the other end is free.
    fn value(&self, side: Side) -> Shape {
        let lone = self.contacts[1 - side.index()] == 0;
        let cubic = self.contacts.contains(&2);
        match (side, lone, cubic) {
            (_, true, _) => self.shape(&[1.0]),
            (Side::Lower, false, true) => self.shape(&[1.0, 0.0, -3.0, 2.0]),
            (Side::Upper, false, true) => self.shape(&[0.0, 0.0, 3.0, -2.0]),
            (Side::Lower, false, false) => self.shape(&[1.0, -1.0]),
            (Side::Upper, false, false) => self.shape(&[0.0, 1.0]),
        }
    }

    /// Slope one.
    fn slope(&self, side: Side) -> Shape {
        let lone = self.contacts[1 - side.index()] == 0;
        let shape = match (side, lone) {
            (Side::Lower, true) => self.shape(&[0.0, 1.0]),
            (Side::Upper, true) => self.shape(&[-1.0, 1.0]),
            (Side::Lower, false) => self.shape(&[0.0, 1.0, -2.0, 1.0]),
            (Side::Upper, false) => self.shape(&[0.0, 0.0, -1.0, 1.0]),
        };
        shape.scaled(self.length)
    }
}

impl<const D: usize> AxisStructure<D> {
    /// From the conditions at the two ends, or that they are joined.
    pub fn new(
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

    fn add(&mut self, side: Side, condition: &Condition<D>, basis: &Basis) {
        let mut lift = |value, slope, data: &Field<D>, shape| {
            let functional = Functional::End { side, value, slope };
            self.lifts.push(Lift { functional, data: data.clone(), shape });
        };
        match condition {
            Condition::Dirichlet(value) => lift(1.0, 0.0, value, basis.value(side)),
            Condition::Cauchy { value, slope } => {
                lift(1.0, 0.0, value, basis.value(side));
                lift(0.0, 1.0, slope, basis.slope(side));
            }
            other => {
                let Some((a, b, data)) = other.spring() else { return };
                lift(a, b, data, basis.slope(side).scaled(1.0 / b));
                let free = basis.value(side).plus(&basis.slope(side), -a / b);
                self.traces.push(free.normalised());
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
            traces: vec![basis.shape(&[1.0])],
            lifts: vec![lift(0, basis.value(Side::Upper))],
        };
        if periodicity == Periodicity::ValueAndSlope {
            let both = basis.slope(Side::Lower).plus(&basis.slope(Side::Upper), 1.0);
            structure.traces.push(both.normalised());
            structure.lifts.push(lift(1, basis.slope(Side::Upper)));
        }
        structure
    }
}

//! What is known of the solution on a face.

use crate::field::Field;

/// A condition on one face of a box, or one edge of a polygon. On a box, derivatives are taken along
/// the face's axis, in its positive direction on both ends, and functions do not depend on that
/// axis' coordinate; on an edge, derivatives are taken along the outward normal.
#[derive(Clone, Debug)]
pub enum Condition<const D: usize> {
    /// u = b (4.33).
    Dirichlet(Field<D>),
    /// ∂u/∂x = c (4.39).
    Neumann(Field<D>),
    /// u = b and ∂u/∂x = c (4.36).
    Cauchy {
        /// Value b.
        value: Field<D>,
        /// Slope c.
        slope: Field<D>,
    },
    /// a u + b ∂u/∂x = c (4.42).
    Robin {
        /// Factor a of the value.
        value_factor: f64,
        /// Factor b of the slope; not zero.
        slope_factor: f64,
        /// Right-hand side c.
        data: Field<D>,
    },
}

impl<const D: usize> Condition<D> {
    /// Of a condition on the slope: factors of value and slope, and the right-hand side.
    pub(crate) fn spring(&self) -> Option<(f64, f64, &Field<D>)> {
        match self {
            Self::Neumann(slope) => Some((0.0, 1.0, slope)),
            Self::Robin { value_factor, slope_factor, data } => {
                Some((*value_factor, *slope_factor, data))
            }
            Self::Dirichlet(_) | Self::Cauchy { .. } => None,
        }
    }

    /// How many derivatives, counting the value, the features must have vanish on the face.
    pub(crate) fn contact(&self) -> usize {
        match self {
            Self::Dirichlet(_) => 1,
            Self::Neumann(_) | Self::Cauchy { .. } | Self::Robin { .. } => 2,
        }
    }
}

/// What the two ends of a periodic axis share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Periodicity {
    /// Values only.
    Value,
    /// Values and slopes.
    ValueAndSlope,
}

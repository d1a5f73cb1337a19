//! The balance of forces that a solver solves.

use sinew_energy::{Body, ForceBalance, ThetaError};

/// Balance of forces of a [`Body`], whose stable equilibria are the minima of its potential, or of a [`ForceBalance`], which may have none:
/// incompressible bodies by mixed elements, and pressures on surfaces whose rim moves freely. Functions take either by reference.
#[derive(Clone, Copy, Debug)]
pub struct Balance<'p> {
    pub(crate) body: &'p Body,
    pub(crate) whole: Option<&'p ForceBalance>,
}

impl<'p> From<&'p Body> for Balance<'p> {
    fn from(body: &'p Body) -> Self {
        Self { body, whole: None }
    }
}

impl<'p> From<&'p ForceBalance> for Balance<'p> {
    fn from(balance: &'p ForceBalance) -> Self {
        Self { body: &balance.body, whole: Some(balance) }
    }
}

impl<'p> Balance<'p> {
    /// The body; of a balance of forces the part with a potential.
    pub fn body(&self) -> &'p Body {
        self.body
    }

    /// Whether equilibria are those of a potential: no followers with a loose rim and no field of pressure.
    pub fn has_potential(&self) -> bool {
        self.whole.is_none_or(|whole| whole.followers.is_empty() && whole.pressure_field.is_none())
    }

    /// Number of unknown pressures.
    pub(crate) fn pressures(&self) -> usize {
        let field = self.whole.and_then(|whole| whole.pressure_field.as_ref());
        field.map_or(0, |field| field.unknowns)
    }

    /// Checks that θ is one of the body, and of its followers.
    pub(crate) fn check_theta(&self, theta: &[f64]) -> Result<(), ThetaError> {
        self.whole.map_or_else(|| self.body.check_theta(theta), |whole| whole.check_theta(theta))
    }
}

//! The evidence of a model: which one, and its value.

pub(crate) mod factor;
mod gradient;
pub(crate) mod gram;
pub(crate) mod state;

use crate::model::compile::Compiled;
use crate::model::data::{Noise, Role};

/// The density of the data of which a fit takes the maximum and ensembles draw: one for both.
#[doc(alias = "marginal likelihood")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evidence {
    /// ln p(y_u, y_f) (4.18). Unbounded where noise-free collocation is met by the prior mean
    /// itself, be it as θ → 0: a covariance K_ff → 0 then makes the collocation values as likely
    /// as one likes, and u is lost.
    Joint,
    /// ln p(y_u | y_f) + ln p(y_f) / n_f with the number n_f of imposed values: a generalised posterior in which they count
    /// for one value together, that is, at a temperature of n_f.
    UnitInformation,
    /// Unit information where an equation with free parameters is imposed without errors or with known ones, and where values are
    /// measured of one that the prior mean meets by itself (as f = 0 often is); joint elsewhere. [`crate::Model::evidence`] says which.
    ///
    /// Noise-free collocation says of θ how far the true solution is from typical draws of the prior, n_f times
    /// over, not how accurate measurements are: with the joint evidence that makes intervals too narrow.
    #[default]
    Auto,
}

impl Evidence {
    pub(crate) fn resolve<const D: usize>(self, groups: &[Compiled<D>], parameters: usize) -> Self {
        let measured =
            groups.iter().any(|g| g.given.role == Role::Observed && !g.given.values.is_empty());
        let trivial = groups.iter().any(Compiled::is_trivially_satisfied);
        let believed = |group: &Compiled<D>| {
            group.given.role == Role::Imposed
                && matches!(group.given.noise, Noise::Exact | Noise::Known(_))
        };
        match self {
            Self::Auto if parameters > 0 && groups.iter().any(believed) => Self::UnitInformation,
            Self::Auto if trivial && measured => Self::UnitInformation,
            Self::Auto => Self::Joint,
            chosen => chosen,
        }
    }
}

/// An evidence with its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Logarithm of the evidence.
    pub value: f64,
    /// Derivatives of that logarithm in the parameters, each on the scale that it is adjusted on.
    pub gradient: Vec<f64>,
    /// Relative jitter that the factorisation needed.
    pub jitter: f64,
}

//! Guards that keep an energy finite while an emulator is trained on it.

use sinew_num::Scalar;
use std::fmt::Debug;

/// Bounds on the arguments of an energy density.
///
/// The solver uses [`Exact`], which is zero-sized and compiles to nothing; training uses
/// [`Barriers`]. A guard is the identity at every admissible state, and everywhere in what it does not define.
pub trait Guard: Copy + Debug + Send + Sync + 'static {
    /// Guarded `J − 1` from `J − 1`.
    fn volume_change<S: Scalar>(&self, volume_change: S) -> S {
        volume_change
    }
    /// Guarded first invariant, as `I₁ − 3` from `I₁ − 3`.
    fn first_invariant<S: Scalar>(&self, excess: S) -> S {
        excess
    }
    /// Guarded fibre invariant, as `I₄ − 1` from `I₄ − 1`.
    fn fibre_invariant<S: Scalar>(&self, excess: S) -> S {
        excess
    }
    /// Guarded exponent of a Fung-type exponential.
    fn exponent<S: Scalar>(&self, exponent: S) -> S {
        exponent
    }
}

/// No guard: the energy as it is defined, +∞ outside its domain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exact;

impl Guard for Exact {}

/// The barriers of the thesis for training, eqs. (3.17)–(3.19).
///
/// Below `J = volume_ratio_threshold` the volume ratio decays exponentially to
/// `least_volume_ratio` instead of crossing zero; above their thresholds invariants saturate
/// like `tanh`. The exponent is bounded too: with the caps on the invariants alone a
/// Holzapfel–Ogden energy still reaches 5e136 on a tangled mesh.
#[doc(alias = "barrier")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barriers {
    /// J_ch of (3.18): J above it is left alone.
    pub volume_ratio_threshold: f64,
    /// J_min of (3.18): limit of the guarded J as J → −∞.
    pub least_volume_ratio: f64,
    /// I₁ above it saturates.
    pub first_invariant_threshold: f64,
    /// I₄ above it saturates.
    pub fibre_invariant_threshold: f64,
    /// Exponents above it saturate.
    pub exponent_threshold: f64,
}

impl Default for Barriers {
    fn default() -> Self {
        Self {
            volume_ratio_threshold: 0.05,
            least_volume_ratio: 1e-3,
            first_invariant_threshold: 10.0,
            fibre_invariant_threshold: 8.0,
            exponent_threshold: 15.0,
        }
    }
}

/// `z` up to `threshold`, `tanh(z − threshold) + threshold` above, eq. (3.19).
fn saturate<S: Scalar>(z: S, threshold: f64) -> S {
    z.branch_below(threshold, || z.clone(), || (z.clone() - threshold).tanh() + threshold)
}

impl Guard for Barriers {
    fn volume_change<S: Scalar>(&self, volume_change: S) -> S {
        let (threshold, least) = (self.volume_ratio_threshold, self.least_volume_ratio);
        let width = threshold - least;
        let decayed = || {
            // Clamped first, because tensors evaluate both branches, and both must be finite.
            let depth = volume_change.clone().at_most(threshold - 1.0) - (threshold - 1.0);
            (depth * width.recip()).exp() * width + (least - 1.0)
        };
        volume_change.branch_below(threshold - 1.0, decayed, || volume_change.clone())
    }
    fn first_invariant<S: Scalar>(&self, excess: S) -> S {
        saturate(excess, self.first_invariant_threshold - 3.0)
    }
    fn fibre_invariant<S: Scalar>(&self, excess: S) -> S {
        saturate(excess, self.fibre_invariant_threshold - 1.0)
    }
    fn exponent<S: Scalar>(&self, exponent: S) -> S {
        saturate(exponent, self.exponent_threshold)
    }
}

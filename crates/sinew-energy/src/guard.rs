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
/// Below J = 0.05 the volume ratio decays exponentially to 1e-3 instead of crossing zero; above I₁ = 10 and I₄ = 8 invariants saturate
/// like `tanh`. Exponents are bounded by 15 too: with the caps on the invariants alone a
/// Holzapfel–Ogden energy still reaches 5e136 on a tangled mesh.
#[doc(alias = "barrier")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Barriers {}

/// J_ch of (3.18): J above it is left alone.
pub(crate) const VOLUME_RATIO: f64 = 0.05;
/// J_min of (3.18): limit of the guarded J as J → −∞.
const LEAST_VOLUME_RATIO: f64 = 1e-3;
/// I₁ above it saturates.
const FIRST_INVARIANT: f64 = 10.0;
/// I₄ above it saturates.
const FIBRE_INVARIANT: f64 = 8.0;
/// Exponents above it saturate.
const EXPONENT: f64 = 15.0;

/// `z` up to `threshold`, `tanh(z − threshold) + threshold` above, eq. (3.19).
fn saturate<S: Scalar>(z: S, threshold: f64) -> S {
    z.branch_below(threshold, || z.clone(), || (z.clone() - threshold).tanh() + threshold)
}

impl Guard for Barriers {
    fn volume_change<S: Scalar>(&self, volume_change: S) -> S {
        let (threshold, least) = (VOLUME_RATIO, LEAST_VOLUME_RATIO);
        let width = threshold - least;
        let decayed = || {
            // Clamped first, because tensors evaluate both branches, and both must be finite.
            let depth = volume_change.clone().at_most(threshold - 1.0) - (threshold - 1.0);
            (depth * width.recip()).exp() * width + (least - 1.0)
        };
        volume_change.branch_below(threshold - 1.0, decayed, || volume_change.clone())
    }
    fn first_invariant<S: Scalar>(&self, excess: S) -> S {
        saturate(excess, FIRST_INVARIANT - 3.0)
    }
    fn fibre_invariant<S: Scalar>(&self, excess: S) -> S {
        saturate(excess, FIBRE_INVARIANT - 1.0)
    }
    fn exponent<S: Scalar>(&self, exponent: S) -> S {
        saturate(exponent, EXPONENT)
    }
}

//! Solids put together from parts: resistance to changes of shape, to changes of volume, and active stress.

use crate::invariants::MOST_PARAMETERS;
use crate::laws::Penalty;
use crate::{Guard, InvariantLaw, Invariants};
use sinew_num::Scalar;
use std::fmt::Debug;
use std::ops::RangeInclusive;

/// Strain energy density of changes of shape: one part of a [`Solid`].
///
/// A formula in the invariants, which [`Solid`] forms of the isochoric part C̄ = J^(−2/3) C of the strain, or of
/// the whole strain.
pub trait ShapeEnergy<const D: usize>: Clone + Debug + Send + Sync + 'static {
    /// See [`crate::Law::NAME`].
    const NAME: &'static str;
    /// See [`crate::Law::PARAMETERS`].
    const PARAMETERS: &'static [&'static str];

    /// See [`crate::Law::bounds`].
    fn bounds(_index: usize) -> RangeInclusive<f64> {
        crate::law::POSITIVE
    }

    /// Energy density [stress unit of the parameters θ]. The invariants are guarded in J only.
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, D>, guard: &G) -> S;
}

/// Strain energy density of changes of volume: one part of a [`Solid`].
pub trait VolumeEnergy: Clone + Debug + Send + Sync + 'static {
    /// See [`crate::Law::constants`].
    fn constants(&self) -> Vec<(&'static str, f64)>;

    /// See [`crate::Law::with_softer_volume`].
    fn with_softer_volume(&self, _factor: f64) -> Option<Self> {
        None
    }

    /// Energy density \[stress\] as a function of J − 1.
    fn density<S: Scalar>(&self, volume_change: S) -> S;
}

/// Active stress of a material: one part of a [`Solid`].
pub trait ActiveStress<const D: usize>: Clone + Debug + Send + Sync + 'static {
    /// Names of the entries of θ that it reads, which follow those of the shape energy.
    const PARAMETERS: &'static [&'static str];
    /// Whether the part does nothing, so that it need not be computed.
    const NONE: bool = false;

    /// Energy density \[stress\], a function of the whole strain.
    fn density_of<S: Scalar>(&self, parameters: &[S], invariants: &Invariants<S, D>) -> S;
}

/// No active stress: takes no storage and no time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passive;

impl<const D: usize> ActiveStress<D> for Passive {
    const PARAMETERS: &'static [&'static str] = &[];
    const NONE: bool = true;

    #[inline]
    fn density_of<S: Scalar>(&self, _parameters: &[S], invariants: &Invariants<S, D>) -> S {
        invariants.volume_change.constant(0.0)
    }
}

/// Strain that resists changes of shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Strain {
    /// C̄ = J^(−2/3) C, without the change of volume, thesis eq. (3.4).
    #[default]
    Isochoric,
    /// C itself.
    Whole,
}

/// A solid of three parts: material × volume response × active stress.
///
/// ```
/// use sinew_energy::{InvariantLaw, laws::{ActiveTension, HolzapfelOgden}};
///
/// // Myocardium that contracts along its fibres by a tension in θ.
/// let contracting = HolzapfelOgden.nearly_incompressible(25.0).with_active(ActiveTension);
/// fn parameters<L: InvariantLaw<1>>(_: &L) -> &'static [&'static str] { L::PARAMETERS }
/// assert_eq!(parameters(&contracting), ["a", "b", "a_f", "b_f", "T_a"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid<M, V, A = Passive> {
    /// Resistance to changes of shape.
    pub shape: M,
    /// Resistance to changes of volume.
    pub volume: V,
    /// Stress of its own.
    pub active: A,
    /// Strain that `shape` reads.
    pub strain: Strain,
}

/// A solid whose changes of volume cost `½P(J − 1)²`.
pub type NearlyIncompressible<M> = Solid<M, Penalty>;

impl<M, V> Solid<M, V> {
    /// Solid with a shape energy of the isochoric strain, and a volumetric response.
    pub const fn new(shape: M, volume: V) -> Self {
        Self { shape, volume, active: Passive, strain: Strain::Isochoric }
    }
}

impl<M, V, A> Solid<M, V, A> {
    /// Solid with an active stress.
    pub fn with_active<B>(self, active: B) -> Solid<M, V, B> {
        Solid { shape: self.shape, volume: self.volume, active, strain: self.strain }
    }
}

/// One list after another, filled up with empty names.
const fn joined(
    first: &'static [&'static str],
    second: &'static [&'static str],
) -> [&'static str; MOST_PARAMETERS] {
    let mut all = [""; MOST_PARAMETERS];
    let mut i = 0;
    while i < first.len() + second.len() {
        all[i] = if i < first.len() { first[i] } else { second[i - first.len()] };
        i += 1;
    }
    all
}

impl<M: ShapeEnergy<D>, V: VolumeEnergy, A: ActiveStress<D>, const D: usize> InvariantLaw<D>
    for Solid<M, V, A>
{
    const NAME: &'static str = M::NAME;
    const PARAMETERS: &'static [&'static str] = const { &joined(M::PARAMETERS, A::PARAMETERS) }
        .split_at(M::PARAMETERS.len() + A::PARAMETERS.len())
        .0;

    fn bounds(index: usize) -> RangeInclusive<f64> {
        // A tension may vanish or push.
        let active = f64::MIN..=f64::MAX;
        if index < M::PARAMETERS.len() { M::bounds(index) } else { active }
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        self.volume.constants()
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Self> {
        Some(Self { volume: self.volume.with_softer_volume(factor)?, ..self.clone() })
    }

    #[inline]
    fn density_of<S: Scalar, G: Guard>(&self, theta: &[S], i: &Invariants<S, D>, guard: &G) -> S {
        let (of_shape, of_active) = theta.split_at(M::PARAMETERS.len());
        let strain = match self.strain {
            Strain::Isochoric => i.isochoric(guard),
            Strain::Whole => Invariants {
                volume_change: guard.volume_change(i.volume_change.clone()),
                ..i.clone()
            },
        };
        let volume = self.volume.density(strain.volume_change.clone());
        let passive = self.shape.density_of(of_shape, &strain, guard) + volume;
        if A::NONE {
            return passive;
        }
        passive + self.active.density_of(of_active, i)
    }
}

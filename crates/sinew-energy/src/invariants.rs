//! Objective laws: functions of J, I₁ and the strain between material directions.
//!
//! Such a law is one formula in a few scalar arguments. Its stress and tangent follow by the chain
//! rule: Taylor numbers in the arguments (2 for an isotropic law, 3 with fibres, 8 with a whole
//! frame) instead of the nine entries of ∇u, times the arguments' own derivatives in closed form.

use crate::law::finite_or_infinite;
use crate::{Guard, Law, Response};
use sinew_num::{Jet, Mat3, Scalar, Slope, dot3};
use std::fmt::Debug;
use std::ops::RangeInclusive;

/// Arguments of an objective law; all are zero at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Invariants<S, const D: usize> {
    /// `J − 1`.
    pub volume_change: S,
    /// `I₁ − 3`.
    pub first: S,
    /// `d_p·(C − I)d_q` between the material directions, symmetric; `I₄ − 1` on its diagonal.
    pub strain: [[S; D]; D],
}

impl<S: Scalar, const D: usize> Invariants<S, D> {
    /// The invariants of `F = I + H`.
    pub(crate) fn new(displacement_gradient: &Mat3<S>, directions: &[[S; 3]; D]) -> Self {
        let h = displacement_gradient;
        Self {
            volume_change: h.volume_change(),
            first: h.first_invariant_minus_three(),
            strain: directions
                .each_ref()
                .map(|a| directions.each_ref().map(|b| h.strain_between(a, b))),
        }
    }

    /// The invariants of `C̄ = J^(−2/3) C` with the guarded J, which is kept as `volume_change`,
    /// thesis eq. (3.4). The directions must be orthonormal.
    pub(crate) fn isochoric<G: Guard>(&self, guard: &G) -> Self {
        let volume_change = guard.volume_change(self.volume_change.clone());
        let scale = (volume_change.clone().ln_1p() * (-2.0 / 3.0)).exp_m1();
        // x̄ − x₀ = (x − x₀) + x (J^(−2/3) − 1) keeps the digits that x J^(−2/3) − x₀ loses.
        let scaled =
            |excess: &S, rest: f64| excess.clone() + (excess.clone() + rest) * scale.clone();
        let delta = |p, q| if p == q { 1.0 } else { 0.0 };
        Self {
            first: scaled(&self.first, 3.0),
            strain: std::array::from_fn(|p| {
                std::array::from_fn(|q| scaled(&self.strain[p][q], delta(p, q)))
            }),
            volume_change,
        }
    }
}

/// A strain-energy law that is a function of [`Invariants`]; it is a [`Law`] thereby.
pub trait InvariantLaw<const D: usize>: Clone + Debug + Send + Sync + 'static {
    /// See [`Law::NAME`].
    const NAME: &'static str;
    /// See [`Law::PARAMETERS`].
    const PARAMETERS: &'static [&'static str];

    /// See [`Law::bounds`].
    fn bounds(_index: usize) -> RangeInclusive<f64> {
        crate::law::POSITIVE
    }

    /// See [`Law::constants`].
    fn constants(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// See [`Law::with_softer_volume`].
    fn with_softer_volume(&self, _factor: f64) -> Option<Self> {
        None
    }

    /// Energy density [stress unit of the parameters] as a function of the invariants.
    fn density_of<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        invariants: &Invariants<S, D>,
        guard: &G,
    ) -> S;
}

impl<L: InvariantLaw<D>, const D: usize> Law<D> for L {
    const NAME: &'static str = L::NAME;
    const PARAMETERS: &'static [&'static str] = L::PARAMETERS;

    fn bounds(index: usize) -> RangeInclusive<f64> {
        L::bounds(index)
    }

    fn constants(&self) -> Vec<(&'static str, f64)> {
        InvariantLaw::constants(self)
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Self> {
        InvariantLaw::with_softer_volume(self, factor)
    }

    fn density<S: Scalar, G: Guard>(
        &self,
        parameters: &[S],
        displacement_gradient: &Mat3<S>,
        directions: &[[S; 3]; D],
        guard: &G,
    ) -> S {
        self.density_of(parameters, &Invariants::new(displacement_gradient, directions), guard)
    }

    #[inline]
    fn stress<G: Guard>(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &[[f64; 3]; D],
        guard: &G,
    ) -> (f64, Mat3<f64>) {
        let state = State::new(displacement_gradient, directions);
        // Written so that a NaN is inadmissible.
        let admissible = guard.volume_change(state.invariants.volume_change) > -1.0;
        if !admissible {
            return (f64::INFINITY, Mat3::ZERO);
        }
        match const { arguments(D) } {
            2 => stress::<L, G, D, 2>(self, parameters, &state, guard),
            3 => stress::<L, G, D, 3>(self, parameters, &state, guard),
            5 => stress::<L, G, D, 5>(self, parameters, &state, guard),
            _ => stress::<L, G, D, 8>(self, parameters, &state, guard),
        }
    }

    fn response(
        &self,
        parameters: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &[[f64; 3]; D],
    ) -> Response {
        let state = State::new(displacement_gradient, directions);
        let admissible = state.invariants.volume_change > -1.0;
        if !admissible {
            return Response::INADMISSIBLE;
        }
        match const { arguments(D) } {
            2 => response::<L, D, 2>(self, parameters, &state),
            3 => response::<L, D, 3>(self, parameters, &state),
            5 => response::<L, D, 5>(self, parameters, &state),
            _ => response::<L, D, 8>(self, parameters, &state),
        }
    }

    fn stress_rate(
        &self,
        parameters: &[f64],
        rates: &[f64],
        displacement_gradient: &Mat3<f64>,
        directions: &[[f64; 3]; D],
    ) -> Mat3<f64> {
        let state = State::new(displacement_gradient, directions);
        match const { arguments(D) } {
            2 => stress_rate::<L, D, 3>(self, parameters, rates, &state),
            3 => stress_rate::<L, D, 4>(self, parameters, rates, &state),
            5 => stress_rate::<L, D, 6>(self, parameters, rates, &state),
            _ => stress_rate::<L, D, 9>(self, parameters, rates, &state),
        }
    }
}

/// Number of arguments of a law that reads `directions` directions.
const fn arguments(directions: usize) -> usize {
    assert!(directions <= 3, "space has three directions");
    2 + directions * (directions + 1) / 2
}

/// Index of the argument `strain[p][q]`.
fn argument<const D: usize>(p: usize, q: usize) -> usize {
    let (p, q) = if p <= q { (p, q) } else { (q, p) };
    2 + p * D - p * (p + 1) / 2 + q
}

/// The most parameters that a law may have.
pub(crate) const MOST_PARAMETERS: usize = 9;

/// A deformation with the terms of its invariants' derivatives.
struct State<'a, const D: usize> {
    invariants: Invariants<f64, D>,
    /// `F = I + H`.
    deformation: Mat3<f64>,
    /// `cof F = ∂J/∂F`.
    cofactor: Mat3<f64>,
    directions: &'a [[f64; 3]; D],
    /// `F d` of each direction.
    deformed: [[f64; 3]; D],
}

impl<'a, const D: usize> State<'a, D> {
    #[inline]
    fn new(h: &Mat3<f64>, directions: &'a [[f64; 3]; D]) -> Self {
        let minors = h.cofactors();
        let trace = h.trace();
        let determinant = (0..3).map(|j| h[0][j] * minors[0][j]).sum::<f64>();
        let moved = directions.map(|d| h.apply(&d));
        let strain = |p: usize, q: usize| {
            dot3(&directions[p], &moved[q])
                + dot3(&moved[p], &directions[q])
                + dot3(&moved[p], &moved[q])
        };
        let invariants = Invariants {
            volume_change: trace + minors.trace() + determinant,
            first: 2.0 * trace + h.squared_norm(),
            strain: std::array::from_fn(|p| std::array::from_fn(|q| strain(p, q))),
        };
        Self {
            invariants,
            deformation: h.plus_identity(),
            // cof(I + H) = (1 + tr H) I − Hᵀ + cof H.
            cofactor: Mat3::from_fn(|i, j| (1.0 + trace) * delta(i, j) - h[j][i] + minors[i][j]),
            directions,
            deformed: std::array::from_fn(|p| {
                std::array::from_fn(|i| directions[p][i] + moved[p][i])
            }),
        }
    }

    /// The invariants as variables of a Taylor type.
    #[inline]
    fn seeded<S: Copy>(&self, variable: impl Fn(f64, usize) -> S) -> Invariants<S, D> {
        let Invariants { volume_change, first, strain } = self.invariants;
        Invariants {
            volume_change: variable(volume_change, 0),
            first: variable(first, 1),
            strain: std::array::from_fn(|p| {
                std::array::from_fn(|q| variable(strain[p][q], argument::<D>(p, q)))
            }),
        }
    }

    /// `Σ_k weights[k] ∂(argument k)/∂H`.
    #[inline]
    fn pull_back<const K: usize>(&self, weights: &[f64; K]) -> Mat3<f64> {
        let mut result = Mat3::from_fn(|i, j| {
            weights[0] * self.cofactor[i][j] + 2.0 * weights[1] * self.deformation[i][j]
        });
        for p in 0..D {
            for q in p..D {
                let weight = weights[argument::<D>(p, q)];
                let (a, b) = (&self.directions[p], &self.directions[q]);
                let (fa, fb) = (&self.deformed[p], &self.deformed[q]);
                for i in 0..3 {
                    for j in 0..3 {
                        result.0[i][j] += weight * (fa[i] * b[j] + fb[i] * a[j]);
                    }
                }
            }
        }
        result
    }
}

#[inline]
fn stress<L: InvariantLaw<D>, G: Guard, const D: usize, const K: usize>(
    law: &L,
    parameters: &[f64],
    state: &State<D>,
    guard: &G,
) -> (f64, Mat3<f64>) {
    let constants = constants::<L, _, D>(parameters, Slope::<K>::constant);
    let arguments = state.seeded(Slope::<K>::variable);
    let slope = law.density_of(&constants[..L::PARAMETERS.len()], &arguments, guard);
    let stress = state.pull_back(&slope.gradient);
    if !stress.squared_norm().is_finite() {
        return (f64::INFINITY, Mat3::ZERO);
    }
    (finite_or_infinite(slope.value), stress)
}

/// The last variable of the `K` runs along the rates.
fn stress_rate<L: InvariantLaw<D>, const D: usize, const K: usize>(
    law: &L,
    parameters: &[f64],
    rates: &[f64],
    state: &State<D>,
) -> Mat3<f64> {
    let mut moving = constants::<L, _, D>(parameters, Jet::<K>::constant);
    moving.iter_mut().zip(rates).for_each(|(p, rate)| p.gradient[K - 1] = *rate);
    let arguments = state.seeded(Jet::<K>::variable);
    let jet = law.density_of(&moving[..L::PARAMETERS.len()], &arguments, &crate::Exact);
    state.pull_back(&jet.hessian[K - 1])
}

fn response<L: InvariantLaw<D>, const D: usize, const K: usize>(
    law: &L,
    parameters: &[f64],
    state: &State<D>,
) -> Response {
    let constants = constants::<L, _, D>(parameters, Jet::<K>::constant);
    let arguments = state.seeded(Jet::<K>::variable);
    let jet = law.density_of(&constants[..L::PARAMETERS.len()], &arguments, &crate::Exact);
    let stress = state.pull_back(&jet.gradient);
    let tangent = tangent(state, &jet);
    let finite = jet.value.is_finite()
        && stress.squared_norm().is_finite()
        && tangent.as_flattened().iter().all(|t| t.is_finite());
    if finite { Response { energy: jet.value, stress, tangent } } else { Response::INADMISSIBLE }
}

/// `Σ_k Ψ_k ∂²(argument k) + Σ_kl Ψ_kl ∂(argument k) ⊗ ∂(argument l)`.
fn tangent<const D: usize, const K: usize>(state: &State<D>, jet: &Jet<K>) -> [[f64; 9]; 9] {
    let mut tangent = [[0.0; 9]; 9];
    for k in 0..K {
        let unit: [f64; K] = std::array::from_fn(|l| if k == l { 1.0 } else { 0.0 });
        let (left, right) = (state.pull_back(&unit), state.pull_back(&jet.hessian[k]));
        let (left, right) = (left.0.as_flattened(), right.0.as_flattened());
        for row in 0..9 {
            for column in 0..9 {
                tangent[row][column] += left[row] * right[column];
            }
        }
    }
    add_geometric(state, &jet.gradient, &mut tangent);
    tangent
}

/// Adds `Σ_k weights[k] ∂²(argument k)/∂H²`.
fn add_geometric<const D: usize, const K: usize>(
    state: &State<D>,
    weights: &[f64; K],
    tangent: &mut [[f64; 9]; 9],
) {
    state.deformation.add_second_of_determinant(weights[0], tangent);
    // The others are δ_ik times a symmetric matrix in j and l.
    let mut block = Mat3::from_fn(|j, l| 2.0 * weights[1] * delta(j, l));
    for p in 0..D {
        for q in p..D {
            let (a, b) = (&state.directions[p], &state.directions[q]);
            let weight = weights[argument::<D>(p, q)];
            for j in 0..3 {
                for l in 0..3 {
                    block.0[j][l] += weight * (a[j] * b[l] + b[j] * a[l]);
                }
            }
        }
    }
    for row in 0..9 {
        for l in 0..3 {
            tangent[row][3 * (row / 3) + l] += block[row % 3][l];
        }
    }
}

/// The parameters as constants of a Taylor type, without an allocation per cell.
///
/// # Panics
/// If there are too many or too few; [`crate::Body::check_theta`] tells.
#[inline]
fn constants<L: InvariantLaw<D>, S: Copy, const D: usize>(
    parameters: &[f64],
    constant: impl Fn(f64) -> S,
) -> [S; MOST_PARAMETERS] {
    let count = const {
        assert!(L::PARAMETERS.len() <= MOST_PARAMETERS, "raise MOST_PARAMETERS");
        L::PARAMETERS.len()
    };
    assert_eq!(parameters.len(), count, "parameters of the law");
    std::array::from_fn(|i| constant(if i < count { parameters[i] } else { 0.0 }))
}

fn delta(i: usize, j: usize) -> f64 {
    if i == j { 1.0 } else { 0.0 }
}

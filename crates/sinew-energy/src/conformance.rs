//! Conformance tests of strain-energy laws, those of this crate and yours.
//!
//! ```
//! use sinew_energy::{conformance::{Claims, check_law}, laws::NeoHookean};
//!
//! let seed = 1;
//! check_law(&NeoHookean, &[1.0, 2.0], &[], Claims::default(), seed).expect("a law");
//! ```

use crate::guard::VOLUME_RATIO;
use crate::law::{response_by_jets, stress_by_slopes};
use crate::lower::geometry::orthonormalise;
use crate::{Barriers, Exact, Law, Response};
use sinew_num::{Mat3, SplitMix64, dot};
use thiserror::Error;

/// A property of a law that does not hold.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{law}: violated: {property}: found {found:e}, allowed {allowed:e}, at H = ({})", crate::listed(state.0.as_flattened()))]
pub struct Failure {
    /// Name of the law.
    pub law: &'static str,
    /// The property, in words.
    pub property: &'static str,
    /// Displacement gradient where it fails.
    pub state: Mat3<f64>,
    /// The error found.
    pub found: f64,
    /// The error allowed.
    pub allowed: f64,
}

/// Claims of a law beyond being smooth; a hyperelastic solid claims all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Claims {
    /// Without strain there is no stress.
    pub stress_free_at_rest: bool,
    /// Rotating the deformed body changes no energy.
    pub objective: bool,
    /// The energy is +∞ at J ≤ 0.
    pub positive_volume: bool,
}

impl Default for Claims {
    fn default() -> Self {
        Self { stress_free_at_rest: true, objective: true, positive_volume: true }
    }
}

/// Rounding in f64 after some hundred operations, relative.
const ROUNDING: f64 = 1e-12;
/// Step of central differences that balances rounding and truncation in f64.
const STEP: f64 = 1e-5;
/// Error of central differences with [`STEP`], relative to the largest derivative.
const DIFFERENCE: f64 = 1e-6;
/// Strain at which digits are tested: its third power is below, and the rounding errors of F above what is allowed.
const SMALL_STRAIN: f64 = 1e-7;
/// Error of the work of stresses by the trapezoidal rule [relative to stiffness and the third power of the strain]: third derivatives.
const TRAPEZOID: f64 = 100.0;
/// Random states per property.
const SAMPLES: usize = 20;

/// Runs every check on a law with parameters that make sense and unit, perpendicular directions.
///
/// # Errors
/// Every property that does not hold, once per failing state.
pub fn check_law<L: Law<D>, const D: usize>(
    law: &L,
    parameters: &[f64],
    directions: &[[f64; 3]; D],
    claims: Claims,
    seed: u64,
) -> Result<(), Vec<Failure>> {
    let mut suite =
        Suite { law, parameters, directions, claims, stiffness: 1.0, failures: Vec::new() };
    for (index, parameter) in parameters.iter().enumerate() {
        let inside = L::bounds(index).contains(parameter);
        suite.hold("the parameters given lie within the law's bounds", Mat3::ZERO, inside);
    }
    suite.check_rest();
    let mut states = States::new(seed);
    for _ in 0..SAMPLES {
        let h = states.admissible();
        suite.check_rotation(h, states.rotation());
        suite.check_derivatives(h);
        suite.check_digits(states.any(SMALL_STRAIN));
        suite.check_guards(h);
        for size in [1.0, 10.0, 1e3] {
            suite.check_guards(states.any(size));
        }
        for size in [1.0, 30.0, 1e3, 1e30, 1e100, 1e200] {
            suite.check_extremes(states.any(size));
        }
    }
    suite.check_collapse();
    if suite.failures.is_empty() { Ok(()) } else { Err(suite.failures) }
}

struct Suite<'a, L, const D: usize> {
    law: &'a L,
    parameters: &'a [f64],
    directions: &'a [[f64; 3]; D],
    claims: Claims,
    /// Largest entry of the tangent at rest \[stress\]: the scale of absolute tolerances.
    stiffness: f64,
    failures: Vec<Failure>,
}

impl<L: Law<D>, const D: usize> Suite<'_, L, D> {
    /// Records a failure where `found` is above `allowed`, or is NaN.
    fn require(&mut self, property: &'static str, state: Mat3<f64>, found: f64, allowed: f64) {
        let holds = found <= allowed;
        if !holds {
            self.failures.push(Failure { law: L::NAME, property, state, found, allowed });
        }
    }

    fn hold(&mut self, property: &'static str, state: Mat3<f64>, holds: bool) {
        self.require(property, state, f64::from(u8::from(!holds)), 0.0);
    }

    fn stress(&self, h: &Mat3<f64>) -> (f64, Mat3<f64>) {
        self.law.stress(self.parameters, h, self.directions, &Exact)
    }

    fn response(&self, h: &Mat3<f64>) -> Response {
        self.law.response(self.parameters, h, self.directions)
    }

    fn check_rest(&mut self) {
        let rest = self.response(&Mat3::ZERO);
        self.stiffness = norm(rest.tangent.as_flattened());
        let allowed = ROUNDING * self.stiffness;
        self.require("the energy at rest is zero", Mat3::ZERO, rest.energy.abs(), allowed);
        if self.claims.stress_free_at_rest {
            let stress = norm(rest.stress.0.as_flattened());
            self.require("the stress at rest is zero", Mat3::ZERO, stress, allowed);
        }
    }

    fn check_rotation(&mut self, h: Mat3<f64>, rotation: Mat3<f64>) {
        if !self.claims.objective {
            return;
        }
        let (energy, stress) = self.stress(&h);
        let turned = moved(&rotation, &h);
        let (turned_energy, turned_stress) = self.stress(&turned);
        // Rounding of F in the turned state reaches the energy through the stress.
        let scale = self.stiffness + norm(stress.0.as_flattened());
        let error = (turned_energy - energy).abs();
        self.require("rotation leaves the energy alone", h, error, ROUNDING * scale);
        let expected =
            Mat3::from_fn(|i, j| (0..3).map(|k| rotation[i][k] * stress[k][j]).sum::<f64>());
        let error = difference(turned_stress.0.as_flattened(), expected.0.as_flattened());
        let scale = norm(self.response(&h).tangent.as_flattened());
        self.require("rotation turns the stress with it", h, error, ROUNDING * scale);
    }

    fn check_derivatives(&mut self, h: Mat3<f64>) {
        let (parameters, directions) = (self.parameters, self.directions);
        let closed = self.response(&h);
        let (energy, stress) = self.stress(&h);
        let density = self.law.density(parameters, &h, directions, &Exact);
        let jets = response_by_jets(self.law, parameters, &h, directions);
        let slopes = stress_by_slopes(self.law, parameters, &h, directions, &Exact);
        let stiffness = norm(jets.tangent.as_flattened());
        let (allowed, rough) = (ROUNDING * stiffness, DIFFERENCE * stiffness);

        let values = [self.law.energy(parameters, &h, directions, &Exact), energy, closed.energy];
        let error = difference(&values, &[density; 3]);
        self.require("energy, stress and response give the same energy", h, error, allowed);
        for found in [&stress, &closed.stress, &jets.stress] {
            let error = difference(found.0.as_flattened(), slopes.1.0.as_flattened());
            self.require("the stress agrees with Taylor numbers", h, error, allowed);
        }
        let tangent = closed.tangent.as_flattened();
        let error = difference(tangent, jets.tangent.as_flattened());
        self.require("the tangent agrees with jets", h, error, allowed);
        let transposed: [f64; 81] = std::array::from_fn(|k| tangent[9 * (k % 9) + k / 9]);
        let error = difference(tangent, &transposed);
        self.require("the tangent is symmetric", h, error, allowed);

        for entry in 0..9 {
            let up = self.stress(&shifted(&h, entry, STEP));
            let down = self.stress(&shifted(&h, entry, -STEP));
            let slope = (up.0 - down.0) / (2.0 * STEP);
            let error = (slope - stress[entry / 3][entry % 3]).abs();
            self.require("the stress agrees with differences of the energy", h, error, rough);
            let column: [f64; 9] =
                std::array::from_fn(|k| (up.1[k / 3][k % 3] - down.1[k / 3][k % 3]) / (2.0 * STEP));
            let error = difference(&column, &closed.tangent[entry]);
            self.require("the tangent agrees with differences of the stress", h, error, rough);
        }
    }

    /// Written in ∇u the energy loses digits like ε/strain; written in F like ε/strain², which single precision cannot afford.
    fn check_digits(&mut self, h: Mat3<f64>) {
        let (parameters, directions) = (self.parameters, self.directions);
        let work = |at: &Mat3<f64>| {
            let (_, stress) = stress_by_slopes(self.law, parameters, at, directions, &Exact);
            dot(stress.0.as_flattened(), h.0.as_flattened())
        };
        let trapezoid = 0.5 * (work(&Mat3::ZERO) + work(&h));
        let density = self.law.density(parameters, &h, directions, &Exact);
        let allowed = TRAPEZOID * SMALL_STRAIN.powi(3) * self.stiffness;
        let error = (density - trapezoid).abs();
        self.require("the energy keeps its digits at small strain", h, error, allowed);
    }

    fn check_guards(&mut self, h: Mat3<f64>) {
        let barriers = Barriers::default();
        let (energy, stress) = self.law.stress(self.parameters, &h, self.directions, &barriers);
        let finite = energy.is_finite() && norm(stress.0.as_flattened()).is_finite();
        self.hold("guarded energies are finite on a tangled mesh", h, finite);
        let admissible = h.volume_change() > VOLUME_RATIO - 1.0 && h.squared_norm() < 0.25;
        if admissible {
            let exact = self.stress(&h);
            let error = difference(stress.0.as_flattened(), exact.1.0.as_flattened());
            let error = error + (energy - exact.0).abs();
            self.require("guards are the identity at admissible states", h, error, 0.0);
        }
    }

    fn check_extremes(&mut self, h: Mat3<f64>) {
        let (energy, stress) = self.stress(&h);
        let plain = self.law.energy(self.parameters, &h, self.directions, &Exact);
        let response = self.response(&h);
        let energies = [energy, plain, response.energy];
        let (stresses, tangent) = ([stress.0, response.stress.0], response.tangent);
        let derivatives =
            stresses.as_flattened().as_flattened().iter().chain(tangent.as_flattened());
        let nan = energies.iter().chain(derivatives).any(|x| x.is_nan());
        self.hold("nothing is NaN near collapse and overflow", h, !nan);
        let inverted = self.claims.positive_volume && h.volume_change() <= -1.0;
        if inverted {
            let infinite = energies.iter().all(|&x| x == f64::INFINITY);
            self.hold("the energy is infinite at J <= 0", h, infinite);
        }
    }

    /// J → 0⁺ along one axis, along two and all round, then J = 0, J < 0 and NaN.
    fn check_collapse(&mut self) {
        let diagonal = |d: [f64; 3]| Mat3::from_fn(|i, j| if i == j { d[i] - 1.0 } else { 0.0 });
        for exponent in [-1, -2, -4, -8, -16, -100, -300] {
            let s = 10f64.powi(exponent);
            for state in [[s, 1.0, 1.0], [s, s, 1.0], [s; 3], [s, s.recip(), 1.0]] {
                self.check_extremes(diagonal(state));
            }
        }
        for state in [[0.0, 1.0, 1.0], [0.0; 3], [-1.0, 1.0, 1.0], [-1.0; 3], [-1e-9, 2.0, 3.0]] {
            self.check_extremes(diagonal(state));
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut h = Mat3::ZERO;
            h.0[1][2] = value;
            h.0[0][0] = value;
            self.check_extremes(h);
        }
    }
}

/// A stream of random states, the same on every machine.
struct States(SplitMix64);

impl States {
    fn new(seed: u64) -> Self {
        Self(SplitMix64(seed))
    }

    /// Entries up to `size`, so that J may be anything.
    fn any(&mut self, size: f64) -> Mat3<f64> {
        Mat3::from_fn(|_, _| size * self.0.number())
    }

    /// A state that a soft tissue may be in: entries up to 0.15, J between 0.6 and 1.6.
    fn admissible(&mut self) -> Mat3<f64> {
        loop {
            let h = self.any(0.15);
            if (-0.4..0.6).contains(&h.volume_change()) {
                return h;
            }
        }
    }

    /// A rotation of random axes.
    fn rotation(&mut self) -> Mat3<f64> {
        let mut axes = self.any(1.0).0;
        // Once more, for the rounding errors of axes that were nearly parallel.
        (0..2).for_each(|_| _ = orthonormalise(&mut axes));
        let sign = Mat3(axes).determinant().signum();
        Mat3(axes.map(|axis| axis.map(|x| sign * x)))
    }
}

/// `R(I + H) − I`.
fn moved(rotation: &Mat3<f64>, h: &Mat3<f64>) -> Mat3<f64> {
    let f = h.plus_identity();
    Mat3::from_fn(|i, j| {
        (0..3).map(|k| rotation[i][k] * f[k][j]).sum::<f64>() - Mat3::IDENTITY[i][j]
    })
}

/// `h` with `step` added to one entry.
fn shifted(h: &Mat3<f64>, entry: usize, step: f64) -> Mat3<f64> {
    let mut h = *h;
    h.0[entry / 3][entry % 3] += step;
    h
}

/// Largest entry; NaN if one is.
fn norm(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |m: f64, x| if m.is_nan() || x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Largest difference of entries; NaN if one is.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<_> = a.iter().zip(b).map(|(x, y)| x - y).collect();
    norm(&differences)
}

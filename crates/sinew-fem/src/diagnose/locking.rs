//! Locking of linear elements: the displacement that is lost, estimated before a solve from mesh and material alone.
//!
//! The model of the loss was fitted to beams, cubes and ventricles against quadratic tetrahedra:
//! `cargo test --workspace --test fem locking -- --nocapture` (docs/verification.md, "Locking").

mod comparison;
mod model;
mod proportions;

pub use comparison::{FormulationDifference, FormulationError, compare_formulations};
pub use proportions::Proportions;

use model::Model;
use sinew_energy::{Body, ThetaError};
use sinew_mesh::Element;
use sinew_num::Mat3;
use std::fmt;

/// Above this K/μ, linear elements resist bending by their volume: at 5, tetrahedra with three elements through
/// the thickness of a beam lose 13 % of its deflection, with six 6 %.
pub const LARGEST_BULK_TO_SHEAR: f64 = 5.0;
/// Ratio of length and thickness from which on bodies bend rather than shear.
const SLENDER: f64 = 3.0;
/// A smaller share of the displacement is no more than other errors of discretisation.
const LEAST_SHARE: f64 = 0.06;
/// Number of parameters whose ranges are combined in all corners: 1024 evaluations of the law.
const MOST_CORNERS: usize = 10;

/// Locking of the elements of a body, in numbers.
///
/// Its `Display` gives the expected loss of displacement, the cause and a remedy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LockingWarning {
    /// The elements.
    pub element: &'static Element,
    /// Expected loss relative to the displacement of elements that do not lock, 0 to 1; within a factor of two on the
    /// bodies of the fit.
    pub expected_share: f64,
    /// Ratio K/μ of bulk and shear modulus at rest if it exceeds [`LARGEST_BULK_TO_SHEAR`] and no volume ratio
    /// is averaged; +∞ when the material resists changes of volume only.
    pub bulk_to_shear: Option<f64>,
    /// The body's proportions if it is slender and has too few elements through its thickness.
    pub bending: Option<Proportions>,
}

/// Whether the elements of a body are too stiff for it at θ: `None` when they are not, and for quadratic ones.
///
/// - K and μ are estimated from the tangent at rest, `K = I:A:I/9` and `10 μ = tr A − 3K`, which is exact for
///   isotropic laws.
/// - The thickness is four times the volume over the surface, that of a rod, but no more than the least
///   principal extent. A curved shell counts as twice as thick.
/// - The loss is that of beams in bending, reduced for stout bodies. A body in pure tension loses less.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let warning = sinew_fem::locking(&scene.lower()?, &[75.0, 7500.0])?.expect("linear tetrahedra lock");
/// assert!((warning.bulk_to_shear.unwrap() - (100.0 + 2.0 / 3.0)).abs() < 1e-9);
/// // Measured: 12.5 mm of 47.8 mm, so that 74 % are lost.
/// assert!((warning.expected_share / 0.74 - 1.0).abs() < 0.25);
/// eprintln!("{warning}"); // names Scene::averaged() and others
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// θ that makes no sense.
pub fn locking(potential: &Body, theta: &[f64]) -> Result<Option<LockingWarning>, ThetaError> {
    potential.check_theta(theta)?;
    Ok(locking_of(potential, theta, || Proportions::of(potential)))
}

/// Locking at the corner of the ranges of the law's parameters that loses the most.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::{ByYoungPoisson, NeoHookean}};
/// # use sinew_mesh::box_tetrahedra;
/// # let law = ByYoungPoisson(NeoHookean);
/// # let scene = Scene::new(box_tetrahedra([10.0; 3], [3; 3]), law).parameter(Parameter::log("E", "kPa", 1.0..=6.0))
/// #     .parameter(Parameter::log("nu", "1", 0.3..=0.45)).load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
/// #     .support(Support::clamped("x_min"));
/// let warning = sinew_fem::locking_over_ranges(&scene.lower()?)?.expect("nu = 0.45 locks");
/// assert!((warning.bulk_to_shear.unwrap() - 29.0 / 3.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Ranges outside the bounds of the law.
pub fn locking_over_ranges(potential: &Body) -> Result<Option<LockingWarning>, ThetaError> {
    let centre = potential.centre();
    let free = potential.material.parameters().len().min(potential.parameters.len());
    let proportions = Proportions::of(potential);
    let mut worst: Option<LockingWarning> = None;
    for corner in 0..1_usize << free.min(MOST_CORNERS) {
        let mut theta = centre.clone();
        for (bit, parameter) in potential.parameters[..free].iter().enumerate() {
            theta[bit] = parameter.range[corner >> bit.min(MOST_CORNERS - 1) & 1];
        }
        potential.check_theta(&theta)?;
        let found = locking_of(potential, &theta, || proportions);
        let more = |w: &LockingWarning| worst.is_none_or(|o| o.expected_share < w.expected_share);
        worst = found.filter(more).or(worst);
    }
    Ok(worst)
}

/// Locking at a checked θ, with the body's proportions given.
pub(crate) fn locking_of(
    potential: &Body,
    theta: &[f64],
    proportions: impl FnOnce() -> Option<Proportions>,
) -> Option<LockingWarning> {
    let element = potential.element();
    if element.is_quadratic() {
        return None;
    }
    let averaged = !potential.patches.is_empty();
    let ratio = bulk_to_shear(potential, theta).filter(|_| !averaged);
    let bulk_to_shear = ratio.filter(|&ratio| ratio > LARGEST_BULK_TO_SHEAR);
    let body = proportions()?;
    let bending = (body.slenderness > SLENDER).then_some(body);
    if bulk_to_shear.is_none() && bending.is_none() {
        return None;
    }
    let expected_share = Model::of(element, averaged).share(&body, ratio);
    let locks = expected_share >= LEAST_SHARE;
    locks.then_some(LockingWarning { element, expected_share, bulk_to_shear, bending })
}

/// Points of a body at which K/μ is evaluated: one cell may be a scar.
const POINTS: usize = 9;

/// Median of K/μ of the material at rest over points spread over the body; `None` without resistance to changes of volume.
pub(crate) fn bulk_to_shear(potential: &Body, theta: &[f64]) -> Option<f64> {
    let count = potential.volumes.len();
    let points = (0..count).step_by(count.div_ceil(POINTS).max(1));
    let ratios: Option<Vec<f64>> =
        points.map(|point| bulk_to_shear_at(potential, theta, point)).collect();
    let mut ratios = ratios?;
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

fn bulk_to_shear_at(potential: &Body, theta: &[f64], point: usize) -> Option<f64> {
    // A rotation of the directions changes neither K nor the trace.
    let response = potential.material.response(point, potential.law_parameters(theta), &Mat3::ZERO);
    let (tangent, prestress) = (&response.tangent, response.stress.trace());
    let bulk = [0, 4, 8].map(|i| tangent[i][0] + tangent[i][4] + tangent[i][8]);
    // Active stress S adds δ_ik S_jl to the tangent, which is no stiffness of the material.
    let bulk = (bulk.iter().sum::<f64>() - prestress) / 9.0;
    let trace = (0..9).map(|i| tangent[i][i]).sum::<f64>() - 3.0 * prestress;
    let shear = (trace - 3.0 * bulk) / 10.0;
    // Below rounding there is no shear modulus: an ideal fluid.
    let fluid = shear <= f64::EPSILON * bulk;
    (bulk > 0.0 && trace.is_finite()).then_some(if fluid { f64::INFINITY } else { bulk / shear })
}

impl LockingWarning {
    /// Expected loss and its cause, without a remedy.
    pub fn reason(&self) -> String {
        let Self { element, expected_share, bulk_to_shear, bending } = self;
        let lost = 100.0 * expected_share;
        let mut text = format!(
            "linear {} are too stiff here: they are expected to lose {lost:.0} % of the displacement",
            element.plural
        );
        if let Some(ratio) = bulk_to_shear {
            text += &format!("; K/mu = {ratio:.1} is above {LARGEST_BULK_TO_SHEAR}");
        }
        if let Some(Proportions { slenderness, elements_through_thickness: across, .. }) = bending {
            text += &format!(
                "; the body is {slenderness:.1} times as long as thick with {across:.1} elements through its thickness"
            );
        }
        text
    }
}

impl fmt::Display for LockingWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.reason())?;
        if self.bulk_to_shear.is_some() {
            write!(f, "; Scene::averaged() cures the volume")?;
        }
        let quadratic = match self.element.corners {
            8 => "quadratic tetrahedra",
            _ => "mesh.quadratic()",
        };
        write!(f, "; {quadratic} cures both, with Scene::mixed() when nearly incompressible")
    }
}

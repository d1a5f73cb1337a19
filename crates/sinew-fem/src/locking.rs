//! Linear elements that are too stiff: how much is told before a solve, from mesh and material alone.
//!
//! The limits are where elements lose about a tenth of a beam's deflection, by
//! `cargo run -p sinew-fem --example locking -- --thresholds` (docs/design.md, "Elements").

mod proportions;

pub use proportions::Proportions;

use sinew_energy::{Body, ThetaError};
use sinew_mesh::Element;
use sinew_num::Mat3;
use std::fmt;

/// Above this K/μ, linear elements resist bending by their volume: at 5, tetrahedra with three elements through
/// the thickness of a beam lose 13 % of its deflection, with six 6 %.
pub const LARGEST_BULK_TO_SHEAR: f64 = 5.0;
/// From this ratio of length and thickness on, how much is lost in bending hardly depends on it.
const SLENDER: f64 = 3.0;

/// How many elements must lie through the thickness of a slender body, and what was measured.
struct Measured {
    fewest_through_thickness: f64,
    bending: &'static str,
    volume: &'static str,
}

/// Also for triangles, which are as poor: strains are constant in both.
const TETRAHEDRA: Measured = Measured {
    fewest_through_thickness: 6.0,
    bending: "tetrahedra reached 24, 53, 71, 81 and 91 % of a beam's deflection with 1, 2, 3, 4 and 6",
    volume: "tetrahedra reached 87, 77, 46 and 33 % of a beam's deflection at 5, 10, 50 and 100",
};
const HEXAHEDRA: Measured = Measured {
    fewest_through_thickness: 3.0,
    bending: "hexahedra reached 67, 89 and 95 % of a beam's deflection with 1, 2 and 3",
    volume: "hexahedra reached 94, 89, 70 and 59 % of a beam's deflection at 5, 10, 50 and 100",
};

fn measured(element: &Element) -> &'static Measured {
    if element.corners == 8 { &HEXAHEDRA } else { &TETRAHEDRA }
}

/// Elements that are too stiff for this body, with the numbers that say so.
///
/// Its `Display` says how far off such elements were on a beam, and what to use instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LockingWarning {
    /// The elements.
    pub element: &'static Element,
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
///   principal extent. A curved shell counts as twice as thick, so that coarse ones may pass.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let warning = sinew_fem::locking(&scene.lower()?, &[75.0, 7500.0])?.expect("linear tetrahedra lock");
/// assert!((warning.bulk_to_shear.unwrap() - (100.0 + 2.0 / 3.0)).abs() < 1e-9);
/// eprintln!("{warning}"); // names Scene::lower_averaged() and others
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// θ that makes no sense.
pub fn locking(potential: &Body, theta: &[f64]) -> Result<Option<LockingWarning>, ThetaError> {
    potential.check_theta(theta)?;
    Ok(locking_of(potential, theta, || Proportions::of(potential)))
}

/// The same for θ that was checked, with the body's proportions from elsewhere.
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
    let bulk_to_shear =
        bulk_to_shear(potential, theta).filter(|&ratio| !averaged && ratio > LARGEST_BULK_TO_SHEAR);
    let fewest = measured(element).fewest_through_thickness;
    let bending = proportions()
        .filter(|body| body.slenderness > SLENDER && body.elements_through_thickness < fewest);
    let locks = bulk_to_shear.is_some() || bending.is_some();
    locks.then_some(LockingWarning { element, bulk_to_shear, bending })
}

/// K/μ of the tangent at rest; `None` without resistance to changes of volume.
fn bulk_to_shear(potential: &Body, theta: &[f64]) -> Option<f64> {
    let parameters = potential.law_parameters(theta);
    // Turning the directions changes neither K nor the trace: one point speaks for all.
    let response = potential.material.response(0, parameters, &Mat3::ZERO);
    let tangent = &response.tangent;
    let bulk = [0, 4, 8].map(|i| tangent[i][0] + tangent[i][4] + tangent[i][8]);
    let bulk = bulk.iter().sum::<f64>() / 9.0;
    let trace: f64 = (0..9).map(|i| tangent[i][i]).sum();
    let shear = (trace - 3.0 * bulk) / 10.0;
    // Below rounding there is no shear modulus: an ideal fluid.
    let fluid = shear <= f64::EPSILON * bulk;
    (bulk > 0.0 && trace.is_finite()).then_some(if fluid { f64::INFINITY } else { bulk / shear })
}

impl fmt::Display for LockingWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let measured = measured(self.element);
        write!(f, "linear {} are too stiff here", self.element.plural)?;
        if let Some(ratio) = self.bulk_to_shear {
            let (limit, volume) = (LARGEST_BULK_TO_SHEAR, measured.volume);
            write!(f, "; K/mu = {ratio:.1} is above {limit} ({volume}): lower by ")?;
            write!(f, "Scene::lower_averaged()")?;
        }
        if let Some(Proportions { slenderness, elements_through_thickness: across }) = self.bending
        {
            let (fewest, bending) = (measured.fewest_through_thickness, measured.bending);
            write!(f, "; the body is {slenderness:.1} times as long as thick with {across:.1} ")?;
            write!(f, "elements through its thickness, below {fewest} ({bending}): refine")?;
        }
        let quadratic = match self.element.corners {
            8 => "quadratic tetrahedra",
            _ => "mesh.quadratic()",
        };
        write!(f, "; {quadratic} cures both, with Scene::lower_mixed() when nearly incompressible")
    }
}

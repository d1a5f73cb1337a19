//! Locking of linear elements: the displacement that is lost, estimated at an equilibrium by one linear problem in enriched cells.
//!
//! Estimates beside measurements: `cargo xtask measure locking` (docs/design.md, "Elements").

mod comparison;
mod enriched;
mod estimate;

pub use comparison::{FormulationDifference, FormulationError, compare_formulations};

use crate::elements::check::check_state;
use crate::elements::moduli::bulk_to_shear;
use crate::elements::system::System;
use crate::{Options, SolveError, Solver};
use sinew_energy::Body;
use sinew_mesh::Element;
use std::fmt;

/// Above this K/μ, linear elements resist bending by their volume: at 5, tetrahedra with three elements through
/// the thickness of a beam lose 13 % of its deflection, with six 6 %.
pub const LARGEST_BULK_TO_SHEAR: f64 = 5.0;
/// A smaller share of the displacement is no more than other errors of discretisation.
const LEAST_SHARE: f64 = 0.06;

/// Locking of the elements of a body, in numbers.
///
/// Its `Display` gives the expected loss of displacement, the cause and a remedy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LockingWarning {
    /// The elements.
    pub element: &'static Element,
    /// Expected loss relative to the displacement of elements that do not lock; within a factor of two on nearly all bodies of
    /// docs/design.md. 1 where the better elements do not move along with these, so that only most is known to be lost.
    pub expected_share: f64,
    /// Ratio K/μ of bulk and shear modulus at rest if it exceeds [`LARGEST_BULK_TO_SHEAR`] and no volume ratio
    /// is averaged; +∞ when the material resists changes of volume only.
    pub bulk_to_shear: Option<f64>,
}

/// Whether the elements of a body are too stiff for it at an equilibrium \[length\]: `None` when they lose less than 6 % of the
/// displacement, and for quadratic ones.
///
/// The stiffness of quadratic simplices, or of hexahedra with incompatible modes, is taken at the displacement of the linear ones, with a
/// smooth pressure. It gives another response to the loads, by conjugate gradients with the factor of the linear elements. The displacement
/// follows from both by the power of the load that it grows with. A solution or a prediction may be judged; the displacement zero is judged by
/// the response at rest.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_fem::{Options, Solver, locking};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let body = scene.lower()?;
/// let theta = [75.0, 7500.0];
/// let solution = Solver::new(&body)?.solve(&theta, &Options::default())?;
/// let warning = locking(&body, &theta, &solution.displacement)?.expect("linear tetrahedra lock");
/// assert!((warning.bulk_to_shear.unwrap() - (100.0 + 2.0 / 3.0)).abs() < 1e-9);
/// // Measured: 12.5 mm of 47.8 mm, so that 74 % are lost.
/// assert!((warning.expected_share / 0.74 - 1.0).abs() < 0.25);
/// eprintln!("{warning}"); // names Scene::averaged() and others
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// θ or a displacement that are not of the body, a displacement that inverts a cell, a body that is free to move.
pub fn locking(
    body: &Body,
    theta: &[f64],
    displacement: &[f64],
) -> Result<Option<LockingWarning>, SolveError> {
    check_state(body, displacement, theta)?;
    let element = body.element();
    if element.is_quadratic() {
        return Ok(None);
    }
    let expected_share = System::new(body)?.loss(displacement, theta)?;
    let ratio = bulk_to_shear(body, theta).filter(|_| body.patches.is_empty());
    let bulk_to_shear = ratio.filter(|&ratio| ratio > LARGEST_BULK_TO_SHEAR);
    let warning = LockingWarning { element, expected_share, bulk_to_shear };
    Ok((expected_share >= LEAST_SHARE).then_some(warning))
}

/// [`locking`] at the equilibrium in the middle of the ranges of all parameters, which is solved for; at rest where there is none.
///
/// # Errors
/// As for [`locking`].
pub fn locking_at_centre(body: &Body) -> Result<Option<LockingWarning>, SolveError> {
    let theta = body.centre();
    body.check_theta(&theta)?;
    if body.element().is_quadratic() {
        return Ok(None);
    }
    match Solver::new(body)?.solve(&theta, &Options::default()) {
        Ok(solution) => locking(body, &theta, &solution.displacement),
        Err(SolveError::NotConverged(_)) => locking(body, &theta, &vec![0.0; 3 * body.nodes]),
        Err(other) => Err(other),
    }
}

impl LockingWarning {
    /// Expected loss and its cause, without a remedy.
    pub fn reason(&self) -> String {
        let Self { element, expected_share, bulk_to_shear } = self;
        let lost = match *expected_share {
            share if share < 1.0 => format!("{:.0} % of", 100.0 * share),
            _ => "most of".into(),
        };
        let mut text = format!(
            "linear {} are too stiff here: they are expected to lose {lost} the displacement",
            element.plural
        );
        if let Some(ratio) = bulk_to_shear {
            text += &format!("; K/mu = {ratio:.1} is above {LARGEST_BULK_TO_SHEAR}");
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

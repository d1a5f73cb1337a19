//! Locking of linear elements: the displacement that is lost, estimated at an equilibrium by one linear problem in enriched cells, or
//! measured beside a better formulation.
//!
//! Estimates beside measurements: docs/design.md, "Elements".

mod enriched;
mod estimate;

use crate::elements::{System, bulk_to_shear, check_length, check_state};
use crate::linear::difference;
use crate::{Options, Result, SolveError, Solver};
use sinew_energy::Body;
use sinew_energy::metrics::mean_and_largest;
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
/// smooth pressure. It gives another response to the loads, by conjugate gradients that the linear elements precondition. The displacement
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
pub fn locking(body: &Body, theta: &[f64], displacement: &[f64]) -> Result<Option<LockingWarning>> {
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

/// [`locking`] at the equilibrium in the middle of the ranges of all parameters, which is solved for; at rest where there is none, and at rest
/// beside the middle where nothing moves there, as at a pressure of zero.
///
/// # Errors
/// As for [`locking`].
pub fn locking_at_centre(body: &Body) -> Result<Option<LockingWarning>> {
    let theta = body.centre();
    body.check_theta(&theta)?;
    if body.element().is_quadratic() {
        return Ok(None);
    }
    let rest = vec![0.0; 3 * body.nodes];
    match Solver::new(body)?.solve(&theta, &Options::default()) {
        Ok(solution) if solution.displacement == rest => {
            locking(body, &body.beside_centre(), &rest)
        }
        Ok(solution) => locking(body, &theta, &solution.displacement),
        Err(SolveError::NotConverged(_)) => locking(body, &theta, &rest),
        Err(other) => Err(other),
    }
}

impl LockingWarning {
    /// Expected loss and its cause, without a remedy.
    pub fn reason(&self) -> String {
        let Self { element, expected_share, bulk_to_shear } = self;
        let percent = format!("{:.0} % of", 100.0 * expected_share);
        let lost = if *expected_share < 1.0 { &percent } else { "most of" };
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

/// Difference between the solutions of a body in two kinds of elements, at the nodes of the first; the second are the
/// better ones.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulationDifference {
    /// Mean nodal distance \[length\].
    pub mean: f64,
    /// Largest nodal distance \[length\].
    pub largest: f64,
    /// Mean nodal displacement, in the first and in the better elements \[length\].
    pub displacement: [f64; 2],
    /// Name, and volume in the first and in the better elements, of each cavity \[length³\].
    pub cavities: Vec<(String, [f64; 2])>,
    /// Unit of lengths.
    pub length_unit: String,
}

/// Compares a displacement with that of the same body in better elements: quadratic ones with the same nodes first
/// ([`sinew_mesh::TetMesh::quadratic`]).
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{Options, Solver, compare_formulations};
/// # let beam = |mesh| Scene::new(mesh, NeoHookean).parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
/// #     .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0)).load(Load::BodyForce([0.0, 0.0, -9.8e-4]))
/// #     .support(Support::clamped("x_min"));
/// # let quadratic = |mesh| Scene::new(mesh, NeoHookean).parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
/// #     .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0)).load(Load::BodyForce([0.0, 0.0, -9.8e-4]))
/// #     .support(Support::clamped("x_min"));
/// let mesh = sinew_mesh::box_tetrahedra([50.0, 10.0, 10.0], [5, 1, 1]);
/// let bodies = [beam(mesh.clone()).lower()?, quadratic(mesh.quadratic()).lower()?];
/// let mut found = Vec::new();
/// for body in &bodies {
///     found.push(Solver::new(body)?.solve(&[75.0, 75.0], &Options::default())?.displacement);
/// }
/// let difference = compare_formulations(&bodies[0], &found[0], &bodies[1], &found[1])?;
/// assert!(difference.displacement_loss() > 0.5, "{difference}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A displacement that is not of its body, and bodies whose first nodes differ.
pub fn compare_formulations(
    body: &Body,
    displacement: &[f64],
    better: &Body,
    better_displacement: &[f64],
) -> Result<FormulationDifference> {
    check_length(3 * body.nodes, displacement)?;
    check_length(3 * better.nodes, better_displacement)?;
    if !better.positions.starts_with(&body.positions) {
        return Err(SolveError::OtherNodes);
    }
    let other = &better_displacement[..displacement.len()];
    let [mean, largest] = mean_and_largest(&difference(displacement, other));
    let names = body.cavities.iter().map(|cavity| cavity.name.clone());
    let volumes = body.cavity_volumes(displacement).into_iter();
    let volumes = volumes.zip(better.cavity_volumes(better_displacement));
    let cavities = names.zip(volumes.map(<[f64; 2]>::from)).collect();
    let displacement = [displacement, other].map(|u| mean_and_largest(u)[0]);
    let length_unit = body.units.length.clone();
    Ok(FormulationDifference { mean, largest, displacement, cavities, length_unit })
}

impl FormulationDifference {
    /// Loss of mean displacement relative to the better elements; negative if the first ones move farther.
    pub fn displacement_loss(&self) -> f64 {
        let [own, better] = self.displacement;
        if own == better { 0.0 } else { 1.0 - own / better }
    }
}

impl fmt::Display for FormulationDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mean, largest, displacement: [own, better], cavities, length_unit: unit } = self;
        write!(
            f,
            "{mean:.4} {unit} apart in the mean, {largest:.4} {unit} at most; mean displacement {own:.4} instead of {better:.4} \
             {unit}, {:.1} % lost",
            100.0 * self.displacement_loss()
        )?;
        for (name, [own, better]) in cavities {
            write!(f, "; volume of {name} {own:.6e} for {better:.6e} {unit}3")?;
        }
        Ok(())
    }
}

//! Comparison of one body in two formulations.

use crate::linear::vector::difference;
use sinew_energy::Body;
use sinew_energy::metrics::mean_and_largest;
use std::fmt;

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

/// Two solutions that cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct FormulationError(String);

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
) -> Result<FormulationDifference, FormulationError> {
    for (body, displacement) in [(body, displacement), (better, better_displacement)] {
        let (found, nodes) = (displacement.len(), body.nodes);
        if found != 3 * nodes {
            return Err(FormulationError(format!(
                "{found} numbers are not a displacement of {nodes} nodes; give three per node"
            )));
        }
    }
    if !better.positions.starts_with(&body.positions) {
        let reason = "the better body does not begin with the nodes of the first; make its mesh of that one, by `quadratic`";
        return Err(FormulationError(reason.into()));
    }
    let other = &better_displacement[..displacement.len()];
    let [mean, largest] = mean_and_largest(&difference(displacement, other));
    let volumes = body.cavity_volumes(displacement).into_iter();
    let volumes = volumes.zip(better.cavity_volumes(better_displacement));
    let names = body.cavities.iter().map(|cavity| cavity.name.clone());
    Ok(FormulationDifference {
        mean,
        largest,
        displacement: [displacement, other].map(|u| mean_and_largest(u)[0]),
        cavities: names.zip(volumes.map(|(own, better)| [own, better])).collect(),
        length_unit: body.units.length.clone(),
    })
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

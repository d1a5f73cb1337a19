//! Simple shear of every law.

use super::homogeneous::{ELEMENTS, Material, eight_boxes, exponentials, mean_stress};
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Measure, Row, Rows};
use crate::verify::solve::{Found, displaced, with_moved_boundary};
use anyhow::{Context, Result};
use sinew_energy::laws::{ByYoungPoisson, LinearElastic, NeoHookean};

/// Relative: eight digits.
const EIGHT_DIGITS: Band = Band::below(1e-8);
/// Normal of the sliding planes, direction of sliding, name.
const PLANES: [(usize, usize, &str); 3] = [(0, 1, "fs"), (1, 0, "sf"), (1, 2, "sn")];
/// Amounts of shear.
const AMOUNTS: [f64; 3] = [0.3, 0.1, 0.5];

/// Shear stress by normal, direction and amount.
type Stress<'a> = &'a dyn Fn(usize, usize, f64) -> f64;

/// Each law and element under simple shear: the shear stress, from the reactions of a distorted mesh.
pub(super) const CASE: Case = Case {
    name: "shear",
    title: "Simple shear of every law in every element",
    provenance: "Closed forms of the shear stress, which no bulk modulus enters: own code over the invariants, tested \
         against tabulated values; μγ for neo-Hookean and linear bodies.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    let mut judge = |material: &Material, stress: Stress<'_>| -> Result<()> {
        for formulation in ELEMENTS {
            rows.0.push(worst(effort, formulation, material, stress)?);
        }
        Ok(())
    };
    // μ = 2, from E = 5 and ν = 1/4 in the second.
    let linear_in_shear = |_: usize, _: usize, amount: f64| 2.0 * amount;
    let young = ByYoungPoisson(NeoHookean);
    for material in [
        Material::new("neo-Hookean", NeoHookean, &[2.0, 3.0]),
        Material::new("neo-Hookean by E and ν", young, &[5.0, 0.25]),
        Material::new("linear elastic", LinearElastic, &[2.0, 3.0]),
    ] {
        judge(&material, &linear_in_shear)?;
    }
    exponentials().iter().try_for_each(|body| {
        judge(&body.material, &|normal, along, amount| {
            body.reference.shear_stress(normal, along, amount)
        })
    })
}

/// The row of the state with the largest error.
fn worst(
    effort: Effort,
    formulation: Formulation,
    material: &Material,
    stress: Stress<'_>,
) -> Result<Row> {
    let Material { name, theta, .. } = material;
    let mut worst: Option<Row> = None;
    for &amount in effort.levels(1, &AMOUNTS) {
        for &(normal, along, plane) in effort.levels(1, &PLANES) {
            let slide = |x: [f64; 3]| {
                let mut u = [0.0; 3];
                u[along] = amount * x[normal];
                u
            };
            let (mesh, supports) = with_moved_boundary(eight_boxes(formulation), slide);
            let Found { body, solution, cost } =
                displaced(material.scene(mesh, supports), formulation, theta)?;
            let piola = mean_stress(&body, &solution.displacement, theta);
            // σ = PFᵀ with F = I + γ e_along ⊗ e_normal, J = 1.
            let found = piola[normal][along] + amount * piola[normal][normal];
            let setup = format!("{name}, {plane}, γ = {amount}");
            let label = Label::new(formulation, setup, "shear stress [kPa]");
            let pair = [found, stress(normal, along, amount)];
            let row = Row::new(label, Measure::Relative, pair, EIGHT_DIGITS, cost)?;
            if worst.as_ref().is_none_or(|worst| worst.error < row.error) {
                worst = Some(row);
            }
        }
    }
    worst.context("no state to shear")
}

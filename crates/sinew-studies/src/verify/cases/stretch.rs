//! Stretched blocks with free faces, and simple shear, of every law.

use super::homogeneous::{ELEMENTS, Exponential, Material, eight_boxes, exponentials, mean_stress};
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Measure, Row, Rows};
use crate::verify::reference::{Biaxial, Fung, neo_hookean_block};
use crate::verify::solve::{Found, displaced, mixed, with_moved_boundary};
use anyhow::{Context, Result};
use sinew_energy::laws::{ByYoungPoisson, LinearElastic, NeoHookean};
use sinew_energy::{Scene, Support};
use sinew_mesh::AnyMesh;

/// Relative: eight digits.
const EIGHT_DIGITS: Band = Band::below(1e-8);
/// Loads and stretches of the exponential laws; compression of the fibres switches them off.
const STATES: [(Biaxial, f64); 5] = [
    (Biaxial::Along(0), 1.2),
    (Biaxial::Along(1), 1.2),
    (Biaxial::InPlane, 1.1),
    (Biaxial::Along(0), 0.9),
    (Biaxial::Along(1), 0.85),
];
/// λ/μ and stretches of neo-Hookean bars.
const BARS: [(f64, f64); 5] = [(1.0, 1.5), (10.0, 2.0), (1.0, 0.5), (10.0, 0.5), (1.0, 2.0)];

/// A stretched block with its reference.
struct State<'a> {
    material: &'a Material,
    load: Biaxial,
    stretch: f64,
    /// Stretch along the first free axis.
    lateral: f64,
    /// First Piola–Kirchhoff stress along the first loaded axis \[kPa\].
    stress: f64,
}

impl State<'_> {
    fn loaded(&self) -> &'static [usize] {
        match self.load {
            Biaxial::Along(axis) => &[[0], [1], [2]][axis],
            Biaxial::InPlane => &[0, 1],
        }
    }

    fn free(&self) -> usize {
        match self.load {
            Biaxial::Along(axis) => (axis + 1) % 3,
            Biaxial::InPlane => 2,
        }
    }

    fn name(&self) -> String {
        let load = match self.load {
            Biaxial::Along(axis) => format!("along {}", ["x", "y", "z"][axis]),
            Biaxial::InPlane => "in plane".into(),
        };
        format!("{}, {load} by {}", self.material.name, self.stretch)
    }
}

/// Each law and element stretched along one or two axes, the other faces free: stress and lateral stretch.
pub(super) const CASE: Case = Case {
    name: "stretch",
    title: "Uniaxial and equibiaxial stretch of every law in every element, fibres along x",
    provenance: "Scalar equations for the lateral stretches at which the free faces bear no stress: own code in \
         principal stretches, tested against tabulated values; mixed elements against the incompressible limit.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    let uniaxial = effort.levels(2, &BARS).iter().map(|&bar| (Biaxial::Along(0), 1, bar));
    let equibiaxial = [1.0, 10.0].map(|lame| (Biaxial::InPlane, 2, (lame, 1.3)));
    for (load, loaded, (lame, stretch)) in uniaxial.chain(equibiaxial) {
        let name = format!("neo-Hookean, λ/μ = {lame}");
        let material = &Material::new(name, NeoHookean, &[1.0, lame]);
        let [lateral, stress] = neo_hookean_block(lame, loaded, stretch)?;
        compare_all(rows, &State { material, load, stretch, lateral, stress })?;
    }
    exponentials().iter().try_for_each(|body| exponential(rows, effort, body))
}

fn exponential(rows: &mut Rows, effort: Effort, body: &Exponential) -> Result<()> {
    for &(load, stretch) in effort.levels(1, &STATES) {
        let is_squeezed = load == Biaxial::Along(0) && stretch < 1.0;
        if is_squeezed && matches!(body.reference, Fung::ThesisCode(_)) {
            // Fibres that bear compression buckle: the homogeneous state is not a minimum.
            continue;
        }
        let material = &body.material;
        let mut state = State { material, load, stretch, lateral: 0.0, stress: 0.0 };
        let (loaded, free) = (state.loaded()[0], state.free());
        let block = body.reference.nearly_incompressible(body.bulk, load, stretch)?;
        let volume: f64 = block.stretches.iter().product();
        state.lateral = block.stretches[free];
        state.stress = block.stress[loaded] * volume / stretch;
        compare_all(rows, &state)?;
        let block = body.reference.incompressible(load, stretch)?;
        (state.lateral, state.stress) = (block.stretches[free], block.stress[loaded] / stretch);
        compare(rows, Formulation::Mixed, &state)?;
    }
    Ok(())
}

fn compare_all(rows: &mut Rows, state: &State<'_>) -> Result<()> {
    ELEMENTS.into_iter().try_for_each(|formulation| compare(rows, formulation, state))
}

/// A block on rollers, stretched.
fn block(mesh: AnyMesh, state: &State<'_>) -> Scene {
    let along = |axis: usize, by: f64| std::array::from_fn(|i| (i == axis).then_some(by));
    let name = |axis: usize, end: &str| format!("{}_{end}", ["x", "y", "z"][axis]);
    let mut supports: Vec<_> =
        (0..3).map(|axis| Support::uniform(name(axis, "min"), along(axis, 0.0))).collect();
    for &axis in state.loaded() {
        supports.push(Support::uniform(name(axis, "max"), along(axis, state.stretch - 1.0)));
    }
    state.material.scene(mesh, supports)
}

fn compare(rows: &mut Rows, formulation: Formulation, state: &State<'_>) -> Result<()> {
    let (scene, theta) = (block(eight_boxes(formulation), state), &state.material.theta);
    let loaded = state.loaded()[0];
    let found = match formulation {
        Formulation::Mixed => mixed(scene, 0.0, theta)?,
        _ => displaced(scene, formulation, theta)?,
    };
    let piola = mean_stress(&found.body, &found.solution.displacement, theta);
    // A field of pressure adds p cof F, here p J/s along the load with J = 1.
    let pressure = found.solution.pressure.first();
    let stress =
        pressure.map_or(piola[loaded][loaded], |p| piola[loaded][loaded] + p / state.stretch);
    let lateral = 1.0 + found.at([1.0; 3])[state.free()];
    for (quantity, value, exact) in [
        ("first Piola stress [kPa]", stress, state.stress),
        ("lateral stretch", lateral, state.lateral),
    ] {
        let label = Label::new(formulation, state.name(), quantity);
        rows.relative(label, [value, exact], EIGHT_DIGITS, found.cost)?;
    }
    Ok(())
}

/// Normal of the sliding planes, direction of sliding, name.
const PLANES: [(usize, usize, &str); 3] = [(0, 1, "fs"), (1, 0, "sf"), (1, 2, "sn")];
const AMOUNTS: [f64; 3] = [0.3, 0.1, 0.5];

/// Shear stress by normal, direction and amount.
type Stress<'a> = &'a dyn Fn(usize, usize, f64) -> f64;

/// Each law and element under simple shear: the shear stress, from the reactions of a distorted mesh.
pub(super) const SHEAR: Case = Case {
    name: "shear",
    title: "Simple shear of every law in every element",
    provenance: "Closed forms of the shear stress, which no bulk modulus enters: own code over the invariants, tested \
         against tabulated values; μγ for neo-Hookean and linear bodies.",
    run: run_shear,
};

fn run_shear(effort: Effort, rows: &mut Rows) -> Result<()> {
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

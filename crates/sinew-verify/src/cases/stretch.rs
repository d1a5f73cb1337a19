//! Stretched blocks with free faces, of every law.

use super::homogeneous::{
    Exponential, guccione, holzapfel_ogden, holzapfel_ogden_2009, mean_stress, thesis_code,
};
use crate::case::{Band, Case, Cost, Effort, Formulation, Label, Row, Rows};
use crate::reference::{Biaxial, equibiaxial_bar, uniaxial_bar};
use crate::solve::{balance, displacement_at, lower, minimum, scene, with_directions};
use anyhow::Result;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{FiniteElement, Law, Nodes, Scene, Support};
use sinew_mesh::{HexMesh, Mesh, TetMesh, box_hexahedra, box_tetrahedra};

/// Each law and element stretched along one or two axes, the other faces free: stress and lateral stretch.
pub(super) struct Stretch;

/// Relative: eight digits.
const EIGHT_DIGITS: Band = Band::below(1e-8);
/// Loads and stretches of the exponential laws; compression of the fibres switches them off.
const STATES: [(Biaxial, f64, &str); 5] = [
    (Biaxial::Along(0), 1.2, "along fibres"),
    (Biaxial::Along(1), 1.2, "across fibres"),
    (Biaxial::InPlane, 1.1, "in plane"),
    (Biaxial::Along(0), 0.9, "along fibres"),
    (Biaxial::Along(1), 0.85, "across fibres"),
];

/// A state with its reference.
struct State<'a> {
    law: &'a str,
    load: Biaxial,
    name: &'a str,
    stretch: f64,
    /// Stretch of the first free axis and first Piola stress along the first loaded one.
    lateral: f64,
    stress: f64,
}

impl State<'_> {
    fn loaded(&self) -> Vec<usize> {
        match self.load {
            Biaxial::Along(axis) => vec![axis],
            Biaxial::InPlane => vec![0, 1],
        }
    }

    fn free(&self) -> usize {
        match self.load {
            Biaxial::Along(axis) => (axis + 1) % 3,
            Biaxial::InPlane => 2,
        }
    }
}

impl Case for Stretch {
    fn name(&self) -> &'static str {
        "stretch"
    }

    fn title(&self) -> &'static str {
        "Uniaxial and equibiaxial stretch of every law in every element"
    }

    fn provenance(&self) -> &'static str {
        "Scalar equations for the lateral stretches at which the free faces bear no stress: own code in \
         principal stretches, tested against tabulated values; mixed elements against the incompressible limit."
    }

    fn run(&self, effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
        let tets = box_tetrahedra([1.0; 3], [2; 3]).distorted(5, 0.2);
        let hexes = box_hexahedra([1.0; 3], [2; 3]).distorted(5, 0.2);
        let meshes = Meshes { tets, hexes };
        meshes.neo_hookean(rows, effort)?;
        meshes.exponential(rows, effort, &holzapfel_ogden())?;
        meshes.exponential(rows, effort, &thesis_code())?;
        meshes.exponential(rows, effort, &holzapfel_ogden_2009())?;
        meshes.exponential(rows, effort, &guccione())
    }
}

/// The distorted meshes.
struct Meshes {
    tets: TetMesh,
    hexes: HexMesh,
}

impl Meshes {
    fn neo_hookean(&self, rows: &mut Rows<'_>, effort: Effort) -> Result<()> {
        let stretches: &[(f64, f64)] =
            &[(1.0, 1.5), (10.0, 2.0), (1.0, 0.5), (10.0, 0.5), (1.0, 2.0)];
        for &(lame, stretch) in effort.levels(2, stretches) {
            let bar = uniaxial_bar(1.0, lame, stretch)?;
            let name = format!("neo-Hookean, λ/μ = {lame}");
            let state = State {
                law: &name,
                load: Biaxial::Along(0),
                name: "along x",
                stretch,
                lateral: bar.across,
                stress: bar.stress,
            };
            self.compare(rows, &NeoHookean, &[1.0, lame], [], &state)?;
        }
        for lame in [1.0, 10.0] {
            let sheet = equibiaxial_bar(1.0, lame, 1.3)?;
            let name = format!("neo-Hookean, λ/μ = {lame}");
            let (lateral, stress) = (sheet.across, sheet.stress);
            let state = State {
                law: &name,
                load: Biaxial::InPlane,
                name: "in plane",
                stretch: 1.3,
                lateral,
                stress,
            };
            self.compare(rows, &NeoHookean, &[1.0, lame], [], &state)?;
        }
        Ok(())
    }

    fn exponential<L: Law<D>, const D: usize>(
        &self,
        rows: &mut Rows<'_>,
        effort: Effort,
        body: &Exponential<L, D>,
    ) -> Result<()> {
        for &(load, stretch, name) in effort.levels(1, &STATES) {
            let mut state =
                State { law: body.name, load, name, stretch, lateral: 0.0, stress: 0.0 };
            let (loaded, free) = (state.loaded()[0], state.free());
            let block = body.reference.nearly_incompressible(body.bulk, load, stretch)?;
            let volume: f64 = block.stretches.iter().product();
            state.lateral = block.stretches[free];
            state.stress = block.stress[loaded] * volume / stretch;
            self.compare(rows, &body.law, &body.theta, body.directions(), &state)?;
            let block = body.reference.incompressible(load, stretch)?;
            (state.lateral, state.stress) = (block.stretches[free], block.stress[loaded] / stretch);
            self.compare_mixed(rows, &body.law, &body.theta, body.directions(), &state)?;
        }
        Ok(())
    }

    fn compare<L: Law<D>, const D: usize>(
        &self,
        rows: &mut Rows<'_>,
        law: &L,
        theta: &[f64],
        directions: [[f64; 3]; D],
        state: &State<'_>,
    ) -> Result<()> {
        let tets = with_directions(block(&self.tets, law, theta, state), directions);
        displaced(rows, Formulation::P1, &tets, theta, state)?;
        displaced(rows, Formulation::FBar, &tets, theta, state)?;
        let quadratic = block(&self.tets.quadratic(), law, theta, state);
        let quadratic = with_directions(quadratic, directions);
        displaced(rows, Formulation::P2, &quadratic, theta, state)?;
        let hexes = with_directions(block(&self.hexes, law, theta, state), directions);
        displaced(rows, Formulation::Q1, &hexes, theta, state)?;
        displaced(rows, Formulation::Q1FBar, &hexes, theta, state)
    }

    fn compare_mixed<L: Law<D>, const D: usize>(
        &self,
        rows: &mut Rows<'_>,
        law: &L,
        theta: &[f64],
        directions: [[f64; 3]; D],
        state: &State<'_>,
    ) -> Result<()> {
        let scene = with_directions(block(&self.tets.quadratic(), law, theta, state), directions);
        let body = scene.lower_mixed()?;
        let (solution, cost) = balance(&body, theta)?;
        let lateral = lateral_stretch(&scene.mesh, &solution.displacement, state);
        let piola = mean_stress(&body.potential, &solution.displacement, theta);
        // The field of pressure adds p cof F, here p J/s along the load.
        let pressure = solution.pressure[0];
        let loaded = state.loaded()[0];
        push(
            rows,
            Formulation::Mixed,
            state,
            [lateral, piola[loaded][loaded] + pressure / state.stretch],
            cost,
        )
    }
}

/// A block on rollers, stretched.
fn block<L: Law<D>, const D: usize, const N: usize>(
    mesh: &Mesh<N>,
    law: &L,
    theta: &[f64],
    state: &State<'_>,
) -> Scene<L, D, N> {
    let along = |axis: usize, by: f64| std::array::from_fn(|i| (i == axis).then_some(by));
    let name = |axis: usize, end: &str| format!("{}_{end}", ["x", "y", "z"][axis]);
    let mut supports: Vec<_> =
        (0..3).map(|axis| Support::uniform(name(axis, "min"), along(axis, 0.0))).collect();
    for axis in state.loaded() {
        supports.push(Support::uniform(name(axis, "max"), along(axis, state.stretch - 1.0)));
    }
    scene(mesh.clone(), law.clone(), theta, vec![], supports)
}

fn displaced<L: Law<D>, const D: usize, const N: usize>(
    rows: &mut Rows<'_>,
    formulation: Formulation,
    scene: &Scene<L, D, N>,
    theta: &[f64],
    state: &State<'_>,
) -> Result<()>
where
    Nodes<N>: FiniteElement<N>,
{
    let potential = lower(scene, formulation)?;
    let (solution, cost) = minimum(&potential, theta)?;
    let lateral = lateral_stretch(&scene.mesh, &solution.displacement, state);
    let loaded = state.loaded()[0];
    let piola = mean_stress(&potential, &solution.displacement, theta);
    push(rows, formulation, state, [lateral, piola[loaded][loaded]], cost)
}

fn lateral_stretch<const N: usize>(mesh: &Mesh<N>, displacement: &[f64], state: &State<'_>) -> f64 {
    1.0 + displacement_at(mesh, displacement, [1.0; 3])[state.free()]
}

fn push(
    rows: &mut Rows<'_>,
    formulation: Formulation,
    state: &State<'_>,
    [lateral, stress]: [f64; 2],
    cost: Cost,
) -> Result<()> {
    let label = |quantity: &str| {
        let setup = format!("{}, {} by {}", state.law, state.name, state.stretch);
        Label::new(formulation, setup, quantity)
    };
    let stress = [stress, state.stress];
    rows.push(Row::relative(label("first Piola stress [kPa]"), stress, EIGHT_DIGITS, cost)?);
    let lateral = [lateral, state.lateral];
    rows.push(Row::relative(label("lateral stretch"), lateral, EIGHT_DIGITS, cost)?);
    Ok(())
}

//! Simple shear of every law.

use super::homogeneous::{
    Exponential, guccione, holzapfel_ogden, holzapfel_ogden_2009, mean_stress, thesis_code,
};
use crate::case::{Band, Case, Effort, Formulation, Label, Row, Rows};
use crate::solve::{BOUNDARY, lower, minimum, scene, with_boundary, with_directions};
use anyhow::Result;
use sinew_energy::laws::{ByYoungPoisson, LinearElastic, NeoHookean};
use sinew_energy::{FiniteElement, Law, Nodes, Support};
use sinew_mesh::{HexMesh, Mesh, TetMesh, box_hexahedra, box_tetrahedra};

/// Each law and element under simple shear: the shear stress, from the reactions of a distorted mesh.
pub(super) struct Shear;

/// Relative: eight digits.
const EIGHT_DIGITS: Band = Band::below(1e-8);
/// Normal of the sliding planes, direction of sliding, name.
const PLANES: [(usize, usize, &str); 3] = [(0, 1, "fs"), (1, 0, "sf"), (1, 2, "sn")];
/// Amounts of shear.
const AMOUNTS: [f64; 3] = [0.3, 0.1, 0.5];

/// The distorted meshes.
struct Meshes {
    tets: TetMesh,
    hexes: HexMesh,
}

/// A law that is sheared, and its shear stress by normal, direction and amount.
struct Sheared<'a, L, const D: usize> {
    name: &'a str,
    law: L,
    theta: &'a [f64],
    directions: [[f64; 3]; D],
    stress: &'a dyn Fn(usize, usize, f64) -> f64,
}

impl Case for Shear {
    fn name(&self) -> &'static str {
        "shear"
    }

    fn title(&self) -> &'static str {
        "Simple shear of every law in every element"
    }

    fn provenance(&self) -> &'static str {
        "Closed forms of the shear stress, which no bulk modulus enters: own code over the invariants, tested \
         against tabulated values; μγ for neo-Hookean and linear bodies."
    }

    fn run(&self, effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
        let tets = box_tetrahedra([1.0; 3], [2; 3]).distorted(5, 0.2);
        let hexes = box_hexahedra([1.0; 3], [2; 3]).distorted(5, 0.2);
        let meshes = Meshes { tets, hexes };
        let isotropic = |_: usize, _: usize, amount: f64| 2.0 * amount;
        let (name, theta) = ("neo-Hookean", &[2.0, 3.0]);
        let law = Sheared { name, law: NeoHookean, theta, directions: [], stress: &isotropic };
        meshes.shear(rows, effort, &law)?;
        // μ = 2 from E = 5, ν = 1/4.
        let (name, theta) = ("neo-Hookean by E and ν", &[5.0, 0.25]);
        let law = ByYoungPoisson(NeoHookean);
        let law = Sheared { name, law, theta, directions: [], stress: &isotropic };
        meshes.shear(rows, effort, &law)?;
        let (name, theta) = ("linear elastic", &[2.0, 3.0]);
        let law = Sheared { name, law: LinearElastic, theta, directions: [], stress: &isotropic };
        meshes.shear(rows, effort, &law)?;
        meshes.shear_exponential(rows, effort, &holzapfel_ogden())?;
        meshes.shear_exponential(rows, effort, &thesis_code())?;
        meshes.shear_exponential(rows, effort, &holzapfel_ogden_2009())?;
        meshes.shear_exponential(rows, effort, &guccione())
    }
}

impl Meshes {
    fn shear_exponential<L: Law<D>, const D: usize>(
        &self,
        rows: &mut Rows<'_>,
        effort: Effort,
        body: &Exponential<L, D>,
    ) -> Result<()> {
        let stress = |normal, along, amount| body.reference.shear_stress(normal, along, amount);
        let law = Sheared {
            name: body.name,
            law: body.law.clone(),
            theta: &body.theta,
            directions: body.directions(),
            stress: &stress,
        };
        self.shear(rows, effort, &law)
    }

    fn shear<L: Law<D>, const D: usize>(
        &self,
        rows: &mut Rows<'_>,
        effort: Effort,
        law: &Sheared<'_, L, D>,
    ) -> Result<()> {
        rows.push(worst(effort, Formulation::P1, &self.tets, law)?);
        rows.push(worst(effort, Formulation::P2, &self.tets.quadratic(), law)?);
        rows.push(worst(effort, Formulation::FBar, &self.tets, law)?);
        rows.push(worst(effort, Formulation::Q1, &self.hexes, law)?);
        rows.push(worst(effort, Formulation::Q1FBar, &self.hexes, law)?);
        Ok(())
    }
}

/// The row of the state with the largest error.
fn worst<L: Law<D>, const D: usize, const N: usize>(
    effort: Effort,
    formulation: Formulation,
    mesh: &Mesh<N>,
    law: &Sheared<'_, L, D>,
) -> Result<Row>
where
    Nodes<N>: FiniteElement<N>,
{
    let mut worst: Option<Row> = None;
    for &amount in effort.levels(1, &AMOUNTS) {
        for &(normal, along, plane) in effort.levels(1, &PLANES) {
            let slide = |x: [f64; 3]| {
                let mut u = [0.0; 3];
                u[along] = amount * x[normal];
                u
            };
            let mesh = with_boundary(mesh.clone());
            let supports = vec![Support::moved(BOUNDARY, &mesh, slide)];
            let scene = scene(mesh, law.law.clone(), law.theta, vec![], supports);
            let potential = lower(&with_directions(scene, law.directions), formulation)?;
            let (solution, cost) = minimum(&potential, law.theta)?;
            let piola = mean_stress(&potential, &solution.displacement, law.theta);
            // σ = PFᵀ with F = I + γ e_along ⊗ e_normal, J = 1.
            let stress = piola[normal][along] + amount * piola[normal][normal];
            let setup = format!("{}, {plane}, γ = {amount}", law.name);
            let label = Label::new(formulation, setup, "shear stress [kPa]");
            let reference = (law.stress)(normal, along, amount);
            let row = Row::relative(label, [stress, reference], EIGHT_DIGITS, cost)?;
            if worst.as_ref().is_none_or(|worst| worst.error < row.error) {
                worst = Some(row);
            }
        }
    }
    worst.ok_or_else(|| anyhow::anyhow!("no state to shear"))
}

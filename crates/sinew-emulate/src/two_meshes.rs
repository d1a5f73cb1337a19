//! A coarse mesh for every parameter set, and one solution on the fine one.

use crate::correction::refined;
use crate::{Body, Error, Result, coordinates::dot};
use sinew_fem::{HeldStiffness, Options, Solver, obey_supports, sweep};
use sinew_mesh::Prolongation;

/// An emulator that is not trained: the body on a coarser mesh is solved for every parameter set, and what that lacks is taken from one
/// solution of both at the centre of the parameters' ranges (two fidelities, as P. Perdikaris et al., Proc. R. Soc. A 473, 2017, have more).
///
/// `û(θ) = α u_c(θ) + (u − α u_c)(centre) · ‖u_c(θ)‖ / ‖u_c(centre)‖`, with the α that leaves least at the centre: what a coarse mesh is
/// off grows with the displacement, and turns with it where a load is reversed. It is for laws over so wide ranges that no expansion about one solution holds. The coarse mesh needs
/// what the law needs to be the same material, such as two cells through a wall whose fibres turn.
///
/// ```
/// use sinew_emulate::TwoMeshes;
/// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{Options, Solver, coarse_displacement};
/// use sinew_mesh::box_tetrahedra;
///
/// // A bar whose stiffness is known to a factor of a hundred.
/// let [fine, coarse] = [[16, 4, 4], [6, 2, 2]].map(|cells| {
///     let stiffness = |name: &str| Parameter::log(name, "kPa", 2.0..=200.0);
///     let scene = Scene::new(box_tetrahedra([40.0, 8.0, 8.0], cells), NeoHookean)
///         .parameter(stiffness("mu"))
///         .parameter(stiffness("lambda"))
///         .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
///         .support(Support::clamped("x_min"));
///     scene.lower().expect("a bar")
/// });
/// let emulator = TwoMeshes::new(&fine, &coarse)?;
/// let theta = [5.0, 60.0];
/// let found = emulator.predict(&[theta.to_vec()])?.remove(0);
/// let exact = Solver::new(&fine)?.solve(&theta, &Options::default())?.displacement;
/// let norm = |u: &mut dyn Iterator<Item = f64>| u.map(|u| u * u).sum::<f64>().sqrt();
/// let off = norm(&mut found.iter().zip(&exact).map(|(a, b)| a - b)) / norm(&mut exact.iter().copied());
/// // The coarse mesh alone is several times as far off: it locks.
/// let alone = coarse_displacement(&coarse, &fine, &theta, &Options::default())?;
/// let of_alone = norm(&mut alone.iter().zip(&exact).map(|(a, b)| a - b)) / norm(&mut exact.iter().copied());
/// assert!(off < 0.1 && of_alone > 3.0 * off, "{off} {of_alone}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct TwoMeshes<'b> {
    /// The fine body with its stiffness at the centre.
    held: HeldStiffness<'b>,
    coarse: &'b Body,
    prolongation: Prolongation,
    /// α.
    part: f64,
    /// The coarse displacement at the centre over its size.
    known: Vec<f64>,
    /// What it lacks there, over the same size.
    lacks: Vec<f64>,
}

impl<'b> TwoMeshes<'b> {
    /// Solves both at the centre of the ranges of the fine body's parameters.
    ///
    /// # Errors
    /// [`Error::OtherParameters`] for bodies of different parameters; no equilibrium at the centre, or one without displacement.
    pub fn new(fine: &'b Body, coarse: &'b Body) -> Result<Self> {
        let [names, others] = [fine, coarse].map(|body| {
            let names = body.parameters.iter().map(|parameter| parameter.name.as_str());
            names.collect::<Vec<_>>().join(", ")
        });
        if names != others {
            return Err(Error::OtherParameters { names, others });
        }
        let centre = fine.centre();
        let prolongation = Prolongation::new(&coarse.positions, &fine.positions);
        let (mut solver, options) = (Solver::new(fine)?, Options::default());
        let exact = solver.solve(&centre, &options)?.displacement;
        let of_coarse = Solver::new(coarse)?.solve(&centre, &options)?.displacement;
        let known = prolongation.vectors(&of_coarse);
        let squared = dot(&known, &known);
        if squared == 0.0 {
            let advice = "give ranges whose centre has a load";
            return Err(Error::Setting {
                what: "the displacement of the coarse mesh at the centre of the ranges",
                value: 0.0,
                advice,
            });
        }
        let (part, size) = (dot(&exact, &known) / squared, squared.sqrt());
        let lacks = exact.iter().zip(&known).map(|(u, c)| (u - part * c) / size).collect();
        let known = known.iter().map(|c| c / size).collect();
        let held = solver.held_stiffness(&exact, &centre)?;
        Ok(Self { held, coarse, prolongation, part, known, lacks })
    }

    /// Displacements of the fine body at each of `thetas`, node by node \[length\].
    ///
    /// # Errors
    /// Parameter sets at which the coarse body has no equilibrium, the first of them.
    pub fn predict(&self, thetas: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let swept = sweep(self.coarse, thetas, &Options::default(), || {})?;
        let of = |solved: sinew_fem::Solution| {
            let now = self.prolongation.vectors(&solved.displacement);
            // Loads that are reversed reverse what is lacking.
            let size = dot(&now, &now).sqrt().copysign(dot(&now, &self.known));
            let parts = now.iter().zip(&self.lacks);
            let mut found: Vec<f64> = parts.map(|(c, lack)| self.part * c + size * lack).collect();
            obey_supports(self.held.body(), &mut found);
            found
        };
        swept.results.into_iter().map(|solved| Ok(of(solved?))).collect()
    }

    /// The same after at most `steps` quasi-Newton steps each, with the stiffness of the one solution: [`crate::Emulator::refine`].
    ///
    /// # Errors
    /// As [`TwoMeshes::predict`].
    pub fn refine(&self, thetas: &[Vec<f64>], steps: usize) -> Result<Vec<Vec<f64>>> {
        refined(&self.held, thetas, &self.predict(thetas)?, steps)
    }
}

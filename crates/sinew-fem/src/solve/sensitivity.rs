//! Stiffness at an equilibrium, and sensitivities to θ.

use crate::elements::{Followers, State, System, Unknowns, check_length, check_potential};
use crate::linear::dot;
use crate::{Result, Solution, SolveError, Solver};
use sinew_energy::{Magnitude, PressureSurface};
use sinew_num::Mat3;

/// Largest residual of a linear system whose solution counts as a derivative \[relative to its right-hand side\]:
/// iterations end at 1e-10, or where rounding errors stop them.
const MOST_LEFT: f64 = 1e-6;

/// The stiffness of the free degrees of freedom at an equilibrium, its lower half by entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness {
    /// Degree of freedom `3 × node + component` of each row and column; along the axes of the node's frame, if
    /// [`sinew_energy::BodyArrays::frames`] has one.
    pub degree_of_freedom: Vec<usize>,
    /// Rows of the entries; column by column.
    pub rows: Vec<usize>,
    /// Start of each column in the entries, and their number.
    pub column_starts: Vec<usize>,
    /// The entries \[stress·length\].
    pub values: Vec<f64>,
}

impl Solver<'_> {
    /// Derivative of the displacement in each entry of θ: one vector like the displacement per entry.
    ///
    /// The implicit function theorem `K ∂u/∂θ = −∂²Π/∂u∂θ`, with exact derivatives throughout and one
    /// factorisation for all entries.
    ///
    /// # Errors
    /// A solution of another body, [`SolveError::Singular`], or [`SolveError::Inadmissible`] where derivatives overflow.
    pub fn sensitivity(&mut self, solution: &Solution) -> Result<Vec<Vec<f64>>> {
        let at = self.checked(solution, &solution.theta)?;
        self.system.sensitivity(&at, &solution.theta, solution.load_factor)
    }

    /// Sensitivities at a displacement \[length\] near to an equilibrium under the whole load, as if it were one.
    ///
    /// # Errors
    /// As [`Solver::sensitivity`].
    pub fn sensitivity_at(&mut self, displacement: &[f64], theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        check_potential(self.body(), displacement, theta)?;
        self.system.sensitivity(&Unknowns::of(displacement), theta, 1.0)
    }

    /// Derivative in each entry of θ of a quantity of interest whose derivative in the displacement is
    /// `slope`: one linear system whatever the number of parameters (the adjoint method). Add the quantity's direct
    /// dependence on θ.
    ///
    /// # Errors
    /// A solution of another body, a slope that does not fit it, or [`SolveError::Singular`].
    #[doc(alias("adjoint", "gradient"))]
    pub fn adjoint_sensitivity(&mut self, solution: &Solution, slope: &[f64]) -> Result<Vec<f64>> {
        let Solution { displacement, theta, load_factor, .. } = solution;
        check_length(self.body().prescribed.len(), slope)?;
        check_potential(self.body(), displacement, theta)?;
        let shift = self.system.factorise_at(&Unknowns::of(displacement), theta, *load_factor)?;
        let slope: Vec<f64> = self.system.sparsity.gather(slope).collect();
        let (adjoint, _) = self.system.solve(&slope, shift)?;
        let state = State { displacement, theta, load_factor: *load_factor, pressure: &[] };
        let entry = |unit: &Vec<f64>| dot(&self.system.rate_by_theta(state, unit), &adjoint);
        self.system.finite(units(theta.len()).iter().map(entry).collect())
    }

    /// Second derivative of the potential at a solution.
    ///
    /// # Errors
    /// A solution of another body, or [`SolveError::Inadmissible`].
    pub fn stiffness(&mut self, solution: &Solution) -> Result<Stiffness> {
        let Solution { displacement, theta, load_factor, .. } = solution;
        self.visit(displacement, (theta, *load_factor), None)?;
        let System { sparsity, assembly, .. } = &self.system;
        Ok(Stiffness {
            degree_of_freedom: sparsity.degree_of_freedom.clone(),
            rows: sparsity.pattern.row_idx().to_vec(),
            column_starts: sparsity.pattern.col_ptr().to_vec(),
            values: assembly.matrix[..sparsity.entries()].to_vec(),
        })
    }

    /// Second derivative of the potential at a displacement times a direction, over all degrees of freedom.
    ///
    /// # Errors
    /// θ or vectors that do not belong to the body, or an energy that is not finite there.
    pub fn stiffness_times(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
        direction: &[f64],
    ) -> Result<Vec<f64>> {
        check_length(self.body().prescribed.len(), direction)?;
        self.visit(displacement, (theta, 1.0), None)?;
        let mut forces = vec![0.0; displacement.len()];
        let state = State::whole(displacement, theta);
        self.system.assembly.add_stiffness_times(self.body(), state, direction, &mut forces);
        Ok(forces)
    }
}

impl System<'_> {
    fn sensitivity(
        &mut self,
        at: &Unknowns,
        theta: &[f64],
        load_factor: f64,
    ) -> Result<Vec<Vec<f64>>> {
        let shift = self.factorise_at(at, theta, load_factor)?;
        let state = State { displacement: &at.displacement, theta, load_factor, pressure: &[] };
        let column = |unit: &Vec<f64>| self.slope(self.rate_by_theta(state, unit), shift);
        units(theta.len()).iter().map(column).collect()
    }

    /// Change of the displacement that balances a rate of the unbalanced forces, by the stiffness factorised last.
    pub(crate) fn slope(&self, rate: Vec<f64>, shift: f64) -> Result<Vec<f64>> {
        let (change, outcome) = self.solve(&rate, shift)?;
        // Written so that a NaN is an error as well.
        let solved = outcome.relative_residual <= MOST_LEFT;
        if !solved {
            return Err(SolveError::Singular);
        }
        self.finite(self.sparsity.scattered(change))
    }

    /// Derivative of the balance of free displacements and pressures along a direction in θ.
    pub(crate) fn rate_by_theta(&self, state: State<'_>, direction: &[f64]) -> Vec<f64> {
        let (body, State { displacement, theta, load_factor, .. }) = (self.body, state);
        let (parameters, mut direction) = (body.law_parameters(theta), direction.to_vec());
        // Loads are scaled by the load factor, parameters of the law are not.
        direction[parameters.len()..].iter_mut().for_each(|d| *d *= load_factor);
        let rates = body.law_parameters(&direction);
        let mut forces = vec![0.0; displacement.len()];
        let change = |point: usize, h: &Mat3<f64>| {
            Some((0.0, body.material.stress_rate(point, parameters, rates, h)))
        };
        if body.add_stress_forces(displacement, change, &mut forces).is_none() {
            forces.fill(f64::NAN);
        }
        // A load is linear in its magnitude, so its change is the load of the changed magnitude.
        let varies = |load: &&PressureSurface| matches!(load.magnitude, Magnitude::Theta(_));
        for pressure in body.pressures.iter().filter(varies) {
            pressure.value_and_add_gradient(displacement, &direction, &mut forces);
        }
        for surface in body.followers.iter().filter(varies) {
            let follower = Followers::new(std::slice::from_ref(surface));
            follower.add_forces(displacement, &direction, &mut forces);
        }
        let mut rate: Vec<f64> = self.sparsity.gather(&forces).collect();
        rate.resize(rate.len() + self.pressures(), 0.0);
        rate
    }

    /// Factorises the stiffness at a displacement; returns the shift of the factor, which only preconditions then.
    pub(crate) fn factorise_at(
        &mut self,
        at: &Unknowns,
        theta: &[f64],
        load_factor: f64,
    ) -> Result<f64> {
        self.assemble(at, theta, load_factor, None);
        self.assembly.check()?;
        let (shift, _) = self.factorise(false).ok_or(SolveError::Singular)?;
        if shift > 0.0 && self.body.has_potential() { Err(SolveError::Singular) } else { Ok(shift) }
    }

    /// Derivatives that do not overflow where the energy does not yet.
    fn finite(&self, slopes: Vec<f64>) -> Result<Vec<f64>> {
        let cell = self.assembly.worst_cell;
        let finite = slopes.iter().all(|s| s.is_finite());
        if finite { Ok(slopes) } else { Err(SolveError::Inadmissible { cell }) }
    }
}

/// The directions of so many entries of θ.
pub(crate) fn units(entries: usize) -> Vec<Vec<f64>> {
    let unit = |index| (0..entries).map(|i| f64::from(u8::from(i == index))).collect();
    (0..entries).map(unit).collect()
}

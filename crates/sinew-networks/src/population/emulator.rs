//! An emulator of any body, by a network that has learned a population.

use super::settings::{Population, TRIED};
use super::template::Template;
use crate::Result;
use crate::network::TrainedNetwork;
use sinew_emulate::parts::{admissible, check_length, require_finite};
use sinew_emulate::{Body, Design, Emulator, Record, TaylorExpansion};
use sinew_fem::Solver;
use sinew_gnn::Surrogate;
use std::time::Instant;

/// A network that has learned a population.
#[derive(Clone, Debug)]
pub struct PopulationEmulator {
    pub(super) recipe: Population,
    pub(super) seed: u64,
    pub(super) surrogate: Surrogate,
    pub(super) template: Template,
}

impl PopulationEmulator {
    /// The emulator of a body, be it one of the population or not, with any mesh.
    ///
    /// # Errors
    /// Other names, order, ranges, units or scales of the parameters than the population's, or a body that cannot be prepared.
    pub fn on<'b>(&self, body: &'b Body) -> Result<Emulator<'b>> {
        let start = Instant::now();
        let (geometry, ..) = self.recipe.geometry(body, &self.template, self.seed)?;
        let network = TrainedNetwork::new(self.surrogate.clone(), geometry)?;
        let mut record = Record::new("pi");
        record.about = "network that has learned a population".into();
        record.prepare_s = start.elapsed().as_secs_f64();
        Ok(Emulator::new(body, Box::new(network), record))
    }

    /// Displacements of a body at each of `thetas` \[length\], from one state: what the network predicts for the centre of the
    /// parameters' ranges, after `newton_steps` there. The Taylor expansion of second order about it uses a frozen stiffness.
    ///
    /// # Errors
    /// As [`PopulationEmulator::on`] and [`Emulator::predict`].
    pub fn expansion_on(
        &self,
        body: &Body,
        thetas: &[Vec<f64>],
        newton_steps: usize,
    ) -> Result<Vec<Vec<f64>>> {
        let emulator = self.on(body)?;
        thetas.iter().try_for_each(|theta| check_length(body, theta))?;
        let centre = body.centre();
        let state = emulator.predict(std::slice::from_ref(&centre))?.displacement;
        let mut solver = Solver::new(body)?;
        let steps = solver.newton_steps(&admissible(body, &state), &centre, newton_steps)?;
        let state = steps.into_iter().next_back().map_or(state, |step| step.displacement);
        let topology = self.template.graph(body, self.seed)?;
        // The form is not chosen at `thetas`: a prediction must not depend on the other parameter sets of the call.
        let tried = Design::LatinHypercube.sample(&body.parameters, TRIED, self.seed)?;
        let taylor = TaylorExpansion::about(&mut solver, &topology.clusters, &state, &tried)?;
        let fields: Vec<_> = thetas
            .iter()
            .map(|theta| taylor.at(body, theta))
            .collect::<sinew_emulate::Result<Vec<_>>>()?;
        require_finite(body, thetas, &fields.concat())?;
        Ok(fields)
    }
}

//! Geometry and batch of a body.

use super::settings::{Loss, Population, Start, TRIED};
use super::template::Template;
use crate::{Result, coordinates, graph};
use sinew_coordinates::Coordinates as Meaning;
use sinew_coordinates::Motions;
use sinew_emulate::parts::{dot, expand, scaling, work};
use sinew_emulate::{Body, Design, split_seed};
use sinew_energy::Barriers;
use sinew_fem::{Options, Solution, SolveError, Solver, sweep};
use sinew_gnn::{
    DataFit, DataSet, EnergyNormFit, Geometry, GeometryBatch, MinimumPotential, Objective, Sample,
};
use sinew_graph::Topology;
use std::sync::Arc;

/// Energies beyond so many times the work of the loads count by their logarithm.
const FORGIVEN: f64 = 1.0;

impl Population {
    /// Geometry of a body, and the work of its loads, or the gain of a Newton step if that is more.
    ///
    /// If the start is only near equilibrium, unit outputs cost nine times the energy gain of a Newton step, plus a part of
    /// the loads' work. The step itself is then a feature of the nodes. From an equilibrium, unit outputs cost nine times
    /// the median gain of a Newton step over some parameter sets.
    pub(super) fn geometry<'b>(
        &self,
        body: &'b Body,
        template: &Template,
        seed: u64,
    ) -> Result<(Geometry, f64, Solver<'b>)> {
        template.require(body)?;
        let (topology, centre) = (template.graph(body, seed)?, body.centre());
        let mut solver = Solver::new(body)?;
        let anchor = self.anchor(&mut solver, &topology, template)?;
        let motions = Motions::about(&anchor, &topology.clusters, body, &centre)?;
        let thetas = Design::LatinHypercube.sample(&body.parameters, TRIED, seed)?;
        let (motions, first) = expand(&mut solver, motions, &thetas)?;
        let work = work(body, &anchor);
        let (step, gain, energy) = match self.start {
            Start::Near { .. } => {
                let (step, gain) = missing_step(&mut solver, &anchor, &centre)?;
                (
                    Some(step),
                    gain,
                    coordinates::FIRST_SHARE * gain + coordinates::ENERGY_SHARE * work,
                )
            }
            Start::Equilibrium => {
                let gains = gains(&mut solver, &motions, &thetas, work)?;
                let mut units: Vec<f64> = gains.iter().map(|[_, unit]| *unit).collect();
                units.sort_by(f64::total_cmp);
                (None, 0.0, coordinates::FIRST_SHARE * units[units.len() / 2])
            }
        };
        let (motions, first) = (motions.of_energy(energy)?, first.of_energy(energy)?);
        let mut geometry = graph::geometry_at(&body.positions, body, topology)?;
        if let Some(step) = step {
            graph::add_features(&mut geometry, &first.clone().with_expansion(&[step], body)?)?;
        }
        graph::add_features(&mut geometry, &first)?;
        geometry.coordinates = Meaning::Motions(motions);
        Ok((geometry, work.max(gain), solver))
    }

    /// The state that a body's outputs are about \[length\].
    pub(super) fn anchor(
        &self,
        solver: &mut Solver<'_>,
        topology: &Topology,
        template: &Template,
    ) -> Result<Vec<f64>> {
        match (self.start, &template.solved) {
            (Start::Near { newton_steps }, Some(solved)) => {
                let guess = solved.interpolated_to(solver.body());
                coordinates::nearby(solver, topology, guess, newton_steps)
            }
            _ => {
                let centre = solver.body().centre();
                Ok(solver.solve(&centre, &Options::default())?.displacement)
            }
        }
    }

    pub(super) fn batch(
        &self,
        body: &Body,
        template: &Template,
        seed: u64,
        index: u64,
    ) -> Result<GeometryBatch> {
        let (geometry, energy, mut solver) = self.geometry(body, template, seed)?;
        let seed = split_seed(seed, index);
        let thetas = Design::LatinHypercube.sample(&body.parameters, self.training.batch, seed)?;
        if self.loss != Loss::Energy {
            return self.batch_of_simulations(body, geometry, thetas);
        }
        let sample = |theta| Sample { geometry: 0, theta, displacement: Vec::new() };
        let potential = Arc::new(body.clone().with_barriers(Barriers::default()));
        let objective =
            MinimumPotential::new(vec![potential], energy)?.logarithmic_above(FORGIVEN)?;
        let objective = match (self.start, &geometry.coordinates) {
            (Start::Equilibrium, Meaning::Motions(motions)) => {
                objective.relative_to(gains(&mut solver, motions, &thetas, energy)?)?
            }
            _ => objective,
        };
        let (samples, objective) = (thetas.into_iter().map(sample).collect(), Box::new(objective));
        Ok(GeometryBatch { geometry, samples, objective })
    }

    /// Solves a body at parameter sets and leaves out failures. A body with fewer than two solutions is refused.
    fn batch_of_simulations(
        &self,
        body: &Body,
        geometry: Geometry,
        thetas: Vec<Vec<f64>>,
    ) -> Result<GeometryBatch> {
        let solved = sweep(body, &thetas, &Options::default(), || ())?;
        let samples = solved.thetas.into_iter().zip(solved.results);
        let sample = |(theta, found): (Vec<f64>, std::result::Result<Solution, SolveError>)| {
            let displacement = found.ok()?.displacement;
            Some(Sample { geometry: 0, theta, displacement })
        };
        let samples: Vec<Sample> = samples.filter_map(sample).collect();
        if samples.len() < 2 {
            return Err(sinew_gnn::Error::NothingToTrain("a body that was solved nowhere").into());
        }
        let data =
            DataSet { geometries: vec![geometry], training: samples, validation: Vec::new() };
        let objective: Box<dyn Objective> = match self.loss {
            Loss::SimulationsByStiffness => {
                let motions = origin(&data.geometries[0]);
                let stiffness = body.stiffness(motions, &body.centre());
                let stiffness = stiffness.ok_or(sinew_coordinates::CoordinateError::NoStiffness)?;
                Box::new(EnergyNormFit::new(vec![stiffness], &data)?)
            }
            Loss::Simulations | Loss::Energy => {
                let state = origin(&data.geometries[0]);
                let size = dot(state, state);
                Box::new(DataFit::new((size / body.nodes as f64).sqrt())?)
            }
        };
        let DataSet { mut geometries, training: samples, .. } = data;
        Ok(GeometryBatch { geometry: geometries.remove(0), samples, objective })
    }
}

/// The state that outputs are about \[length\].
pub(super) fn origin(geometry: &Geometry) -> &[f64] {
    match &geometry.coordinates {
        Meaning::Motions(motions) => motions.origin(),
        _ => &[],
    }
}

/// `[energy, gain]` at each of `thetas` of a Newton step from the Taylor expansion, with the frozen stiffness. The gain is
/// at least a small part of the loads' work. Without a usable step the pair is `[−work, work]`.
fn gains(
    solver: &mut Solver<'_>,
    motions: &Motions,
    thetas: &[Vec<f64>],
    work: f64,
) -> Result<Vec<[f64; 2]>> {
    /// The part of the work that counts as precise: displacements that are off by a thousandth or so.
    const LEAST: f64 = 1e-5;
    let body = solver.body();
    let scaling = scaling(body)?;
    let of = |theta: &Vec<f64>| -> Result<[f64; 2]> {
        let state = motions.expansion_at(&scaling.standardise(theta)?, body)?;
        let energy = body.value(&state, theta);
        Ok(match missing_step(solver, &state, theta) {
            Ok((_, gain)) if gain < work && energy.is_finite() => {
                [energy - gain, gain.max(LEAST * work)]
            }
            _ => [-work, work],
        })
    };
    thetas.iter().map(of).collect()
}

/// Newton step from a state \[length\] with the frozen stiffness, and the energy that it gains.
fn missing_step(solver: &mut Solver<'_>, state: &[f64], theta: &[f64]) -> Result<(Vec<f64>, f64)> {
    let mut step = solver.step_with_frozen_tangent(state, theta)?;
    step.iter_mut().zip(state).for_each(|(to, from)| *to -= from);
    let mut gradient = vec![0.0; state.len()];
    solver.body().value_and_gradient(state, theta, &mut gradient);
    let gain = 0.5 * dot(&gradient, &step).abs();
    Ok((step, gain))
}

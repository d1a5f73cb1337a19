//! Simulations of ventricles of random shape, kept in files that several processes may fill.

use super::hull::hull_volume;
use crate::populations::nested::{coarse_displacement, solve_nested};
use crate::populations::options::Options;
use crate::populations::prolongation::Prolongation;
use crate::populations::simulated::Simulated;
use crate::populations::stage::{Stage, shape_parameters};
use crate::populations::variant::Inputs;
use crate::program::cpu_seconds_of;
use crate::ventricle_shape::VentricleShape;
use anyhow::{Context, Result, ensure};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;
use sinew::{Body, Parameter};
use sinew_emulate::coordinates::{Coordinates, Dirichlet};
use sinew_emulate::{Design, split_seed, store};
use sinew_energy::BodyArrays;
use sinew_fem::{Options as SolverOptions, Solver};
use sinew_gnn::Geometry;
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};
use std::path::Path;

/// Cells through the wall, around, from apex to base: a mesh of 484 nodes, and one of 6788, the nearest to the thesis' 6784; with
/// those of the coarse mesh. Fibres turn through the wall, so that one cell across it is another material.
const CELLS: [[[usize; 3]; 2]; 2] = [[[3, 16, 8], [2, 8, 4]], [[3, 64, 30], [2, 16, 8]]];
/// Sizes for a check of the code.
const QUICK: [[usize; 3]; 2] = [[3, 8, 4], [2, 8, 4]];
/// Neighbours that virtual nodes are joined to, κ.
const NEIGHBOURS: usize = 5;
/// Growth counts as a parameter up to e to this.
const GROWTH: f64 = 2.0;
/// Simulations in a file.
const CHUNK: usize = 50;

/// A population: how its bodies are made.
#[derive(Debug)]
pub(super) struct Ventricles {
    stage: Stage,
    seed: u64,
}

/// A ventricle with its parameters and what the solver found.
#[derive(Debug)]
pub(super) struct Ventricle {
    /// Coefficients of its shape, of mean zero and variance near one.
    pub numbers: Vec<f64>,
    /// a, b, a_f, b_f.
    pub theta: Vec<f64>,
    /// The lowered scene.
    pub body: Body,
    /// Node by node \[mm\].
    pub displacement: Vec<f64>,
    /// Solution on a coarse mesh.
    pub coarse: Coarse,
}

/// A solution on a coarse mesh.
#[derive(Debug)]
pub(super) struct Coarse {
    /// At the nodes of the fine mesh \[mm\].
    pub displacement: Vec<f64>,
    /// Logarithm of the inflated cavity's volume over that at rest.
    pub growth: f64,
}

/// A solution for numbers of a shape and parameters.
type Solve = fn(&Ventricles, &[f64], &[f64]) -> Result<Vec<f64>>;

impl Ventricles {
    /// The population of a run.
    pub(super) fn new(options: &Options) -> Result<Self> {
        let cells = if options.quick { QUICK } else { CELLS[usize::from(options.full)] };
        Ok(Self { stage: Stage::inflated(cells)?, seed: options.seed })
    }

    /// Numbers of the shape of one of the population.
    fn numbers(&self, index: usize) -> Vec<f64> {
        let seed = split_seed(self.seed, index as u64);
        self.stage.shape(&mut ChaCha8Rng::seed_from_u64(seed))
    }

    /// Wanted ventricles among the first `count` of the population, by number, with their solutions, from files within `folder` where these are;
    /// those without equilibrium are left out.
    pub(super) fn simulated(
        &self,
        count: usize,
        wanted: impl Fn(usize) -> bool + Sync,
        folder: &Path,
    ) -> Result<Vec<(usize, Ventricle)>> {
        let [layers, around, along] = self.stage.cells;
        let folder = folder.join(format!("{layers}x{around}x{along}-seed-{}", self.seed));
        let thetas = self.thetas(count)?;
        let mut all = Vec::new();
        for chunk in 0..count.div_ceil(CHUNK) {
            let own = chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
            if !own.clone().any(&wanted) {
                continue;
            }
            let kept = |mesh: &str, find: Solve| {
                let file = folder.join(format!("{:05}-{:05}{mesh}.npy", own.start, own.end));
                kept_table(&file, own.len(), || {
                    eprintln!("simulations {} to {} of {count}{mesh}", own.start + 1, own.end);
                    let row = |index| find(self, &self.numbers(index), &thetas[index]);
                    own.clone().into_par_iter().map(row).collect()
                })
            };
            let (fine, coarse) = (kept("", Self::solve)?, kept("-coarse", Self::coarse)?);
            let own: Vec<_> = own
                .clone()
                .zip(fine.into_iter().zip(coarse))
                .filter(|(index, _)| wanted(*index))
                .collect();
            let ventricle = |(index, fields): (usize, (Vec<f64>, Vec<f64>))| -> Result<_> {
                let ventricle = self.ventricle(&self.numbers(index), &thetas[index], fields)?;
                Ok(ventricle.map(|ventricle| (index, ventricle)))
            };
            let ventricles: Vec<_> = own.into_par_iter().map(ventricle).collect::<Result<_>>()?;
            all.extend(ventricles.into_iter().flatten());
        }
        Ok(all)
    }

    /// The ventricle whose shape numbers are zero.
    pub(super) fn mean(&self) -> Result<Body> {
        let [body, _] = self.stage.bodies(&[])?;
        Ok(body)
    }

    /// Parameter sets, spread evenly.
    pub(super) fn thetas(&self, count: usize) -> Result<Vec<Vec<f64>>> {
        let body = self.mean()?;
        Ok(Design::Sobol.sample(&body.parameters, count, self.seed)?)
    }

    /// One shape at some parameters, with the solutions; those without equilibrium are left out.
    pub(super) fn at(&self, numbers: &[f64], thetas: &[Vec<f64>]) -> Result<Vec<Ventricle>> {
        let one = |theta: &Vec<f64>| {
            let fields = (self.solve(numbers, theta)?, self.coarse(numbers, theta)?);
            self.ventricle(numbers, theta, fields)
        };
        let all: Vec<_> = thetas.par_iter().map(one).collect::<Result<_>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// Displacements of a shape \[mm\]; NaN where the solver finds none.
    fn solve(&self, numbers: &[f64], theta: &[f64]) -> Result<Vec<f64>> {
        let [fine, coarse] = self.stage.bodies(numbers)?;
        let solved = solve_nested(&coarse, &fine, theta);
        let none = || vec![f64::NAN; 3 * fine.nodes];
        Ok(solved.map_or_else(|_| none(), |solved| solved.displacement))
    }

    /// Logarithm of the cavity's growth on the coarse mesh, and the displacements of that at the nodes of the fine one \[mm\]; NaN where the
    /// solver finds none.
    fn coarse(&self, numbers: &[f64], theta: &[f64]) -> Result<Vec<f64>> {
        let [fine, coarse] = self.stage.bodies(numbers)?;
        let Ok(solved) = Solver::new(&coarse)?.solve(theta, &SolverOptions::default()) else {
            return Ok(vec![f64::NAN; 1 + 3 * fine.nodes]);
        };
        let rest = vec![0.0; 3 * coarse.nodes];
        let growth = volume(&coarse, &solved.displacement) / volume(&coarse, &rest);
        let prolongation = Prolongation::new(&coarse.positions, &fine.positions);
        let displacement = prolongation.vectors(&solved.displacement);
        Ok(std::iter::once(growth.ln()).chain(displacement).collect())
    }

    /// A ventricle with its fields on both meshes, if both have an equilibrium.
    fn ventricle(
        &self,
        numbers: &[f64],
        theta: &[f64],
        (displacement, coarse): (Vec<f64>, Vec<f64>),
    ) -> Result<Option<Ventricle>> {
        let [body, _] = self.stage.bodies(numbers)?;
        ensure!(
            displacement.len() == 3 * body.nodes && coarse.len() == 1 + displacement.len(),
            "a simulation of {} and {} numbers is not of {} nodes; remove it",
            displacement.len(),
            coarse.len(),
            body.nodes
        );
        if !displacement.iter().chain(&coarse).all(|u| u.is_finite()) {
            return Ok(None);
        }
        let coarse = Coarse { growth: coarse[0], displacement: coarse[1..].to_vec() };
        let (numbers, theta) = (numbers.to_vec(), theta.to_vec());
        Ok(Some(Ventricle { numbers, theta, body, displacement, coarse }))
    }

    /// Mean CPU times of ventricles on the coarse mesh, at the nodes of the fine one, and of the solver by way of it \[s\]; the bodies are
    /// there.
    pub(super) fn times(&self, quick: bool, ventricles: &[Ventricle]) -> Result<[f64; 2]> {
        let mut seconds = [0.0; 2];
        for Ventricle { numbers, theta, .. } in ventricles {
            let [fine, coarse] = self.stage.bodies(numbers)?;
            let by_coarse = || Ok(coarse_displacement(&coarse, &fine, theta)?);
            seconds[0] += cpu_seconds_of(quick, by_coarse)?;
            seconds[1] += cpu_seconds_of(quick, || Ok(solve_nested(&coarse, &fine, theta)?))?;
        }
        Ok(seconds.map(|s| s / ventricles.len() as f64))
    }

    /// Displacement of the nodes by every number of a shape \[mm\], root mean square.
    pub(super) fn sizes(&self) -> Result<Vec<f64>> {
        /// Size of a deviation: small, for the mean shape to stay a ventricle.
        const PART: f64 = 0.1;
        let points = |numbers: &[f64]| -> Result<Vec<[f64; 3]>> {
            Ok(VentricleShape::new(numbers)?.hexahedra(self.stage.cells)?.points)
        };
        let mean = points(&[])?;
        let size = |number: usize| -> Result<f64> {
            let numbers: Vec<f64> =
                (0..=number).map(|k| if k == number { PART } else { 0.0 }).collect();
            let moved = points(&numbers)?;
            let squared =
                moved.iter().flatten().zip(mean.iter().flatten()).map(|(a, b)| (a - b).powi(2));
            Ok((squared.sum::<f64>() / mean.len() as f64).sqrt() / PART)
        };
        (0..VentricleShape::NUMBERS).map(size).collect()
    }

    /// The graph of the mean ventricle, which all share.
    pub(super) fn graph(&self, virtual_nodes: &[usize]) -> Result<Topology> {
        let [body, _] = self.stage.bodies(&[])?;
        let config = AugmentationConfig {
            roots_per_layer: virtual_nodes.to_vec(),
            neighbours: NEIGHBOURS,
            seed: self.seed,
            ..AugmentationConfig::for_nodes(body.nodes)
        };
        Ok(augment(&body.positions, &body.mesh.edges(), &config)?)
    }
}

/// Rows of a file, found and written where there is none.
fn kept_table(
    file: &Path,
    rows: usize,
    find: impl FnOnce() -> Result<Vec<Vec<f64>>>,
) -> Result<Vec<Vec<f64>>> {
    let table = match file.exists() {
        true => store::read_table(file)?,
        false => {
            let found = find()?;
            store::write_table(file, &found)?;
            found
        }
    };
    let (file, found) = (file.display(), table.len());
    ensure!(found == rows, "{file} holds {found} simulations, not {rows}; remove it");
    Ok(table)
}

impl Coarse {
    /// Root mean square of the displacement \[mm\].
    fn size(&self) -> f64 {
        let squares: f64 = self.displacement.iter().map(|u| u * u).sum();
        (squares / self.displacement.len() as f64).sqrt()
    }
}

impl Ventricle {
    /// Logarithm of the cavity's volume over that at rest.
    pub(super) fn growth(&self, displacement: &[f64]) -> f64 {
        (self.volume(displacement) / self.volume(&vec![0.0; displacement.len()])).ln()
    }

    /// Displacement that the coarse mesh predicts.
    pub(super) fn known_growth(&self, told: Inputs) -> f64 {
        if told.coarse { self.coarse.growth } else { 0.0 }
    }

    /// Largest |J − 1| of a cell.
    pub(super) fn largest_volume_change(&self) -> f64 {
        let BodyArrays { volumes, points_per_cell, .. } = &*self.body;
        let of_cell = |(cell, volumes): (usize, &[f64])| {
            let change = |k: usize| {
                let h =
                    self.body.displacement_gradient(cell * points_per_cell + k, &self.displacement);
                volumes[k] * h.volume_change()
            };
            (0..*points_per_cell).map(change).sum::<f64>().abs() / volumes.iter().sum::<f64>()
        };
        volumes.chunks(*points_per_cell).enumerate().map(of_cell).fold(0.0, f64::max)
    }

    /// Volume of the inflated cavity \[mm³\].
    pub(super) fn volume(&self, displacement: &[f64]) -> f64 {
        volume(&self.body, displacement)
    }
}

impl Simulated for Ventricle {
    fn body(&self) -> &Body {
        &self.body
    }

    fn theta(&self) -> &[f64] {
        &self.theta
    }

    fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    fn inputs(&self, told: Inputs) -> Vec<f64> {
        let growth = told.coarse.then_some(self.coarse.growth);
        self.numbers[..told.numbers].iter().chain(&self.theta).copied().chain(growth).collect()
    }

    fn parameters(&self, told: Inputs) -> Vec<Parameter> {
        let numbers = shape_parameters(told.numbers);
        let growth = told.coarse.then(|| Parameter::linear("growth", "", 0.0..=GROWTH));
        numbers.chain(self.body.parameters.iter().cloned()).chain(growth).collect()
    }

    /// Features for networks (thesis §2.4.1): on nodes the base, the endocardium, the vector across the wall, the fibre and the radial
    /// direction, and what the coarse mesh says; the first numbers of its shape for all of it.
    fn geometry(&self, topology: &Topology, told: Inputs) -> Result<Geometry> {
        let BodyArrays { positions, mesh, nodes, .. } = &*self.body;
        let sets = mesh.node_sets();
        let indicator = |name: &str| FeatureMatrix::indicator(*nodes, &sets[name]);
        // Layers of nodes follow each other from the inside.
        let sheet = sets["endo"].len();
        let across = |node: usize| -> [f64; 3] {
            let [inner, outer] = [node % sheet, nodes - sheet + node % sheet];
            std::array::from_fn(|i| positions[outer][i] - positions[inner][i])
        };
        let across: Vec<_> = (0..*nodes).map(across).collect();
        let fibres = mesh.point_fields()["fibre"].to_vectors::<3>();
        let fibres = fibres.context("a ventricle without fibres")?;
        let radial = |x: &[f64; 3]| {
            let r = x[0].hypot(x[1]).max(f64::MIN_POSITIVE);
            [x[0] / r, x[1] / r]
        };
        let radial: Vec<_> = positions.iter().map(radial).collect();
        let columns = indicator("base")?
            .hstack(&indicator("endo")?)?
            .hstack(&FeatureMatrix::from_rows(&across))?
            .hstack(&FeatureMatrix::from_rows(&fibres))?
            .hstack(&FeatureMatrix::from_rows(&radial))?;
        let (nodes, _) = self.coarse.displacement.as_chunks::<3>();
        let columns = match told.coarse {
            true => columns.hstack(&FeatureMatrix::from_rows(nodes))?,
            false => columns,
        };
        let growth = told.coarse.then_some(self.coarse.growth);
        Ok(Geometry {
            features: graph_features(topology, positions, &columns, 3)?,
            global: self.numbers[..told.numbers].iter().copied().chain(growth).collect(),
            dirichlet: Dirichlet::of_body(&self.body),
            coordinates: Coordinates::Components,
            topology: topology.clone(),
        })
    }

    fn known(&self, told: Inputs) -> Option<(&[f64], f64)> {
        told.coarse.then(|| (&self.coarse.displacement[..], self.coarse.size()))
    }

    fn lengths(displacement: &[f64]) -> Vec<f64> {
        displacement.as_chunks::<3>().0.iter().map(|[x, y, z]| x.hypot(*y).hypot(*z)).collect()
    }

    fn volume_error(&self, found: &[f64]) -> Option<f64> {
        let volume = self.volume(&self.displacement);
        Some((self.volume(found) - volume).abs() / volume)
    }
}

/// LVV, the volume of the convex hull of the endocardium \[mm³\].
fn volume(body: &Body, displacement: &[f64]) -> f64 {
    let (moves, _) = displacement.as_chunks::<3>();
    let at = |&node: &usize| std::array::from_fn(|i| body.positions[node][i] + moves[node][i]);
    hull_volume(&body.mesh.node_sets()["endo"].iter().map(at).collect::<Vec<_>>())
}

//! What the example programs share: a case file that describes one's own body and emulator.
//!
//! The programs are in `examples/examples`; start one with `cargo run -p sinew-examples --example NAME`.

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Parameter, Sampling, Scene, Support, Units};
use sinew_gnn::{Dirichlet, EmulatorConfig, Geometry, ParameterScaling};
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};
use sinew_mesh::{TetMesh, box_tetrahedra, read_tet_mesh};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A case file: see `examples/cases/hanging_bar.toml` for every key with its unit.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// How the emulator is trained.
    pub method: Method,
    /// Folder for what the programs write, relative to where they are started.
    pub output: PathBuf,
    /// The body.
    pub mesh: MeshSource,
    /// What acts on it.
    pub load: LoadCase,
    /// Ranges of the material parameters.
    pub parameters: Parameters,
    /// Length and rates of the training.
    pub training: Training,
    /// Sizes of the network.
    pub network: Network,
}

/// On simulations or on the potential energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Minimum potential energy, no simulations.
    Pi,
    /// Simulated displacements.
    Dd,
}

/// Where the mesh comes from and where it is held.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSource {
    /// A file, relative to the case file.
    pub file: Option<PathBuf>,
    /// A generated box.
    #[serde(rename = "box")]
    pub generated: Option<BoxMesh>,
    /// Node set, or point field that is not zero where the body is held.
    pub clamped: String,
}

/// A box of tetrahedra.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxMesh {
    /// Edge lengths \[mm\].
    pub extent: [f64; 3],
    /// Cells along each edge.
    pub cells: [usize; 3],
}

/// Loads; at least one.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadCase {
    /// Force per reference volume [kPa/mm].
    pub body_force: Option<[f64; 3]>,
    /// A pressure that follows the surface.
    pub pressure: Option<SurfacePressure>,
}

/// A pressure on a part of the surface whose rim is held.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfacePressure {
    /// Facet set.
    pub facets: String,
    /// Pressure against the solid \[kPa\].
    pub value: f64,
}

/// Smallest and largest Lamé parameters \[kPa\].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Shear modulus μ.
    pub mu: [f64; 2],
    /// First Lamé parameter λ.
    pub lambda: [f64; 2],
}

/// Length and rates of the training.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Training {
    /// Parameter sets to train with.
    pub samples: usize,
    /// Optimiser steps.
    pub steps: usize,
    /// Parameter sets per step.
    pub batch: usize,
    /// Peak learning rate.
    pub learning_rate: f64,
    /// Seed of everything random.
    pub seed: u64,
}

/// Sizes of the network.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Width of the embeddings.
    pub latent: usize,
    /// Width of the hidden layers.
    pub width: usize,
    /// Message-passing steps.
    pub message_passing_steps: usize,
}

/// A case made ready: the body as solver and emulator read it.
#[derive(Debug)]
pub struct Prepared {
    /// Mesh with its sets.
    pub mesh: TetMesh,
    /// Potential energy.
    pub potential: Body,
    /// Augmented graph.
    pub topology: Topology,
    /// Features and supports.
    pub geometry: Geometry,
    /// Sizes of the network.
    pub network: EmulatorConfig,
    /// Parameter ranges.
    pub scaling: ParameterScaling,
}

impl Case {
    /// The case that comes with the examples, `examples/cases/hanging_bar.toml`.
    ///
    /// # Errors
    /// A file that was changed or removed since.
    pub fn bundled() -> Result<Self> {
        Self::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/hanging_bar.toml"))
    }

    /// Reads a case file; its mesh file is relative to its folder.
    ///
    /// # Errors
    /// A file that cannot be read, or a key that is missing, unknown or of the wrong type, by name and line.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("the case file {} cannot be read", path.display()))?;
        let mut case: Self =
            toml::from_str(&text).with_context(|| format!("in {}", path.display()))?;
        if let Some(file) = &mut case.mesh.file {
            *file = path.parent().unwrap_or(Path::new(".")).join(&*file);
        }
        Ok(case)
    }

    /// Members of an endless sequence of parameter sets that fill the ranges evenly and log-uniformly (an
    /// additive recurrence, Roberts 2018). The first [`Training::samples`] are trained on.
    pub fn thetas(&self, members: Range<usize>) -> Vec<Vec<f64>> {
        const STEPS: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];
        let ranges = [self.parameters.mu, self.parameters.lambda];
        let value = |i: usize, axis: usize| {
            let share = (0.5 + STEPS[axis] * (i + 1) as f64).fract();
            let [low, high] = ranges[axis];
            low * (high / low).powf(share)
        };
        members.map(|i| vec![value(i, 0), value(i, 1)]).collect()
    }

    /// The middle of the ranges, on the log scale.
    pub fn centre(&self) -> Vec<f64> {
        [self.parameters.mu, self.parameters.lambda].map(|[low, high]| (low * high).sqrt()).into()
    }

    /// Builds the body.
    ///
    /// # Errors
    /// A mesh that cannot be read or made, a clamped set that does not exist, loads or ranges that make no sense.
    pub fn prepare(&self) -> Result<Prepared> {
        let mesh = self.mesh()?;
        let stiffness = |name: &str, range| Parameter {
            name: name.into(),
            unit: "kPa".into(),
            range,
            sampling: Sampling::Log,
        };
        let scene = Scene {
            name: "case".into(),
            units: Units::mm_kpa(),
            mesh,
            law: NeoHookean,
            directions: Vec::new(),
            parameters: vec![
                stiffness("mu", self.parameters.mu),
                stiffness("lambda", self.parameters.lambda),
            ],
            loads: self.loads()?,
            supports: vec![Support::clamped("clamped")],
        };
        let potential = scene.lower()?;
        let mesh = scene.mesh;
        let nodes = mesh.points.len();
        let mut graph = AugmentationConfig::for_nodes(nodes);
        graph.seed = self.training.seed;
        let topology = augment(&mesh.points, &sinew_mesh::edges(&mesh), &graph)?;
        let indicator = FeatureMatrix::indicator(nodes, &mesh.node_sets["clamped"])?;
        let features = graph_features(&topology, &mesh.points, &indicator, 3)?;
        let network = EmulatorConfig {
            latent: self.network.latent,
            width: self.network.width,
            steps: self.network.message_passing_steps,
            ..EmulatorConfig::new(3, features.nodes.columns, features.edges.columns, 2)
        };
        let dirichlet = Dirichlet::of_body(&potential);
        let geometry = Geometry {
            features,
            global: Vec::new(),
            dirichlet,
            coordinates: sinew_gnn::Coordinates::Components,
        };
        let ([a, b], [c, d]) = (self.parameters.mu, self.parameters.lambda);
        let scaling = ParameterScaling::logarithmic(&[a, c], &[b, d])?;
        Ok(Prepared { mesh, potential, topology, geometry, network, scaling })
    }

    fn loads(&self) -> Result<Vec<Load>> {
        let body_force = self.load.body_force.map(Load::BodyForce);
        let pressure = self.load.pressure.as_ref().map(|pressure| Load::Pressure {
            facets: pressure.facets.clone(),
            magnitude: Magnitude::Fixed(pressure.value),
        });
        let loads: Vec<_> = body_force.into_iter().chain(pressure).collect();
        ensure!(!loads.is_empty(), "load needs `body_force` or `pressure`");
        Ok(loads)
    }

    /// The mesh, with the held nodes as the set "clamped".
    fn mesh(&self) -> Result<TetMesh> {
        let mut mesh = match (&self.mesh.file, &self.mesh.generated) {
            (Some(file), None) => read_tet_mesh(file)?.0,
            (None, Some(generated)) => {
                let positive =
                    generated.extent.iter().all(|&length| length > 0.0 && length.is_finite());
                ensure!(
                    positive && generated.cells.iter().all(|&count| count > 0),
                    "mesh.box needs positive lengths and at least one cell along each edge"
                );
                box_tetrahedra(generated.extent, generated.cells)
            }
            _ => anyhow::bail!("mesh needs either `file` or `box`"),
        };
        let name = &self.mesh.clamped;
        let held = match mesh.node_sets.get(name) {
            Some(set) => set.clone(),
            None => mesh.nodes_where_nonzero(name).with_context(|| {
                let sets: Vec<_> = mesh.node_sets.keys().collect();
                let fields: Vec<_> = mesh.point_fields.keys().collect();
                format!("mesh.clamped = {name:?} is no node set ({sets:?}) and no point field ({fields:?})")
            })?,
        };
        ensure!(!held.is_empty(), "mesh.clamped = {name:?} holds no node");
        mesh.node_sets.insert("clamped".into(), held);
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped() -> String {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/hanging_bar.toml");
        std::fs::read_to_string(path).unwrap()
    }

    #[test]
    fn the_shipped_case_is_ready_to_train() {
        let case: Case = toml::from_str(&shipped()).unwrap();
        let prepared = case.prepare().unwrap();
        assert_eq!(prepared.potential.nodes, 9 * 3 * 3);
        let inside = |theta: &Vec<f64>| prepared.scaling.contains(theta);
        assert!(case.thetas(0..200).iter().all(inside));
    }

    #[test]
    fn mistakes_are_named() {
        let error = |from: &str, to: &str| {
            let text = shipped().replace(from, to);
            match toml::from_str::<Case>(&text) {
                Ok(case) => format!("{:#}", case.prepare().unwrap_err()),
                Err(error) => error.to_string(),
            }
        };
        assert!(error("clamped = \"x_min\"", "clamped = \"left\"").contains("x_min"));
        assert!(error("steps = 3000", "stepps = 3000").contains("stepps"));
        assert!(error("\"pi\"", "\"magic\"").contains("magic"));
        assert!(error("mu = [8.0, 16.0]", "mu = [-8.0, 16.0]").contains("mu"));
        assert!(error("body_force = [0.0, 0.0, -9.8e-3]", "").contains("body_force"));
        let pressed = "pressure = { facets = \"lid\", value = 0.1 }";
        assert!(error("body_force = [0.0, 0.0, -9.8e-3]", pressed).contains("z_max"));
        assert!(error("cells = [8, 2, 2]", "cells = [8, 0, 2]").contains("mesh.box"));
    }
}

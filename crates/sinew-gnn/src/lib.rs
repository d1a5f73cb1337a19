//! Graph-network emulators of soft-tissue mechanics, trained on simulations or on potential energy.
//!
//! A soft bar, emulated by a regression; `PhysicsInformed` and `DataDriven` in its place train networks:
//!
//! ```
//! use sinew_emulate::TrainingOptions;
//! use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
//! use sinew_gnn::{Recipe, recipe::Regression};
//!
//! let body = Scene::new(sinew_mesh::box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]), NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
//!     .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
//!     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
//!     .support(Support::clamped("x_min"))
//!     .lower()?;
//! let recipe = Recipe::from(Regression::default());
//! let emulator = recipe.train(&body, &TrainingOptions::default(), &mut ())?;
//! println!("{}", emulator.record.choice.as_ref().ok_or("a number of simulations was chosen")?);
//! let prediction = emulator.predict(&[vec![10.0, 12.0]])?;
//! assert!(emulator.estimate(&prediction, 0)?.distance.ok_or("an equilibrium is near")?.mean < 1e-3); // mm
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Recipe`] names all recipes: networks ([`recipe::DataDriven`], [`recipe::PhysicsInformed`]), regression
//! ([`recipe::Regression`]) and the Taylor expansion ([`Recipe::Taylor`]). [`load`] reads an emulator from its folder.
//!
//! # Parts
//!
//! A graph network (thesis, Algorithm 2) passes messages over the augmented graph of a mesh and then
//! decodes, for any parameters θ, the displacement of every node. Here one learns a made-up plane
//! cantilever whose deflection is inverse to its stiffness:
//!
//! ```
//! use sinew_emulate::coordinates::{Coordinates, Dirichlet, OutputScale, ParameterScaling};
//! use sinew_gnn::*;
//! use sinew_graph::{AugmentationConfig, FeatureMatrix, augment, graph_features};
//!
//! // A geometry on its augmented graph.
//! let mesh = sinew_mesh::rectangle_triangles([40.0, 10.0], [6, 2]);
//! let nodes = mesh.points.len();
//! let config = AugmentationConfig::for_nodes(nodes);
//! let topology = augment(&mesh.points, &sinew_mesh::edges(&mesh), &config)?;
//! let clamped: Vec<usize> = (0..nodes).filter(|&i| mesh.points[i][0] == 0.0).collect();
//! let indicator = FeatureMatrix::indicator(nodes, &clamped)?;
//! let geometry = Geometry {
//!     features: graph_features(&topology, &mesh.points, &indicator, 2)?,
//!     global: vec![],
//!     dirichlet: Dirichlet::clamped(nodes, 2, &clamped)?,
//!     coordinates: Coordinates::Components,
//!     topology,
//! };
//!
//! // Samples; training on energy needs no displacements.
//! let deflection = |x: f64, stiffness: f64| -1e-3 * x * x / stiffness;
//! let sample = |stiffness: f64| Sample {
//!     geometry: 0,
//!     theta: vec![stiffness],
//!     displacement: mesh.points.iter().flat_map(|x| [0.0, deflection(x[0], stiffness)]).collect(),
//! };
//! let training: Vec<Sample> = (0..12).map(|i| sample(0.5 * 1.12f64.powi(i))).collect();
//! let data = DataSet { geometries: vec![geometry], training, validation: vec![] };
//!
//! // Scales, network, objective, training.
//! let fields = data.training.iter().map(|sample| &sample.displacement[..]);
//! let output = OutputScale::standardising(2, fields)?;
//! let objective = DataFit::new(output.length())?;
//! let parameters = ParameterScaling::logarithmic(&[0.5], &[2.0])?;
//! let scales = Scales::over(&data.geometries, parameters, output)?;
//! let network = GraphNetworkConfig { width: 16, latent: 8, steps: 2, ..GraphNetworkConfig::new(2, 1, 3, 1) };
//! let device = Backend::Flex.device()?;
//! let surrogate = Surrogate::new(&network, &data, scales, 0, &device)?;
//! let settings = TrainingConfig { learning_rate: 1e-2, budget: TrainingBudget::Steps(200), ..Default::default() };
//! let mut trainer = Trainer::new(surrogate, data, Box::new(objective), settings)?;
//! trainer.run(&mut ())?;
//!
//! // Message passing once, then the decoder only.
//! let surrogate = trainer.into_surrogate();
//! let fixed = surrogate.fixed_geometry(&surrogate.geometries()[0])?;
//! let prediction = fixed.predict(&[vec![0.8]])?;
//! let tip = mesh.points.iter().position(|x| x[0] == 40.0).ok_or("a tip")?;
//! assert!((prediction[0][2 * tip + 1] / deflection(40.0, 0.8) - 1.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`GraphNetwork`]: the network; [`Surrogate`]: the network with units, supports and geometries;
//!   [`FixedGeometry`]: a surrogate on one geometry, with derivatives by θ.
//! - [`Objective`]: what is minimised, the only difference between data-driven ([`DataFit`]) and physics-informed ([`MinimumPotential`]) training.
//! - [`Trainer`]: batches of θ that share one message-passing pass, optimisers (Muon, Adam),
//!   schedules, validation, checkpoints that continue bit for bit.
//!
//! Nothing assumes one geometry or three dimensions.
//!
//! # Equations
//!
//! K message-passing steps with embeddings v of nodes and e of stored edges, each edge from a sender s to a receiver i; sums are signed by the direction (thesis, Algorithm 2 and (2.28)):
//!
//! ```math
//! m_{is} = \phi_e(e_{is}, v_i, v_s), \qquad v_i \leftarrow v_i + \phi_v\Bigl(v_i, \sum_s \pm\, m_{is}\Bigr), \qquad e_{is} \leftarrow e_{is} + m_{is}
//! ```
//!
//! The decoder of each displacement component reads embeddings of the parameters, the shape and the node:
//!
//! ```math
//! \hat u_d(X_i;\theta) = \psi_d\Bigl(z_\theta, z_{\text{global}}, \bigl[v_i, \textstyle\sum_s e_{is}\bigr]\Bigr)
//! ```
//!
//! Losses: supervised ([`DataFit`], thesis (3.11)) and physics-informed, without simulations ([`MinimumPotential`], (3.12) and (3.16)):
//!
//! ```math
//! \mathcal L_{\text{data}} = \operatorname{mean}_i \|u_i - \hat u_i\|, \quad
//! \mathcal L_\Pi = \Pi(\hat u;\theta)
//! ```
//!
//! All are divided by a characteristic length or energy. Cells that training may invert are kept finite by barriers in Π (`sinew_energy::Barriers`).

mod config;
mod data;
mod device;
mod error;
pub mod fused;
mod graph;
mod graph_network;
mod map;
mod network;
mod objective;
mod optimiser;
mod perceptron;
pub mod recipe;
mod store;
mod surrogate;
mod training;

pub use config::{Decoding, GraphNetworkConfig};
pub use data::{DataSet, Geometry, Sample};
pub use device::Backend;
pub use error::{Error, Result};
pub use fused::Activation;
pub use graph::Graph;
pub use graph_network::{Embedding, GraphNetwork};
pub use network::{KINDS, Network, OutputCoordinates};
pub use objective::{DataFit, MinimumPotential, Objective, Potential};
pub use optimiser::OptimiserConfig;
pub use recipe::Recipe;
pub use surrogate::{FixedGeometry, Scales, Surrogate};
pub use training::{
    Concern, HistoryPoint, Schedule, Trainer, TrainingBudget, TrainingConfig, TrainingObserver,
    TrainingProgress, TrainingReport,
};

use sinew_emulate::{Body, Emulator};
use std::path::Path;

/// Reads an emulator of `body`, be its predictor a network or not.
///
/// # Errors
/// As [`Emulator::load`].
pub fn load<'b>(folder: &Path, body: &'b Body) -> sinew_emulate::Result<Emulator<'b>> {
    Emulator::load_with(folder, body, KINDS)
}

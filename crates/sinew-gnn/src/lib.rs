//! Graph-network emulators of soft-tissue mechanics, trained on simulations or on potential energy

mod config;
mod data;
mod device;
mod emulator;
mod error;
mod files;
mod fixed;
mod graph;
mod kernels;
mod objective;
mod optimiser;
mod output_basis;
mod perceptron;
mod random;
mod scaling;
mod schedule;
mod store;
mod surrogate;
mod training;

pub use config::{Activation, EmulatorConfig};
pub use data::{DataSet, Dirichlet, Geometry, Sample};
pub use device::Backend;
pub use emulator::Emulator;
pub use error::{Error, Result};
pub use fixed::{FixedGeometry, Prediction, Sensitivity};
pub use graph::GraphTensors;
pub use kernels::KernelChoice;
pub use objective::{
    Batch, DataFit, DataFitWithGradient, GradientOperator, MinimumPotential, Objective, Potential,
};
pub use optimiser::{Muon, MuonConfig, Optimiser, OptimiserConfig};
pub use output_basis::OutputBasis;
pub use scaling::{GlobalScaling, OutputScale, ParameterRange, ParameterScale, ParameterScaling};
pub use schedule::Schedule;
pub use surrogate::{Scales, Surrogate};
pub use training::{
    Budget, HistoryPoint, Observer, Progress, StopReason, Trainer, TrainingConfig, TrainingReport,
};

//! Graph-network emulators of soft-tissue mechanics, trained on simulations or on potential energy

mod config;
mod data;
mod device;
mod emulator;
mod error;
mod fixed;
mod graph;
mod kernels;
mod perceptron;
mod random;
mod scaling;
mod surrogate;

pub use config::{Activation, EmulatorConfig};
pub use data::{DataSet, Dirichlet, Geometry, Sample};
pub use device::Backend;
pub use emulator::Emulator;
pub use error::{Error, Result};
pub use fixed::{FixedGeometry, Prediction, Sensitivity};
pub use graph::GraphTensors;
pub use kernels::KernelChoice;
pub use scaling::{GlobalScaling, OutputScale, ParameterRange, ParameterScale, ParameterScaling};
pub use surrogate::{Scales, Surrogate};

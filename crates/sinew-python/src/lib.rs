//! The compiled half of the Python package `pysinew`: cases and emulators, numbers in and out as numpy arrays.
//!
//! A leaf without logic of its own. The Python half (`python/pysinew`) reads what users write, and makes what they read.

mod arrays;
mod calibration;
mod case;
mod emulator;
mod errors;
mod mesh;
mod relay;
mod results;
mod runs;
mod training;

use pyo3::prelude::*;

/// Module `pysinew._native`.
#[pymodule]
#[pyo3(name = "_native")]
fn native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("NETWORKS", sinew::NETWORKS)?;
    module.add_class::<case::NativeCase>()?;
    module.add_class::<emulator::NativeEmulator>()?;
    module.add_class::<mesh::NativeMesh>()?;
    module.add_class::<runs::NativeRuns>()?;
    module.add_function(wrap_pyfunction!(case::scenes, module)?)?;
    module.add_function(wrap_pyfunction!(calibration::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(calibration::check_calibration, module)?)?;
    module.add_function(wrap_pyfunction!(calibration::synthesise, module)?)?;
    Ok(())
}

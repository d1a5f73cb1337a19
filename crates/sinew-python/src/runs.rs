//! Emulators of stored runs of any solver.

use crate::arrays::{matrix, rows, vector};
use crate::errors::{self, Kind};
use crate::mesh::NativeMesh;
use crate::relay;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use sinew::runs::{Measured, Runs, RunsPosterior, RunsPosteriorError};
use sinew::sample::NutsOptions;
use sinew_emulate::{Output, RunsEmulator};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Gaussian processes of numbers or displacements over θ.
#[pyclass(frozen, module = "pysinew._native")]
pub(crate) struct NativeRuns(Arc<RunsEmulator>);

/// Values of an output, a row for each θ, and half-widths of their 95 % intervals.
type Predicted<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);
/// Name, unit and a matrix with a row per run.
type Column<'py> = (String, String, PyReadonlyArray2<'py, f64>);

#[pymethods]
impl NativeRuns {
    /// Fits outputs to θ; displacements on a mesh.
    #[staticmethod]
    fn fit(
        py: Python<'_>,
        parameters: Vec<(String, String)>,
        thetas: PyReadonlyArray2<'_, f64>,
        outputs: Vec<Column<'_>>,
        mesh: Option<&NativeMesh>,
        listener: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let heads: Vec<_> = parameters.iter().map(|(name, unit)| (&name[..], &unit[..])).collect();
        let output =
            |(name, unit, values): Column<'_>| Output { name, unit, values: rows(&values) };
        let outputs = outputs.into_iter().map(output).collect();
        let made = Runs::new(&heads, rows(&thetas), outputs, |run| format!("run {run}"));
        let Runs { parameters, thetas, outputs, .. } =
            made.map_err(|reason| Kind::Case.of(py, reason))?;
        let mesh = mesh.map(|mesh| mesh.make(py)).transpose()?.map(|(mesh, _)| mesh);
        let fitted = relay::run(py, listener, move |observer| {
            RunsEmulator::fit(parameters, &thetas, &outputs, mesh, observer)
        })?;
        fitted
            .map(|emulator| Self(Arc::new(emulator)))
            .map_err(|error| errors::emulator(py, &error))
    }

    #[staticmethod]
    fn load(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let loaded = RunsEmulator::load(&within(&folder));
        loaded
            .map(|emulator| Self(Arc::new(emulator)))
            .map_err(|error| errors::emulator(py, &error))
    }

    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        self.0.save(&within(&folder)).map_err(|error| errors::emulator(py, &error))
    }

    /// Names, units and ranges.
    #[getter]
    fn parameters(&self) -> Vec<(&str, &str, (f64, f64))> {
        let told = |p: &'_ sinew::Parameter| (p.range[0], p.range[1]);
        self.0.parameters.iter().map(|p| (&p.name[..], p.unit.name(), told(p))).collect()
    }

    /// Name, unit, error of runs left out and R² of each output.
    #[getter]
    fn left_out(&self) -> Vec<(&str, &str, f64, f64)> {
        let told = self.0.left_out().iter();
        told.map(|left| (&left.name[..], &left.unit[..], left.error, left.r_squared())).collect()
    }

    /// Whether outputs are displacements.
    #[getter]
    fn of_fields(&self) -> bool {
        self.0.mesh.is_some()
    }

    fn predict<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Vec<Predicted<'py>>> {
        let thetas = rows(&thetas);
        let found: Result<Vec<_>, _> =
            py.detach(|| thetas.iter().map(|t| self.0.predict(t)).collect());
        let found = found.map_err(|error| errors::emulator(py, &error))?;
        let output = |place: usize| {
            let values: Vec<f64> = found.iter().flat_map(|all| all[place].values.clone()).collect();
            let widths = found.iter().map(|all| all[place].half_width).collect();
            let shape = [thetas.len(), values.len() / thetas.len().max(1)];
            Ok((matrix(py, values, shape)?, vector(py, widths)))
        };
        (0..self.0.left_out().len()).map(output).collect()
    }

    /// Warnings about parameters outside their ranges.
    fn outside(&self, theta: Vec<f64>) -> Vec<String> {
        sinew::outside(&self.0.parameters, &theta)
    }

    /// Groups of draws for arviz as JSON, the result in lines, and warnings; data by output, value and standard deviation.
    fn posterior(
        &self,
        py: Python<'_>,
        data: Vec<(String, f64, f64)>,
        seed: u64,
        draws: usize,
        listener: &Bound<'_, PyAny>,
    ) -> PyResult<(String, Vec<String>, Vec<String>)> {
        let emulator = self.0.clone();
        let measured = |(output, value, sd)| Measured { output, value, sd };
        let data: Vec<Measured> = data.into_iter().map(measured).collect();
        let options = NutsOptions { seed, draws, ..NutsOptions::default() };
        let found = relay::run(py, listener, move |observer| {
            RunsPosterior::new(&emulator, &data, &options, observer)
        })?;
        let posterior = found.map_err(|error| match &error {
            RunsPosteriorError::Input(_) => Kind::Case.of(py, error),
            RunsPosteriorError::Chains(_) => Kind::Calibration.of(py, error),
        })?;
        Ok((posterior.to_arviz().to_json(), posterior.in_words(), posterior.warnings))
    }
}

/// Folder of the emulator within that of the program.
fn within(folder: &Path) -> PathBuf {
    folder.join("emulator")
}

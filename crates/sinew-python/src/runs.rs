//! Emulators of stored runs of any solver.

use crate::arrays::{Array, Rows};
use crate::emulator::Page;
use crate::errors::Result;
use crate::mesh::NativeMesh;
use crate::relay;
use pyo3::prelude::*;
use sinew::runs::{Measured, Runs, RunsPosterior};
use sinew::sample::NutsOptions;
use sinew_emulate::{Output, RunsEmulator};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Gaussian processes of numbers or displacements over θ.
#[pyclass(frozen, module = "pysinew._native")]
pub(crate) struct NativeRuns(Arc<RunsEmulator>);

/// Values of an output, a row for each θ, and half-widths of their 95 % intervals.
type Predicted = (Array, Array);
/// Name, unit and a matrix with a row per run.
type Column = (String, String, Rows);

#[pymethods]
impl NativeRuns {
    /// Fits outputs to θ; displacements on a mesh.
    #[staticmethod]
    fn fit(
        parameters: Vec<(String, String)>,
        thetas: Rows,
        outputs: Vec<Column>,
        mesh: Option<&NativeMesh>,
        listener: &Bound<'_, PyAny>,
    ) -> Result<Self> {
        let heads: Vec<_> = parameters.iter().map(|(name, unit)| (&name[..], &unit[..])).collect();
        let output = |(name, unit, Rows(values)): Column| Output { name, unit, values };
        let outputs = outputs.into_iter().map(output).collect();
        let runs = Runs::new(&heads, thetas.0, outputs, |run| format!("run {run}"))?;
        let made = mesh.map(NativeMesh::make).transpose()?;
        if made.as_ref().is_some_and(|(_, report)| report.unused_nodes > 0) {
            return Err("mesh: leave nodes of no cell out, there and in the displacements".into());
        }
        let runs = match made {
            Some((mesh, _)) => runs.on(mesh)?,
            None => runs,
        };
        let fitted = relay::run(listener, move |observer| runs.fit(observer))?;
        Ok(Self(Arc::new(fitted)))
    }

    #[staticmethod]
    fn load(folder: PathBuf) -> Result<Self> {
        Ok(Self(Arc::new(RunsEmulator::load(&within(&folder))?)))
    }

    fn save(&self, folder: PathBuf) -> Result<()> {
        Ok(self.0.save(&within(&folder))?)
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

    /// Reasons not to trust it.
    #[getter]
    fn warnings(&self) -> &[String] {
        &self.0.warnings
    }

    /// Whether outputs are displacements.
    #[getter]
    fn of_fields(&self) -> bool {
        self.0.mesh.is_some()
    }

    fn predict(&self, py: Python<'_>, thetas: Rows) -> Result<Vec<Predicted>> {
        let predict =
            || thetas.0.iter().map(|theta| self.0.predict(theta)).collect::<Result<_, _>>();
        let found: Vec<Vec<sinew_emulate::Predicted>> = py.detach(predict)?;
        let output = |place: usize| {
            let values: Vec<f64> = found.iter().flat_map(|all| all[place].values.clone()).collect();
            let widths = found.iter().map(|all| all[place].half_width).collect();
            let shape = [thetas.0.len(), values.len() / thetas.0.len().max(1)];
            (Array::new(values, shape), Array::vector(widths))
        };
        Ok((0..self.0.left_out().len()).map(output).collect())
    }

    /// The emulator of displacements as one page for a browser, what was measured of it by name, and notes.
    fn page(&self, py: Python<'_>) -> Result<Page> {
        let viewer = py.detach(|| sinew::viewer_of_runs(&self.0, "runs", sinew::PAGE_SEED))?;
        Ok((viewer.to_html(), viewer.facts, viewer.notes))
    }

    /// Warnings about parameters outside their ranges.
    fn outside(&self, theta: Vec<f64>) -> Vec<String> {
        sinew::outside(&self.0.parameters, &theta)
    }

    /// Groups of draws for arviz as JSON, the result in lines, and warnings; data by output, value and standard deviation.
    fn posterior(
        &self,
        data: Vec<(String, f64, f64)>,
        seed: u64,
        draws: usize,
        listener: &Bound<'_, PyAny>,
    ) -> Result<(String, Vec<String>, Vec<String>)> {
        let emulator = self.0.clone();
        let measured = |(output, value, sd)| Measured { output, value, sd };
        let data: Vec<Measured> = data.into_iter().map(measured).collect();
        let options = NutsOptions { seed, draws, ..NutsOptions::default() };
        let posterior = relay::run(listener, move |observer| {
            RunsPosterior::new(&emulator, &data, &options, observer)
        })?;
        Ok((posterior.to_arviz().to_json(), posterior.in_words(), posterior.warnings))
    }
}

/// Folder of the emulator within that of the program.
fn within(folder: &Path) -> PathBuf {
    folder.join("emulator")
}

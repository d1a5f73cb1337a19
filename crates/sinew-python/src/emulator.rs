//! Emulators: predictions, error estimates, corrections, sensitivities.

use crate::arrays::{cube, rows, vector};
use crate::errors::{self, Kind};
use crate::relay;
use numpy::{PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::self_cell;
use sinew::case::Training;
use sinew::{Body, Emulator, Estimate, Prediction, TrainingOptions};
use sinew_emulate::{Error, Warning};
use std::path::{Path, PathBuf};
use std::sync::Arc;

self_cell!(
    /// An emulator with the body that it is of.
    struct Owned {
        owner: Arc<Body>,
        #[not_covariant]
        dependent: Emulator,
    }
);

/// A trained emulator.
#[pyclass(frozen, module = "pysinew._native")]
pub(crate) struct NativeEmulator(Arc<Owned>);

/// Predictions of so many sets are made beside Python, so that Ctrl-C is heard; fewer take less time than that.
const MANY: usize = 1000;

impl NativeEmulator {
    /// Shares the emulator with another thread.
    pub(crate) fn shared(&self) -> Self {
        Self(self.0.clone())
    }

    pub(crate) fn trained(
        py: Python<'_>,
        body: Arc<Body>,
        training: Training,
        options: TrainingOptions,
        listener: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let made = relay::run(py, listener, move |observer| {
            Owned::try_new(body, |body| training.train(body, &options, observer))
        })?;
        made.map(|owned| Self(Arc::new(owned))).map_err(|error| errors::emulator(py, &error))
    }

    pub(crate) fn loaded(py: Python<'_>, body: Arc<Body>, folder: &Path) -> PyResult<Self> {
        let made = py.detach(|| Owned::try_new(body, |body| sinew::load(folder, body)));
        made.map(|owned| Self(Arc::new(owned))).map_err(|error| errors::emulator(py, &error))
    }

    fn body(&self) -> &Arc<Body> {
        self.0.borrow_owner()
    }

    pub(crate) fn with<T>(&self, call: impl for<'b> FnOnce(&Emulator<'b>) -> T) -> T {
        self.0.with_dependent(|_, emulator| call(emulator))
    }

    /// Work beside Python with the emulator.
    fn beside<T: Send + 'static>(
        &self,
        py: Python<'_>,
        listener: &Bound<'_, PyAny>,
        work: impl for<'b> FnOnce(&Emulator<'b>) -> Result<T, Error> + Send + 'static,
    ) -> PyResult<T> {
        let shared = self.shared();
        let found = relay::run(py, listener, move |_| shared.with(work))?;
        found.map_err(|error| errors::emulator(py, &error))
    }
}

/// Displacements, and the warnings of each.
type Predicted<'py> = (Bound<'py, PyArray3<f64>>, Vec<Vec<String>>);

#[pymethods]
impl NativeEmulator {
    /// Provenance of the emulator, as JSON.
    #[getter]
    fn record(&self, py: Python<'_>) -> PyResult<String> {
        let record = self.with(|emulator| serde_json::to_string(&emulator.record));
        record.map_err(|error| Kind::Emulator.of(py, error))
    }

    /// Provenance of the emulator, for people.
    #[getter]
    fn words(&self) -> String {
        self.with(|emulator| {
            let record = &emulator.record;
            let chosen = record.choice.as_ref().map(ToString::to_string);
            chosen.unwrap_or_else(|| record.about.clone())
        })
    }

    /// Reasons not to trust it.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.with(|emulator| said(&emulator.record.warnings))
    }

    /// Stores it in a folder.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        let saved = self.with(|emulator| emulator.save(&folder));
        saved.map_err(|error| errors::emulator(py, &error))
    }

    /// Displacements at every row of θ and the warnings of each, after some quasi-Newton steps with a frozen stiffness.
    fn predict<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
        refine: usize,
        listener: &Bound<'py, PyAny>,
    ) -> PyResult<Predicted<'py>> {
        let thetas = rows(&thetas);
        let shape = [thetas.len(), self.body().nodes, 3];
        let found = if refine > 0 || thetas.len() >= MANY {
            self.beside(py, listener, move |emulator| emulator.refine(&thetas, refine))?
        } else {
            let found = py.detach(|| self.with(|emulator| emulator.predict(&thetas)));
            found.map_err(|error| errors::emulator(py, &error))?
        };
        let warnings = found.warnings.iter().map(|warnings| said(warnings)).collect();
        Ok((cube(py, found.displacement, shape)?, warnings))
    }

    /// Error estimates of displacements, a row each.
    fn estimate<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
        displacements: PyReadonlyArray2<'py, f64>,
        listener: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (thetas, displacement) = (rows(&thetas), rows(&displacements).concat());
        let warnings = thetas.iter().map(|_| Vec::new()).collect();
        let prediction = Prediction { thetas, displacement, warnings };
        let found = self.beside(py, listener, move |emulator| emulator.estimates(&prediction))?;
        self.told(py, &found)
    }

    /// Displacements at every row of θ after Newton steps, their estimates and warnings.
    fn correct<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
        steps: usize,
        listener: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let thetas = rows(&thetas);
        let shape = [thetas.len(), self.body().nodes, 3];
        let shared = self.shared();
        let found = relay::run(py, listener, move |observer| {
            let mut counter = sinew_emulate::Counter::new(observer, "correct", 0, thetas.len());
            let correct = |theta: &Vec<f64>| -> Result<sinew::Correction, Error> {
                let found = shared.with(|emulator| emulator.correct(theta, steps))?;
                match counter.step(1, "") {
                    std::ops::ControlFlow::Continue(()) => Ok(found),
                    std::ops::ControlFlow::Break(()) => {
                        Err(Error::Interrupted { stage: "correct".into() })
                    }
                }
            };
            thetas.iter().map(correct).collect::<Result<Vec<_>, Error>>()
        })?;
        let found = found.map_err(|error| errors::emulator(py, &error))?;
        let estimates: Vec<Estimate> = found.iter().map(|found| found.estimate.clone()).collect();
        let result = self.told(py, &estimates)?;
        let warnings: Vec<_> = found.iter().map(|found| said(&found.warnings)).collect();
        result.set_item("set_warnings", warnings)?;
        let displacements = found.into_iter().flat_map(|found| found.displacement).collect();
        result.set_item("displacement", cube(py, displacements, shape)?)?;
        Ok(result)
    }

    /// Derivatives of the displacement by each parameter in its own unit, at one θ.
    fn sensitivity<'py>(
        &self,
        py: Python<'py>,
        theta: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let theta = rows(&theta).concat();
        let found = py.detach(|| self.with(|emulator| emulator.sensitivity(&theta)));
        let found = found.map_err(|error| errors::emulator(py, &error))?;
        by_own_units(py, self.body(), found)
    }
}

impl NativeEmulator {
    /// Estimates by name, NaN where there is no estimate.
    fn told<'py>(&self, py: Python<'py>, found: &[Estimate]) -> PyResult<Bound<'py, PyDict>> {
        let result = PyDict::new(py);
        let distances = || found.iter().map(|estimate| estimate.distance.as_ref());
        let number = |of: fn(&sinew_emulate::Distance) -> f64| {
            vector(py, distances().map(|distance| distance.map_or(f64::NAN, of)).collect())
        };
        result.set_item("mean", number(|distance| distance.mean))?;
        result.set_item("largest", number(|distance| distance.largest))?;
        result.set_item("energy_norm", number(|distance| distance.energy_norm))?;
        result.set_item("relative", number(|distance| distance.relative))?;
        let residuals =
            found.iter().map(|estimate| estimate.residual.unwrap_or(f64::NAN)).collect();
        result.set_item("residual", vector(py, residuals))?;
        let unit = &self.body().units.length;
        let words: Vec<_> = found.iter().map(|estimate| estimate.in_words(unit)).collect();
        result.set_item("words", words)?;
        Ok(result)
    }
}

/// Derivatives of the displacement by each parameter in its own unit, from those in the units of the scene.
pub(crate) fn by_own_units<'py>(
    py: Python<'py>,
    body: &Body,
    found: Vec<Vec<f64>>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let own = body.parameters.iter().map(|parameter| parameter.unit.in_scene(1.0));
    let scaled = found
        .into_iter()
        .zip(own)
        .flat_map(|(field, unit)| field.into_iter().map(move |u| u * unit));
    cube(py, scaled.collect(), [body.parameters.len(), body.nodes, 3])
}

fn said(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

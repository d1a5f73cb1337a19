//! Emulators: predictions, error estimates, corrections, sensitivities.

use crate::arrays::{Array, Flat, Rows};
use crate::errors::{Result, said};
use crate::relay;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use self_cell::self_cell;
use sinew::case::{Training, doubtful_emulator};
use sinew::{Body, Emulator, Estimate, Prediction, TrainingOptions};
use sinew_emulate::Error;
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
        body: Arc<Body>,
        training: Training,
        options: TrainingOptions,
        listener: &Bound<'_, PyAny>,
    ) -> Result<Self> {
        let made = relay::run(listener, move |observer| {
            Owned::try_new(body, |body| training.train(body, &options, observer))
        })?;
        Ok(Self(Arc::new(made)))
    }

    pub(crate) fn loaded(py: Python<'_>, body: Arc<Body>, folder: &Path) -> Result<Self> {
        let made = py.detach(|| Owned::try_new(body, |body| sinew::load(folder, body)))?;
        Ok(Self(Arc::new(made)))
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
        listener: &Bound<'_, PyAny>,
        work: impl for<'b> FnOnce(&Emulator<'b>) -> Result<T, Error> + Send + 'static,
    ) -> Result<T> {
        let shared = self.shared();
        relay::run(listener, move |_| shared.with(work))
    }
}

/// Displacements, and the warnings of each.
type Predicted = (Array, Vec<Vec<String>>);
/// A page, facts about it, and notes.
pub(crate) type Page = (String, Vec<(String, String)>, Vec<String>);

#[pymethods]
impl NativeEmulator {
    /// Provenance of the emulator, as JSON.
    #[getter]
    fn record(&self) -> Result<String> {
        Ok(self.with(|emulator| serde_json::to_string(&emulator.record))?)
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

    /// Doubts about its displacements.
    fn doubts(&self, py: Python<'_>) -> Vec<String> {
        let unknown = |error| vec![format!("its displacements were not checked: {error}")];
        py.detach(|| self.with(doubtful_emulator)).unwrap_or_else(unknown)
    }

    /// Stores it in a folder.
    fn save(&self, folder: PathBuf) -> Result<()> {
        Ok(self.with(|emulator| emulator.save(&folder))?)
    }

    /// Displacements at every row of θ and the warnings of each, after some quasi-Newton steps with a frozen stiffness.
    fn predict(
        &self,
        thetas: Rows,
        refine: usize,
        listener: &Bound<'_, PyAny>,
    ) -> Result<Predicted> {
        let shape = [thetas.0.len(), self.body().nodes, 3];
        let found = if refine > 0 || thetas.0.len() >= MANY {
            self.beside(listener, move |emulator| emulator.refine(&thetas.0, refine))?
        } else {
            listener.py().detach(|| self.with(|emulator| emulator.predict(&thetas.0)))?
        };
        let warnings = found.warnings.iter().map(said).collect();
        Ok((Array::new(found.displacement, shape), warnings))
    }

    /// The emulator as one page for a browser, what was measured of it by name, and notes.
    fn page(&self, listener: &Bound<'_, PyAny>) -> Result<Page> {
        let shared = self.shared();
        relay::run(listener, move |observer| {
            shared.with(|emulator| -> Result<_, Error> {
                let viewer = sinew::viewer(emulator, sinew::PAGE_SEED, observer)?;
                Ok((viewer.to_html(), viewer.facts, viewer.notes))
            })
        })
    }

    /// Error estimates of displacements, a row each.
    fn estimate<'py>(
        &self,
        thetas: Rows,
        displacements: Flat,
        listener: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyDict>> {
        let warnings = thetas.0.iter().map(|_| Vec::new()).collect();
        let prediction = Prediction { thetas: thetas.0, displacement: displacements.0, warnings };
        let found = self.beside(listener, move |emulator| emulator.estimates(&prediction))?;
        Ok(self.told(listener.py(), &found)?)
    }

    /// Displacements at every row of θ after Newton steps, their estimates and warnings.
    fn correct<'py>(
        &self,
        thetas: Rows,
        steps: usize,
        listener: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyDict>> {
        let shape = [thetas.0.len(), self.body().nodes, 3];
        let shared = self.shared();
        let found = relay::run(listener, move |observer| {
            let mut counter = sinew_emulate::Counter::new(observer, "correct", 0, thetas.0.len());
            let correct = |theta: &Vec<f64>| -> Result<sinew::Correction, Error> {
                let found = shared.with(|emulator| emulator.correct(theta, steps))?;
                let _ = counter.step(1, "");
                counter.check().map(|()| found)
            };
            thetas.0.iter().map(correct).collect::<Result<Vec<_>, Error>>()
        })?;
        let estimates: Vec<Estimate> = found.iter().map(|found| found.estimate.clone()).collect();
        let result = self.told(listener.py(), &estimates)?;
        let warnings: Vec<_> = found.iter().map(|found| said(&found.warnings)).collect();
        result.set_item("set_warnings", warnings)?;
        let displacements = found.into_iter().flat_map(|found| found.displacement).collect();
        result.set_item("displacement", Array::new(displacements, shape))?;
        Ok(result)
    }

    /// Derivatives of the displacement by each parameter in its own unit, at one θ.
    fn sensitivity(&self, py: Python<'_>, theta: Flat) -> Result<Array> {
        let found = py.detach(|| self.with(|emulator| emulator.sensitivity(&theta.0)))?;
        Ok(by_own_units(self.body(), found))
    }
}

impl NativeEmulator {
    /// Estimates by name, NaN where there is no estimate.
    fn told<'py>(&self, py: Python<'py>, found: &[Estimate]) -> PyResult<Bound<'py, PyDict>> {
        let result = PyDict::new(py);
        let distances = || found.iter().map(|estimate| estimate.distance.as_ref());
        let number = |of: fn(&sinew_emulate::Distance) -> f64| {
            Array::vector(distances().map(|distance| distance.map_or(f64::NAN, of)).collect())
        };
        result.set_item("mean", number(|distance| distance.mean))?;
        result.set_item("largest", number(|distance| distance.largest))?;
        result.set_item("energy_norm", number(|distance| distance.energy_norm))?;
        result.set_item("relative", number(|distance| distance.relative))?;
        let residuals =
            found.iter().map(|estimate| estimate.residual.unwrap_or(f64::NAN)).collect();
        result.set_item("residual", Array::vector(residuals))?;
        let unit = &self.body().units.length;
        let words: Vec<_> = found.iter().map(|estimate| estimate.in_words(unit)).collect();
        result.set_item("words", words)?;
        Ok(result)
    }
}

/// Derivatives of the displacement by each parameter in its own unit, from those in the units of the scene.
pub(crate) fn by_own_units(body: &Body, found: Vec<Vec<f64>>) -> Array {
    let own = body.parameters.iter().map(|parameter| parameter.unit.in_scene(1.0));
    let scaled = found
        .into_iter()
        .zip(own)
        .flat_map(|(field, unit)| field.into_iter().map(move |u| u * unit));
    Array::new(scaled.collect(), [body.parameters.len(), body.nodes, 3])
}

//! Cases: bodies, their parameters and solutions.

use crate::arrays::{matrix, rows, stacked, vector};
use crate::emulator::{NativeEmulator, by_own_units};
use crate::errors::{self, Kind};
use crate::mesh::NativeMesh;
use crate::{relay, results, training};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use sinew::case::Formulation;
use sinew::stresses::add_stresses;
use sinew::{
    Body, Case, TrainingOptions, admissible, locking_in_words, outside, theta_in_words, theta_of,
};
use sinew_emulate::{Answers, Design, simulate_by};
use sinew_energy::{Fibres, Sampling};
use sinew_fem::{
    LoadSteps, Options, Solver, Unload, UnloadOptions, cell_stresses, held_sets, locking, reactions,
};
use sinew_mesh::{DISPLACEMENT, Field, to_vtu, with_cells};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Names of the built-in scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    sinew::scenes::SCENES.iter().map(|scene| scene.name).collect()
}

/// A case with its body.
#[pyclass(frozen, module = "pysinew._native")]
pub(crate) struct NativeCase {
    pub(crate) case: Case,
    pub(crate) body: Arc<Body>,
}

impl NativeCase {
    pub(crate) fn lowered(py: Python<'_>, case: Case) -> PyResult<Self> {
        let body = py.detach(|| case.body()).map_err(|error| Kind::Case.of(py, error))?;
        Ok(Self { case, body: Arc::new(body) })
    }

    /// A case, on a mesh in memory where one is given.
    fn on(
        py: Python<'_>,
        case: Result<Case, sinew::CaseError>,
        mesh: Option<&NativeMesh>,
    ) -> PyResult<Self> {
        let mut case = case.map_err(|error| Kind::Case.of(py, error))?;
        if let Some(mesh) = mesh {
            let (mesh, report) = mesh.make(py)?;
            if report.unmatched_facets > 0 {
                let reason = format!(
                    "mesh: {} cells of the boundary are facets of no cell; give facets by the nodes of their cell",
                    report.unmatched_facets
                );
                return Err(Kind::Case.of(py, reason));
            }
            case = case.on(mesh);
            // The case is new, so that nothing stands there.
            let _ = case.mesh.report.set(report);
        }
        Self::lowered(py, case)
    }

    /// θ in the unit of the scene that the law has a meaning for.
    pub(crate) fn thetas(&self, thetas: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
        let (py, thetas) = (thetas.py(), rows(thetas));
        for theta in &thetas {
            admissible(&self.body, theta)
                .map_err(|why| Kind::Case.of(py, format!("theta: {why}")))?;
        }
        Ok(thetas)
    }
}

#[pymethods]
impl NativeCase {
    /// A case file, or a built-in scene of that name.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let case = Case::read(&path).map_err(|error| Kind::Case.of(py, error))?;
        Self::lowered(py, case)
    }

    /// The text of a case file, on a mesh in memory where one is given.
    #[staticmethod]
    #[pyo3(signature = (text, file, mesh=None))]
    fn parse(py: Python<'_>, text: &str, file: &str, mesh: Option<&NativeMesh>) -> PyResult<Self> {
        Self::on(py, Case::parse(text, file), mesh)
    }

    /// The keys of a case file as JSON, on a mesh in memory where one is given.
    #[staticmethod]
    #[pyo3(signature = (json, name, mesh=None))]
    fn from_json(
        py: Python<'_>,
        json: &str,
        name: &str,
        mesh: Option<&NativeMesh>,
    ) -> PyResult<Self> {
        let table: toml::Table = serde_json::from_str(json)
            .map_err(|error| Kind::Case.of(py, format!("{name}: {error}")))?;
        Self::on(py, Case::from_keys(&table, name), mesh)
    }

    /// State that another process makes the case from: text, name of its file, whether its cells are made quadratic, mesh as a VTU file.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<(&str, &str, bool, Bound<'py, PyBytes>)> {
        let wrong = |error: &dyn std::fmt::Display| Kind::Case.of(py, error);
        let mesh = self.case.mesh_made().map_err(|error| wrong(&error))?;
        let mesh = with_cells!(&mesh, mesh => to_vtu(mesh)).map_err(|error| wrong(&error))?;
        let quadratic = self.case.formulation == Formulation::Quadratic;
        Ok((self.case.text(), self.case.file(), quadratic, PyBytes::new(py, &mesh)))
    }

    /// The case of a state.
    #[staticmethod]
    fn revived(
        py: Python<'_>,
        text: &str,
        file: &str,
        quadratic: bool,
        mesh: &[u8],
    ) -> PyResult<Self> {
        let (mesh, _) =
            sinew_mesh::parse("mesh.vtu", mesh).map_err(|error| Kind::Case.of(py, error))?;
        let case = Case::revived(text, file, mesh).map_err(|error| Kind::Case.of(py, error))?;
        match quadratic {
            true => Self::lowered(py, case.with_formulation(Formulation::Quadratic)),
            false => Self::lowered(py, case),
        }
    }

    #[getter]
    fn name(&self) -> &str {
        &self.case.name
    }

    #[getter]
    fn text(&self) -> &str {
        self.case.text()
    }

    /// Name, unit, smallest and largest value in that unit, sampling, of every parameter.
    #[getter]
    fn parameters(&self) -> Vec<(String, String, f64, f64, &'static str)> {
        let of = |p: &sinew::Parameter| {
            let [low, high] = p.range.map(|end| p.unit.shown(end));
            let sampling = match p.sampling {
                Sampling::Log => "log",
                Sampling::Linear => "linear",
            };
            (p.name.clone(), p.unit.name().to_string(), low, high, sampling)
        };
        self.body.parameters.iter().map(of).collect()
    }

    /// Names of the cavities that pressures act in.
    #[getter]
    fn cavities(&self) -> Vec<String> {
        self.body.cavities.iter().map(|cavity| cavity.name.clone()).collect()
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = self.body.mesh.points();
        matrix(py, points.as_flattened().to_vec(), [points.len(), 3])
    }

    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let mesh = &self.body.mesh;
        let indices = mesh.cells().iter().map(|&node| node as i64).collect();
        let count = mesh.cell_count();
        matrix(py, indices, [count, mesh.cells().len() / count.max(1)])
    }

    /// VTK's number for the kind of cell.
    #[getter]
    fn vtk_type(&self) -> u8 {
        self.body.element().vtk_type
    }

    /// Nodes of the sets of nodes and of facets, by name.
    #[getter]
    fn sets<'py>(&self, py: Python<'py>) -> PyResult<[Bound<'py, PyDict>; 2]> {
        let (nodes, facets) = (PyDict::new(py), PyDict::new(py));
        let mesh = &self.body.mesh;
        for (name, set) in mesh.node_sets() {
            nodes.set_item(name, vector(py, set.iter().map(|&node| node as i64).collect()))?;
        }
        for (name, set) in mesh.facet_sets() {
            let each: Vec<Vec<usize>> =
                set.iter().map(|&facet| mesh.nodes_of_facet(facet)).collect();
            let width = each.first().map_or(0, Vec::len);
            let indices = each.iter().flatten().map(|&node| node as i64).collect();
            facets.set_item(name, matrix(py, indices, [each.len(), width])?)?;
        }
        Ok([nodes, facets])
    }

    /// Doubts about the case, as the program tells them.
    fn warnings(&self) -> Vec<String> {
        let report = self.case.mesh.report.get().cloned().unwrap_or_default();
        let changes = if report.unused_nodes > 0 { report.changes() } else { Vec::new() };
        let mesh = report.warnings().into_iter().chain(changes);
        let mesh = mesh.map(|said| format!("mesh: {said}"));
        mesh.chain(self.case.warnings(&self.body)).collect()
    }

    /// A warning that the cells are too stiff in the middle of the ranges of the parameters, if they are.
    fn locking(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let found =
            sinew_fem::locking_at_centre(&self.body).map_err(|error| Kind::Solve.of(py, error))?;
        Ok(found.map(|found| locking_in_words(&found)))
    }

    /// θ in the unit of the scene from names and texts such as `7 mmHg`.
    fn theta<'py>(
        &self,
        py: Python<'py>,
        pairs: Vec<(String, String)>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let pairs: Vec<(&str, &str)> =
            pairs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
        let theta =
            theta_of(&pairs, &self.body.parameters).map_err(|error| Kind::Case.of(py, error))?;
        Ok(vector(py, theta))
    }

    /// θ in the unit of the scene from the parameters' own.
    fn in_scene<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.converted(py, &thetas, sinew::Unit::in_scene)
    }

    /// θ in the parameters' own units from that of the scene.
    fn shown<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.converted(py, &thetas, sinew::Unit::shown)
    }

    /// θ in words.
    fn in_words(&self, theta: PyReadonlyArray1<'_, f64>) -> String {
        theta_in_words(&self.body, &theta.as_array().to_vec())
    }

    /// Values outside their ranges, in words; those without a meaning are refused.
    fn outside(&self, thetas: PyReadonlyArray2<'_, f64>) -> PyResult<Vec<String>> {
        let thetas = self.thetas(&thetas)?;
        Ok(thetas.iter().flat_map(|theta| outside(&self.body.parameters, theta)).collect())
    }

    /// The middle of the ranges, in the unit of the scene.
    fn centre<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.body.centre())
    }

    /// A design of θ in the unit of the scene.
    fn sample<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        seed: u64,
        design: &str,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let design: Design = serde_json::from_value(design.into())
            .map_err(|error| Kind::Case.of(py, format!("design: {error}")))?;
        let thetas = design
            .sample(&self.body.parameters, count, seed)
            .map_err(|error| errors::emulator(py, &error))?;
        stacked(py, &thetas, self.body.parameters.len())
    }

    /// Volumes of the cavities, a row per displacement \[mm³\].
    fn volumes<'py>(
        &self,
        py: Python<'py>,
        displacements: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let fields = rows(&displacements);
        let found: Vec<_> = fields.iter().map(|field| self.body.cavity_volumes(field)).collect();
        stacked(py, &found, self.body.cavities.len())
    }

    /// Stress and strain of the cells at one displacement, by name.
    fn stresses<'py>(
        &self,
        py: Python<'py>,
        theta: PyReadonlyArray1<'py, f64>,
        displacement: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (theta, field) = (theta.as_array().to_vec(), displacement.as_array().to_vec());
        results::stresses(py, &self.body, &field, &theta)
    }

    /// Forces of the supports on the node sets that they hold \[stress·length²\], by name.
    fn reactions(
        &self,
        py: Python<'_>,
        theta: PyReadonlyArray1<'_, f64>,
        displacement: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Vec<(String, [f64; 3])>> {
        let (theta, field) = (theta.as_array().to_vec(), displacement.as_array().to_vec());
        let forces = py.detach(|| reactions(&self.body, &field, &[], &theta));
        let forces = forces.map_err(|error| Kind::Solve.of(py, error))?;
        Ok(held_sets(&self.body).map(|(name, _)| name.clone()).zip(forces).collect())
    }

    /// Derivatives of the equilibrium's displacement by each parameter in its own unit, at one θ.
    fn sensitivity<'py>(
        &self,
        py: Python<'py>,
        theta: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let theta = self.thetas(&theta)?.concat();
        let found = py.detach(|| {
            let mut solver = Solver::new(&self.body)?;
            let solution = solver.solve(&theta, &Options::default())?;
            solver.sensitivity(&solution)
        });
        by_own_units(py, &self.body, found.map_err(|error| Kind::Solve.of(py, error))?)
    }

    /// Solutions at every row of θ: displacements (NaN for failed rows), failures by row, seconds by row, warnings.
    #[pyo3(signature = (thetas, load_steps, folder, listener))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
        load_steps: bool,
        folder: Option<PathBuf>,
        listener: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (body, thetas) = (self.body.clone(), self.thetas(&thetas)?);
        let asked = thetas.clone();
        let load_steps = if load_steps { LoadSteps::Always } else { LoadSteps::WhenNeeded };
        let found = relay::run(py, listener, move |observer| {
            let options = Options { load_steps, ..Options::default() };
            simulate_by(&body, &asked, "solve", folder.as_deref(), &options, observer)
        })?;
        let found = found.map_err(|error| errors::emulator(py, &error))?;
        results::solutions(py, &self.body, &thetas, found)
    }

    /// Displacements at every row of θ to a relative accuracy, each with its checked error.
    #[pyo3(signature = (thetas, accuracy, emulator, listener))]
    fn answers<'py>(
        &self,
        py: Python<'py>,
        thetas: PyReadonlyArray2<'py, f64>,
        accuracy: f64,
        emulator: Option<&NativeEmulator>,
        listener: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (body, thetas) = (self.body.clone(), self.thetas(&thetas)?);
        let (asked, trained) = (thetas.clone(), emulator.map(NativeEmulator::shared));
        let found = relay::run(py, listener, move |observer| match trained {
            None => Answers::to(&body, &asked, accuracy, None, observer),
            Some(trained) => trained.with(|emulator| {
                Answers::to(emulator.body(), &asked, accuracy, Some(emulator), observer)
            }),
        })?;
        let found = found.map_err(|error| errors::emulator(py, &error))?;
        results::answers(py, &self.body, &found)
    }

    /// An emulator by the case's recipe, its keys replaced by those in `options` (JSON).
    #[pyo3(signature = (options, folder, resume, restart, listener))]
    fn train(
        &self,
        py: Python<'_>,
        options: &str,
        folder: Option<PathBuf>,
        resume: bool,
        restart: bool,
        listener: &Bound<'_, PyAny>,
    ) -> PyResult<NativeEmulator> {
        let training = training::replaced(self.case.training.clone(), options)
            .map_err(|reason| Kind::Case.of(py, reason))?;
        let options = TrainingOptions { folder, resume, restart, ..training.options() };
        NativeEmulator::trained(py, self.body.clone(), training, options, listener)
    }

    /// An emulator of this body that was stored.
    fn load(&self, py: Python<'_>, folder: PathBuf) -> PyResult<NativeEmulator> {
        NativeEmulator::loaded(py, self.body.clone(), &folder)
    }

    /// The case at rest whose loading gives this one's mesh back, and numbers about it.
    #[pyo3(signature = (theta, keep_fibres, listener))]
    fn unload<'py>(
        &self,
        py: Python<'py>,
        theta: PyReadonlyArray2<'py, f64>,
        keep_fibres: bool,
        listener: &Bound<'py, PyAny>,
    ) -> PyResult<(Self, Bound<'py, PyDict>)> {
        let theta = self.thetas(&theta)?.concat();
        let body = self.body.clone();
        let fibres = if keep_fibres { Fibres::Kept } else { Fibres::Carried };
        let found = relay::run(py, listener, move |_| {
            Unload::new(&body)?.fibres(fibres).solve(&theta, &UnloadOptions::default())
        })?;
        let found = found.map_err(|error| Kind::Solve.of(py, error))?;
        let rest =
            self.case.at_rest(&self.body, &found).map_err(|error| Kind::Case.of(py, error))?;
        let numbers = PyDict::new(py);
        numbers
            .set_item("displacement", matrix(py, found.displacement(), [self.body.nodes, 3])?)?;
        numbers.set_item("distance", found.loading.map_or(f64::NAN, |loading| loading.distance))?;
        numbers.set_item("volume_ratios", found.volume_ratios.map(|ratio| ratio.value))?;
        numbers.set_item("iterations", found.iterations)?;
        let stiff = locking(&found.rest, &found.theta, &found.displacement()).ok().flatten();
        numbers.set_item("warnings", stiff.iter().map(locking_in_words).collect::<Vec<_>>())?;
        Ok((Self::lowered(py, rest)?, numbers))
    }

    /// Writes mesh and displacement of one set as a VTU file, with stresses where θ is given.
    #[pyo3(signature = (path, displacement, theta=None))]
    fn write_vtu(
        &self,
        py: Python<'_>,
        path: PathBuf,
        displacement: PyReadonlyArray2<'_, f64>,
        theta: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<()> {
        let mut mesh = (*self.body.mesh).clone();
        let field = crate::arrays::triples(&displacement);
        if let Some(theta) = theta {
            let cells = cell_stresses(&self.body, field.as_flattened(), &theta.as_array().to_vec());
            let cells = cells.map_err(|error| Kind::Solve.of(py, error))?;
            add_stresses(&mut mesh, &self.body, &cells);
        }
        mesh.point_fields_mut().insert(DISPLACEMENT.into(), Field::vectors(&field));
        mesh.write_vtu(Path::new(&path)).map_err(|error| Kind::Case.of(py, error))
    }

    /// The case in quadratic cells.
    fn quadratic(&self, py: Python<'_>) -> PyResult<Self> {
        Self::lowered(py, self.case.clone().with_formulation(Formulation::Quadratic))
    }
}

impl NativeCase {
    fn converted<'py>(
        &self,
        py: Python<'py>,
        thetas: &PyReadonlyArray2<'py, f64>,
        convert: impl Fn(&sinew::Unit, f64) -> f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let parameters = &self.body.parameters;
        let mut thetas = rows(thetas);
        for theta in &mut thetas {
            for (value, parameter) in theta.iter_mut().zip(parameters) {
                *value = convert(&parameter.unit, *value);
            }
        }
        stacked(py, &thetas, parameters.len())
    }
}

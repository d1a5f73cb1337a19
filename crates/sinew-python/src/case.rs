//! Cases: bodies, their parameters and solutions.

use crate::arrays::{Array, Flat, Rows, indices, triples};
use crate::emulator::{NativeEmulator, by_own_units};
use crate::errors::{Result, said};
use crate::mesh::NativeMesh;
use crate::{relay, results, training};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyBytes, PyDict};
use sinew::case::Formulation;
use sinew::output::end_in_words;
use sinew::stresses::{StressField, add_stresses, stress_fields};
use sinew::{
    Body, Case, TrainingOptions, admissible, locking_in_words, outside, parse_way, theta_in_words,
    theta_of, thetas_along,
};
use sinew_emulate::{Answers, Counter, Design, simulate_by};
use sinew_energy::{Fibres, Sampling};
use sinew_fem::{
    LoadSteps, Options, Solver, Unload, UnloadOptions, compare_formulations, held_sets,
    mixed_stresses, reactions,
};
use sinew_mesh::{DISPLACEMENT, Field, to_vtu, with_cells};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Distances, loss, volumes and words of a comparison of cells.
type Compared = (f64, f64, f64, Vec<(String, [f64; 2])>, String);

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
    pub(crate) fn lowered(py: Python<'_>, case: Case) -> Result<Self> {
        let body = py.detach(|| case.lowered())?;
        Ok(Self { case, body: Arc::new(body) })
    }

    /// A case, on a mesh in memory where one is given.
    fn on(py: Python<'_>, mut case: Case, mesh: Option<&NativeMesh>) -> Result<Self> {
        if let Some(mesh) = mesh {
            let (mesh, report) = mesh.make()?;
            if report.unmatched_facets > 0 {
                let count = report.unmatched_facets;
                return Err(format!(
                    "mesh: {count} cells of the boundary are facets of no cell; give facets by the nodes of their cell"
                )
                .into());
            }
            case = case.on(mesh);
            // The case is new, so that nothing stands there.
            let _ = case.mesh.report.set(report);
        }
        Self::lowered(py, case)
    }

    /// Requires a potential energy, which all but solutions rests on.
    fn potential(&self) -> Result<()> {
        if !self.body.has_potential() {
            self.case.body()?;
        }
        Ok(())
    }

    /// Requires θ that the law has a meaning for.
    fn check(&self, thetas: &[Vec<f64>]) -> Result<()> {
        let mut found = thetas.iter().map(|theta| admissible(&self.body, theta));
        Ok(found.try_for_each(|found| found.map_err(|why| format!("theta: {why}")))?)
    }
}

#[pymethods]
impl NativeCase {
    /// A case file, or a built-in scene of that name.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> Result<Self> {
        Self::lowered(py, Case::read(&path)?)
    }

    /// The text of a case file, on a mesh in memory where one is given.
    #[staticmethod]
    #[pyo3(signature = (text, file, mesh=None))]
    fn parse(py: Python<'_>, text: &str, file: &str, mesh: Option<&NativeMesh>) -> Result<Self> {
        Self::on(py, Case::parse(text, file)?, mesh)
    }

    /// The keys of a case file as JSON, on a mesh in memory where one is given.
    #[staticmethod]
    #[pyo3(signature = (json, name, mesh=None))]
    fn from_json(
        py: Python<'_>,
        json: &str,
        name: &str,
        mesh: Option<&NativeMesh>,
    ) -> Result<Self> {
        let table = serde_json::from_str(json).map_err(|error| format!("{name}: {error}"))?;
        Self::on(py, Case::from_keys(&table, name)?, mesh)
    }

    /// State that another process makes the case from: text, name of its file, whether its cells are made quadratic, mesh as a VTU file.
    fn state<'py>(&self, py: Python<'py>) -> Result<(&str, &str, bool, Bound<'py, PyBytes>)> {
        let mesh = self.case.mesh_made()?;
        let mesh = with_cells!(&mesh, mesh => to_vtu(mesh))?;
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
    ) -> Result<Self> {
        let (mesh, _) = sinew_mesh::parse("mesh.vtu", mesh)?;
        let case = Case::revived(text, file, mesh)?;
        let case = if quadratic { case.with_formulation(Formulation::Quadratic) } else { case };
        Self::lowered(py, case)
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
    fn points(&self) -> Array {
        let points = self.body.mesh.points();
        Array::new(points.as_flattened().to_vec(), [points.len(), 3])
    }

    #[getter]
    fn cells(&self) -> Array<i64> {
        let (cells, count) = (self.body.mesh.cells(), self.body.mesh.cell_count());
        Array::new(indices(cells), [count, cells.len() / count.max(1)])
    }

    /// VTK's number for the kind of cell.
    #[getter]
    fn vtk_type(&self) -> u8 {
        self.body.element().vtk_type
    }

    /// Nodes of the sets of nodes and of facets, by name.
    #[getter]
    fn sets(&self) -> [BTreeMap<String, Array<i64>>; 2] {
        let mesh = &self.body.mesh;
        let nodes = mesh.node_sets().iter();
        let nodes = nodes.map(|(name, set)| (name.clone(), Array::vector(indices(set))));
        let facets = mesh.facet_sets().iter().map(|(name, set)| {
            let each: Vec<_> = set.iter().map(|&facet| mesh.nodes_of_facet(facet)).collect();
            let width = each.first().map_or(0, Vec::len);
            (name.clone(), Array::new(indices(each.iter().flatten()), [each.len(), width]))
        });
        [nodes.collect(), facets.collect()]
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
    fn locking(&self, listener: &Bound<'_, PyAny>) -> Result<Option<String>> {
        self.potential()?;
        let body = self.body.clone();
        let found = relay::run(listener, move |_| sinew_fem::locking_at_centre(&body))?;
        Ok(said(found.as_ref().map(locking_in_words)).pop())
    }

    /// θ in the unit of the scene from names and texts such as `7 mmHg`.
    fn theta(&self, pairs: Vec<(String, String)>) -> Result<Array> {
        Ok(Array::vector(theta_of(&pairs, &self.body.parameters)?))
    }

    /// θ in the unit of the scene from the parameters' own.
    fn in_scene(&self, thetas: Rows) -> Array {
        self.converted(thetas, sinew::Unit::in_scene)
    }

    /// θ in the parameters' own units from that of the scene.
    fn shown(&self, thetas: Rows) -> Array {
        self.converted(thetas, sinew::Unit::shown)
    }

    /// θ in words.
    fn in_words(&self, theta: Flat) -> String {
        theta_in_words(&self.body, &theta.0)
    }

    /// Values outside their ranges, in words; those without a meaning are refused.
    fn outside(&self, thetas: Rows) -> Result<Vec<String>> {
        self.check(&thetas.0)?;
        Ok(thetas.0.iter().flat_map(|theta| outside(&self.body.parameters, theta)).collect())
    }

    /// The middle of the ranges, in the unit of the scene.
    fn centre(&self) -> Array {
        Array::vector(self.body.centre())
    }

    /// A design of θ in the unit of the scene.
    fn sample(&self, count: usize, seed: u64, design: &str) -> Result<Array> {
        let design: Design =
            serde_json::from_value(design.into()).map_err(|error| format!("design: {error}"))?;
        let thetas = design.sample(&self.body.parameters, count, seed)?;
        Ok(Array::stacked(&thetas, self.body.parameters.len()))
    }

    /// Volumes of the cavities, a row per displacement \[mm³\].
    fn volumes(&self, py: Python<'_>, fields: Rows) -> Array {
        let of = |field: &Vec<f64>| self.body.cavity_volumes(field);
        let found: Vec<_> = py.detach(|| fields.0.iter().map(of).collect());
        Array::stacked(&found, self.body.cavities.len())
    }

    /// Stress and strain of the cells at one displacement, by name.
    fn stresses<'py>(
        &self,
        py: Python<'py>,
        theta: Flat,
        displacement: Flat,
        pressure: Flat,
    ) -> Result<Bound<'py, PyDict>> {
        let cells =
            py.detach(|| mixed_stresses(&self.body, &displacement.0, &pressure.0, &theta.0))?;
        let array = |field: StressField| {
            let shape = [vec![cells.len()], field.shape()].concat();
            (field.name, Array::new(field.values, shape))
        };
        Ok(stress_fields(&cells).into_iter().map(array).into_py_dict(py)?)
    }

    /// Forces of the supports on the node sets that they hold \[stress·length²\], by name.
    fn reactions(
        &self,
        py: Python<'_>,
        theta: Flat,
        displacement: Flat,
        pressure: Flat,
    ) -> Result<Vec<(String, [f64; 3])>> {
        let forces = py.detach(|| reactions(&self.body, &displacement.0, &pressure.0, &theta.0))?;
        Ok(held_sets(&self.body).map(|(name, _)| name.clone()).zip(forces).collect())
    }

    /// Derivatives of the equilibrium's displacement by each parameter in its own unit, at one θ.
    fn sensitivity(&self, py: Python<'_>, theta: Rows) -> Result<Array> {
        self.potential()?;
        self.check(&theta.0)?;
        let found = py.detach(|| {
            let mut solver = Solver::new(&self.body)?;
            let solution = solver.solve(&theta.0.concat(), &Options::default())?;
            solver.sensitivity(&solution)
        })?;
        Ok(by_own_units(&self.body, found))
    }

    /// Solutions at every row of θ: displacements (NaN for failed rows), failures by row, seconds by row, warnings.
    fn solve<'py>(
        &self,
        thetas: Rows,
        load_steps: bool,
        folder: Option<PathBuf>,
        listener: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyDict>> {
        if folder.is_some() {
            self.potential()?;
        }
        self.check(&thetas.0)?;
        let (body, asked) = (self.body.clone(), thetas.0.clone());
        // Other solutions than those that are kept without it.
        let folder = folder.map(|f| if load_steps { f.join("load_steps") } else { f });
        let load_steps = if load_steps { LoadSteps::Always } else { LoadSteps::WhenNeeded };
        let found = relay::run(listener, move |observer| {
            let options = Options { load_steps, ..Options::default() };
            simulate_by(&body, &asked, "solve", folder.as_deref(), &options, observer)
        })?;
        Ok(results::solutions(listener.py(), &self.body, &thetas.0, &found)?)
    }

    /// Equilibria along a way of one parameter (`p=0..8mmHg`), each from the one before: θ in the unit of the scene, displacements as far as the
    /// path goes, why it ends, and warnings.
    fn along<'py>(
        &self,
        theta: Rows,
        way: &str,
        steps: u32,
        listener: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyDict>> {
        let way = parse_way(way, &self.body.parameters)?;
        let thetas = thetas_along(&theta.0.concat(), way, steps);
        self.check(&thetas)?;
        let (py, body, asked) = (listener.py(), self.body.clone(), thetas.clone());
        let trace = relay::run(listener, move |observer| {
            let mut counter = Counter::new(observer, "follow", 0, asked.len());
            Solver::new(&body)?.trace(&asked, &Options::default(), || counter.step(1, ""))
        })?;
        let found = PyDict::new(py);
        let solutions = &trace.solutions;
        let fields: Vec<_> = solutions.iter().map(|solution| &solution.displacement[..]).collect();
        let warnings = results::doubts(py, &self.body, &thetas[..fields.len()], &fields);
        let fields = (0..thetas.len()).map(|row| Some(&solutions.get(row)?.displacement));
        found.set_item("displacement", results::by_nodes(&self.body, fields))?;
        let pressures = (0..thetas.len()).map(|row| Some(&solutions.get(row)?.pressure));
        found.set_item("pressure", results::by_row_or_nan(&pressures.collect::<Vec<_>>()))?;
        found.set_item("theta", Array::stacked(&thetas, self.body.parameters.len()))?;
        found.set_item("found", solutions.len())?;
        found.set_item("end", trace.end.map(|end| end_in_words(&self.body, &end)))?;
        found.set_item("warnings", warnings)?;
        Ok(found)
    }

    /// Mean and largest distance \[mm\] of a displacement from that of the same body in better cells, the loss of mean displacement, volumes of
    /// cavities by both, and all in words.
    fn compared(
        &self,
        py: Python<'_>,
        displacement: Flat,
        better: &Self,
        better_displacement: Flat,
    ) -> Result<Compared> {
        let [own, other] = [&self.body, &better.body];
        let compare = || compare_formulations(own, &displacement.0, other, &better_displacement.0);
        let found = py.detach(compare)?;
        let [kind, better] = [own, other].map(|body| body.element().plural);
        let words = format!("{kind} against {better}: {found}");
        Ok((found.mean, found.largest, found.displacement_loss(), found.cavities, words))
    }

    /// Displacements at every row of θ to a relative accuracy, each with its checked error.
    fn answers<'py>(
        &self,
        thetas: Rows,
        accuracy: f64,
        emulator: Option<&NativeEmulator>,
        listener: &Bound<'py, PyAny>,
    ) -> Result<Bound<'py, PyDict>> {
        self.potential()?;
        self.check(&thetas.0)?;
        let (body, trained) = (self.body.clone(), emulator.map(NativeEmulator::shared));
        let asked = thetas.0.clone();
        let found = relay::run(listener, move |observer| match trained {
            None => Answers::to(&body, &thetas.0, accuracy, None, observer),
            Some(trained) => trained.with(|emulator| {
                Answers::to(emulator.body(), &thetas.0, accuracy, Some(emulator), observer)
            }),
        })?;
        Ok(results::answers(listener.py(), &self.body, &asked, &found)?)
    }

    /// An emulator by the case's recipe, its keys replaced by those in `options` (JSON).
    fn train(
        &self,
        options: &str,
        folder: Option<PathBuf>,
        resume: bool,
        restart: bool,
        listener: &Bound<'_, PyAny>,
    ) -> Result<NativeEmulator> {
        self.potential()?;
        let training = training::replaced(self.case.training.clone(), options)?;
        let options = TrainingOptions { folder, resume, restart, ..training.options() };
        NativeEmulator::trained(self.body.clone(), training, options, listener)
    }

    /// An emulator of this body that was stored.
    fn load(&self, py: Python<'_>, folder: PathBuf) -> Result<NativeEmulator> {
        self.potential()?;
        // Training keeps it in a folder of the run.
        let inner = folder.join("emulator");
        let folder = if inner.is_dir() { inner } else { folder };
        NativeEmulator::loaded(py, self.body.clone(), &folder)
    }

    /// The case at rest whose loading gives this one's mesh back, and numbers about it.
    #[pyo3(signature = (theta, keep_fibres, listener))]
    fn unload<'py>(
        &self,
        theta: Rows,
        keep_fibres: bool,
        listener: &Bound<'py, PyAny>,
    ) -> Result<(Self, Bound<'py, PyDict>)> {
        self.potential()?;
        self.check(&theta.0)?;
        let (py, body) = (listener.py(), self.body.clone());
        let fibres = if keep_fibres { Fibres::Kept } else { Fibres::Carried };
        let found = relay::run(listener, move |_| {
            Unload::new(&body)?.fibres(fibres).solve(&theta.0.concat(), &UnloadOptions::default())
        })?;
        let rest = py.detach(|| self.case.at_rest(&self.body, &found))?;
        let numbers = PyDict::new(py);
        let displacement = Array::new(found.displacement(), [self.body.nodes, 3]);
        numbers.set_item("displacement", displacement)?;
        numbers.set_item("distance", found.loading.map_or(f64::NAN, |loading| loading.distance))?;
        numbers.set_item("volume_ratios", found.volume_ratios.map(|ratio| ratio.value))?;
        numbers.set_item("iterations", found.iterations)?;
        let warnings = results::doubts(
            py,
            &found.rest,
            std::slice::from_ref(&found.theta),
            &[&found.displacement()],
        );
        numbers.set_item("warnings", warnings)?;
        Ok((Self::lowered(py, rest)?, numbers))
    }

    /// Writes mesh and displacement of one set as a VTU file, with stresses where θ is given.
    #[pyo3(signature = (path, displacement, pressure, theta=None))]
    fn write_vtu(
        &self,
        py: Python<'_>,
        path: PathBuf,
        displacement: Flat,
        pressure: Flat,
        theta: Option<Flat>,
    ) -> Result<()> {
        py.detach(|| {
            let mut mesh = (*self.body.mesh).clone();
            let field = triples(displacement);
            if let Some(Flat(theta)) = theta {
                let cells = mixed_stresses(&self.body, field.as_flattened(), &pressure.0, &theta)?;
                add_stresses(&mut mesh, &self.body, &cells);
            }
            mesh.point_fields_mut().insert(DISPLACEMENT.into(), Field::vectors(&field));
            Ok(mesh.write_vtu(path)?)
        })
    }

    /// The case in quadratic cells.
    fn quadratic(&self, py: Python<'_>) -> Result<Self> {
        Self::lowered(py, self.case.clone().with_formulation(Formulation::Quadratic))
    }
}

impl NativeCase {
    fn converted(
        &self,
        Rows(mut thetas): Rows,
        convert: impl Fn(&sinew::Unit, f64) -> f64,
    ) -> Array {
        let parameters = &self.body.parameters;
        for theta in &mut thetas {
            for (value, parameter) in theta.iter_mut().zip(parameters) {
                *value = convert(&parameter.unit, *value);
            }
        }
        Array::stacked(&thetas, parameters.len())
    }
}

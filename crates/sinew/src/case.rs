//! Case files: a body, its parameters and its training in one TOML file.
//!
//! Every key is described in `docs/case-file.md`. Lengths are in mm and stresses in kPa throughout; meshes, ranges and
//! pressures may be given in other units, which are converted when the file is read.

mod factors;
mod fibre_rule;
mod fibres;
mod laws;
mod loads;
mod mesh;
mod sanity;
mod select;
mod source;
mod supports;
mod training;
mod units;

pub use factors::Factors;
pub use fibre_rule::{EllipsoidRule, FibreRule};
pub use fibres::Fibres;
pub use laws::{Law, Range};
pub use loads::{FoundationLoad, Load, Pressure, Rim};
pub use mesh::{BiventricleMesh, BoxMesh, Element, EllipsoidMesh, MeshSource};
pub use sanity::{
    branched_in_words, doubtful_displacements, doubtful_emulator, locking_at_most,
    locking_in_words, moved_most, negligible_displacement,
};
pub use select::Select;
pub use supports::{Rotation, Support};
pub use training::{Optimiser, RecipeName, Training};
pub use units::stress_in_kpa;
pub(crate) use units::{LENGTH, STRESS, VOLUME, number_and_unit, stress};

use serde::Deserialize;
use serde::de::IgnoredAny;
use sinew_energy::laws::NamedLaw;
use sinew_energy::{Body, Magnitude, Scene, SceneError};
use sinew_mesh::AnyMesh;
use source::Source;
pub use source::{CaseError, Exactly, parse_tables};
pub(crate) use source::{Result, advise, cell_name};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Content of a case file.
///
/// ```
/// use sinew::case::Case;
///
/// let case = Case::parse(
///     r#"
///     law = "neo-hookean"
///     loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
///     supports = [{ clamped = "x_min" }]
///
///     [mesh]
///     box = { extent = [100.0, 10.0, 10.0], cells = [12, 4, 5] }
///
///     [parameters]
///     mu = [50.0, 100.0]
///     lambda = [50.0, 100.0]
///     "#,
///     "beam.toml",
/// )?;
/// let body = case.body()?;
/// assert_eq!((body.name.as_str(), body.nodes, body.parameters.len()), ("beam", 390, 2));
/// # Ok::<(), sinew::case::CaseError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the scene, for reports and folders; by default that of the file.
    #[serde(default)]
    pub name: String,
    /// Description, in a line.
    #[serde(default)]
    pub about: String,
    /// Source of the mesh.
    pub mesh: MeshSource,
    /// The law, by its name, with its constants.
    pub law: Law,
    /// Element formulation: integration of volumes.
    #[serde(default)]
    pub formulation: Formulation,
    /// Factors of the tension `T_a` in θ by which the body contracts along its fibres; by default they are 1.
    #[serde(default, deserialize_with = "factors::active")]
    pub active: Option<Factors>,
    /// Factors of the stiffness from place to place; the tension of `active` does not change.
    pub stiffness: Option<Factors>,
    /// Ranges of θ by name, in any order: the law's parameters and those that loads name.
    pub parameters: BTreeMap<String, Range>,
    /// Directions of fibres, for laws that read them.
    pub fibres: Option<Fibres>,
    /// Loads.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Supports.
    pub supports: Vec<Support>,
    /// Sets of nodes and facets by name, chosen by where they are.
    #[serde(default)]
    pub select: BTreeMap<String, Select>,
    /// Settings of an emulator's training.
    #[serde(default)]
    pub training: Training,
    /// States of a patient, which [`crate::PatientFile`] reads.
    #[serde(default)]
    phases: IgnoredAny,
    /// Measurements of a patient.
    #[serde(default)]
    data: IgnoredAny,
    /// Settings of a calibration.
    #[serde(default)]
    calibration: IgnoredAny,
    #[serde(skip)]
    pub(crate) source: Source,
}

/// Element formulation: integration of volumes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Formulation {
    /// The cells of the mesh as they are.
    #[default]
    Plain,
    /// One mean volume ratio per hexahedron or patch of tetrahedra: for materials that hardly change their volume.
    Averaged,
    /// Quadratic cells made of linear tetrahedra or triangles.
    Quadratic,
    /// Quadratic cells with a linear field of pressure (Taylor and Hood): incompressible, and without a potential, so that it is solved and
    /// nothing is trained on it.
    Mixed,
    /// Plain cells if they are expected to lose at most 15 % of the displacement in the middle of the ranges
    /// ([`sinew_fem::locking_at_centre`]), averaged ones if these lose at most 30 %, else quadratic ones; hexahedra are averaged at most.
    Auto,
}

/// Shares of the displacement that [`Formulation::Auto`] may lose to locking. Averaged cells take up to three times the time of plain ones.
/// Quadratic ones take 5 to 40 times, and the estimate may be twice the loss.
const MOST_LOST: [(Formulation, f64); 2] =
    [(Formulation::Plain, 0.15), (Formulation::Averaged, 0.3)];

/// Endings of files of meshes.
const MESHES: [&str; 8] = ["vtk", "vtu", "vtp", "msh", "inp", "stl", "pts", "elem"];

impl Case {
    /// Reads a case file, or the built-in scene of that name where there is no such file. A mesh file is relative to the
    /// case file, as are the surfaces of selections.
    ///
    /// # Errors
    /// A file that cannot be read, or what [`Case::parse`] refuses.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        if let (false, Some(scene)) = (path.exists(), crate::scenes::find(path)) {
            return Self::parse(scene.text, scene.name);
        }
        let ending = |mesh: &&str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(mesh));
        let reason = if MESHES.iter().any(ending) {
            Some(
                "this is the name of a mesh, not of a case; name the mesh by `file` under [mesh] of a case file, or by --mesh beside a case",
            )
        } else {
            let reason = "this is a folder; name a case file. Emulators of stored runs are for `sinew predict`, `calibrate`, `serve` and `export --page`";
            path.is_dir().then_some(reason)
        };
        let file = path.to_string_lossy();
        let error = |reason| Source::new(&file, "").error(&[], reason);
        if let Some(reason) = reason {
            return Err(error(reason.into()));
        }
        let text = std::fs::read_to_string(path).map_err(|why| {
            let known = crate::scenes::SCENES.iter().map(|scene| scene.name);
            let advice = match why.kind() {
                std::io::ErrorKind::InvalidData => "; save it as text in UTF-8".into(),
                _ => advise(&file, known, "built-in scenes"),
            };
            error(format!("the case file cannot be read: {why}{advice}"))
        })?;
        Ok(Self::parse(&text, &file)?.beside_its_file())
    }

    /// The case with paths of files that are relative to its own.
    fn beside_its_file(mut self) -> Self {
        let own = PathBuf::from(&self.source.file);
        let folder = own.parent().unwrap_or(Path::new("."));
        self.paths().for_each(|file| *file = folder.join(&*file));
        self
    }

    fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let fibres = self.fibres.as_mut().and_then(|fibres| fibres.file.as_mut());
        let surfaces = self.select.values_mut().flat_map(|select| select.files());
        self.mesh.file.as_mut().into_iter().chain(fibres).chain(surfaces)
    }

    /// Files that it reads: mesh, fibres and surfaces of selections.
    pub fn files(&self) -> Vec<PathBuf> {
        self.clone().paths().map(|file| file.clone()).collect()
    }

    /// The case in another process: its text, the name of its file, and its mesh as [`Case::mesh_made`] gives it there.
    ///
    /// # Errors
    /// As [`Case::parse`].
    pub fn revived(text: &str, file: &str, mesh: AnyMesh) -> Result<Self, CaseError> {
        let mut case = Self::parse(text, file)?.beside_its_file();
        case.mesh.made = Some(Arc::new(mesh));
        Ok(case)
    }

    /// Reads a case from text; `file` names it in errors.
    ///
    /// # Errors
    /// Text that is not TOML; a key that is missing, misspelt or of the wrong type, with its line and a suggestion.
    pub fn parse(text: &str, file: &str) -> Result<Self, CaseError> {
        Self::of(Source::new(file, text), file)
    }

    /// Case of keys in memory, such as those of a program in Python; `name` names it in errors, which know no lines.
    ///
    /// ```
    /// let keys = "law = \"neo-hookan\"\nsupports = []\nparameters = {}\nmesh = { file = \"bar.vtu\" }";
    /// let error = sinew::Case::from_keys(&keys.parse()?, "bar")?.body().unwrap_err();
    /// assert_eq!(error.to_string(), "bar, law: there is no law `neo-hookan`; did you mean `neo-hookean`?");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Case::parse`].
    pub fn from_keys(keys: &toml::Table, name: &str) -> Result<Self, CaseError> {
        Self::of(Source::unseen(name, &keys.to_string()), name)
    }

    fn of(source: Source, file: &str) -> Result<Self> {
        let mut case: Self = toml::from_str(&source.text).map_err(|error| source.syntax(&error))?;
        if case.name.is_empty() {
            let stem = Path::new(file).file_stem().unwrap_or_default();
            case.name = stem.to_string_lossy().into_owned();
        }
        case.source = source;
        if let Some((key, reason)) = case.training.objection() {
            let keys: Vec<&str> = std::iter::once("training").chain(key.split('.')).collect();
            return Err(case.source.error(&keys, reason));
        }
        Ok(case)
    }

    /// Case with the mesh of another file.
    pub fn with_mesh(mut self, file: PathBuf) -> Self {
        let MeshSource { unit, merge, keep, .. } = self.mesh;
        let file = Some(file);
        self.mesh = MeshSource { file, unit, merge, keep, is_other: true, ..MeshSource::default() };
        self
    }

    /// Case on a mesh in memory, in the unit of length that its `mesh` names.
    ///
    /// ```
    /// use sinew::Case;
    ///
    /// let text = r#"
    ///     law = "neo-hookean"
    ///     supports = [{ clamped = "x_min" }]
    ///     mesh.unit = "cm"
    ///     parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
    /// "#;
    /// let mesh = sinew_mesh::box_tetrahedra([3.0, 1.0, 1.0], [3, 1, 1]);
    /// let body = Case::parse(text, "bar.toml")?.on(mesh.into()).body()?;
    /// assert_eq!(body.positions.iter().map(|x| x[0]).fold(0.0, f64::max), 30.0);
    /// # Ok::<(), sinew::CaseError>(())
    /// ```
    pub fn on(mut self, mesh: AnyMesh) -> Self {
        let given = Some(Arc::new(mesh));
        let MeshSource { unit, merge, keep, .. } = self.mesh;
        self.mesh = MeshSource { given, unit, merge, keep, ..MeshSource::default() };
        self
    }

    /// Case in another formulation.
    pub fn with_formulation(self, formulation: Formulation) -> Self {
        Self { formulation, ..self }
    }

    /// The mesh \[mm\] before sets are chosen in it and fibres laid.
    ///
    /// # Errors
    /// A mesh that cannot be read or made.
    pub fn mesh_made(&self) -> Result<AnyMesh, CaseError> {
        self.mesh.make(&self.source)
    }

    /// Name of the case file.
    pub fn file(&self) -> &str {
        &self.source.file
    }

    /// Text of the case file.
    pub fn text(&self) -> &str {
        &self.source.text
    }

    /// The body, in mm and kPa.
    ///
    /// # Errors
    /// A mesh that cannot be read or made; names that mesh or law lack; ranges, units and loads that make no sense: each
    /// with file, line and key. A case without a potential, which [`Case::lowered`] takes.
    pub fn body(&self) -> Result<Body, CaseError> {
        self.potential(self.lowered()?)
    }

    /// The body on another mesh than its own, in mm, with the sets that fibres, loads and supports name.
    ///
    /// # Errors
    /// As [`Case::body`].
    pub fn body_on(&self, mesh: AnyMesh) -> Result<Body, CaseError> {
        self.potential(self.lowered_on(mesh)?)
    }

    /// The body, also of a case without a potential ([`Body::has_potential`]): mixed elements, and pressures whose rim moves
    /// freely. It is solved ([`crate::Solver`]), and nothing is trained on it.
    ///
    /// # Errors
    /// As [`Case::body`], but for a case without a potential.
    pub fn lowered(&self) -> Result<Body, CaseError> {
        // Names and ranges are checked before the mesh is read.
        let law = self.law.row(&self.source)?;
        self.check_active(law)?;
        self.lower_parameters(law)?;
        self.check_selections()?;
        self.lowered_on(self.mesh.make(&self.source)?)
    }

    /// [`Case::lowered`] on another mesh than its own.
    ///
    /// # Errors
    /// As [`Case::lowered`].
    pub fn lowered_on(&self, mut mesh: AnyMesh) -> Result<Body, CaseError> {
        self.mesh.check_filled(&mesh, &self.source)?;
        self.lower_selections(&mut mesh)?;
        if let Some(fibres) = &self.fibres {
            fibres.lay(&mut mesh, &self.source)?;
        }
        if self.formulation != Formulation::Auto {
            return self.lower(mesh, self.formulation);
        }
        let last = if mesh.element().corners == 8 {
            Formulation::Averaged
        } else {
            Formulation::Quadratic
        };
        for (formulation, most) in MOST_LOST {
            let lowered = self.lower(mesh.clone(), formulation)?;
            // Values outside the law's bounds are an error of the ranges, which is reported elsewhere.
            let locking = sinew_fem::locking_at_centre(&lowered).ok().flatten();
            if formulation == last || locking.is_none_or(|found| found.expected_share <= most) {
                return Ok(lowered);
            }
        }
        self.lower(mesh, last)
    }

    /// The body on a mesh that has its fibres.
    fn lower(&self, mut mesh: AnyMesh, formulation: Formulation) -> Result<Body> {
        let law = self.law.row(&self.source)?;
        self.check_active(law)?;
        let parameters = self.lower_parameters(law)?;
        self.check_kinds(&mesh)?;
        if matches!(formulation, Formulation::Quadratic | Formulation::Mixed) {
            // Nodes are marked before means of the marks would stand in the middle of edges.
            let sets = self.sets_of_nodes();
            sets.for_each(|(_, set)| drop(supports::add_node_set(&mut mesh, set)));
            let is_linear = !mesh.element().is_quadratic();
            mesh = mesh::quadratic(mesh).map_err(|element| {
                let reason = format!("{element} have no quadratic form here; choose \"averaged\"");
                self.source.error(&["formulation"], reason)
            })?;
            self.fibres.iter().filter(|_| is_linear).for_each(|fibres| fibres.raise(&mut mesh));
        }
        let loads = self.lower_loads(&mesh, law)?;
        let supports = self.lower_supports(&mut mesh)?;
        for (key, factors) in self.factors() {
            factors.prepare(key, &mut mesh, &self.source)?;
        }
        let material = self.law.material(law, self.active.is_some());
        let scene = Scene { parameters, loads, supports, ..Scene::new(mesh, material) };
        let scene = match formulation {
            Formulation::Averaged => scene.averaged(),
            Formulation::Mixed => scene.mixed(),
            _ => scene,
        };
        // One load that says so lets all pass, for `check_rims` to name those that do not say so.
        let loose = self.loads.iter().any(|load| load.is_loose());
        let mut scene = if loose { scene.loose_rims() } else { scene };
        scene.name.clone_from(&self.name);
        scene.material = scene.material.with_directions(self.directions(law, &scene)?);
        let body = scene.lower().map_err(|error| self.place(error))?;
        self.check_rims(&body)?;
        self.check_bounds(&body)?;
        let body = self.with_factors(body)?;
        // In kPa and the law's units by now.
        let known = |p: &sinew_energy::Parameter| {
            self.parameters[&p.name].value.map(|_| (p.name.clone(), p.range[0]))
        };
        let known: Vec<_> = body.parameters.iter().filter_map(known).collect();
        let known: Vec<_> = known.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        body.with_known(&known).map_err(|error| self.place(error))
    }

    /// Unit directions, as many as the law reads, of cells, nodes or quadrature points.
    fn directions(&self, law: &NamedLaw, scene: &Scene) -> Result<Vec<[f64; 3]>> {
        match self.fibres.as_ref().and_then(|fibres| fibres.ellipsoid) {
            Some(rule) if law.directions > 0 => {
                rule.directions(law, &self.mesh, scene, &self.source)
            }
            _ => fibres::directions(self.fibres.as_ref(), law, scene, &self.source),
        }
    }

    /// Warnings about a case that can be solved: fibres of opposite sign, by angles in radians or that the law does not read, loads of zero, sizes and stiffnesses outside those of
    /// tissue, parts that touch or overlap without common nodes, supports that hold every node, no load, parameters that change nothing. `body` is the lowered case.
    pub fn warnings(&self, body: &Body) -> Vec<String> {
        let fibres = self.fibres.iter().flat_map(|fibres| fibres.warnings(body));
        fibres.chain(self.without_effect()).chain(self.doubts(body)).collect()
    }

    /// Names of the parameters that loads read, each once, as they come.
    fn load_parameters(&self) -> Vec<&str> {
        let mut known = BTreeSet::new();
        self.loads
            .iter()
            .filter_map(|load| load.parameter())
            .filter(|name| known.insert(*name))
            .collect()
    }

    fn lower_loads(&self, mesh: &AnyMesh, law: &NamedLaw) -> Result<Vec<sinew_energy::Load>> {
        let names = self.load_parameters();
        let index = |name: &str| {
            let at = names.iter().position(|known| *known == name).unwrap_or_default();
            Magnitude::Theta(self.law_parameters(law).count() + at)
        };
        let lower = |(number, load): (usize, &Load)| load.lower(number, mesh, index, &self.source);
        self.loads.iter().enumerate().map(lower).collect()
    }

    fn lower_supports(&self, mesh: &mut AnyMesh) -> Result<Vec<sinew_energy::Support>> {
        // Springs may hold the body too; lowering the scene checks whether they hold all rigid motions.
        let held = self.loads.iter().any(|load| load.foundation.is_some());
        let reason = "the body is held nowhere; add { clamped = \"NODE SET\" }";
        self.source.refuse_if(self.supports.is_empty() && !held, &["supports"], || reason)?;
        let lower =
            |(number, support): (usize, &Support)| support.lower(number, mesh, &self.source);
        self.supports.iter().enumerate().map(lower).collect()
    }

    /// Names the key behind an error of the scene, where it is known.
    fn place(&self, error: SceneError) -> CaseError {
        let key: &[&str] = match &error {
            SceneError::Range { name, .. } | SceneError::KnownValue { name, .. } => {
                &["parameters", name]
            }
            SceneError::Fibres(_) => &["fibres"],
            SceneError::NotFinite { what, .. } if what.contains("prescribed") => &["supports"],
            SceneError::Supports(_) => &["supports"],
            SceneError::NotFinite { .. } | SceneError::Loads(_) | SceneError::LooseRim(_) => {
                &["loads"]
            }
            SceneError::Parameters(_) => &["parameters"],
            SceneError::Law(_) => &["law"],
            _ => &["mesh"],
        };
        let loose = matches!(error, SceneError::LooseRim(_));
        let advice = if loose { self.advice_on_rims() } else { String::new() };
        self.source.error(key, format!("{error}{advice}"))
    }
}

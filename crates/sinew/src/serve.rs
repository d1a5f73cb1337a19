//! Models for samplers and other programs: the requests of UM-Bridge 1.0 and their answers.

mod measured;
mod quantities;
mod runs;

use crate::viewer::{Surface, viewer};
use crate::{Emulator, patient::Prepared};
use measured::Measured;
use quantities::Quantities;
use serde::Deserialize;
use serde_json::{Value, json};
use sinew_emulate::parts::dot;
use sinew_emulate::{Error as EmulatorError, RunsEmulator, central_differences};
use sinew_energy::{Body, Parameter};
use sinew_fem::{Options, SolverPool};
use std::sync::OnceLock;

/// Models of one body, or of stored runs, for the protocol of UM-Bridge 1.0 (Seelinger et al., "UM-Bridge: Uncertainty quantification and
/// modeling bridge", J. Open Source Software, 2023).
///
/// Input and output of each are one vector, [`Service::heads`]. `solver` finds the equilibrium at θ, `emulator` predicts, and `corrected`
/// takes one Newton step from the prediction: a hierarchy for multilevel samplers. `patient` gives what a patient file measures. Of stored
/// runs `emulator` predicts, and `deviation` gives the standard deviations of its errors.
///
/// ```
/// use sinew::{Case, serve::Service};
///
/// let case = Case::parse(
///     r#"
///     law = "neo-hookean"
///     loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
///     supports = [{ clamped = "x_min" }]
///     mesh.box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }
///     parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
///     "#,
///     "bar.toml",
/// )?;
/// let body = case.body()?;
/// let service = Service::new(&body, None);
/// let reply = service.answer("POST", "/Evaluate", r#"{"name": "solver", "input": [[10.0, 12.0]]}"#);
/// assert!(reply.status == 200 && reply.text.starts_with(r#"{"output":[["#));
/// let refused = service.answer("POST", "/Evaluate", r#"{"name": "solver", "input": [[10.0]]}"#);
/// assert!(refused.status == 400 && refused.text.contains("InvalidInput"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Service<'b> {
    source: Source<'b>,
    patient: Option<Measured<'b>>,
}

/// A body or stored runs, with their models.
enum Source<'b> {
    Body(Box<OfBody<'b>>),
    Runs(&'b RunsEmulator),
}

/// Models of a body.
struct OfBody<'b> {
    body: &'b Body,
    emulator: Option<Emulator<'b>>,
    page: Option<Page>,
    solvers: SolverPool<'b>,
}

/// Answer to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// Status of HTTP: 200, 400 for what the client has to change, 404, or 500 where there is no result.
    pub status: u16,
    /// Media type: JSON, but for the page.
    pub kind: &'static str,
    /// Content.
    pub text: String,
}

impl Response {
    fn json(status: u16, value: &Value) -> Self {
        Self { status, kind: "application/json", text: value.to_string() }
    }

    /// Error of the protocol, of a kind that it names.
    pub fn failed(status: u16, kind: &str, message: &str) -> Self {
        Self::json(status, &json!({ "error": { "type": kind, "message": message } }))
    }
}

/// Model that answers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Model {
    Emulator,
    Corrected,
    Solver,
    Patient,
    Deviation,
}

impl Model {
    const ALL: [Self; 5] =
        [Self::Emulator, Self::Corrected, Self::Solver, Self::Patient, Self::Deviation];

    fn name(self) -> &'static str {
        ["emulator", "corrected", "solver", "patient", "deviation"][self as usize]
    }
}

/// A request as the protocol writes it; what a request does not need is absent.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object with `name` and `input`")]
struct Request {
    name: String,
    input: Option<Vec<Vec<f64>>>,
    out_wrt: Option<usize>,
    in_wrt: Option<usize>,
    sens: Option<Vec<f64>>,
    vec: Option<Vec<f64>>,
    config: Option<Config>,
}

/// Settings of a request; other keys of its `config` are ignored.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Config {
    /// Whether an emulator may predict outside the ranges of its parameters.
    extrapolate: bool,
}

impl Request {
    /// Weights of the outputs or a direction of the input, for requests of derivatives; empty for others.
    fn weights(&self, path: &str, [inputs, outputs]: [usize; 2]) -> Result<Vec<f64>, Response> {
        let (name, given, expected) = match path {
            "/Gradient" => ("sens", &self.sens, outputs),
            "/ApplyJacobian" => ("vec", &self.vec, inputs),
            _ => return Ok(Vec::new()),
        };
        for (name, index) in [("outWrt", self.out_wrt), ("inWrt", self.in_wrt)] {
            if index != Some(0) {
                let given = index.map_or("missing".into(), |index| index.to_string());
                return refuse(format!(
                    "{name} is {given}; there is one input and one output, so give 0"
                ));
            }
        }
        match given {
            Some(values) if values.len() == expected => Ok(values.clone()),
            given => {
                let found = given.as_ref().map_or(0, Vec::len);
                refuse(format!("{name} has {found} entries; give {expected}"))
            }
        }
    }

    /// Requires θ within the ranges that an emulator is trained on, unless it may extrapolate.
    fn within(&self, parameters: &[Parameter], theta: &[f64], other: &str) -> Result<(), Response> {
        let outside = crate::outside(parameters, theta);
        if outside.is_empty() || self.config.as_ref().is_some_and(|config| config.extrapolate) {
            return Ok(());
        }
        let (outside, name) = (outside.join("; "), &self.name);
        refuse(format!(
            "{outside}, where `{name}` extrapolates; give values within the ranges, {other}or send \"config\": \
             {{\"extrapolate\": true}}"
        ))
    }
}

/// The one vector of an input, with an entry for each head.
fn input(heads: &[String], input: Option<&[Vec<f64>]>) -> Result<Vec<f64>, Response> {
    let (names, expected) = (heads.join(", "), heads.len());
    match input {
        Some([values]) if values.len() == expected => Ok(values.clone()),
        Some([values]) => {
            let found = values.len();
            refuse(format!("the input has {found} entries; give {expected}: {names}"))
        }
        input => {
            let found = input.map_or(0, <[_]>::len);
            refuse(format!("the input has {found} vectors; give one: {names}"))
        }
    }
}

/// Requests about a model.
const REQUESTS: [&str; 6] =
    ["/ModelInfo", "/InputSizes", "/OutputSizes", "/Evaluate", "/Gradient", "/ApplyJacobian"];

fn refuse<T>(message: String) -> Result<T, Response> {
    Err(Response::failed(400, "InvalidInput", &message))
}

/// A computation without a result.
impl<E: Into<EmulatorError>> From<E> for Response {
    fn from(error: E) -> Self {
        Self::failed(500, "InvalidOutput", &error.into().to_string())
    }
}

impl<'b> Service<'b> {
    /// Service for a body, with the emulator that `emulator` and `corrected` use; `solver` alone without one.
    pub fn new(body: &'b Body, emulator: Option<Emulator<'b>>) -> Self {
        let of = OfBody { body, emulator, page: None, solvers: SolverPool::new(body) };
        Self { source: Source::Body(Box::new(of)), patient: None }
    }

    /// Service for an emulator of stored runs, without a solver. Its displacements have no derivatives.
    pub fn of_runs(runs: &'b RunsEmulator) -> Self {
        Self { source: Source::Runs(runs), patient: None }
    }

    /// Gives the page of a body's emulator at `/` too, as [`crate::viewer()`] makes it at the first request. It shows the solver's displacement
    /// where the sliders rest, and the true error beside the shown one.
    pub fn with_page(mut self, seed: u64) -> Self {
        if let Source::Body(of) = &mut self.source {
            let surface = of.emulator.as_ref().and_then(|_| Surface::of(&of.body.mesh));
            of.page = surface.map(|surface| Page { surface, seed, html: OnceLock::new() });
        }
        self
    }

    /// Whether there is a page.
    pub fn has_page(&self) -> bool {
        self.page().is_some()
    }

    fn page(&self) -> Option<(&Page, &Emulator<'b>)> {
        let Source::Body(of) = &self.source else { return None };
        of.page.as_ref().zip(of.emulator.as_ref())
    }

    /// Adds the model `patient`: the data of a patient file as functions of its unknown parameters, through the unloaded body and all phases.
    ///
    /// # Errors
    /// As for [`Prepared::patient`].
    pub fn with_patient(self, prepared: &'b Prepared) -> Result<Self, String> {
        Ok(Self { patient: Some(Measured::of(prepared)?), ..self })
    }

    /// Names of the models.
    pub fn models(&self) -> Vec<&'static str> {
        let there = |model: &Model| match (model, &self.source) {
            (Model::Patient, _) => self.patient.is_some(),
            (Model::Solver, Source::Body(_)) | (Model::Emulator, Source::Runs(_)) => true,
            (Model::Deviation, Source::Runs(runs)) => runs.mesh.is_none(),
            (Model::Emulator | Model::Corrected, Source::Body(of)) => of.emulator.is_some(),
            _ => false,
        };
        Model::ALL.into_iter().filter(there).map(Model::name).collect()
    }

    /// Names of the entries of the input and of the output of a model, with their units. Outputs are the data of a patient file; of other models
    /// of a body the volumes of cavities \[length³\], then mean and largest nodal displacement \[length\]; those of stored runs, of their
    /// displacements mean, largest and half-width of the 95 % interval of the root mean square nodal error.
    pub fn heads(&self, model: &str) -> [Vec<String>; 2] {
        match (&self.patient, &self.source) {
            (Some(patient), _) if model == Model::Patient.name() => patient.heads(),
            (_, Source::Body(of)) => {
                [crate::heads(&of.body.parameters), Quantities(of.body).names()]
            }
            (_, Source::Runs(runs)) => [crate::heads(&runs.parameters), runs::names(runs)],
        }
    }

    /// Answer to a request; never a panic, whatever it holds.
    pub fn answer(&self, method: &str, path: &str, text: &str) -> Response {
        if let ("GET", "/", Some((page, emulator))) = (method, path, self.page()) {
            return match page.html(emulator) {
                Ok(text) => Response { status: 200, kind: "text/html; charset=utf-8", text },
                Err(text) => Response { status: 500, kind: "text/plain; charset=utf-8", text },
            };
        }
        let found = match (method, path.trim_end_matches('/')) {
            ("GET", "/Info") => Ok(json!({ "protocolVersion": 1.0, "models": self.models() })),
            ("POST", path) => self.posted(path, text),
            _ => {
                let reason = format!("{method} {path} is no request of UM-Bridge 1.0");
                Err(Response::failed(404, "UnsupportedFeature", &reason))
            }
        };
        found.map_or_else(|refused| refused, |value| Response::json(200, &value))
    }

    fn posted(&self, path: &str, text: &str) -> Result<Value, Response> {
        let of_page = self.page().map(|_| "/Surface");
        let known: Vec<_> = REQUESTS.into_iter().chain(of_page).collect();
        if !known.contains(&path) {
            let message = format!("{path} is not supported; there are: {}", known.join(", "));
            return Err(Response::failed(400, "UnsupportedFeature", &message));
        }
        let request: Request = serde_json::from_str(text).or_else(|error| {
            refuse(format!("the request cannot be read: {error}; send JSON with finite numbers"))
        })?;
        let named =
            |model: &Model| model.name() == request.name && self.models().contains(&model.name());
        let Some(model) = Model::ALL.into_iter().find(named) else {
            let (name, models) = (&request.name, self.models().join(", "));
            let message = format!("there is no model `{name}`; there are: {models}");
            return Err(Response::failed(400, "ModelNotFound", &message));
        };
        let slopes = !matches!(&self.source, Source::Runs(runs) if runs.mesh.is_some());
        match path {
            "/ModelInfo" => Ok(json!({ "support": {
                "Evaluate": true, "Gradient": slopes, "ApplyJacobian": slopes, "ApplyHessian": false
            } })),
            "/Gradient" | "/ApplyJacobian" if !slopes => {
                let reason = "displacements of stored runs have no derivatives here; ask /Evaluate";
                Err(Response::failed(400, "UnsupportedFeature", reason))
            }
            "/InputSizes" => Ok(json!({ "inputSizes": [self.heads(model.name())[0].len()] })),
            "/OutputSizes" => Ok(json!({ "outputSizes": [self.heads(model.name())[1].len()] })),
            _ => self.computed(path, model, &request),
        }
    }

    fn computed(&self, path: &str, model: Model, request: &Request) -> Result<Value, Response> {
        let heads = self.heads(model.name());
        let values = input(&heads[0], request.input.as_deref())?;
        let by = request.weights(path, heads.map(|heads| heads.len()))?;
        let output = match (&self.patient, &self.source) {
            (Some(_), _) if model == Model::Patient && path == "/Surface" => {
                return refuse("the model `patient` has no surface; ask another model".into());
            }
            (Some(patient), _) if model == Model::Patient => patient.answer(path, &values, &by)?,
            (_, Source::Body(of)) => of.answer(path, model, &values, &by, request)?,
            (_, Source::Runs(runs)) => {
                request.within(&runs.parameters, &values, "")?;
                let found = runs::at(runs, model == Model::Deviation, &values)?;
                product(path, &by, found.0, values.len(), |row, d| found.1[row][d])
            }
        };
        let output = finite(output)?;
        Ok(match path {
            "/Surface" => json!({ "displacement": output }),
            "/Evaluate" => json!({ "output": [output] }),
            _ => json!({ "output": output }),
        })
    }
}

impl<'b> OfBody<'b> {
    fn answer(
        &self,
        path: &str,
        model: Model,
        values: &[f64],
        by: &[f64],
        request: &Request,
    ) -> Result<Vec<f64>, Response> {
        let parameters = self.body.parameters.iter().zip(values);
        let theta: Vec<f64> = parameters.map(|(p, &value)| p.unit.in_scene(value)).collect();
        crate::admissible(self.body, &theta).or_else(refuse)?;
        if model != Model::Solver {
            request.within(&self.body.parameters, &theta, "ask the model `solver`, ")?;
        }
        match (path, &self.page) {
            ("/Surface", Some(page)) => {
                Ok(page.surface.of_field(&self.displacement(model, &theta)?))
            }
            ("/Evaluate", _) => Ok(Quantities(self.body).of(&self.displacement(model, &theta)?)),
            _ => self.derivatives(path, model, &theta, by),
        }
    }

    fn displacement(&self, model: Model, theta: &[f64]) -> Result<Vec<f64>, Response> {
        if model == Model::Solver {
            return self
                .solvers
                .with(|solver| Ok(solver.solve(theta, &Options::default())?.displacement));
        }
        let predicted = self.emulator()?.predict(&[theta.to_vec()])?.displacement;
        match model {
            Model::Corrected => self.solvers.with(|solver| {
                Ok(solver.newton_steps(&predicted, theta, 1)?.remove(0).displacement)
            }),
            _ => Ok(predicted),
        }
    }

    /// Derivatives of the displacement, parameter by parameter [length per unit of the scene].
    fn sensitivity(&self, model: Model, theta: &[f64]) -> Result<Vec<Vec<f64>>, Response> {
        match model {
            Model::Emulator => Ok(self.emulator()?.sensitivity(theta)?),
            Model::Solver => self.solvers.with(|solver| {
                let solution = solver.solve(theta, &Options::default())?;
                Ok(solver.sensitivity(&solution)?)
            }),
            _ => central_differences(self.body, theta, |theta| self.displacement(model, &theta)),
        }
    }

    /// Products of the derivatives of the quantities in the parameters' own units with `by`.
    fn derivatives(
        &self,
        path: &str,
        model: Model,
        theta: &[f64],
        by: &[f64],
    ) -> Result<Vec<f64>, Response> {
        let quantities = Quantities(self.body);
        let sizes: Vec<f64> = self.body.parameters.iter().map(|p| p.unit.in_scene(1.0)).collect();
        if model == Model::Solver && path == "/Gradient" {
            // One linear system, whatever the number of parameters.
            let slopes = self.solvers.with(|solver| {
                let solution = solver.solve(theta, &Options::default())?;
                let slope = quantities.slope(&solution.displacement, by);
                solver.adjoint_sensitivity(&solution, &slope)
            })?;
            return Ok(slopes.iter().zip(sizes).map(|(slope, size)| slope * size).collect());
        }
        let displacement = self.displacement(model, theta)?;
        let (gradients, columns) =
            (quantities.gradients(&displacement), self.sensitivity(model, theta)?);
        let slope = |row: usize, i: usize| sizes[i] * dot(&gradients[row], &columns[i]);
        Ok(product(path, by, quantities.of(&displacement), sizes.len(), slope))
    }

    fn emulator(&self) -> Result<&Emulator<'b>, Response> {
        let missing = || Response::failed(400, "ModelNotFound", "there is no emulator");
        self.emulator.as_ref().ok_or_else(missing)
    }
}

/// Requires numbers that JSON has a place for.
fn finite(values: Vec<f64>) -> Result<Vec<f64>, Response> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(values),
        Some(value) => {
            let reason =
                format!("the output holds {value}; give parameters nearer to their ranges");
            Err(Response::failed(500, "InvalidOutput", &reason))
        }
    }
}

/// Values, or products of their derivatives by the input with `by`: a row for each value, a column for each entry of the input.
fn product(
    path: &str,
    by: &[f64],
    values: Vec<f64>,
    inputs: usize,
    slope: impl Fn(usize, usize) -> f64,
) -> Vec<f64> {
    let rows = 0..values.len();
    match path {
        "/Evaluate" => values,
        "/Gradient" => {
            (0..inputs).map(|i| rows.clone().map(|row| by[row] * slope(row, i)).sum()).collect()
        }
        _ => rows.map(|row| (0..inputs).map(|i| by[i] * slope(row, i)).sum()).collect(),
    }
}

/// Script that asks.
const SCRIPT: &str = include_str!("serve/live.js");

/// Page that is made at the first request.
struct Page {
    surface: Surface,
    seed: u64,
    html: OnceLock<Result<String, String>>,
}

impl Page {
    /// The page, or the reason for its absence.
    fn html(&self, emulator: &Emulator<'_>) -> Result<String, String> {
        let make = || {
            let page = viewer(emulator, self.seed, &mut ()).map_err(|error| error.to_string())?;
            let script = format!("<script>{SCRIPT}</script></body>");
            Ok(page.to_html().replace("</body>", &script))
        };
        self.html.get_or_init(make).clone()
    }
}

//! Emulators of soft-tissue mechanics with checked error estimates, from a mesh or a case file.
//!
//! Displacements to a prescribed accuracy:
//!
//! ```
//! use sinew::mesh::box_tetrahedra;
//! use sinew::{Answers, Design, Load, Parameter, Scene, Support, laws::NeoHookean};
//!
//! // A bar that bends under its own weight, of any stiffness in a range.
//! let body = Scene::new(box_tetrahedra([30.0, 6.0, 6.0], [6, 2, 2]), NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
//!     .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
//!     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
//!     .support(Support::clamped("x_min"))
//!     .lower()?;
//!
//! // Thirty parameter sets to a relative error of 1e-3, by the method with the fewest expected Newton steps.
//! let thetas = Design::LatinHypercube.sample(&body.parameters, 30, 1)?;
//! let found = Answers::to(&body, &thetas, 1e-3, None, &mut ())?;
//! for answer in found.answers {
//!     assert!(answer?.is_within(1e-3)); // checked by steps that contract
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crates below are modules of this one: [`mesh`], [`energy`], [`fem`], [`emulate`], [`calibrate`] and [`report`].
//!
//! A case file names a mesh, a law, fibres, loads, supports and the ranges of parameters θ; [`Case`] reads it,
//! [`Case::body`] makes the [`Body`] that everything else speaks to. The program `sinew` does all of this from a
//! terminal; `docs/case-file.md` describes every key. The second example measures an emulator on unseen parameters.
//!
//! Compile with `--release`: Sinew's own workspace optimises all profiles, a crate that depends on it does not.
//!
//! ```
//! use sinew::{Case, Comparison, TestSet, Train, recipe::Regression, simulate};
//!
//! // Mesh, law, loads, supports and ranges: a body.
//! let case = Case::parse(
//!     r#"
//!     law = "neo-hookean"
//!     loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]   # kPa/mm
//!     supports = [{ clamped = "x_min" }]
//!     mesh.box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }
//!     parameters = { mu = [8.0, 16.0], lambda = [8.0, 16.0] }
//!     training = { held_out = 4 }
//!     "#,
//!     "bar.toml",
//! )?;
//! let body = case.body()?;
//!
//! // An emulator, from nine simulations.
//! let recipe = Regression { simulations: 9, most: 9, target: 0.0 };
//! let emulator = recipe.train(&body, &case.training.options(), &mut ())?;
//!
//! // A prediction, its error estimate, and a correction by one Newton step.
//! let theta = vec![10.0, 12.0];
//! let prediction = emulator.predict(&[theta.clone()])?;
//! let estimate = emulator.estimate(&prediction, 0)?;
//! let corrected = emulator.correct(&theta, 1)?;
//! assert!(corrected.estimate.residual < estimate.residual);
//!
//! // Errors and times on unseen cases.
//! let test = TestSet::new(&body, simulate(&body, &[theta], "test", None, &mut ())?);
//! let mut comparison = Comparison::new(&test)?;
//! comparison.add("regression", &emulator, &test, 2)?;
//! println!("{comparison}");
//! let found = &comparison.methods[0].evaluation;
//! assert!(found.corrected[0].errors.err_u.max < found.raw.err_u.max);
//! let page = comparison.report()?.to_html();
//! assert!(page.contains("regression + 1 Newton"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod at_rest;
pub mod calibration;
pub mod case;
mod comparison;
pub mod npz;
pub mod output;
mod page;
mod patient;
pub mod runs;
pub mod scenes;
pub mod serve;
pub mod stresses;
mod theta;
mod viewer;
mod wall;

pub use at_rest::mesh_at_rest;
pub use case::{Case, CaseError, locking_in_words};
pub use comparison::{Comparison, Method};
pub use patient::{PatientFile, Prepared};
#[cfg(not(feature = "networks"))]
pub use sinew_emulate::recipe;
pub use sinew_emulate::{
    Answer, Answers, Correction, Design, Emulator, Error as EmulatorError, Estimate, Evaluation,
    Prediction, Record, Simulations, TestSet, Train, TrainingOptions, Warning, simulate,
};
pub use sinew_energy::{
    Body, Law, Load, Parameter, Sampling, Scene, SceneError, Support, ThetaError, Unit, laws,
};
pub use sinew_fem::{
    FrozenStiffness, Line, Options, Refined, Solution, SolveError, Solver, Stop, sweep,
};
#[cfg(feature = "networks")]
pub use sinew_gnn::{Backend, Recipe, load, recipe};
pub use sinew_mesh::MeshError;
pub use sinew_report::ReportError;
pub use theta::{
    TableRow, ThetaText, admissible, heads, outside, parse_theta, parse_theta_but, parse_way,
    range_in_words, read_rows, read_thetas, theta_in_words, theta_of, thetas_along,
    values_in_words,
};
pub use viewer::{PAGE_SEED, viewer, viewer_of_runs};
pub use wall::ventricle;
pub use {
    sinew_calibrate as calibrate, sinew_emulate as emulate, sinew_energy as energy,
    sinew_fem as fem, sinew_mesh as mesh, sinew_report as report, sinew_sample as sample,
};

/// Makes memory that a program frees leave it at once: glibc keeps freed blocks of up to 32 MB, a fifth of the peak of a body of
/// 28 000 nodes. For the first line of a program.
pub fn free_at_once() {
    // SAFETY: sets a number of the allocator, 4 MB.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 22);
    }
}

/// Whether emulators that are networks can be trained and loaded: the feature `networks`.
pub const NETWORKS: bool = cfg!(feature = "networks");

/// Reads an emulator of `body`; networks need the feature `networks`.
///
/// # Errors
/// As [`Emulator::load`].
#[cfg(not(feature = "networks"))]
pub fn load<'b>(folder: &std::path::Path, body: &'b Body) -> sinew_emulate::Result<Emulator<'b>> {
    Emulator::load(folder, body)
}

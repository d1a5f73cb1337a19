//! The commands, one file each, and what they share.

mod batch;
pub(crate) mod calibrate;
pub(crate) mod evaluate;
pub(crate) mod export;
pub(crate) mod mesh;
pub(crate) mod predict;
pub(crate) mod runs;
pub(crate) mod sample;
pub(crate) mod scenes;
mod script;
pub(crate) mod serve;
pub(crate) mod solve;
mod stop;
pub(crate) mod train;
pub(crate) mod unload;

use anyhow::{Context, Result};
use batch::{Batch, ThetaArguments, Written};
use clap::Args;
use script::quoted;
use sinew::case::{Formulation, branched_in_words, doubtful_displacements, locking_at_most};
use sinew::{
    Body, Case, CaseError, Emulator, EmulatorError, FrozenStiffness, Simulations, ThetaText,
    simulate, theta_in_words,
};
use sinew_emulate::Terminal;
use sinew_fem::{LockingWarning, SolveError};
use std::ffi::OsStr;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use stop::stoppable;

/// A case, and its mesh where that is another one.
#[derive(Debug, Args)]
pub(crate) struct CaseFile {
    /// Case file, or the name of a built-in scene (`sinew scenes`)
    case: PathBuf,
    /// Mesh file (VTK, VTU, gmsh or Abaqus) instead of the case's own mesh
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
}

impl CaseFile {
    /// The case on its mesh.
    fn read(&self) -> Result<Case> {
        let case = Case::read(&self.case)?;
        Ok(self.mesh.iter().fold(case, |case, mesh| case.with_mesh(mesh.clone())))
    }

    /// Case and body; warnings of the body are told on standard error. A case without a potential is refused.
    pub(crate) fn open(&self) -> Result<(Case, Body)> {
        let case = self.read()?;
        let body = tell_body(&case, case.body())?;
        Ok((case, body))
    }

    /// Arguments that name the same case, for a shell.
    fn words(&self) -> String {
        let mesh = self.mesh.as_ref().map(|mesh| format!(" --mesh {}", quoted(mesh)));
        quoted(&self.case) + &mesh.unwrap_or_default()
    }

    /// Refuses to write over a file that was read.
    fn keep_sources(&self, output: &Path) -> Result<()> {
        let mut sources = Case::read(&self.case)?.files();
        sources.extend(self.mesh.iter().chain([&self.case]).cloned());
        keep(sources.iter(), output)
    }
}

/// Refuses to write over a file that was read.
fn keep<'a>(mut sources: impl Iterator<Item = &'a PathBuf>, output: &Path) -> Result<()> {
    refuse_if(sources.any(|file| same(file, output)), || {
        format!("-o: {} is an input, which would be lost; name another file", output.display())
    })
}

/// Body and folder of the results.
#[derive(Debug, Args)]
pub(crate) struct CaseArguments {
    #[command(flatten)]
    file: CaseFile,
    /// Folder for results [default: out/NAME]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl CaseArguments {
    /// The case and the folder for its results.
    pub(crate) fn read(&self) -> Result<(Case, PathBuf)> {
        let case = self.file.read()?;
        let folder = self.folder(&case);
        Ok((case, folder))
    }

    /// Arguments that name the same case and folder, for a shell.
    fn words(&self) -> String {
        let out = self.out.as_ref().map(|out| format!(" --out {}", quoted(out)));
        self.file.words() + &out.unwrap_or_default()
    }

    /// [`CaseFile::open`], and the folder.
    pub(crate) fn open(&self) -> Result<(Case, Body, PathBuf)> {
        let (case, body) = self.file.open()?;
        let folder = self.folder(&case);
        Ok((case, body, folder))
    }

    /// [`CaseArguments::open`] for what can do without a potential.
    pub(crate) fn open_lowered(&self) -> Result<(Case, Body, PathBuf)> {
        let (case, folder) = self.read()?;
        let body = tell_body(&case, case.lowered())?;
        Ok((case, body, folder))
    }

    fn folder(&self, case: &Case) -> PathBuf {
        // A name may hold what paths read as folders.
        let kept = |c: char| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' };
        self.out_or(case.name.chars().map(kept).collect::<String>().as_ref())
    }

    /// The folder that was named, or that of a name.
    fn out_or(&self, name: &OsStr) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("out").join(name))
    }
}

/// Result of lowering a case. Tells on standard error what the reader of its mesh changed, also where that is an error then.
fn tell_reading<T>(case: &Case, made: Result<T, CaseError>) -> Result<T, CaseError> {
    if let (Some(report), Some(file)) = (case.mesh.report.get(), &case.mesh.file) {
        let file = file.display();
        report.warnings().iter().for_each(|doubt| eprintln!("warning: {file}: {doubt}"));
        report.changes().iter().for_each(|change| eprintln!("{file}: {change}"));
    }
    made
}

/// [`tell_reading`] of a body; tells its warnings as well, and the formulation that was chosen for it.
fn tell_body(case: &Case, made: Result<Body, CaseError>) -> Result<Body, CaseError> {
    let body = tell_reading(case, made)?;
    warn(case.warnings(&body));
    if case.formulation == Formulation::Auto {
        let averaged = if body.patches.is_empty() { "" } else { ", volume ratios averaged" };
        eprintln!("formulation auto: {}{averaged}", body.element().plural);
    }
    Ok(body)
}

/// Another body whose solution and stiffness are known.
#[derive(Debug, Args)]
pub(crate) struct Neighbour {
    /// Case file or built-in scene of another body with the same connectivity and the same supports: its solution and
    /// stiffness give the predictions for this body
    #[arg(long, value_name = "CASE")]
    from: Option<PathBuf>,
}

impl Neighbour {
    /// The other body, where one was named.
    ///
    /// # Errors
    /// A case that cannot be read.
    pub(crate) fn body(&self) -> Result<Option<Body>> {
        self.from.as_ref().map(|path| Ok(Case::read(path)?.body()?)).transpose()
    }

    /// Emulator of `body` by the solution and the stiffness of the other body.
    ///
    /// # Errors
    /// Bodies whose cells or supports differ, another body that has no equilibrium.
    pub(crate) fn emulator<'b>(&self, other: &'b Body, body: &'b Body) -> Result<Emulator<'b>> {
        let unlike = |error: EmulatorError| {
            let name = self.from.as_deref().unwrap_or(Path::new("")).display();
            let said = format!("--from {name}: {error}");
            match error {
                EmulatorError::Solve(SolveError::OtherBody { .. }) => Usage(said).into(),
                _ => anyhow::Error::msg(said),
            }
        };
        let known = FrozenStiffness::new(other).map_err(|error| unlike(error.into()))?;
        Emulator::frozen_stiffness(body, &known).map_err(unlike)
    }
}

/// Tells on standard error that cells are too stiff for the body, if they are.
pub(crate) fn warn_of_locking(locking: Result<Option<LockingWarning>, SolveError>) {
    match locking {
        Ok(None) => {}
        Ok(Some(found)) => eprintln!("warning: {}", sinew::locking_in_words(&found)),
        Err(why) => eprintln!("warning: whether the cells are too stiff is not known: {why}"),
    }
}

/// Tells on standard error what to doubt of the states of a body at sets of parameters.
pub(crate) fn tell_states<'a>(
    body: &Body,
    thetas: &'a [Vec<f64>],
    fields: impl Iterator<Item = &'a [f64]> + Clone,
) {
    warn_of_locking(locking_at_most(body, thetas.iter().zip(fields.clone())));
    warn(doubtful_displacements(body, &fields.collect::<Vec<_>>()));
}

/// Prints warnings on standard error.
fn warn<W: Display>(warnings: impl IntoIterator<Item = W>) {
    warnings.into_iter().for_each(|warning| eprintln!("warning: {warning}"));
}

/// Warnings of one kind that are printed; the others are counted.
pub(crate) const MOST_WARNINGS: usize = 5;

/// Emulators in a folder of results by the names of their folders, short ones first; one at least.
pub(crate) fn trained(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    if folder.exists() {
        for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if path.join("emulator/emulator.json").exists() {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                found.push((name, path.join("emulator")));
            }
        }
    }
    let reason = || format!("there is no emulator in {}; make one: sinew train", folder.display());
    refuse_if(found.is_empty(), reason)?;
    // regression-25 before regression-100.
    found.sort_by(|(a, _), (b, _)| (a.len(), a).cmp(&(b.len(), b)));
    Ok(found)
}

/// Name and folder of the emulator that is asked for by its name, or of the only one, or of the one that the case's recipe makes.
pub(crate) fn chosen(
    wanted: Option<&str>,
    case: &Case,
    folder: &Path,
) -> Result<(String, PathBuf)> {
    let mut found = trained(folder)?;
    let own = case.training.recipe_name();
    let place = match (wanted, &found[..]) {
        (None, [_]) => Some(0),
        _ => found.iter().position(|(name, _)| name == wanted.unwrap_or(own.key())),
    };
    if let Some(place) = place {
        return Ok(found.swap_remove(place));
    }
    let names: Vec<_> = found.iter().map(|(name, _)| name.as_str()).collect();
    let (folder, names) = (folder.display(), names.join(", "));
    match wanted {
        Some(wanted) => refuse(format!(
            "--emulator {wanted}: there is no emulator of that name in {folder}; there are: {names}"
        )),
        None => refuse(format!(
            "{folder} holds several emulators; choose one with --emulator NAME: {names}"
        )),
    }
}

/// Solves with a bar on the terminal; what has no equilibrium is told on standard error.
pub(crate) fn solved(
    body: &Body,
    thetas: &[Vec<f64>],
    stage: &str,
    folder: Option<&Path>,
) -> Result<Simulations> {
    let mut terminal = if folder.is_some() { stoppable()? } else { Terminal::default() };
    let found = simulate(body, thetas, stage, folder, &mut terminal)?;
    tell_found(body, &found);
    Ok(found)
}

/// Tells doubts about solutions on standard error, and what has no equilibrium.
pub(crate) fn tell_found(body: &Body, found: &Simulations) {
    tell_solved(body, found);
    let failures = &found.failures;
    failures.iter().take(MOST_WARNINGS).for_each(|failure| told_failure(body, failure));
    if let Some(more @ 1..) = failures.len().checked_sub(MOST_WARNINGS) {
        eprintln!("no equilibrium at {more} more");
    }
}

/// Cure of solutions on other branches.
const STEPWISE: &str = "`sinew solve --load-steps`";

/// Tells doubts about solutions on standard error, and other stable equilibria.
pub(crate) fn tell_solved(body: &Body, found: &Simulations) {
    tell_states(body, &found.thetas, found.fields.iter().map(Vec::as_slice));
    warn(branched_in_words(body, found, STEPWISE));
}

/// Tells a sample without equilibrium on standard error.
fn told_failure(body: &Body, failure: &sinew_emulate::Failure) {
    eprintln!("no equilibrium at {}: {}", theta_in_words(body, &failure.theta), failure.reason);
}

/// An error with its causes, each said once.
pub(crate) fn told(error: &anyhow::Error) -> String {
    if let Some(EmulatorError::Interrupted { stage }) = error.downcast_ref() {
        return format!(
            "stopped in the stage `{stage}` with everything stored; the same command goes on from there"
        );
    }
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text += &format!("\n  because {cause}");
        }
    }
    text
}

/// Exit code of an error: 3 where a signal stopped the run, 2 where the user can correct it without a computation, its own for a check.
pub(crate) fn code(error: &anyhow::Error) -> u8 {
    if let Some(Unpassed(code)) = error.downcast_ref() {
        return *code;
    }
    use EmulatorError as E;
    let is_usage = |cause: &(dyn std::error::Error + 'static)| match cause.downcast_ref() {
        Some(E::Setting { .. } | E::Request(_) | E::Samples(_)) => true,
        _ => cause.is::<CaseError>() || cause.is::<ThetaText>() || cause.is::<Usage>(),
    };
    match error.downcast_ref() {
        Some(E::Interrupted { .. }) => 3,
        _ if error.chain().any(is_usage) => 2,
        _ => 1,
    }
}

/// A check without the answer that a script waits for, with its exit code.
#[derive(Debug, thiserror::Error)]
#[error("the check is not passed; its first line says why")]
pub(crate) struct Unpassed(pub u8);

/// A command line that asks for something that does not exist.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Usage(pub String);

/// Makes a folder for results before anything is computed for it.
fn make_folder(folder: &Path) -> Result<()> {
    let place = folder.display();
    std::fs::create_dir_all(folder)
        .or_else(|error| refuse(format!("{place}: {error}; check the path and the permissions")))
}

/// Most parameter sets that are drawn: their table takes gigabytes.
const MOST_SETS: f64 = 1e8;

/// A number of parameter sets of a command line, such as 10000 or 1e4.
fn count(text: &str) -> Result<usize, String> {
    let whole = text.parse().ok().filter(|count: &f64| count.fract() == 0.0);
    match whole.ok_or("give a whole number, such as 100")? {
        count if (1.0..=MOST_SETS).contains(&count) => Ok(count as usize),
        _ => Err(format!("{text} is not in 1..={MOST_SETS}")),
    }
}

/// Whether two paths name one file, which exists.
fn same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Requires the name of a VTU file in a folder that exists, before anything is computed for it.
fn check_vtu(file: &Path) -> Result<()> {
    let reason = || format!("-o {}: the name must end with .vtu", file.display());
    refuse_if(file.extension().is_none_or(|extension| extension != "vtu"), reason)?;
    check_folder(file)
}

/// Requires that the folder of a file exists.
fn check_folder(file: &Path) -> Result<()> {
    let folder = file.parent().unwrap_or(file);
    let (named, place) = (file.display(), folder.display());
    refuse_if(!folder.as_os_str().is_empty() && !folder.is_dir(), || {
        format!("-o {named}: there is no folder {place}; make it, or name another file")
    })
}

/// Refuses to replace a file that a command did not write: its own begin with its mark.
fn keep_foreign(command: &str, mark: &str, file: &Path) -> Result<()> {
    let own = std::fs::read(file).is_ok_and(|text| text.starts_with(mark.as_bytes()));
    refuse_if(!own && file.exists(), || {
        format!(
            "{} is there already, and sinew {command} did not write it; name another file with -o, or remove it",
            file.display()
        )
    })
}

/// Text below a comment: a command's mark, and what the text was made from.
fn marked(mark: &str, origin: &str, text: &str) -> String {
    format!("{mark}{}\n{text}", origin.replace(char::is_control, " "))
}

/// Refuses a command line.
pub(crate) fn refuse<T>(reason: String) -> Result<T> {
    Err(Usage(reason).into())
}

/// Refuses a command line that is wrong.
fn refuse_if<R: Into<String>>(wrong: bool, reason: impl FnOnce() -> R) -> Result<()> {
    if wrong { refuse(reason().into()) } else { Ok(()) }
}

/// The set of parameters where a command line asks for one.
fn single<'t>(option: &str, thetas: &'t [Vec<f64>]) -> Result<&'t Vec<f64>> {
    let [theta] = thetas else {
        return refuse(format!("{option}: give one set of parameters, not {}", thetas.len()));
    };
    Ok(theta)
}

/// Writes a file, which an error names.
fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    std::fs::write(path, content).with_context(|| path.display().to_string())
}

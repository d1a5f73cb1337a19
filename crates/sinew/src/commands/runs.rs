//! Emulators of stored runs of any solver: training, predictions and posteriors.

use super::batch::{MOST_LINES, tell_outside};
use super::calibrate::told;
use super::{CaseArguments, ThetaArguments, refuse, refuse_if, warn, write};
use anyhow::{Context, Result};
use clap::Args;
use serde::Deserialize;
use sinew::calibrate::CalibrateError;
use sinew::calibration::{SOLVES, remove_results};
use sinew::case::parse_tables;
use sinew::output::displacement_in_words;
use sinew::report::format::{digits, digits_beside};
use sinew::runs::{Measured, Runs, RunsPosterior, write_predictions};
use sinew::{EmulatorError, Unit, values_in_words};
use sinew_emulate::{LeftOut, Predicted, RunsEmulator, Terminal};
use sinew_num::try_in_parallel;
use sinew_report::Provenance;
use sinew_sample::{NutsOptions, write_csv};
use std::path::{Path, PathBuf};

/// Runs of any solver.
#[derive(Debug, Args)]
#[group(conflicts_with_all = ["case", "recipe", "samples", "target", "anchors", "minutes", "steps", "seed", "simulations", "from", "name", "resume"])]
pub(crate) struct RunsArguments {
    /// CSV table of runs of any solver, with names in its first line: columns of parameters (--parameters) and of outputs
    #[arg(long, value_name = "CSV", conflicts_with = "mesh", requires = "parameters")]
    from_table: Option<PathBuf>,
    /// Archive of numpy.savez: theta (runs × parameters) and displacements (runs × nodes × 3) on the mesh of --mesh, by any solver
    #[arg(long, value_name = "NPZ", conflicts_with = "from_table", requires_all = ["mesh", "parameters"])]
    from_fields: Option<PathBuf>,
    /// Columns of the table that are parameters, by names separated by commas; names of the parameters of --from-fields
    #[arg(long, value_name = "NAMES")]
    parameters: Option<String>,
    /// Columns of the table to emulate [default: all others]
    #[arg(long, value_name = "NAMES", requires = "from_table")]
    outputs: Option<String>,
    /// Column of the table with a VTU file for each run, whose displacements are emulated
    #[arg(long, value_name = "NAME", requires = "from_table", conflicts_with = "outputs")]
    files: Option<String>,
}

/// Folder of the emulator within OUT.
const EMULATOR: &str = "emulator";

impl RunsArguments {
    pub(crate) fn are_given(&self) -> bool {
        self.from_table.is_some() || self.from_fields.is_some()
    }

    pub(crate) fn train(&self, case: &CaseArguments, restart: bool) -> Result<()> {
        let parameters = self.parameters.as_deref().unwrap_or_default();
        let (file, runs) = match (&self.from_table, &self.from_fields, &case.file.mesh) {
            (Some(file), ..) => match &self.files {
                Some(column) => (file, Runs::read_files(file, parameters, column)?),
                None => (file, Runs::read_table(file, parameters, self.outputs.as_deref())?),
            },
            (None, Some(file), Some(mesh)) => (file, Runs::read_fields(file, mesh, parameters)?),
            _ => return refuse("--from-fields needs --mesh".into()),
        };
        let folder = case.out_or(file.file_stem().unwrap_or_default());
        refuse_if(folder.join(EMULATOR).exists() && !restart, || {
            format!(
                "{} holds an emulator already; replace it with --restart, or name another folder with --out",
                folder.display()
            )
        })?;
        let emulator = runs.fit(&mut Terminal::default())?;
        emulator.save(&folder.join(EMULATOR))?;
        tell(&emulator);
        println!("written: {}", folder.display());
        Ok(())
    }
}

/// Errors of runs left out.
fn tell(emulator: &RunsEmulator) {
    for left in emulator.left_out() {
        let LeftOut { name, unit, runs, folds, error, deviation, widest: (width, theta), .. } =
            left;
        let how = if folds == runs { "leave-one-out".into() } else { format!("{folds}-fold") };
        let (unit, r_squared) = (Unit::from(unit.as_str()).suffix(), left.r_squared());
        let (error, share) = (digits(*error, 3), digits(error / deviation, 2));
        let place = values_in_words(&emulator.parameters, theta);
        println!(
            "{name}: error {error}{unit} ({how}), {share} of the standard deviation, R² {r_squared:.5}; widest interval ± {}{unit} at {place}",
            digits(*width, 2)
        );
    }
}

/// The emulator of stored runs that the place of the case names, if it does. Other options are `asked` for in vain.
pub(crate) fn trained(
    case: &CaseArguments,
    asked: impl IntoIterator<Item = bool>,
    options: &str,
) -> Result<Option<RunsEmulator>> {
    let folder = case.file.case.join(EMULATOR);
    if !folder.join(RunsEmulator::FILE).exists() {
        return Ok(None);
    }
    let extra = asked.into_iter().any(|asked| asked) || case.file.mesh.is_some();
    refuse_if(extra, || format!("stored runs have no solver: leave {options} and --mesh out"))?;
    let emulator = RunsEmulator::load(&folder)?;
    warn(&emulator.warnings);
    Ok(Some(emulator))
}

/// Predicts outputs with their intervals, and writes them.
pub(crate) fn predict(
    emulator: &RunsEmulator,
    case: &CaseArguments,
    theta: &ThetaArguments,
    pictures: usize,
) -> Result<()> {
    let out = case.out.as_ref().unwrap_or(&case.file.case).join("predict");
    let thetas = theta.of(&emulator.parameters, &out)?;
    tell_outside(&emulator.parameters, &thetas);
    let found = try_in_parallel(thetas, |theta| -> Result<_, EmulatorError> {
        let found = emulator.predict(&theta)?;
        Ok((theta, found))
    })?;
    for (theta, found) in found.iter().take(MOST_LINES) {
        println!("{}: {}", values_in_words(&emulator.parameters, theta), said(emulator, found));
    }
    write_predictions(&out, emulator, &found, pictures)?;
    println!("written: {}", out.display());
    Ok(())
}

/// Measured values of outputs of an emulator, in TOML.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DataFile {
    /// Folder that `sinew train --from-table` wrote, beside the file.
    emulator: PathBuf,
    #[serde(default)]
    data: Vec<Measured>,
    #[serde(default)]
    seed: u64,
    draws: Option<usize>,
}

impl DataFile {
    /// The file, if it names an emulator.
    pub(crate) fn read(path: &Path) -> Result<Option<Self>> {
        let Ok(text) = std::fs::read_to_string(path) else { return Ok(None) };
        let names = |table: toml::Table| table.contains_key("emulator");
        if !text.parse().is_ok_and(names) {
            return Ok(None);
        }
        let file: Self = parse_tables(&text, &path.to_string_lossy())?;
        let folder = path.with_file_name(&file.emulator);
        Ok(Some(Self { emulator: folder, ..file }))
    }

    /// Draws parameters given the data, and writes them with the file's settings.
    pub(crate) fn calibrate(&self, case: &CaseArguments, seed: Option<u64>) -> Result<()> {
        let file = &case.file.case;
        let out = case.out_or(file.file_stem().unwrap_or_default()).join("calibrate");
        refuse_if(out.join(SOLVES).exists(), || {
            format!("{} holds the calibration of a patient; give another --out", out.display())
        })?;
        std::fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
        remove_results(&out).map_err(told)?;
        let inner = self.emulator.join(EMULATOR);
        let folder = if inner.exists() { &inner } else { &self.emulator };
        let emulator = RunsEmulator::load(folder)?;
        let default = NutsOptions::default();
        let draws = self.draws.map_or(default.draws, |draws| draws.div_ceil(default.chains));
        let options = NutsOptions { draws, seed: seed.unwrap_or(self.seed), ..default };
        let mut terminal = Terminal::default();
        let posterior = RunsPosterior::new(&emulator, &self.data, &options, &mut terminal);
        let posterior = posterior.or_else(|error| match error {
            CalibrateError::Input(reason) => refuse(format!("{}: {reason}", file.display())),
            error => Err(error.into()),
        })?;
        warn(&posterior.warnings);
        posterior.in_words().iter().for_each(|line| println!("{line}"));
        write_csv(&out.join("posterior.csv"), &posterior.columns())?;
        posterior.to_arviz().write(&out.join("posterior.json"))?;
        let provenance = Provenance {
            seed: Some(options.seed),
            config: std::fs::read_to_string(file).unwrap_or_default(),
            ..Provenance::of_this_run("sinew", env!("CARGO_MANIFEST_DIR"))
        };
        write(&out.join("provenance.json"), serde_json::to_string_pretty(&provenance)?)?;
        println!("written: {}", out.display());
        Ok(())
    }
}

/// Outputs with their 95 % errors.
fn said(emulator: &RunsEmulator, found: &[Predicted]) -> String {
    let one = |(left, Predicted { values, half_width }): (&LeftOut, &Predicted)| {
        let value = match emulator.mesh {
            None => digits_beside(values[0], *half_width, 6),
            Some(_) => displacement_in_words(values, &left.unit),
        };
        let unit = Unit::from(left.unit.as_str()).suffix();
        format!("{} {value} ± {}{unit}", left.name, digits(*half_width, 2))
    };
    emulator.left_out().iter().zip(found).map(one).collect::<Vec<_>>().join(", ")
}

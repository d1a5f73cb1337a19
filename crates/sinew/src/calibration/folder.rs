//! Folder of a calibration: solves to go on from, and results.

use super::{Curve, arviz, report, too_stiff};
use crate::mesh_at_rest;
use crate::patient::{PatientFile, Prepared};
use sinew_calibrate::{CalibrateError, Patient, Posterior, Solves};
use sinew_report::Provenance;
use std::fmt::Display;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Solves of a run within its folder.
pub const SOLVES: &str = "solves.csv";
/// Results of a run within its folder.
const RESULTS: &str =
    "posterior.csv posterior.json provenance.json edpvr.csv rest.vtu report.html report.json";

/// An error at a file.
fn at<E: Display>(path: &Path) -> impl Fn(E) -> CalibrateError {
    move |error| CalibrateError::Store(format!("{}: {error}", path.display()))
}

/// Solves that are kept in the folder of a run: `resume` goes on from those of an earlier one, `restart` replaces them. Earlier results are removed.
///
/// # Errors
/// Solves of an earlier run that are neither resumed nor replaced, or of another patient; a folder that cannot be written.
pub fn kept<'f>(
    solves: Solves<'f>,
    folder: &Path,
    file: &PatientFile,
    prepared: &Prepared,
    [resume, restart]: [bool; 2],
) -> Result<Solves<'f>, CalibrateError> {
    std::fs::create_dir_all(folder).map_err(at(folder))?;
    let stored = folder.join(SOLVES);
    // The first line names the patient.
    let text = std::fs::read_to_string(&stored).unwrap_or_default();
    let count = text.lines().count().saturating_sub(1);
    if count > 0 && !resume && !restart {
        let advice = "--resume goes on from them, --restart starts anew without them";
        return Err(CalibrateError::Store(format!(
            "{} holds {count} solves of an earlier run; {advice}",
            stored.display()
        )));
    }
    let solves = solves.kept_in(&stored, &identity(file, prepared)?, resume)?;
    remove_results(folder).map(|()| solves)
}

/// Removes the results of an earlier run, which would stand beside solves of another.
///
/// # Errors
/// A file that cannot be removed.
pub fn remove_results(folder: &Path) -> Result<(), CalibrateError> {
    let remove = |path: PathBuf| match std::fs::remove_file(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(at(&path)(format!(
            "the result of an earlier run cannot be removed: {error}; check the permissions"
        ))),
        _ => Ok(()),
    };
    RESULTS.split(' ').map(|name| folder.join(name)).try_for_each(remove)
}

/// Hash of the inputs of a solve: the file's settings, whatever their order and comments, and the mesh with its nodes, cells, sets and
/// fields, from which the body follows.
fn identity(file: &PatientFile, prepared: &Prepared) -> Result<String, CalibrateError> {
    let mut hash = DefaultHasher::new();
    let settings = file.settings().map_err(|error| CalibrateError::Input(error.to_string()))?;
    settings.hash(&mut hash);
    format!("{:?}", prepared.body.mesh).hash(&mut hash);
    Ok(format!("# solves of a patient, {:016x}", hash.finish()))
}

/// Writes draws, pressure–volume curve, body at rest and page into the folder of a run; the provenance gets the text of the patient file. Returns
/// the page, and warnings.
///
/// # Errors
/// A file that cannot be written, most likely parameters at which the body has no state.
pub fn written(
    file: &PatientFile,
    prepared: &Prepared,
    patient: &Patient,
    posterior: &Posterior,
    provenance: Provenance,
    folder: &Path,
) -> Result<(PathBuf, Vec<String>), CalibrateError> {
    posterior.write_csv(&folder.join("posterior.csv"))?;
    arviz(prepared, posterior).write(&folder.join("posterior.json"))?;
    let (mut curves, mut doubts) = (Vec::new(), Vec::new());
    for (cavity, _) in &prepared.pressures {
        match Curve::new(prepared, posterior, cavity) {
            Ok(curve) => curves.push(curve),
            Err(reason) => doubts.push(format!("no pressure–volume curve: {reason}")),
        }
    }
    if let Some(curve) = curves.first() {
        let path = folder.join("edpvr.csv");
        std::fs::write(&path, curve.to_csv()).map_err(at(&path))?;
    }
    let rest = patient.states_checked(&posterior.mode.theta, false);
    let rest = rest.map_err(|error| {
        CalibrateError::NoPosterior(format!(
            "the draws are written, but there is no state at the most probable parameters: {error}"
        ))
    })?;
    doubts.extend(too_stiff(&rest));
    if let Some(unloaded) = &rest.unloaded {
        let path = folder.join("rest.vtu");
        mesh_at_rest(&prepared.body, unloaded).write_vtu(&path).map_err(at(&path))?;
    }
    let provenance = Provenance { config: file.case.text().trim_end().into(), ..provenance };
    let page = report(&file.case.name, prepared, posterior, &curves, &rest, provenance);
    Ok((page.write(folder).map_err(at(folder))?, doubts))
}

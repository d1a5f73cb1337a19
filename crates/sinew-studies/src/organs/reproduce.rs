//! The study of organs, from the command line to the report.

use crate::organs::options::Options;
use crate::organs::run::section;
use crate::organs::scenes::{CUBES, ORGANS, Organ, PARTS};
use crate::organs::{cubes, newcomers};
use crate::program::Growing;
use anyhow::{Context, Result};
use std::path::PathBuf;

/// Runs everything that is asked for and writes the report, anew after every scene; the path of `report.html`.
///
/// # Errors
/// Whatever keeps a scene from being run, and files that cannot be written. Scenes that are done are kept.
pub fn reproduce(options: &Options) -> Result<PathBuf> {
    let about = "Error and time on the same meshes, parameters and machine; the truth is our finite-element solution.";
    let names = ["The thesis’ organs", about];
    let mut growing = Growing::new(names, (options.seed, options.quick), options, |report| {
        let [all, met] = report.verdicts();
        format!(
            "{met} of {all} comparisons with medians that the thesis prints are met, each emulator counted for itself."
        )
    })?;
    let mut page = None;
    for organ in ORGANS.iter().filter(|organ| options.wants(organ.key)) {
        match section(options, organ).with_context(|| format!("scene {}", organ.key))? {
            Some(section) => page = Some(growing.add(section, &options.out)?),
            None => growing.report.notes.push(absent(options, organ)),
        }
    }
    for part in PARTS.iter().filter(|part| options.wants(part.key)) {
        let section = match part.key {
            CUBES => cubes::section(options),
            _ => newcomers::section(options),
        };
        let section = section.with_context(|| format!("scene {}", part.key))?;
        page = Some(growing.add(section, &options.out)?);
    }
    page.with_context(|| format!("nothing was run: {}", growing.report.notes.join("; ")))
}

fn absent(options: &Options, organ: &Organ) -> String {
    let file = organ.mesh.unwrap_or_default();
    let note = match options.quick {
        true => format!("{} was not run: a quick check leaves published meshes out", organ.scene),
        false => {
            let file = options.meshes.join(file);
            format!("{} was not run: there is no {} (--meshes)", organ.scene, file.display())
        }
    };
    eprintln!("{note}");
    note
}

//! Bodies at rest of loaded images.

use super::{CaseArguments, ThetaArguments, refuse, warn_of_locking};
use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use sinew::output::displacement_in_words;
use sinew::{Body, Case, theta_in_words};
use sinew_energy::Fibres;
use sinew_fem::{Unload, UnloadOptions, Unloaded};
use sinew_mesh::{AnyMesh, Field};
use sinew_report::format::trimmed;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Fields of the directions in the file at rest, and their keys in a case file.
const DIRECTIONS: [(&str, &str); 2] = [("fibre", "field"), ("sheet", "sheets")];
/// Unbalanced forces \[relative to loads and reactions\] of the image that the case file at rest may leave.
const SAME: f64 = 1e-6;

/// Image and its load.
#[derive(Debug, Args)]
#[command(after_help = "\
CASE has the mesh of the loaded state, such as an image at end-diastolic pressure. Writes the reference configuration whose
loading gives that mesh: FILE with its sets, directions, the displacement to the image (u_to_image) and the ratio of
volumes in the reference configuration and in the image (det_f), and its case file (FILE with .toml).

Example: sinew unload LeftVentricle --mesh wall.vtu --theta a=0.18,b=2.6,a_f=3.3,b_f=2.7,p=8mmHg -o rest.vtu")]
pub(crate) struct UnloadCommand {
    #[command(flatten)]
    case: CaseArguments,
    #[command(flatten)]
    theta: ThetaArguments,
    /// Output: mesh of the reference configuration
    #[arg(short, long, value_name = "FILE", default_value = "rest.vtu")]
    output: PathBuf,
    /// Whether fibre directions of the image are pulled back to the reference configuration, or kept
    #[arg(long, value_name = "HOW", default_value = "carried")]
    fibres: Convention,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Convention {
    Carried,
    Kept,
}

impl UnloadCommand {
    pub(crate) fn run(&self) -> Result<()> {
        if self.output.extension().is_none_or(|extension| extension != "vtu") {
            return refuse(format!("-o {}: the name must end with .vtu", self.output.display()));
        }
        let (case, image, _) = self.case.open()?;
        let thetas = self.theta.read(&image)?.thetas();
        let [theta] = &thetas[..] else {
            return refuse(format!("--theta: give one set of parameters, not {}", thetas.len()));
        };
        let fibres = match self.fibres {
            Convention::Carried => Fibres::Carried,
            Convention::Kept => Fibres::Kept,
        };
        let mut unload = Unload::new(&image)?.fibres(fibres);
        let unloaded = unload.solve(theta, &UnloadOptions::default())?;
        warn_of_locking(unloaded.locking);
        println!("{}{}", theta_in_words(&image, theta), said(&image, &unloaded));
        picture(&image, &unloaded).write_vtu(&self.output)?;
        let file = self.output.with_extension("toml");
        let text = at_rest(&case, &unloaded, &self.output)?;
        std::fs::write(&file, text).with_context(|| file.display().to_string())?;
        println!("written: {} and {}", self.output.display(), file.display());
        if let Some(left) = left(&file, &unloaded) {
            eprintln!("warning: loaded from {}, {left}", file.display());
        }
        Ok(())
    }
}

/// How far nodes are from the image, how volumes change, and how it was found.
fn said(image: &Body, unloaded: &Unloaded) -> String {
    let unit = &image.units.length;
    let rest = vec![0.0; unloaded.motion.len()];
    let (before, after) = (image.cavity_volumes(&rest), unloaded.rest.body.cavity_volumes(&rest));
    let volumes = image.cavities.iter().zip(before.iter().zip(&after));
    let volumes: String = volumes
        .map(|(cavity, (loaded, rest))| {
            let [loaded, rest] = [loaded, rest].map(|volume| trimmed(*volume, 6));
            format!(
                ", volume of {} {rest} {unit}3 at rest, {loaded} {unit}3 in the image",
                cavity.name
            )
        })
        .collect();
    let [least, largest] = &unloaded.volume_ratios;
    let off = unloaded.loading.map_or(f64::NAN, |loading| loading.distance);
    format!(
        ": displacement to the image {}{volumes}; det f from {least} to {largest}; {} iterations; loaded from rest off by {off:.1e} {unit}",
        displacement_in_words(&unloaded.motion, unit),
        unloaded.iterations
    )
}

/// The mesh at rest with its fields.
fn picture(image: &Body, unloaded: &Unloaded) -> AnyMesh {
    let rest = &unloaded.rest.body;
    let mut mesh = (*rest.mesh).clone();
    let to_image = Field::vectors(unloaded.displacement().as_chunks::<3>().0);
    mesh.point_fields_mut().insert("u_to_image".into(), to_image);
    let sums = |volumes: &[f64]| -> Vec<f64> {
        volumes.chunks(rest.points_per_cell).map(|of_cell| of_cell.iter().sum()).collect()
    };
    let ratios = sums(&rest.volumes).iter().zip(sums(&image.volumes)).map(|(r, i)| r / i).collect();
    mesh.cell_fields_mut().insert("det_f".into(), Field::scalars(ratios));
    let count = rest.material.directions(0).len();
    for (direction, (name, _)) in DIRECTIONS.into_iter().enumerate().take(count) {
        let rows: Vec<_> = (0..rest.cell_count()).map(|cell| mean(rest, cell, direction)).collect();
        mesh.point_fields_mut().remove(name);
        mesh.cell_fields_mut().insert(name.into(), Field::vectors(&rows));
    }
    mesh
}

/// The mean direction of a cell; that of its point where it has one.
fn mean(rest: &Body, cell: usize, direction: usize) -> [f64; 3] {
    let points = rest.points_per_cell;
    let at = |point: usize| rest.material.directions(point)[direction];
    if points == 1 {
        return at(cell);
    }
    let sum = (cell * points..(cell + 1) * points)
        .fold([0.0; 3], |sum: [f64; 3], point| std::array::from_fn(|i| sum[i] + at(point)[i]));
    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    sum.map(|x| x / length)
}

/// The case file of the body at rest: that of the image with another mesh, its sets in it, and the directions as fields.
fn at_rest(case: &Case, unloaded: &Unloaded, mesh: &Path) -> Result<String> {
    let mut root: Table = case.text().parse().context("the case file cannot be read again")?;
    let file = mesh.file_name().unwrap_or_default().to_string_lossy().into_owned();
    root.insert("name".into(), Value::String(format!("{} at rest", case.name)));
    root.insert(
        "mesh".into(),
        Value::Table(Table::from_iter([("file".into(), Value::String(file))])),
    );
    let rest = &unloaded.rest.body;
    let formulation = if rest.patches.is_empty() { "plain" } else { "averaged" };
    root.insert("formulation".into(), Value::String(formulation.into()));
    root.remove("select");
    let count = rest.material.directions(0).len();
    if count > 0 {
        let named = DIRECTIONS.into_iter().take(count);
        let fields = named.map(|(name, key)| (key.into(), Value::String(name.into())));
        root.insert("fibres".into(), Value::Table(fields.collect()));
    }
    Ok(toml::to_string(&root)?)
}

/// Differences of the case file at rest from the body, if something is left.
fn left(file: &Path, unloaded: &Unloaded) -> Option<String> {
    let body = match Case::read(file).and_then(|case| case.body()) {
        Ok(body) => body,
        Err(error) => return Some(format!("there is no body: {error}")),
    };
    let displacement = unloaded.displacement();
    let mut forces = vec![0.0; displacement.len()];
    if body.nodes != unloaded.rest.body.nodes {
        return Some("the body has other nodes".into());
    }
    body.value_and_gradient(&displacement, &unloaded.theta, &mut forces);
    let free = body.free_degrees_of_freedom();
    let squares = free.iter().map(|&dof| body.frames.component(dof, &forces).powi(2));
    let unbalanced = squares.sum::<f64>().sqrt() / unloaded.force_scale.max(f64::MIN_POSITIVE);
    // Written so that a NaN is told as well.
    let same = unbalanced <= SAME;
    (!same).then(|| {
        format!(
            "the image is not quite an equilibrium (unbalanced forces {unbalanced:.1e} of loads and reactions): directions that differ within a \
             cell, loads or supports given by places or a turn are not the same in a case file at rest"
        )
    })
}

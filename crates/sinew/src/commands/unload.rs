//! Bodies at rest of loaded images.

use super::{
    CaseFile, ThetaArguments, check_vtu, keep_foreign, marked, single, tell_states, write,
};
use anyhow::{Result, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use sinew::output::displacement_in_words;
use sinew::stresses::add_stresses;
use sinew::{Body, Case, mesh_at_rest, theta_in_words};
use sinew_energy::Fibres;
use sinew_fem::{Unload, UnloadOptions, Unloaded, mixed_stresses};
use sinew_mesh::AnyMesh;
use sinew_report::format::trimmed;
use std::path::{Path, PathBuf};

/// Beginning of the case files at rest that the command writes.
const MARK: &str = "# unloaded from ";
/// Field of the fibres.
const FIBRE: &str = "fibre";
/// Unbalanced forces \[relative to loads and reactions\] of the image that the case file at rest may leave, and components of directions.
const SAME: f64 = 1e-6;

/// Image and its load.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/unload.txt"))]
pub(crate) struct UnloadCommand {
    #[command(flatten)]
    case: CaseFile,
    #[command(flatten)]
    theta: ThetaArguments,
    /// Output: mesh of the reference configuration
    #[arg(short, long, visible_alias = "out", value_name = "FILE", default_value = "rest.vtu")]
    output: PathBuf,
    /// Whether fibre directions of the image are pulled back to the reference configuration, or kept
    #[arg(long, value_name = "HOW", default_value = "carried", value_parser = PossibleValuesParser::new(["carried", "kept"]).map(|name| if name == "kept" { Fibres::Kept } else { Fibres::Carried }))]
    fibres: Fibres,
    /// Write stress, strain and volumes of the image too, at cells and averaged to nodes, and its fibres as fibre_in_image
    #[arg(long)]
    fields: bool,
}

impl UnloadCommand {
    pub(crate) fn run(&self) -> Result<()> {
        check_vtu(&self.output)?;
        let (case, image) = self.case.open()?;
        let file = self.output.with_extension("toml");
        [&self.output, &file].into_iter().try_for_each(|to| self.case.keep_sources(to))?;
        keep_foreign("unload", MARK, &file)?;
        let thetas = self.theta.read(&image, None, None)?.thetas();
        let theta = single("--theta", &thetas)?;
        let mut unload = Unload::new(&image)?.fibres(self.fibres);
        let unloaded = unload.solve(theta, &UnloadOptions::default())?;
        let displacement = unloaded.displacement();
        tell_states(&unloaded.rest, &thetas, std::iter::once(&displacement[..]));
        println!("{}{}", theta_in_words(&image, theta), said(&image, &unloaded));
        picture(&image, &unloaded, self.fields)?.write_vtu(&self.output)?;
        let text = case.text_at_rest(&unloaded, Some(&self.output))?;
        let text = marked(MARK, &self.case.words(), &text);
        write(&file, text)?;
        println!("written: {} and {}", self.output.display(), file.display());
        if let Some(left) = left(&file, &unloaded) {
            bail!("loaded from {}, {left}", file.display());
        }
        Ok(())
    }
}

/// Distance of nodes from the image, changes of volumes, and course of the search, in words.
fn said(image: &Body, unloaded: &Unloaded) -> String {
    let unit = &image.units.length;
    let rest = vec![0.0; unloaded.motion.len()];
    let (before, after) = (image.cavity_volumes(&rest), unloaded.rest.cavity_volumes(&rest));
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

/// The mesh at rest with its fields, and with stresses of the image if they are wanted.
fn picture(image: &Body, unloaded: &Unloaded, stresses: bool) -> Result<AnyMesh> {
    let mut mesh = mesh_at_rest(image, unloaded);
    if stresses {
        // The case file at rest reads the directions at rest under this name.
        let at_rest = mesh.cell_fields_mut().remove(FIBRE);
        let rest = &unloaded.rest;
        let cells = mixed_stresses(rest, &unloaded.displacement(), &[], &unloaded.theta)?;
        add_stresses(&mut mesh, rest, &cells);
        let fields = mesh.cell_fields_mut();
        if let Some(at_rest) = at_rest
            && let Some(in_image) = fields.insert(FIBRE.into(), at_rest)
        {
            fields.insert("fibre_in_image".into(), in_image);
        }
    }
    Ok(mesh)
}

/// Differences of the case file at rest from the body, if something is left.
fn left(file: &Path, unloaded: &Unloaded) -> Option<String> {
    let body = match Case::read(file).and_then(|case| case.body()) {
        Ok(body) => body,
        Err(error) => return Some(format!("there is no body: {error}")),
    };
    let displacement = unloaded.displacement();
    let mut forces = vec![0.0; displacement.len()];
    if body.nodes != unloaded.rest.nodes {
        return Some("the body has other nodes".into());
    }
    // Without a load they leave no forces.
    let turns = |&point: &usize| {
        let [a, b] =
            [&body, &unloaded.rest].map(|body| body.material.directions(point).as_flattened());
        a.iter().zip(b).any(|(a, b)| (a - b).abs() > SAME)
    };
    if let Some(point) = (0..body.volumes.len()).find(turns) {
        let cell = point / body.points_per_cell;
        return Some(format!("directions that differ within a cell, such as {cell}, are its mean"));
    }
    let places = body.prescribed.iter().enumerate();
    let apart = places.filter_map(|(dof, place)| {
        Some((body.frames.component(dof, &displacement) - (*place)?).abs())
    });
    let size = displacement.iter().map(|u| u.abs()).fold(0.0, f64::max);
    let apart = apart.fold(0.0, f64::max);
    if apart > SAME * size {
        let unit = &body.units.length;
        return Some(format!(
            "supports hold nodes up to {apart:.1e} {unit} from the image: a turn is about other places in a case file at rest; hold the nodes \
             where they are, or prescribe x, y and z"
        ));
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
             cell, and loads or supports given by places, are not the same in a case file at rest"
        )
    })
}

//! Run of one scene, to its section of the report.

use crate::organs::options::Options;
use crate::organs::scenes::Organ;
use crate::program;
use anyhow::{Context, Result};
use sinew::case::{RecipeName, Training};
use sinew::{Body, Case, Comparison, Emulator, Recipe, TestSet, TrainingOptions};
use sinew_emulate::{Budget, Terminal, Train, store};
use sinew_report::{Block, Section};
use std::path::{Path, PathBuf};

/// Newton steps that predictions are corrected by.
pub(crate) const CORRECTIONS: usize = 2;
/// File of the options that a scene was run with.
const OPTIONS: &str = "options.json";
/// Cases, simulations and steps of a quick check.
pub(super) const QUICK: [usize; 3] = [4, 12, 4];
/// Cells of a stand-in ventricle and of a cube in a quick check.
const QUICK_CELLS: [usize; 3] = [1, 16, 6];

/// Prepares the folder of a scene: emptied, or checked to hold a run with the same options.
pub(crate) fn begin(options: &Options, key: &str) -> Result<PathBuf> {
    let folder = options.out.join(key);
    let folders = std::slice::from_ref(&folder);
    if program::begin(&folder.join(OPTIONS), folders, options.resume, options)?.is_some() {
        same(options, key)?;
    }
    Ok(folder)
}

/// Requires that a scene was run with the same options.
pub(crate) fn same(options: &Options, key: &str) -> Result<()> {
    let folder = options.out.join(key);
    let stored = store::read_json(&folder.join(OPTIONS))?;
    let stored = stored.with_context(|| format!("there is no run in {}", folder.display()))?;
    program::same_options(&stored, options, &folder)
}

/// The case of a scene and whether it is the scene itself; `None` where its mesh is absent and nothing stands in.
pub(crate) fn case(options: &Options, organ: &Organ) -> Result<Option<(Case, bool)>> {
    let read = |name: &str| Case::read(Path::new(name));
    let (mut case, own) = match organ.mesh.map(|file| options.meshes.join(file)) {
        None => (read(organ.scene)?, true),
        Some(file) if file.exists() && !options.quick => (read(organ.scene)?.with_mesh(file), true),
        Some(_) => match organ.stand_in {
            Some(name) => (read(name)?, false),
            None => return Ok(None),
        },
    };
    if options.quick {
        if let Some(cuboid) = &mut case.mesh.cuboid {
            cuboid.cells.0 = cuboid.cells.0.map(|cells| cells.min(4));
        }
        if let Some(ellipsoid) = &mut case.mesh.ellipsoid {
            ellipsoid.cells.0 = QUICK_CELLS;
        }
    }
    Ok(Some((case, own)))
}

pub(crate) fn section(options: &Options, organ: &Organ) -> Result<Option<Section>> {
    let Some((case, own)) = case(options, organ)? else { return Ok(None) };
    eprintln!("\n{}: {}", case.name, case.about);
    let folder = begin(options, organ.key)?;
    let title = match own {
        true => organ.scene.to_string(),
        false => format!("{} (in the place of {})", case.name, organ.scene),
    };
    let comparison = program::kept(&folder.join("comparison.json"), options.resume, || {
        measure(options, organ, &case.body()?, &folder)
    })?;
    println!("{comparison}");
    let mut section = match organ.thesis.filter(|_| own) {
        Some(thesis) => thesis.section(&comparison, organ.key, &title)?,
        None => comparison.section(organ.key, &title)?,
    };
    section.blocks.insert(0, Block::Text(format!("{}. {}", case.about, organ.note)));
    Ok(Some(section))
}

fn measure(options: &Options, organ: &Organ, body: &Body, folder: &Path) -> Result<Comparison> {
    let test = test_set(options, body, organ.test, folder)?;
    let mut comparison = Comparison::new(&test)?;
    for &name in &options.recipe {
        let recipe = recipe(options, organ, name);
        let budget = match name.is_network() {
            true => options.training(organ.minutes, QUICK[2]),
            false => Budget::default(),
        };
        let emulator = train(options, body, &recipe, budget, None, &folder.join(recipe.key()))?;
        comparison.add(recipe.key(), &emulator, &test, CORRECTIONS)?;
    }
    Ok(comparison)
}

/// Trains by a recipe, from the networks in `start` if there are some.
pub(crate) fn train<'b>(
    options: &Options,
    body: &'b Body,
    recipe: &Recipe,
    budget: Budget,
    start: Option<PathBuf>,
    folder: &Path,
) -> Result<Emulator<'b>> {
    let training = program::training(options.quick, options.seed, folder, options.resume);
    let training = TrainingOptions { budget, start, ..training };
    Ok(recipe.train(body, &training, &mut Terminal::default())?)
}

/// Cases with their solutions, few for a quick check.
pub(crate) fn test_set<'b>(
    options: &Options,
    body: &'b Body,
    cases: usize,
    folder: &Path,
) -> Result<TestSet<'b>> {
    let cases = if options.quick { QUICK[0] } else { cases };
    Ok(program::test_set(body, cases, options.seed, folder)?.0)
}

fn recipe(options: &Options, organ: &Organ, recipe: RecipeName) -> Recipe {
    let samples = match (options.quick, recipe) {
        (true, _) => Some(QUICK[1]),
        (false, RecipeName::Regression) => Some(organ.simulations),
        (false, _) => None,
    };
    // A regression takes all simulations.
    Training { recipe: Some(recipe), samples, target: Some(0.0), ..Training::default() }.recipe()
}

//! An emulator of one ventricle meets others (thesis B.5): other shapes, other meshes, other numbers of nodes.

use crate::options::Options;
use crate::organs::{ORGANS, Organ};
use crate::run::{CORRECTIONS, test_set, train};
use anyhow::{Context, Result, ensure};
use sinew::case::EllipsoidMesh;
use sinew::recipe::PhysicsInformed;
use sinew::{Body, Case, Comparison, Recipe};
use sinew_emulate::{Budget, store};
use sinew_report::{Block, Section};
use std::path::Path;

/// Name on the command line.
pub const KEY: &str = "new-ventricle";
/// Training time by default \[min\]: twice as many seconds per shape as the thesis takes for one of both.
pub const MINUTES: f64 = 2.0 * SECONDS * SHAPES.len() as f64 / 60.0;
/// The thesis' time to learn a new ventricle \[s\].
const SECONDS: f64 = 90.0;
/// Cases that errors are measured on.
const CASES: usize = 50;

/// A shape that no training has seen, between two ellipsoids \[mm\].
struct Shape {
    name: &'static str,
    mesh: EllipsoidMesh,
}

/// Slender, everyday and round, of different resolution.
const SHAPES: [Shape; 3] = [
    shape("slender", [19.0, 30.0], [62.0, 76.0], [2, 24, 14]),
    shape("everyday", [22.0, 36.0], [58.0, 74.0], [2, 32, 16]),
    shape("round", [27.0, 38.0], [52.0, 66.0], [3, 32, 16]),
];

const fn shape(name: &'static str, short: [f64; 2], long: [f64; 2], cells: [usize; 3]) -> Shape {
    Shape { name, mesh: EllipsoidMesh { short, long, base: 0.0, cells } }
}

/// Trains the emulator of the ventricle unless it is there, and takes it to every shape.
///
/// # Errors
/// Whatever keeps a shape from being solved or learned.
pub fn section(options: &Options) -> Result<Section> {
    let organ = ORGANS.iter().find(|organ| organ.key == "ventricle").context("no ventricle")?;
    let start = options.out.join(organ.key).join("pi");
    ensure!(
        start.join("emulator").exists(),
        "there is no emulator of the ventricle to start from; run the scene `ventricle` first (--only ventricle,{KEY})"
    );
    let mut blocks = vec![Block::Text(
        "The emulator that was trained by energy on the ventricle above meets ventricles of other shapes, meshes and numbers of \
         nodes: as it is, after 90 s of training by energy there, and beside an emulator that starts from nothing with the \
         same 90 s."
            .into(),
    )];
    for shape in &SHAPES {
        let comparison = meet(options, organ, shape, &start)?;
        println!("{comparison}");
        let own = comparison.section(shape.name, shape.name, &Default::default())?;
        blocks.push(Block::Text(format!("{}, {} nodes.", shape.name, comparison.nodes)));
        let tables = own
            .blocks
            .into_iter()
            .filter(|block| matches!(block, Block::Table(_) | Block::Surfaces(_)));
        blocks.extend(tables);
    }
    Ok(Section { name: KEY.into(), title: "New ventricles".into(), blocks })
}

fn meet(options: &Options, organ: &Organ, shape: &Shape, start: &Path) -> Result<Comparison> {
    let folder = options.out.join(KEY).join(shape.name);
    let file = folder.join("comparison.json");
    if let Some(done) = store::read_json(&file)?.filter(|_| options.resume) {
        return Ok(done);
    }
    eprintln!("\nnew ventricle, {}", shape.name);
    let body = body(options, organ, shape)?;
    let test = test_set(options, &body, CASES, &folder)?;
    let mut comparison = Comparison::new(&test)?;
    let recipe = Recipe::from(PhysicsInformed::default());
    let budget = match options.quick {
        true => Budget::Steps(20),
        false => Budget::Seconds(options.seconds(SECONDS / 60.0)),
    };
    let start = Some(start.to_path_buf());
    for (name, budget, start) in [
        ("as it is", Budget::Steps(0), start.clone()),
        ("trained on", budget, start),
        ("from nothing", budget, None),
    ] {
        let folder = folder.join(name.replace(' ', "-"));
        let emulator = train(options, &body, &recipe, budget, start, &folder)?;
        comparison.add(name, &emulator, &test, CORRECTIONS)?;
    }
    store::write_json(&file, &comparison)?;
    Ok(comparison)
}

/// The body of a shape: law, load and parameters of the ventricle that the network was trained on, fibres by rule.
fn body(options: &Options, organ: &Organ, shape: &Shape) -> Result<Body> {
    let mut case = Case::read(Path::new("IdealVentricle"))?;
    let (trained, _) = crate::run::case(options, organ)?.context("the ventricle is absent")?;
    (case.law, case.parameters) = (trained.law, trained.parameters);
    let mut mesh = shape.mesh;
    if options.quick {
        mesh.cells = [1, 8 * (mesh.cells[1] / 16), 6];
    }
    (case.name, case.mesh.ellipsoid) = (format!("ventricle-{}", shape.name), Some(mesh));
    Ok(case.body()?)
}

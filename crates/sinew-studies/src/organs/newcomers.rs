//! An emulator of one ventricle meets others (thesis B.5): other shapes, other meshes, other numbers of nodes.

use crate::hearts;
use crate::organs::options::Options;
use crate::organs::run::{CORRECTIONS, QUICK, begin, case, same, test_set, train};
use crate::organs::scenes::{NEWCOMER_S, NEWCOMERS as KEY, ORGANS, SHAPES, Shape, Source};
use crate::program;
use anyhow::{Context, Result, ensure};
use nalgebra::{Rotation3, Vector3};
use sinew::recipe::PhysicsInformed;
use sinew::{Body, Case, Comparison, Recipe};
use sinew_emulate::Budget;
use sinew_mesh::{AnyMesh, Field};
use sinew_report::{Block, Section};
use std::path::Path;

const CASES: usize = 50;

/// Trains the emulator of the ventricle unless it is there, and takes it to every shape.
pub(crate) fn section(options: &Options) -> Result<Section> {
    let organ = ORGANS.iter().find(|organ| organ.key == "ventricle").context("no ventricle")?;
    let start = options.out.join(organ.key).join("pi");
    ensure!(
        start.join("emulator").exists(),
        "there is no emulator of the ventricle to start from; run the scene `ventricle` with the recipe pi first"
    );
    same(options, organ.key)?;
    begin(options, KEY)?;
    let budget = budget(options);
    let spent = match budget {
        Budget::Seconds(seconds) => format!("{seconds:.0} s"),
        _ => "a few steps".into(),
    };
    let (trained, _) = case(options, organ)?.context("the ventricle is absent")?;
    let mut blocks = vec![Block::Text(format!(
        "The emulator that was trained by energy on {} meets ventricles of other shapes, meshes and numbers of nodes: as it \
         is, but for one solve that tells where to begin, after {spent} of training by energy there, and beside an emulator \
         trained from scratch for the same time (thesis B.5: 90 s).",
        trained.name
    ))];
    for shape in &SHAPES {
        if let Some(reason) = absent(options, shape) {
            blocks.push(Block::Text(reason));
            continue;
        }
        let folder = options.out.join(KEY).join(shape.name);
        let comparison = program::kept(&folder.join("comparison.json"), options.resume, || {
            meet(options, &trained, shape, &start, &folder)
        })?;
        println!("{comparison}");
        let own = comparison.section(shape.name, shape.name)?;
        blocks.push(Block::Text(format!("{}, {} nodes.", shape.name, comparison.nodes)));
        for mut block in own.blocks {
            if let Block::Table(table) = &mut block {
                table.rows.iter_mut().for_each(|row| row.subject = shape.name.into());
            }
            blocks.extend(matches!(block, Block::Table(_) | Block::Surfaces(_)).then_some(block));
        }
    }
    Ok(Section { name: KEY.into(), title: "New ventricles".into(), blocks })
}

fn budget(options: &Options) -> Budget {
    options.training(NEWCOMER_S / 60.0, QUICK[2])
}

fn meet(
    options: &Options,
    trained: &Case,
    shape: &Shape,
    start: &Path,
    folder: &Path,
) -> Result<Comparison> {
    eprintln!("\nnew ventricle, {}", shape.name);
    let body = body(options, trained, shape, folder)?;
    let test = test_set(options, &body, CASES, folder)?;
    let mut comparison = Comparison::new(&test)?;
    let recipe = Recipe::from(PhysicsInformed::default());
    let budget = budget(options);
    let start = Some(start.to_path_buf());
    for (name, budget, start) in [
        ("pre-trained", Budget::Steps(0), start.clone()),
        ("fine-tuned", budget, start),
        ("from scratch", budget, None),
    ] {
        let folder = folder.join(name.replace(' ', "-"));
        let emulator = train(options, &body, &recipe, budget, start, &folder)?;
        comparison.add(name, &emulator, &test, CORRECTIONS)?;
    }
    Ok(comparison)
}

/// Why a shape cannot be met, if so.
fn absent(options: &Options, shape: &Shape) -> Option<String> {
    let Source::Heart(frame, _) = shape.mesh else { return None };
    if options.quick {
        return Some(format!("{} is left out of a quick check.", shape.name));
    }
    (!hearts::has(&options.hearts, frame)).then(|| {
        let folder = options.hearts.display();
        format!("{} was not met: there are no surfaces of it in {folder} (--hearts).", shape.name)
    })
}

/// The body of a shape: law, load and parameters of the ventricle that the network was trained on, fibres by rule.
fn body(options: &Options, trained: &Case, shape: &Shape, folder: &Path) -> Result<Body> {
    let mut case = match shape.mesh {
        Source::Ellipsoids(mut mesh) => {
            let mut case = Case::read(Path::new("IdealVentricle"))?;
            if options.quick {
                mesh.cells.0 = [1, 8 * (mesh.cells.0[1] / 16), 6];
            }
            case.mesh.ellipsoid = Some(mesh);
            case
        }
        Source::Heart(frame, nodes) => {
            let file = folder.join("wall.vtu");
            std::fs::create_dir_all(folder)?;
            heart(&options.hearts, frame, nodes)?.write_vtu(&file)?;
            Case::read(Path::new("LeftVentricle"))?.with_mesh(file)
        }
    };
    (case.law, case.parameters) = (trained.law.clone(), trained.parameters.clone());
    case.name = format!("ventricle-{}", shape.name);
    Ok(case.body()?)
}

/// The left ventricle of a frame of a beat, its axis upright with the base at z = 0, as the network knows ventricles.
pub(crate) fn heart(folder: &Path, frame: &str, nodes: usize) -> Result<AnyMesh> {
    let wall = hearts::wall(folder, frame, nodes)?;
    let [point, normal] = wall.report().base.map(Vector3::from);
    let mut mesh = sinew::ventricle(&wall, false, [60.0, -60.0]).map_err(anyhow::Error::msg)?;
    let turn = Rotation3::rotation_between(&normal, &Vector3::z())
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    mesh.map_points(|x| (turn * (Vector3::from(x) - point)).into());
    if let Some(fibres) = mesh.cell_fields().get("fibre").map(Field::to_f64) {
        let turned = |f: &[f64; 3]| (turn * Vector3::from(*f)).into();
        let turned: Vec<[f64; 3]> = fibres.as_chunks::<3>().0.iter().map(turned).collect();
        mesh.cell_fields_mut().insert("fibre".into(), Field::vectors(&turned));
    }
    Ok(mesh)
}

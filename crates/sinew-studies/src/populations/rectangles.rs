//! Plane beams of the thesis' chapter 2: one network on simulations of rectangles, with and without virtual nodes (Tables A.1 to A.7).

use super::options::Options;
use super::rows::{Measured, table};
use super::simulated::{Compared, Simulated, Targets};
use super::stage;
use super::variant::{Inputs, Pace, Variant};
use super::verdict;
use crate::program::cpu_seconds;
use anyhow::{Context, Result};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use sinew::Parameter;
use sinew_emulate::coordinates::{Coordinates, Dirichlet};
use sinew_fem::{Options as SolverOptions, Solver};
use sinew_gnn::{Geometry, Surrogate};
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};
use sinew_mesh::{AnyMesh, rectangle_triangles};
use sinew_report::{Block, Chart, Distribution, Section};

/// Lengths \[cm\], widths as parts of them, moduli [unit of stress] of the population.
const LENGTHS: [f64; 2] = [4.0, 7.0];
const SLENDERNESS: [f64; 2] = [0.2, 0.4];
const MODULI: [f64; 2] = [4.0, 10.0];
/// Cells along and across.
const CELLS: [usize; 2] = [11, 7];
/// Millimetres in the unit of length.
const MM: f64 = 10.0;

/// A rectangle with its parameters and its displacement.
struct Beam {
    /// Length and width \[cm\].
    size: [f64; 2],
    /// μ and λ.
    theta: Vec<f64>,
    body: sinew::Body,
    /// Displacement in the plane, node by node \[cm\].
    displacement: Vec<f64>,
}

/// Everything measured.
#[derive(Serialize, Deserialize)]
struct Study {
    facts: Vec<(String, String)>,
    trained: Vec<Measured>,
    embedding: Chart,
}

/// The section of the report.
pub(super) fn section(options: &Options) -> Result<Section> {
    let mut studies = options.study(stage::RECTANGLES, study)?;
    let who_wins = verdict::of_measured(studies.iter().map(|study| study.trained.iter()))?;
    let study = studies.swap_remove(0);
    let about = "Rectangles of random length and width under a body force, clamped at one end, in plane strain and small displacements: \
                 networks on simulations, from none to all of their message-passing steps, with and without virtual nodes, and regression over \
                 length, width and moduli.";
    let mut blocks = vec![
        Block::Text(about.into()),
        Block::Facts(study.facts),
        Block::Table(table(&study.trained)?),
    ];
    blocks.extend(who_wins);
    blocks.push(Block::charts(
        "What nodes are to the network",
        "Embeddings of a beam's nodes, by their place along it.",
        [study.embedding],
    ));
    Ok(Section {
        name: stage::RECTANGLES.into(),
        title: "Plane beams of many sizes".into(),
        blocks,
    })
}

fn study(options: &Options) -> Result<Study> {
    eprintln!("\nPlane beams of random length and width");
    let [training, validation, testing] = if options.quick { [6, 2, 3] } else { [225, 25, 50] };
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let drawn = training + validation + testing;
    let clock = cpu_seconds();
    let beams = (0..drawn).map(|_| Beam::draw(&mut random)).collect::<Result<Vec<_>>>()?;
    let simulation_s = (cpu_seconds() - clock) / drawn as f64;
    let (seen, unseen) = beams.split_at(training + validation);
    let sizes = unseen.iter().flat_map(|beam| Beam::lengths(&beam.displacement)).collect();
    let sizes = Distribution::of(sizes).context("no node was tested")?;
    let fact = |name: &str, what: String| (name.to_string(), what);
    let mut facts = vec![
        fact(
            "beams",
            format!(
                "{training} to train, {validation} to choose weights, {testing} to test; 96 nodes"
            ),
        ),
        fact(
            "displacements tested",
            format!("mean {:.2} mm, largest {:.1} mm", sizes.mean, sizes.q100),
        ),
    ];
    let (training, validation) = seen.split_at(training);
    let targets = Targets::absolute();
    let compared = Compared {
        options,
        training,
        validation,
        unseen,
        targets: &targets,
        pace: PACE,
        simulation_s,
        coarse_s: 0.0,
    };
    let mut trained = Vec::new();
    for count in if options.quick { &[6][..] } else { &[225, 25] } {
        trained.push(compared.regression(*count, TOLD)?);
    }
    let (mut embedding, variants) = (Chart::default(), variants(options));
    for (index, variant) in variants.iter().enumerate() {
        let topology = graph(variant, options.seed)?;
        let about =
            "network on simulations, mean nodal distance, the best weights on the validation beams";
        let names = [&variant.name()[..], about];
        let shown = index == EMBEDDED.min(variants.len() - 1);
        let more = |surrogate: &Surrogate| {
            shown.then(|| compared.embedding((variant, surrogate), &topology, 0)).transpose()
        };
        let (found, shown) =
            compared.kept_network(stage::RECTANGLES, names, *variant, &topology, more)?;
        trained.push(found);
        if let Some((chart, fact)) = shown {
            facts.push(fact);
            embedding = chart;
        }
    }
    Ok(Study { facts, trained, embedding })
}

/// Networks of Tables A.1 to A.7.
fn variants(options: &Options) -> Vec<Variant> {
    const LAYERS: [&[usize]; 5] = [&[4], &[8], &[48, 12], &[48, 12, 4], &[48, 24, 6]];
    let of = |steps, latent, virtual_nodes| Variant {
        template: options.template,
        ..Variant::new(steps, latent, virtual_nodes, TOLD)
    };
    if options.quick {
        return vec![of(1, 8, &[]), of(1, 8, TWO)];
    }
    let alone = (1..=if options.template { 0 } else { 6 }).map(|k| of(k, 40, &[]));
    let steps = (1..=6).map(|k| of(k, 40, TWO));
    let layers = LAYERS.into_iter().map(|nodes| of(2, 40, nodes));
    let widths = [3, 6, 10, 20, 60].into_iter().map(|m| of(2, m, TWO));
    alone.chain(steps).chain(layers).chain(widths).collect()
}

/// Virtual nodes of most networks.
const TWO: &[usize] = &[24, 6];

impl Beam {
    fn draw(random: &mut ChaCha8Rng) -> Result<Self> {
        let mut between = |[low, high]: [f64; 2]| low + (high - low) * random.random::<f64>();
        let (length, part) = (between(LENGTHS), between(SLENDERNESS));
        let (size, theta) = ([length, part * length], vec![between(MODULI), between(MODULI)]);
        let mesh = rectangle_triangles(size, CELLS);
        let modulus = |name: &str| Parameter::linear(name, "", MODULI[0]..=MODULI[1]);
        let body = sinew::Scene::new(mesh, sinew::laws::LinearElastic)
            .parameter(modulus("mu"))
            .parameter(modulus("lambda"))
            .load(sinew::Load::BodyForce([0.0, -0.4 * part * part, 0.0]))
            .support(sinew::Support::clamped("x_min"))
            .lower()?;
        let solved = Solver::new(&body)?.solve(&theta, &SolverOptions::default())?;
        let (nodes, _) = solved.displacement.as_chunks::<3>();
        let displacement = nodes.iter().flat_map(|[x, y, _]| [*x, *y]).collect();
        Ok(Self { size, theta, body, displacement })
    }
}

/// Length and width, which every method is told.
const TOLD: Inputs = Inputs { numbers: 2, coarse: false };

impl Simulated for Beam {
    fn body(&self) -> &sinew::Body {
        &self.body
    }

    fn theta(&self) -> &[f64] {
        &self.theta
    }

    fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// The graph of the average beam at its own positions.
    fn geometry(&self, topology: &Topology, _told: Inputs) -> Result<Geometry> {
        let nodes = self.body.nodes;
        let held: Vec<usize> = (0..nodes).filter(|&n| self.body.positions[n][0] == 0.0).collect();
        let indicator = FeatureMatrix::indicator(nodes, &held)?;
        Ok(Geometry {
            features: graph_features(topology, &self.body.positions, &indicator, 2)?,
            global: self.size.to_vec(),
            dirichlet: Dirichlet::clamped(nodes, 2, &held)?,
            coordinates: Coordinates::Components,
            topology: topology.clone(),
        })
    }

    fn inputs(&self, _told: Inputs) -> Vec<f64> {
        let [length, width] = self.size;
        vec![length, width / length, self.theta[0], self.theta[1]]
    }

    fn parameters(&self, _told: Inputs) -> Vec<Parameter> {
        let log =
            |name: &str, unit: &str, [low, high]: [f64; 2]| Parameter::log(name, unit, low..=high);
        let shape = [log("length", "cm", LENGTHS), log("slenderness", "", SLENDERNESS)];
        shape.into_iter().chain(["mu", "lambda"].map(|name| log(name, "", MODULI))).collect()
    }

    fn lengths(displacement: &[f64]) -> Vec<f64> {
        displacement.as_chunks::<2>().0.iter().map(|[x, y]| MM * x.hypot(*y)).collect()
    }
}

/// The graph of the beam of average length and width, or of a template whose cells are 1 cm long and high.
fn graph(variant: &Variant, seed: u64) -> Result<Topology> {
    const NEIGHBOURS: usize = 4;
    let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
    let size = match variant.template {
        true => CELLS.map(|cells| cells as f64),
        false => [middle(LENGTHS), middle(LENGTHS) * middle(SLENDERNESS)],
    };
    let mesh = AnyMesh::from(rectangle_triangles(size, CELLS));
    let config = AugmentationConfig {
        roots_per_layer: variant.virtual_nodes.to_vec(),
        neighbours: NEIGHBOURS,
        seed,
        ..AugmentationConfig::for_nodes(mesh.points().len())
    };
    Ok(augment(mesh.points(), &mesh.edges(), &config)?)
}

/// Training of a network, one beam a step.
const PACE: Pace = Pace::of(3000, 4e-3);
/// The variant whose embeddings are shown: K = 2 with virtual nodes.
const EMBEDDED: usize = 7;

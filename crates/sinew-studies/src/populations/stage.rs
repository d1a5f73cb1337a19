//! The populations: how their bodies are drawn.

use crate::hearts;
use crate::organs::newcomers::heart;
use crate::program::standard_normal;
use crate::shapes::{BeamShape, RingShape};
use crate::ventricle_shape::VentricleShape;
use anyhow::{Context, Result};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew::case::{Exactly, FibreRule};
use sinew::{Body, Case, Parameter};
use sinew_emulate::Design;
use sinew_mesh::{AnyMesh, Field};
use std::path::Path;

#[derive(Clone, Debug)]
pub(super) struct Stage {
    /// Description.
    pub about: &'static str,
    /// Law, loads, supports and parameters.
    pub case: Case,
    pub kind: Kind,
    pub cells: [usize; 3],
    /// Cells of a mesh that is solved in milliseconds.
    pub coarse_cells: [usize; 3],
    /// Cells of meshes coarser and finer than those of the population.
    pub other_cells: [[usize; 3]; 2],
    /// Deviation of the shape numbers, in those of the population.
    pub spread: f64,
    /// Infarcts of every body.
    pub scars: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Rings,
    Beams,
    Ventricles,
    /// Ventricles of hexahedra, whose fibres are those of the rule on tetrahedra.
    Inflated,
}

/// A shape of the population with one parameter set.
#[derive(Debug)]
pub(super) struct Individual {
    /// Shape numbers.
    pub numbers: Vec<f64>,
    /// Body of that shape.
    pub body: Body,
    /// Parameters, within their ranges.
    pub theta: Vec<f64>,
    /// Scars that no mesh knows.
    scars: Vec<Scar>,
    /// The body on a coarse mesh, where that is not made from the numbers.
    coarse: Option<Body>,
}

impl Individual {
    /// No displacement.
    pub(super) fn rest(&self) -> Vec<f64> {
        vec![0.0; 3 * self.body.nodes]
    }
}

/// Names of the two parts that are no stage, on the command line and of their folders.
pub(super) const RECTANGLES: &str = "rectangles";
pub(super) const INFLATED: &str = "inflated";
pub(super) const SPEED: &str = "speed";
pub(super) const KEYS: [&str; 4] = ["rings", "beams", "ventricles", "infarcts"];

impl Stage {
    fn of(
        about: &'static str,
        (kind, case): (Kind, Case),
        [cells, coarse_cells]: [[usize; 3]; 2],
        other_cells: [[usize; 3]; 2],
    ) -> Self {
        let (spread, scars) = (1.0, 0);
        Self { about, case, kind, cells, coarse_cells, other_cells, spread, scars }
    }

    /// The stage of a name, on small meshes for a quick check.
    pub(super) fn new(key: &str, quick: bool) -> Result<Self> {
        let read = |scene: &str| Case::read(Path::new(scene)).context("a built-in scene");
        let sized = |small: [usize; 3], large: [usize; 3]| if quick { small } else { large };
        Ok(match key {
            "rings" => Self::of(
                "Plane rings of 30 shape numbers under a pressure inside and springs outside, the four parameters of Holzapfel and Ogden each over two decades",
                (Kind::Rings, Case::parse(include_str!("ring.toml"), "ring.toml")?),
                [sized([12, 2, 0], [32, 4, 0]), [16, 2, 0]],
                [[24, 3, 0], [44, 6, 0]],
            ),
            "beams" => Self::of(
                "Beams of random length, thickness, taper, waves, bend and twist under their own weight",
                (Kind::Beams, read("OnceClampedBeam")?),
                [sized([6, 2, 2], [10, 3, 3]), [5, 2, 2]],
                [[8, 2, 3], [13, 4, 4]],
            ),
            "ventricles" => Self::of(
                "Left ventricles of 32 smooth modes with the spread of 1093 hearts, fibres by rule, under the pressure of their cavity",
                (Kind::Ventricles, read("IdealVentricle")?),
                [sized([1, 16, 6], [2, 32, 16]), [2, 16, 6]],
                [[2, 24, 12], [2, 40, 20]],
            ),
            "infarcts" => Self {
                about: "The same left ventricles, each with an infarct anywhere: a round scar five to twenty times as stiff, which no mesh knows",
                scars: 1,
                ..Self::new("ventricles", quick)?
            },
            _ => anyhow::bail!("there is no population `{key}`; there are: {}", KEYS.join(", ")),
        })
    }

    /// The ventricles of the thesis' chapter 2, on fine and on coarse cells.
    pub(super) fn inflated(cells: [[usize; 3]; 2]) -> Result<Self> {
        /// Variances are a tenth above those of the hearts, as in the thesis.
        const SPREAD: f64 = 1.048808848170152;
        let about = "Ventricles of random shape, inflated";
        let case = Case::parse(include_str!("inflated/inflated.toml"), "inflated.toml")?;
        let stage = Self::of(about, (Kind::Inflated, case), cells, cells);
        Ok(Self { spread: SPREAD, ..stage })
    }

    /// The frames of a person's beat, each with parameters of its own; none for other populations or where there is no surface in the folder.
    pub(super) fn hearts(&self, folder: &Path) -> Result<Vec<Individual>> {
        const NODES: [usize; 2] = [1500, 400];
        if self.kind != Kind::Ventricles || self.scars > 0 {
            return Ok(Vec::new());
        }
        let individual = |frame| {
            let mut case = Case::read(Path::new("LeftVentricle"))?;
            (case.law, case.parameters) = (self.case.law.clone(), self.case.parameters.clone());
            let [body, coarse] = NODES
                .map(|nodes| -> Result<Body> { Ok(case.body_on(heart(folder, frame, nodes)?)?) });
            let (body, coarse) = (body?, Some(coarse?));
            let (numbers, scars) = (Vec::new(), Vec::new());
            Ok(Individual { numbers, theta: body.centre(), body, scars, coarse })
        };
        let mut hearts = hearts::frames(folder).map(individual).collect::<Result<Vec<_>>>()?;
        if let Some(first) = hearts.first() {
            let thetas = Design::Sobol.sample(&first.body.parameters, hearts.len(), 1)?;
            hearts.iter_mut().zip(thetas).for_each(|(heart, theta)| heart.theta = theta);
        }
        Ok(hearts)
    }

    fn mesh(&self, numbers: &[f64]) -> Result<AnyMesh> {
        Ok(match self.kind {
            Kind::Rings => {
                let [around, across, _] = self.cells;
                RingShape::new(numbers)?.triangles([around, across])?.into()
            }
            Kind::Beams => BeamShape::new(numbers)?.tetrahedra(self.cells)?.into(),
            Kind::Ventricles => VentricleShape::new(numbers)?.tetrahedra(self.cells)?.into(),
            Kind::Inflated => VentricleShape::new(numbers)?.hexahedra(self.cells)?.into(),
        })
    }

    fn on_coarse_cells(&self) -> Self {
        Self { cells: self.coarse_cells, ..self.clone() }
    }

    /// The bodies of a shape on the fine and on the coarse cells; numbers left out are zero.
    pub(super) fn bodies(&self, numbers: &[f64]) -> Result<[Body; 2]> {
        let body = |stage: &Self| -> Result<Body> {
            let mut mesh = stage.mesh(numbers)?;
            if stage.kind == Kind::Inflated {
                let [endocardium, epicardium, base] = ["endo", "epi", "base"].map(String::from);
                let angles = Exactly([60.0, -60.0]);
                let rule = FibreRule { endocardium, epicardium, base, angles, sheet_angles: None };
                let tetrahedra = VentricleShape::new(numbers)?.tetrahedra(stage.cells)?.into();
                let frames = rule.at_nodes(&tetrahedra).map_err(anyhow::Error::msg)?;
                let fibres: Vec<[f64; 3]> = frames.iter().map(|[fibre, ..]| *fibre).collect();
                mesh.point_fields_mut().insert("fibre".into(), Field::vectors(&fibres));
            }
            Ok(stage.case.body_on(mesh)?)
        };
        Ok([body(self)?, body(&self.on_coarse_cells())?])
    }

    /// Numbers of a shape that can be meshed with fine and with coarse cells.
    pub(super) fn shape(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let stages = [self.clone(), self.on_coarse_cells()];
        loop {
            let numbers = self.any_numbers(random);
            if stages.iter().all(|stage| stage.mesh(&numbers).is_ok()) {
                return numbers;
            }
        }
    }

    /// Numbers that may be those of no shape.
    fn any_numbers(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let number = |_| match self.kind {
            Kind::Beams => self.spread * 12f64.sqrt() * (random.random::<f64>() - 0.5),
            _ => self.spread * standard_normal(random),
        };
        (0..self.numbers()).map(number).collect()
    }

    /// The individual of a stream and its number, the same for the same; shapes that the population does not have are drawn again.
    pub(super) fn draw(&self, stream: u64, index: u64) -> Result<Individual> {
        let seed = stream.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        loop {
            let mut numbers = self.any_numbers(&mut random);
            let Ok(mesh) = self.mesh(&numbers) else { continue };
            let mut body = self.case.body_on(mesh)?;
            let scars: Vec<Scar> =
                (0..self.scars).map(|_| Scar::draw(&body, &mut random)).collect();
            body = scarred(body, &scars)?;
            numbers.extend(scars.iter().flat_map(Scar::numbers));
            let theta = Design::Uniform.sample(&body.parameters, 1, random.random())?.remove(0);
            return Ok(Individual { numbers, body, theta, scars, coarse: None });
        }
    }

    /// An individual on a mesh so coarse that it is solved in milliseconds; `None` where that does not unfold.
    pub(super) fn coarse(&self, individual: &Individual) -> Result<Option<Body>> {
        if let Some(coarse) = &individual.coarse {
            return Ok(Some(coarse.clone()));
        }
        let numbers = &individual.numbers[..self.numbers()];
        let Ok(mesh) = self.on_coarse_cells().mesh(numbers) else { return Ok(None) };
        Ok(Some(scarred(self.case.body_on(mesh)?, &individual.scars)?))
    }

    /// The body of the population whose shape numbers are zero, on the mesh of another; `None` if that mesh is not a shape of the population.
    pub(super) fn mean_like(&self, body: &Body) -> Result<Option<Body>> {
        for cells in std::iter::once(self.cells).chain(self.other_cells) {
            let mean = self.case.body_on(Self { cells, ..self.clone() }.mesh(&[])?)?;
            if mean.cells == body.cells {
                return Ok(Some(mean));
            }
        }
        Ok(None)
    }

    fn numbers(&self) -> usize {
        match self.kind {
            Kind::Rings => RingShape::NUMBERS,
            Kind::Beams => BeamShape::NUMBERS,
            _ => VentricleShape::NUMBERS,
        }
    }
}

/// Scar tissue around a node.
#[derive(Debug)]
struct Scar {
    centre: [f64; 3],
    /// \[mm\].
    radius: f64,
    factor: f64,
}

fn scarred(body: Body, scars: &[Scar]) -> Result<Body> {
    Ok(scars.iter().try_fold(body, |body, scar| {
        let factors = scar.factors(&body);
        body.stiffened(&factors)
    })?)
}

impl Scar {
    fn draw(body: &Body, random: &mut ChaCha8Rng) -> Self {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let node = between(0.0, body.nodes as f64) as usize;
        let (radius, factor) = (between(10.0, 20.0), between(5f64.ln(), 20f64.ln()).exp());
        Self { centre: body.positions[node.min(body.nodes - 1)], radius, factor }
    }

    /// Factor of the stiffness at every node.
    fn factors(&self, body: &Body) -> Vec<f64> {
        let at = |x: &[f64; 3]| {
            let squared: f64 = x.iter().zip(self.centre).map(|(a, b)| (a - b).powi(2)).sum();
            let share = (1.0 - squared / self.radius.powi(2)).max(0.0);
            1.0 + (self.factor - 1.0) * share.powi(2)
        };
        body.positions.iter().map(at).collect()
    }

    /// Inputs of a regression, of about size one.
    fn numbers(&self) -> [f64; 5] {
        let [x, y, z] = self.centre.map(|x| x / 30.0);
        [x, y, z, (self.radius - 15.0) / 3.0, (self.factor / 10.0).ln() / 0.4]
    }
}

/// Ranges of so many numbers of a shape, as parameters of a regression: √3 deviations to either side.
pub(super) fn shape_parameters(count: usize) -> impl Iterator<Item = Parameter> {
    let range = 3f64.sqrt();
    (1..=count).map(move |k| Parameter::linear(format!("shape {k}"), "", -range..=range))
}

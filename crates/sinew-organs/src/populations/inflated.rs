//! Ventricles of the thesis' chapter 2: networks on simulations of many shapes, told more or less of the shape (Tables A.8 to A.11).

mod ventricle;

use super::measure::cpu_seconds;
use super::options::Options;
use super::simulated::{self, Measured, Pace, Variant, kept, table, train, untrained};
use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};
use sinew_emulate::{Design, PodRegression, Shard};
use sinew_gnn::{DataSet, ParameterRange, ParameterScale, Sample, Surrogate};
use sinew_graph::Topology;
use sinew_mesh::VentricleShape;
use sinew_report::{Block, Chart, Distribution, Figure, Map, Panel, Section};
use std::path::PathBuf;
use std::time::Instant;
use ventricle::{Seen, Ventricle, Ventricles, lengths};

/// Name on the command line and of its folder.
pub(super) const KEY: &str = "inflated";

/// Steps of a training, one ventricle each, and their largest learning rate; the same when a network goes on to one shape.
const PACE: Pace = Pace { steps: 2000, rate: 4e-3, batch: 1, decoders_only: false };
const TRANSFER: Pace = Pace { steps: 1500, rate: 1e-3, batch: 8, decoders_only: true };
/// Virtual nodes on the small mesh and on the thesis'.
const VIRTUAL_NODES: [&[usize]; 2] = [&[60, 8], &[848, 106, 13]];
/// Ventricles with larger cavities are not tested \[mm³\].
const LARGEST: f64 = 850e3;
/// Simulations of one shape: to go on with, to choose weights, and to test with.
const ONE_SHAPE: [usize; 3] = [85, 15, 100];
/// Points of the map along each parameter.
const POINTS: usize = 8;

/// Everything measured.
#[derive(Serialize, Deserialize)]
struct Study {
    options: Options,
    facts: Vec<(String, String)>,
    population: Vec<Measured>,
    one_shape: Vec<Measured>,
    /// log₁₀ of the median error \[mm\] over b, each over a.
    map: Vec<Vec<Option<f64>>>,
    embedding: Chart,
}

/// What the study works on.
struct Data<'a> {
    options: &'a Options,
    ventricles: &'a Ventricles,
    training: &'a [Ventricle],
    validation: &'a [Ventricle],
    unseen: &'a [Ventricle],
    /// Wall time of one on the coarse mesh \[s\].
    coarse_s: f64,
}

/// The section of the report.
///
/// # Errors
/// A ventricle that cannot be meshed, a training that diverges, files that cannot be written.
pub(super) fn section(options: &Options) -> Result<Section> {
    let study = kept(options, KEY, |study: &Study| &study.options, || study(options))?;
    let about = "Left ventricles of 32 smooth modes, hexahedra with one volume ratio each, Holzapfel and Ogden's law over two decades in \
                 each parameter, 8 mmHg in the cavity: networks on simulations, told none to all of the numbers of a shape; the same about \
                 the solution of the ventricle on a coarse mesh; and regression.";
    let range = [0.1f64, 10.0].map(f64::log10);
    let map = Map {
        title: "log₁₀ of the median err_u [mm]".into(),
        axes: ["log₁₀ a [kPa]", "log₁₀ b"].map(String::from),
        ranges: [range, range],
        scale: Map::range(&study.map),
        rows: study.map,
        marks: Vec::new(),
    };
    let figure = Figure {
        title: "Errors over two parameters".into(),
        caption: "Of the network about the coarse solution on one shape, a_f = 1 kPa, b_f = 1."
            .into(),
        panels: vec![Panel::Map(map)],
    };
    let blocks = vec![
        Block::Text(about.into()),
        Block::Facts(study.facts),
        Block::Table(table(&study.population)?),
        Block::Text(
            "One shape that no network has seen, and what some simulations of it add:".into(),
        ),
        Block::Table(table(&study.one_shape)?),
        Block::Figure(figure),
        Block::charts(
            "What nodes are to the network",
            "Embeddings of a ventricle's nodes, by their place from apex to base.",
            [study.embedding],
        ),
    ];
    Ok(Section { name: KEY.into(), title: "Inflated ventricles".into(), blocks })
}

/// Simulates one part of the ventricles.
///
/// # Errors
/// Files that cannot be written.
pub(super) fn simulate(options: &Options, shard: Shard) -> Result<PathBuf> {
    let count = counts(options).iter().sum();
    Ventricles::new(options)?.simulated(count, &simulations(options), Some(shard))?;
    Ok(simulations(options))
}

/// Ventricles to train, to choose weights, to test.
fn counts(options: &Options) -> [usize; 3] {
    if options.quick { [6, 2, 3] } else { [850, 50, 100] }
}

fn study(options: &Options) -> Result<Study> {
    eprintln!("\nVentricles of random shape, inflated");
    let (ventricles, counts) = (Ventricles::new(options)?, counts(options));
    let start = Instant::now();
    let drawn: usize = counts.iter().sum();
    let all = ventricles.simulated(drawn, &simulations(options), None)?;
    let seconds = start.elapsed().as_secs_f64();
    // By number, so that one without equilibrium moves no other.
    let [mut training, mut validation, mut unseen] = [Vec::new(), Vec::new(), Vec::new()];
    for (index, ventricle) in all {
        let small = ventricle.volume(&ventricle.displacement) < LARGEST;
        match index {
            _ if index < counts[0] => training.push(ventricle),
            _ if index < counts[0] + counts[1] => validation.push(ventricle),
            _ if small => unseen.push(ventricle),
            _ => {}
        }
    }
    let few = "too few ventricles have an equilibrium";
    ensure!(training.len() > 1 && !validation.is_empty() && !unseen.is_empty(), few);
    let coarse_s = ventricles.times(&unseen[0])?[0];
    let (training, validation, unseen) = (&training[..], &validation[..], &unseen[..]);
    let data = Data { options, ventricles: &ventricles, training, validation, unseen, coarse_s };
    let mut facts = data.facts(counts.iter().sum(), seconds)?;
    let mut population = vec![data.coarse_alone(data.unseen)?];
    for count in [4, 2].map(|part| training.len().div_ceil(part).max(2).min(training.len())) {
        for coarse in [false, true] {
            let told = Seen { numbers: ALL, coarse };
            population.push(data.regression(&training[..count], data.unseen, told)?);
        }
    }
    facts.extend(data.volumes_alone()?);
    let mut general = Vec::new();
    for (variant, told, printed) in variants(options) {
        let (measured, surrogate) = data.network(variant, told, printed)?;
        population.push(measured);
        if told.numbers == ALL && (told.coarse || variant.steps == STEPS || options.quick) {
            general.push((variant, told, surrogate));
        }
    }
    let (one_shape, map) = data.one_shape(&general)?;
    let (embedding, fact) = data.embedding(&general[0])?;
    facts.extend([fact, data.times(&general[0])?]);
    Ok(Study { options: options.clone(), facts, population, one_shape, map, embedding })
}

/// Numbers of a shape, and K of the networks that differ in what they are told.
const ALL: usize = VentricleShape::NUMBERS;
const STEPS: usize = 3;

fn simulations(options: &Options) -> PathBuf {
    options.out.join(KEY).join("simulations")
}

/// Networks of Tables A.8 and A.9, and the one about the coarse solution, with the medians that the thesis prints: err_u \[mm\] and
/// LVV \[%\].
fn variants(options: &Options) -> Vec<(Variant, Seen, [Option<f64>; 2])> {
    let virtual_nodes = VIRTUAL_NODES[usize::from(options.full)];
    let of = |steps, numbers, coarse, printed| {
        (Variant { steps, latent: 40, virtual_nodes }, Seen { numbers, coarse }, printed)
    };
    let printed = |error| [Some(error), None];
    if options.quick {
        let variant = Variant { steps: 1, latent: 8, virtual_nodes: &[8] };
        return [false, true]
            .map(|coarse| (variant, Seen { numbers: ALL, coarse }, [None; 2]))
            .to_vec();
    }
    let told = [(0, 527.0), (8, 446.0), (16, 413.0), (24, 318.0)];
    let of_told = |(numbers, micrometres): (usize, f64)| {
        of(STEPS, numbers, false, printed(1e-3 * micrometres))
    };
    let told = told.map(of_told);
    // The thesis' 40 components hold what these 32 numbers do.
    let steps = [(1, 0.298), (5, 0.266)];
    let steps = steps.map(|(k, error)| of(k, ALL, false, printed(error)));
    told.into_iter()
        .chain([of(STEPS, ALL, false, [Some(0.241), Some(0.49)])])
        .chain(steps)
        .chain([1, 3].map(|k| of(k, ALL, true, [Some(0.241), Some(0.49)])))
        .collect()
}

impl Data<'_> {
    fn facts(&self, drawn: usize, wall_s: f64) -> Result<Vec<(String, String)>> {
        let body = &self.unseen.first().context("no ventricle is left to test")?.body;
        let of = |values: Vec<f64>| Distribution::of(values).context("no ventricle");
        let sizes = self.unseen.iter().flat_map(|ventricle| lengths(&ventricle.displacement));
        let sizes = of(sizes.collect())?;
        let changes = of(self.unseen.iter().map(Ventricle::largest_volume_change).collect())?;
        let volumes = of(self.unseen.iter().map(|v| 1e-3 * v.volume(&v.displacement)).collect())?;
        let fact = |name: &str, what: String| (name.to_string(), what);
        Ok(vec![
            fact(
                "ventricles",
                format!(
                    "{drawn} drawn; {} to train, {} to choose weights, {} to test below {:.0} mL; {} nodes, {} cells",
                    self.training.len(),
                    self.validation.len(),
                    self.unseen.len(),
                    1e-3 * LARGEST,
                    body.nodes,
                    body.cells.len() / body.nodes_per_cell
                ),
            ),
            fact("simulations", format!("{wall_s:.0} s, or as long as it takes to read them")),
            fact(
                "displacements tested",
                format!("mean {:.1} mm, largest {:.0} mm", sizes.mean, sizes.q100),
            ),
            fact(
                "inflated cavities",
                format!("{:.0} to {:.0} mL, median {:.0}", volumes.q0, volumes.q100, volumes.q50),
            ),
            fact("largest |J − 1| of a cell", format!("{:.1e} in the median", changes.q50)),
        ])
    }

    /// What the coarse mesh says, by itself.
    fn coarse_alone(&self, unseen: &[Ventricle]) -> Result<Measured> {
        let found = |ventricle: &Ventricle| Ok(ventricle.coarse.displacement.clone());
        let about = "the equilibrium of the ventricle on a coarse mesh, by moving least squares";
        self.measured(
            ["coarse solution", about],
            unseen,
            (0.0, Seen { numbers: ALL, coarse: true }),
            found,
        )
    }

    /// Regression over the numbers of the shape and the logarithms of the parameters.
    fn regression(&self, seen: &[Ventricle], unseen: &[Ventricle], told: Seen) -> Result<Measured> {
        let start = cpu_seconds();
        let inputs: Vec<Vec<f64>> = seen.iter().map(|v| v.inputs(told)).collect();
        let fields: Vec<Vec<f64>> = seen.iter().map(|v| v.target(told)).collect();
        let fit = PodRegression::fit(&seen[0].parameters(told), &inputs, &fields)?;
        let cpu_s = cpu_seconds() - start;
        let found = |v: &Ventricle| Ok(v.displaced(&fit.predict(&v.inputs(told))?, told));
        let method = format!("POD + GP, {} simulations{}", seen.len(), told.name());
        let about = fit.interpolation().to_string();
        let about = about.split(", lengths").next().unwrap_or_default();
        self.measured([&method, about], unseen, (cpu_s, told), found)
    }

    /// Regression of the volume alone, for which no field is needed.
    fn volumes_alone(&self) -> Result<Vec<(String, String)>> {
        let fact = |told: Seen| {
            let seen = &self.training[..self.training.len().div_ceil(2)];
            let inputs: Vec<_> = seen.iter().map(|v| v.inputs(told)).collect();
            let growth = |v: &Ventricle| vec![v.growth(&v.displacement) - v.known_growth(told)];
            let growths: Vec<_> = seen.iter().map(growth).collect();
            let fit = PodRegression::fit(&self.training[0].parameters(told), &inputs, &growths)?;
            let error = |v: &Ventricle| -> Result<f64> {
                let off = fit.predict(&v.inputs(told))?[0] - growth(v)[0];
                Ok(100.0 * off.exp_m1().abs())
            };
            let errors = self.unseen.iter().map(error).collect::<Result<Vec<_>>>()?;
            let errors = Distribution::of(errors).context("no cavity was tested")?;
            let name = format!("regression of the volume alone{}", told.name());
            Ok((
                name,
                format!("{:.2}, {:.2}, {:.2} % (25, 50, 75 %)", errors.q25, errors.q50, errors.q75),
            ))
        };
        [false, true].map(|coarse| fact(Seen { numbers: ALL, coarse })).into_iter().collect()
    }

    fn network(
        &self,
        variant: Variant,
        told: Seen,
        printed: [Option<f64>; 2],
    ) -> Result<(Measured, Surrogate)> {
        let start = cpu_seconds();
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let data = data_set(&topology, self.training, self.validation, told)?;
        let ranges = self.unseen[0].body.parameters.iter().map(|parameter| {
            let [lower, upper] = parameter.range;
            ParameterRange { lower, upper, scale: ParameterScale::Log }
        });
        let surrogate = untrained(variant, &data, ranges.collect(), self.options)?;
        let surrogate = train(surrogate, data, PACE, self.options)?;
        let cpu_s = cpu_seconds() - start;
        let about = format!("network on simulations, told {} numbers of the shape", told.numbers);
        let method = format!("{}, {} numbers{}", variant.name(), told.numbers, told.name());
        let found = predicting(&surrogate, &topology, told);
        let measured = self.measured([&method, &about], self.unseen, (cpu_s, told), found)?;
        Ok((Measured { printed, ..measured }, surrogate))
    }

    /// One shape that nothing was trained on: as it is, and with simulations of it; and a map of errors.
    #[allow(clippy::type_complexity, reason = "rows and a map")]
    fn one_shape(
        &self,
        general: &[(Variant, Seen, Surrogate)],
    ) -> Result<(Vec<Measured>, Vec<Vec<Option<f64>>>)> {
        let numbers = &self.unseen[0].numbers;
        let counts = if self.options.quick { [4, 2, 2] } else { ONE_SHAPE };
        let [design, apart] = [Design::LatinHypercube, Design::Uniform];
        let parameters = &self.unseen[0].body.parameters;
        let seed = self.options.seed;
        let learned = design.sample(parameters, counts[0] + counts[1], seed)?;
        let learned = self.ventricles.at(numbers, &learned)?;
        let tested = self.ventricles.at(numbers, &apart.sample(parameters, counts[2], seed)?)?;
        ensure!(
            learned.len() > counts[1] + 1,
            "too few parameter sets of one shape have an equilibrium"
        );
        let (training, validation) = learned.split_at(learned.len() - counts[1]);
        let mut rows = vec![self.coarse_alone(&tested)?];
        for coarse in [false, true] {
            rows.push(self.regression(training, &tested, Seen { numbers: 0, coarse })?);
        }
        let mut map = Vec::new();
        for (variant, told, surrogate) in general {
            let topology = self.ventricles.graph(variant.virtual_nodes)?;
            let name = format!("{}{}", variant.name(), told.name());
            let about = "of the population";
            let found = predicting(surrogate, &topology, *told);
            let row = self.measured([&name, about], &tested, (0.0, *told), &found)?;
            rows.push(Measured { printed: [Some(0.295), Some(0.43)], ..row });
            if told.coarse && map.is_empty() {
                map = self.map(numbers, &found)?;
            }
            let start = cpu_seconds();
            let data = data_set(&topology, training, validation, *told)?;
            // Every sample has features of its own about a coarse solution, so that message passing has to learn too.
            let pace = Pace { decoders_only: !told.coarse, ..TRANSFER };
            let further = train(surrogate.carried_to(&data)?, data, pace, self.options)?;
            let cpu_s = cpu_seconds() - start;
            let about = format!("trained further on {} simulations of this shape", training.len());
            let found = predicting(&further, &topology, *told);
            let row = self.measured([&name, &about], &tested, (cpu_s, *told), found)?;
            rows.push(Measured { printed: [Some(0.113), Some(0.34)], ..row });
        }
        rows.iter_mut().for_each(|row| row.group = "one shape".into());
        Ok((rows, map))
    }

    /// Errors over the first two parameters, the others in the middle.
    fn map(
        &self,
        numbers: &[f64],
        found: impl Fn(&Ventricle) -> Result<Vec<f64>>,
    ) -> Result<Vec<Vec<Option<f64>>>> {
        let points = if self.options.quick { 2 } else { POINTS };
        let at = |k: usize| 10f64.powf(-1.0 + 2.0 * (k as f64 + 0.5) / points as f64);
        let cell = |a: usize, b: usize| -> Result<Option<f64>> {
            let solved = self.ventricles.at(numbers, &[vec![at(a), at(b), 1.0, 1.0]])?;
            let Some(ventricle) = solved.first() else { return Ok(None) };
            let errors = Distribution::of(ventricle.distances(&found(ventricle)?));
            Ok(errors.map(|errors| errors.q50.log10()))
        };
        let row = |b: usize| (0..points).map(|a| cell(a, b)).collect();
        (0..points).map(row).collect()
    }

    fn embedding(
        &self,
        (variant, told, surrogate): &(Variant, Seen, Surrogate),
    ) -> Result<(Chart, (String, String))> {
        let ventricle = &self.unseen[0];
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let geometry = ventricle.geometry(&topology, *told)?;
        let along: Vec<f64> = ventricle.body.positions.iter().map(|x| x[2]).collect();
        let (chart, share) = simulated::embedding(surrogate, &geometry, &along)?;
        let what = format!("{:.0} % of the variance, {}", 100.0 * share, variant.name());
        Ok((chart, ("two principal components of the embeddings".into(), what)))
    }

    /// Table 2.1: answers for a shape that changes and for one that stays, beside the solver.
    fn times(
        &self,
        (variant, told, surrogate): &(Variant, Seen, Surrogate),
    ) -> Result<(String, String)> {
        const AGAIN: u32 = 20;
        let Ventricle { theta, .. } = &self.unseen[0];
        let topology = self.ventricles.graph(variant.virtual_nodes)?;
        let theta = std::slice::from_ref(theta);
        let time = |answer: &mut dyn FnMut() -> Result<()>| -> Result<f64> {
            let start = Instant::now();
            (0..AGAIN).try_for_each(|_| answer())?;
            Ok(1e3 * start.elapsed().as_secs_f64() / f64::from(AGAIN))
        };
        let geometry = self.unseen[0].geometry(&topology, *told)?;
        let varying = time(&mut || {
            surrogate.predict(&self.unseen[0].geometry(&topology, *told)?, theta)?;
            Ok(())
        })?;
        let fixed = surrogate.fixed_geometry(&geometry)?;
        let fixed = time(&mut || fixed.predict(theta).map(|_| ()).map_err(Into::into))?;
        let [coarse, solver] = self.ventricles.times(&self.unseen[0])?.map(|s| 1e3 * s);
        let what = format!(
            "{varying:.1} ms where the shape changes, {fixed:.2} ms where it stays; the coarse solution {coarse:.0} ms, the solver by way of it {solver:.0} ms; {}, {} threads",
            variant.name(),
            rayon::current_num_threads()
        );
        Ok(("an answer".into(), what))
    }

    fn measured(
        &self,
        [method, about]: [&str; 2],
        unseen: &[Ventricle],
        (cpu_s, told): (f64, Seen),
        found: impl Fn(&Ventricle) -> Result<Vec<f64>>,
    ) -> Result<Measured> {
        let (mut errors, mut volumes) = (Vec::new(), Vec::new());
        let clock = Instant::now();
        let answers = unseen.iter().map(found).collect::<Result<Vec<_>>>()?;
        let mut answer_s = clock.elapsed().as_secs_f64();
        for (ventricle, answer) in unseen.iter().zip(answers) {
            errors.extend(ventricle.distances(&answer));
            let volume = ventricle.volume(&ventricle.displacement);
            volumes.push((ventricle.volume(&answer) - volume).abs() / volume);
            answer_s += if told.coarse { self.coarse_s } else { 0.0 };
        }
        let measured = Measured {
            method: method.into(),
            about: about.into(),
            group: String::new(),
            errors,
            volumes,
            cpu_s,
            answer_s: answer_s / unseen.len() as f64,
            printed: [None; 2],
        };
        measured.tell()?;
        Ok(measured)
    }
}

fn predicting<'a>(
    surrogate: &'a Surrogate,
    topology: &'a Topology,
    told: Seen,
) -> impl Fn(&Ventricle) -> Result<Vec<f64>> + 'a {
    move |ventricle| {
        let geometry = ventricle.geometry(topology, told)?;
        let found = surrogate.predict(&geometry, std::slice::from_ref(&ventricle.theta))?;
        Ok(ventricle.displaced(found.field(0), told))
    }
}

/// Ventricles of the same features share a geometry.
fn data_set(
    topology: &Topology,
    training: &[Ventricle],
    validation: &[Ventricle],
    told: Seen,
) -> Result<DataSet> {
    let mut geometries = Vec::new();
    let mut sample = |ventricle: &Ventricle| -> Result<Sample> {
        let geometry = ventricle.geometry(topology, told)?;
        if geometries.last() != Some(&geometry) {
            geometries.push(geometry);
        }
        Ok(Sample {
            geometry: geometries.len() - 1,
            theta: ventricle.theta.clone(),
            displacement: ventricle.target(told),
        })
    };
    let training = training.iter().map(&mut sample).collect::<Result<_>>()?;
    let validation = validation.iter().map(&mut sample).collect::<Result<_>>()?;
    Ok(DataSet { geometries, training, validation })
}

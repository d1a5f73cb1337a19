//! Report of a calibration.

use super::{Curve, LINEARISED, measured, parameter_in_words, verdict, volumes_in_words};
use crate::case::{locking_at_most, locking_in_words};
use crate::patient::Prepared;
use sinew_calibrate::{PatientStates, Posterior};
use sinew_fem::Unloaded;
use sinew_report::format::{seconds, trimmed};
use sinew_report::{
    Block, Cell, Chart, Provenance, Report, Section, Series, Style, Surfaces, density,
};

/// Name of the ends of a curve's band.
const BAND: &str = "95 % band";
/// Draws in a plot of two parameters.
const MOST_POINTS: usize = 150;
/// Parameters at most for a plot of each pair.
const MOST_PAIRED: usize = 5;

/// The page.
pub fn report(
    title: &str,
    prepared: &Prepared,
    posterior: &Posterior,
    curves: &[Curve],
    states: &PatientStates,
    provenance: Provenance,
) -> Report {
    let (nodes, problem) = (prepared.body.nodes, &posterior.problem);
    let (count, unknowns) = (problem.data.len(), problem.unknowns.len());
    let about = format!("{nodes} nodes, {count} data, {unknowns} unknown parameters");
    let mut report = Report::new(title, about, provenance);
    report.headline = verdict(prepared, posterior);
    report.notes.extend(posterior.predictive.in_words());
    report.notes.extend(too_stiff(states));
    let mut blocks = vec![Block::List(volumes_in_words(prepared, posterior))];
    blocks.extend(curves.iter().map(|curve| curve_block(curve, prepared, posterior)));
    let rest = states.unloaded.as_ref();
    blocks.extend(rest.and_then(|rest| shapes(prepared, rest)));
    report.sections.extend([
        Section { name: "curve".into(), title: "Pressure and volume".into(), blocks },
        parameters(posterior),
        identifiability(posterior),
        data(posterior),
        correction(posterior),
    ]);
    report
}

/// Warning that the cells of a patient's body are too stiff in the phase that moves it most, if they are.
pub fn too_stiff(states: &PatientStates) -> Option<String> {
    let phases = states.phases.iter().map(|phase| (&phase.theta, &phase.displacement[..]));
    let found = locking_at_most(&states.rest, phases).ok().flatten();
    found.as_ref().map(locking_in_words)
}

/// The body at rest beside that of the image.
fn shapes(prepared: &Prepared, unloaded: &Unloaded) -> Option<Block> {
    let (image, rest) = (&prepared.body, &unloaded.rest);
    let mut surfaces = Surfaces::new(&image.mesh.boundary_triangles().0, &rest.positions).ok()?;
    surfaces.quantity = "distance from the place at rest".into();
    (surfaces.unit, surfaces.length, surfaces.linear) = ("mm".into(), "mm".into(), true);
    let moved = unloaded.motion.as_chunks::<3>().0.iter();
    let moved: Vec<f64> = moved.map(|w| w.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
    let still = vec![0.0; moved.len()];
    surfaces.push("most likely parameters", "at rest", &rest.positions, &still).ok()?;
    surfaces.push("the mesh", "in the image", &image.positions, &moved).ok()?;
    Some(Block::Surfaces(surfaces))
}

fn curve_block(curve: &Curve, prepared: &Prepared, posterior: &Posterior) -> Block {
    let axes = ["volume [mL]", "pressure [mmHg]"];
    let mut chart = Chart::new(format!("Cavity {}", curve.cavity), axes, [false; 2]);
    for (name, quantile) in [("posterior median", 1), (BAND, 0), (BAND, 2)] {
        let points = curve.pressures.iter().zip(&curve.volumes).map(|(p, v)| [v[quantile], *p]);
        chart.series.push(Series::new(name, Style::Line, points));
    }
    if let Some(klotz) = curve.klotz {
        let points = curve.pressures.iter().map(|p| [klotz.volume(*p), *p]);
        let name = "Klotz et al. 2006, through the last datum";
        chart = chart.with(Series::new(name, Style::Line, points));
    }
    let measured = measured(prepared, posterior, &curve.cavity);
    chart = chart.with(Series::new("measured", Style::Points, measured));
    let end = curve.end.as_ref().map_or(String::new(), |end| format!("; {end}"));
    let caption =
        format!("Pressures and volumes, solved at {} draws of the posterior{end}.", curve.draws);
    Block::charts("Pressure–volume curve", caption, [chart])
}

fn parameters(posterior: &Posterior) -> Section {
    let count = posterior.problem.unknowns.len();
    let lines = (0..count).map(|at| parameter_in_words(posterior, at)).collect();
    let prior: Vec<Vec<f64>> = (0..count).map(|at| prior_draws(posterior, at)).collect();
    let chart = |at: usize| {
        let head = posterior.problem.unknowns[at].head();
        let draws = posterior.shown(at).concat();
        Chart::new(&head, [&head, "density per decade"], [true, false])
            .with(Series::new("prior", Style::Area, density(&prior[at])))
            .with(Series::new("posterior", Style::Area, density(&draws)))
    };
    let mut blocks =
        vec![Block::List(lines), Block::charts("Prior and posterior", "", (0..count).map(chart))];
    if (2..=MOST_PAIRED).contains(&count) {
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        let charts = pairs.map(|(a, b)| pair(posterior, &prior, a, b));
        blocks.push(Block::charts("Pairs of parameters", "Draws of prior and posterior.", charts));
    }
    Section { name: "parameters".into(), title: "Parameters".into(), blocks }
}

fn pair(posterior: &Posterior, prior: &[Vec<f64>], a: usize, b: usize) -> Chart {
    let [x, y] = [a, b].map(|at| posterior.problem.unknowns[at].head());
    let [u, v] = [a, b].map(|at| posterior.shown(at).concat());
    // Few enough points to be distinguished.
    let points = |u: &[f64], v: &[f64]| {
        let every = u.len().div_ceil(MOST_POINTS).max(1);
        u.iter().zip(v).step_by(every).map(|(u, v)| [*u, *v]).collect::<Vec<_>>()
    };
    Chart::new(format!("{x} and {y}"), [&x, &y], [true, true])
        .with(Series::new("prior", Style::Points, points(&prior[a], &prior[b])))
        .with(Series::new("posterior", Style::Points, points(&u, &v)))
}

/// Quantiles of the prior at equal shares, in an order that does not pair them with those of other parameters.
fn prior_draws(posterior: &Posterior, parameter: usize) -> Vec<f64> {
    use rand::SeedableRng;
    let mut random = rand::rngs::ChaCha8Rng::seed_from_u64(parameter as u64);
    let unknown = &posterior.problem.unknowns[parameter];
    let normals = sinew_sample::standard_normals(posterior.draws.pooled().count(), &mut random);
    normals.into_iter().map(|y| unknown.shown(unknown.prior.logarithm(y)[0].exp())).collect()
}

fn identifiability(posterior: &Posterior) -> Section {
    let found = &posterior.identifiability;
    let head = std::iter::once("eigenvalue").chain(found.names.iter().map(String::as_str));
    let row = |(value, direction): (&f64, &Vec<f64>)| {
        std::iter::once(*value).chain(direction.iter().copied()).map(Cell::from).collect()
    };
    let blocks = vec![
        Block::Text(LINEARISED.into()),
        Block::List(found.directions_in_words()),
        Block::listing(
            "Spectrum of the information of the data, priors being standard normal",
            head,
            found.spectrum.iter().zip(&found.directions).map(row),
        ),
    ];
    Section { name: "identifiability".into(), title: "Identified by the data".into(), blocks }
}

fn data(posterior: &Posterior) -> Section {
    let checks = &posterior.predictive.data;
    let points = checks.iter().enumerate().map(|(at, c)| [at as f64 + 1.0, c.residual]);
    let hints = checks.iter().map(|check| check.name.clone()).collect();
    let series = Series { hints, ..Series::new("residual", Style::Points, points) };
    let axes = ["datum", "measured − predicted [standard deviations]"];
    let chart = Chart::new("Residuals", axes, [false; 2]).with(series);
    let row = |check: &sinew_calibrate::DatumCheck| {
        let datum = posterior.problem.data.iter().find(|d| d.name == check.name);
        let (size, unit) = datum.map_or((1.0, ""), |d| (d.size, d.unit.as_str()));
        vec![
            Cell::from(check.name.as_str()),
            Cell::from(check.value / size),
            Cell::from(check.predicted / size),
            Cell::from(check.deviation / size),
            Cell::from(unit),
            Cell::from(check.residual),
            Cell::from(check.p),
            Cell::from(check.p_left_out),
        ]
    };
    let head = [
        "datum",
        "measured",
        "predicted",
        "sd of the prediction",
        "unit",
        "residual [sd]",
        "p",
        "p, left out",
    ];
    let blocks = vec![
        Block::Text(format!(
            "Probability of misfits in all that are larger than these: {}.",
            trimmed(posterior.predictive.p_overall, 3)
        )),
        Block::charts("Residual of each datum", "", [chart]),
        Block::listing("Each datum", head, checks.iter().map(row)),
    ];
    Section { name: "data".into(), title: "Data and predictions".into(), blocks }
}

fn correction(posterior: &Posterior) -> Section {
    let found = &posterior.correction;
    let [r_hat, bulk, tail] = posterior.coordinates.mixing();
    let facts = [
        ("Pareto k̂", format!("{:.2}", found.k_hat)),
        ("effective share", format!("{:.3}", found.share)),
        (
            "largest error of the emulator",
            format!("{:.3} sd of {}", found.largest_error, found.worst_datum),
        ),
        ("acceptance", format!("{:.3}", found.acceptance)),
        ("rounds", found.rounds.to_string()),
        ("solves", format!("{}, {} without an answer", found.solves, found.failed)),
        ("time", seconds(found.seconds)),
        ("R̂", format!("{r_hat:.4}")),
        ("effective draws", format!("{bulk:.0} in the bulk, {tail:.0} in the tails")),
    ];
    let blocks = vec![
        Block::Text(
            "A polynomial through solves with their derivatives is sampled by NUTS; its draws are corrected by one sweep of \
             independence Metropolis with the solver's likelihood, which makes them draws of the solver's posterior."
                .into(),
        ),
        Block::Facts(facts.map(|(name, value)| (name.to_string(), value)).to_vec()),
    ];
    Section { name: "correction".into(), title: "Correction by the solver".into(), blocks }
}

//! Errors over the plane of two parameters, within the trained ranges and beyond (thesis Fig. 3.9).

use crate::organs::regions::log_median;
use crate::program;
use anyhow::Result;
use serde::{Deserialize, Serialize};
use sinew::{Body, Emulator, Parameter, Sampling, TestSet};
use sinew_emulate::Terminal;
use sinew_report::{Block, Figure, Map, Panel};

/// Points along each parameter.
pub(crate) const POINTS: usize = 13;
/// Extent of the map beyond a range, as a share of it on the scale of its sampling.
const BEYOND: f64 = 0.5;

/// Median nodal errors of some emulators over the plane.
#[derive(Debug, Serialize, Deserialize)]
pub struct ErrorMap {
    names: [String; 2],
    /// Ends of the axes, as powers of ten.
    ranges: [[f64; 2]; 2],
    /// Corners of the trained box, as powers of ten.
    box_corners: Vec<[f64; 2]>,
    /// Median error of each emulator as log₁₀, by rows of the second parameter; `None` where there is no equilibrium.
    emulators: Vec<(String, Vec<Vec<Option<f64>>>)>,
}

/// Solves over the plane and asks the emulators, with `points` along each parameter.
///
/// # Errors
/// A body with other than two parameters on logarithmic scales, files that cannot be read.
pub fn map(body: &Body, emulators: &[(&str, &Emulator<'_>)], points: usize) -> Result<ErrorMap> {
    let [first, second] = &body.parameters[..] else {
        anyhow::bail!("a map is over two parameters, not {}", body.parameters.len());
    };
    if let Some(p) = body.parameters.iter().find(|p| p.sampling != Sampling::Log) {
        anyhow::bail!("a map is over logarithmic scales, and {} has another", p.name);
    }
    let ends = |p: &Parameter| {
        let [low, high] = p.range.map(f64::log10);
        [low - BEYOND * (high - low), high + BEYOND * (high - low)]
    };
    let ranges = [ends(first), ends(second)];
    let at = |[low, high]: [f64; 2], i: usize| {
        10f64.powf(low + (high - low) * i as f64 / (points - 1).max(1) as f64)
    };
    let thetas: Vec<Vec<f64>> = (0..points * points)
        .map(|i| vec![at(ranges[0], i % points), at(ranges[1], i / points)])
        .collect();
    let solved =
        sinew::simulate(body, &thetas, "solve for the map", None, &mut Terminal::default())?;
    let test = TestSet::new(body, solved);
    let mut maps = Vec::new();
    for (name, emulator) in emulators {
        let cases = test.cases(&emulator.predict(&test.thetas)?.fields())?;
        let median = |theta: &Vec<f64>| {
            let case = test.thetas.iter().position(|solved| solved == theta)?;
            log_median(cases[case].err_u.clone())
        };
        let rows = thetas.chunks(points).map(|row| row.iter().map(median).collect()).collect();
        maps.push((name.to_string(), rows));
    }
    let [[a, b], [c, d]] = [first, second].map(|p| p.range.map(f64::log10));
    Ok(ErrorMap {
        names: [first, second]
            .map(|p| format!("log₁₀ {} [{}]", p.name, p.unit.of_scene(&body.units))),
        ranges,
        box_corners: vec![[a, c], [b, c], [b, d], [a, d]],
        emulators: maps,
    })
}

impl ErrorMap {
    /// Picture for the report, with one scale of colours.
    pub fn block(&self, unit: &str) -> Block {
        let all: Vec<Vec<Option<f64>>> =
            self.emulators.iter().flat_map(|(_, rows)| rows.clone()).collect();
        let scale = program::range(&all);
        let panel = |(name, rows): &(String, Vec<Vec<Option<f64>>>)| {
            Panel::Map(Map {
                title: format!("{name}: log₁₀ of the median err_u [{unit}]"),
                axes: self.names.clone(),
                ranges: self.ranges,
                rows: rows.clone(),
                scale,
                marks: vec![("corners of the trained box".into(), self.box_corners.clone())],
            })
        };
        Block::Figure(Figure {
            title: "Errors over the parameters".into(),
            caption: "Within the box that was trained, and half as far again beyond it.".into(),
            panels: self.emulators.iter().map(panel).collect(),
        })
    }
}

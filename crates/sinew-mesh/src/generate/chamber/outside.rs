//! Outer nodes of the wall: from the endocardium to the nearest outer surface.

use super::axis::Base;
use super::trees::{Point, Result, Trees, shown};
use crate::Refusal;
use crate::generate::wall::Sheet;
use crate::quality::Spread;
use std::collections::BTreeSet;

/// Largest share of nodes whose ray misses every outer surface; they take the thickness of their neighbours.
const MISSED: f64 = 0.1;
/// Least thickness relative to the median.
const THIN: f64 = 0.02;
/// Distance below the base, in thicknesses, over which directions rotate into its plane.
const TURNS: f64 = 2.0;

/// The outer end of each node of the sheet.
pub(super) struct Outside {
    pub points: Vec<Point>,
    /// Whether it is on the other ventricle.
    pub septum: Vec<bool>,
    /// Thickness of the wall \[length\].
    pub thickness: Vec<f64>,
    /// Nodes whose outer end was brought nearer than the outer surface, because the thickness jumps beside them.
    pub limited: usize,
    /// Nodes with nothing outside along their direction, which take the thickness around them.
    pub missed: usize,
}

pub(super) fn carry(
    trees: &Trees,
    sheet: &Sheet,
    inner: &[Point],
    base: &Base,
    sweeps: usize,
    slope: f64,
) -> Result<Outside> {
    let neighbours = neighbours(sheet);
    let mut directions = directions(sheet, inner, base, &neighbours, sweeps);
    let ways = inner.iter().zip(&directions).filter_map(|(x, d)| Some(trees.outside(*x, *d)?.0));
    let middle = Spread::of(ways.collect()).map_or(1.0, |ways| ways.median);
    for ((direction, x), at) in directions.iter_mut().zip(inner).zip(&sheet.points) {
        let below = if is_rim(at) { 0.0 } else { (base.centre - x).dot(&base.normal) };
        let free = (below / (TURNS * middle)).clamp(0.0, 1.0);
        let up = direction.dot(&base.normal);
        *direction = (*direction - base.normal * (up * (1.0 - free))).normalize();
    }
    let met: Vec<_> = inner.iter().zip(&directions).map(|(x, d)| trees.outside(*x, *d)).collect();
    let missed = met.iter().filter(|hit| hit.is_none()).count();
    if missed as f64 > MISSED * met.len() as f64 {
        let first = met.iter().position(Option::is_none).unwrap_or_default();
        let (of, at) = (met.len(), shown(inner[first]));
        return Err(Refusal(format!(
            "{missed} of {of} nodes of the endocardium have no outer surface along their normal, the first at {at}; give the epicardium around it, in the same unit, and the septum if there is one"
        )));
    }
    let raw: Vec<f64> = met.iter().map(|hit| hit.map_or(f64::INFINITY, |hit| hit.0)).collect();
    if let Some(thin) = raw.iter().position(|&way| way < THIN * middle) {
        return Err(Refusal(format!(
            "the wall has no thickness at {}; part the surfaces there, or put the base further down",
            shown(inner[thin])
        )));
    }
    let thickness = even(&raw, inner, &neighbours, slope);
    let shorter = thickness.iter().zip(&raw).filter(|(now, met)| met.is_finite() && now < met);
    let ends = inner.iter().zip(&directions).zip(&thickness);
    Ok(Outside {
        points: ends.map(|((x, direction), way)| x + direction * *way).collect(),
        septum: met.iter().map(|hit| hit.is_some_and(|hit| hit.1)).collect(),
        limited: shorter.count(),
        missed,
        thickness,
    })
}

pub(super) fn is_rim(at: &[f64; 3]) -> bool {
    at[0].abs().max(at[1].abs()) == 1.0
}

fn neighbours(sheet: &Sheet) -> Vec<Vec<usize>> {
    let mut neighbours = vec![BTreeSet::new(); sheet.points.len()];
    for quad in &sheet.quads {
        for k in 0..4 {
            let [a, b] = [quad[k], quad[(k + 1) % 4]];
            neighbours[a].insert(b);
            neighbours[b].insert(a);
        }
    }
    neighbours.into_iter().map(Vec::from_iter).collect()
}

/// Unit normals away from the cavity, smoothed; those at the base lie in its plane.
fn directions(
    sheet: &Sheet,
    inner: &[Point],
    base: &Base,
    neighbours: &[Vec<usize>],
    sweeps: usize,
) -> Vec<Point> {
    let mut directions = vec![Point::zeros(); inner.len()];
    for &[a, b, c, d] in &sheet.quads {
        let normal = (inner[c] - inner[a]).cross(&(inner[d] - inner[b]));
        [a, b, c, d].into_iter().for_each(|node| directions[node] += normal);
    }
    let middle = inner.iter().sum::<Point>() / inner.len() as f64;
    let outward: f64 = directions.iter().zip(inner).map(|(d, x)| d.dot(&(x - middle))).sum();
    let settle = |directions: &mut [Point]| {
        for (direction, at) in directions.iter_mut().zip(&sheet.points) {
            if is_rim(at) {
                *direction -= base.normal * direction.dot(&base.normal);
            }
            *direction = direction.try_normalize(0.0).unwrap_or(-base.normal);
        }
    };
    directions.iter_mut().for_each(|direction| *direction *= outward.signum());
    settle(&mut directions);
    for _ in 0..sweeps {
        let mean = |list: &Vec<usize>| {
            list.iter().map(|&node| directions[node]).sum::<Point>() / list.len() as f64
        };
        directions =
            neighbours.iter().zip(&directions).map(|(list, own)| own + mean(list)).collect();
        settle(&mut directions);
    }
    directions
}

/// Largest thickness at or below the measured one with a slope of at most `slope` along the surface.
///
/// Where the other ventricle ends, the outer surface jumps from its endocardium to the epicardium; the wall takes a slope
/// there, through tissue that both ventricles share.
fn even(raw: &[f64], inner: &[Point], neighbours: &[Vec<usize>], slope: f64) -> Vec<f64> {
    let mut thickness = raw.to_vec();
    loop {
        let mut changed = false;
        for node in 0..raw.len() {
            for &other in &neighbours[node] {
                let most = thickness[other] + slope * (inner[node] - inner[other]).norm();
                if thickness[node] > most {
                    thickness[node] = most;
                    changed = true;
                }
            }
        }
        if !changed {
            return thickness;
        }
    }
}

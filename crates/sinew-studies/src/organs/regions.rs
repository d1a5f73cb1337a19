//! Regional errors in a ventricle's wall: base, middle and apex, inner and outer half, and around the axis.

use crate::program;
use anyhow::{Context, Result};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use sinew::{Body, Emulator, TestSet};
use sinew_report::format::digits;
use sinew_report::{Block, Figure, Map, Panel};
use std::collections::BTreeSet;

/// Thirds of the way from the base to the apex.
const THIRDS: [&str; 3] = ["base", "middle", "apex"];
/// Halves of the wall.
const HALVES: [&str; 2] = ["inner half", "outer half"];
/// Fields of a map along the axis and around it.
const FIELDS: [usize; 2] = [6, 12];

/// Region of a node in the wall of a ventricle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Part of the way along the axis, from the middle of the cavity's rim to the node farthest from it.
    pub height: f64,
    /// Part of a turn about that axis, from the direction of x.
    pub turn: f64,
    /// 0 where the nearest boundary is the cavity's, 1 where it is the outer one, in between by distances.
    pub depth: f64,
}

/// Places of the nodes of a body with one cavity; `None` for any other.
pub fn places(body: &Body) -> Option<Vec<Place>> {
    let [cavity] = &body.cavities[..] else { return None };
    let inner: BTreeSet<usize> = cavity.triangles().flatten().copied().collect();
    let held = |node: &usize| (0..3).all(|i| body.prescribed[3 * node + i].is_some());
    let boundary = body.mesh.boundary_facets().into_iter();
    let outer: BTreeSet<usize> =
        boundary.flat_map(|facet| body.mesh.nodes_of_facet(facet)).collect();
    let outer: BTreeSet<usize> =
        outer.difference(&inner).copied().filter(|node| !held(node)).collect();
    let points: Vec<Vector3<f64>> = body.positions.iter().map(|&x| x.into()).collect();
    let rim: BTreeSet<usize> =
        cavity.parts[0].lids.first()?.edges.iter().flatten().copied().collect();
    let origin = rim.iter().map(|&node| points[node]).sum::<Vector3<f64>>() / rim.len() as f64;
    let apex =
        points.iter().max_by(|a, b| (*a - origin).norm().total_cmp(&(*b - origin).norm()))?;
    let length = (apex - origin).norm();
    let axis = (apex - origin) / length;
    let x = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let x = (x - axis * axis.dot(&x)).normalize();
    let y = axis.cross(&x);
    let nearest = |point: &Vector3<f64>, set: &BTreeSet<usize>| {
        set.iter().map(|&node| (points[node] - point).norm()).fold(f64::INFINITY, f64::min)
    };
    let place = |point: &Vector3<f64>| {
        let from = point - origin;
        let [within, without] = [nearest(point, &inner), nearest(point, &outer)];
        Place {
            height: from.dot(&axis) / length,
            turn: (from.dot(&y).atan2(from.dot(&x)) / std::f64::consts::TAU).rem_euclid(1.0),
            depth: within / (within + without),
        }
    };
    (!outer.is_empty()).then(|| points.iter().map(place).collect())
}

/// Errors of some emulators by region.
#[derive(Debug, Serialize, Deserialize)]
pub struct Regions {
    /// Mean displacement in every third and half \[length\].
    displacement: [[f64; 2]; 3],
    emulators: Vec<ByRegion>,
}

#[derive(Debug, Serialize, Deserialize)]
struct ByRegion {
    name: String,
    /// Median nodal error in every third and half \[length\].
    medians: [[Option<f64>; 2]; 3],
    /// Errors of both halves: log₁₀ of the median nodal error, by rows from the base on, over the turn.
    maps: [Vec<Vec<Option<f64>>>; 2],
}

/// Errors of emulators on test cases by region; `None` for a body that is no ventricle.
///
/// # Errors
/// Predictions that fail.
pub fn regions(test: &TestSet<'_>, emulators: &[(&str, &Emulator<'_>)]) -> Result<Option<Regions>> {
    let Some(places) = places(test.body) else { return Ok(None) };
    let free = test.body.free_nodes();
    let cell = |node: usize| {
        let Place { height, depth, .. } = places[node];
        (field(height, THIRDS.len()), field(depth, HALVES.len()))
    };
    let mut sums = [[(0.0, 0usize); 2]; 3];
    for field in &test.fields {
        for &node in &free {
            let (third, half) = cell(node);
            let norm = Vector3::from_column_slice(&field[3 * node..3 * node + 3]).norm();
            let (sum, count) = &mut sums[third][half];
            (*sum, *count) = (*sum + norm, *count + 1);
        }
    }
    let of = |&(name, emulator): &(&str, &Emulator<'_>)| -> Result<ByRegion> {
        let cases = test.cases(&emulator.predict(&test.thetas)?.fields())?;
        let mut by_third = vec![Vec::new(); 6];
        let mut by_field = [0, 1].map(|_| vec![Vec::new(); FIELDS[0] * FIELDS[1]]);
        for case in &cases {
            for (&node, &error) in free.iter().zip(&case.err_u) {
                let (third, half) = cell(node);
                let Place { height, turn, .. } = places[node];
                by_third[2 * third + half].push(error);
                by_field[half][field(height, FIELDS[0]) * FIELDS[1] + field(turn, FIELDS[1])]
                    .push(error);
            }
        }
        let mut medians = by_third.into_iter().map(program::median);
        let mut next = || medians.next().flatten();
        let map = |errors: Vec<Vec<f64>>| {
            let logs: Vec<_> = errors.into_iter().map(log_median).collect();
            logs.chunks(FIELDS[1]).map(<[_]>::to_vec).collect()
        };
        Ok(ByRegion {
            name: name.into(),
            medians: [(); 3].map(|()| [(); 2].map(|()| next())),
            maps: by_field.map(map),
        })
    };
    let emulators = emulators.iter().map(of).collect::<Result<_>>().context("errors by region")?;
    let mean = |(sum, count): (f64, usize)| sum / count.max(1) as f64;
    Ok(Some(Regions { displacement: sums.map(|third| third.map(mean)), emulators }))
}

/// Index of the part that a number is in, of `count` equal parts of 0 to 1; what lies beyond counts with the last or first.
fn field(share: f64, count: usize) -> usize {
    ((share * count as f64) as usize).min(count - 1)
}

/// Logarithm of the upper median; none of nothing.
pub(crate) fn log_median(errors: Vec<f64>) -> Option<f64> {
    program::median(errors).map(|error| error.max(f64::MIN_POSITIVE).log10())
}

impl Regions {
    /// Sections of the report: a list of the regions, and maps of the wall unrolled, with one scale of colours.
    pub fn blocks(&self, unit: &str) -> [Block; 2] {
        let fact = |(third, half): (usize, usize)| {
            let errors = self.emulators.iter().filter_map(|emulator| {
                let median = emulator.medians[third][half]?;
                Some(format!("{} {} {unit}", emulator.name, digits(median, 2)))
            });
            let errors = errors.collect::<Vec<_>>().join(", ");
            let moved = digits(self.displacement[third][half], 2);
            let name = format!("median err_u: {}, {}", THIRDS[third], HALVES[half]);
            (name, format!("{errors}; moves {moved} {unit} in the mean"))
        };
        let facts = (0..3).flat_map(|third| [(third, 0), (third, 1)]).map(fact).collect();
        let all: Vec<_> =
            self.emulators.iter().flat_map(|e| e.maps.iter().flatten().cloned()).collect();
        let scale = program::range(&all);
        let panels = self.emulators.iter().flat_map(|emulator| {
            emulator.maps.iter().zip(HALVES).map(move |(rows, half)| {
                Panel::Map(Map {
                    title: format!("{}, {half}: log₁₀ of the median err_u [{unit}]", emulator.name),
                    axes: ["turn about the axis [°]", "base to apex"].map(String::from),
                    ranges: [[0.0, 360.0], [0.0, 1.0]],
                    rows: rows.clone(),
                    scale,
                    marks: Vec::new(),
                })
            })
        });
        let figure = Figure {
            title: "Errors by region".into(),
            caption: "The wall unrolled, its inner and its outer half: around the axis from the direction of x, and along it from \
                      the base."
                .into(),
            panels: panels.collect(),
        };
        [Block::Facts(facts), Block::Figure(figure)]
    }
}

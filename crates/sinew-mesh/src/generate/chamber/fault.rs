//! Faults of surfaces that no wall lies between: units, places, pieces and rims.

use super::axis::rims;
use super::trees::{Point, Trees, shown};
use crate::geometry::{bounds, merged};
use crate::{Refusal, TriangleMesh, extents};
use sinew_num::connected_cells;
use std::cmp::Reverse;

/// Units that surfaces are written in, by their ratio.
const UNITS: [(f64, [&str; 2]); 3] =
    [(10.0, ["cm", "mm"]), (100.0, ["m", "cm"]), (1000.0, ["m", "mm"])];
/// Lengths of an endocardium in the same unit \[relative to the epicardium's\]: that of two ventricles is the longest.
const LENGTHS: std::ops::RangeInclusive<f64> = 0.35..=1.0;
/// Share of points outside of the epicardium from which on the surfaces count as apart: valves may reach out of it.
const APART: f64 = 0.1;
/// Distance of points that are the same \[relative to the length of their surface\]: digits that files print.
const SAME: f64 = 1e-6;

/// The first fault of the surfaces of a chamber that has no base.
pub(super) fn of([inner, outer]: [&TriangleMesh; 2], trees: &Trees) -> Option<Refusal> {
    // An island far away changes places.
    pieces("endocardium", inner)
        .or_else(|| places(inner, outer, trees))
        .or_else(|| pieces("epicardium", outer))
        .or_else(|| holes("endocardium", inner))
        .or_else(|| holes("epicardium", outer))
}

/// Longest edge of the box around a surface.
fn length(surface: &TriangleMesh) -> f64 {
    extents(&surface.points).into_iter().fold(0.0, f64::max)
}

/// Longest extent of nine tenths of the points, which an island far away does not change.
fn robust_length(surface: &TriangleMesh) -> f64 {
    let (count, apart) = (surface.points.len(), surface.points.len() / 20);
    let along = |axis: usize| {
        let mut places: Vec<f64> = surface.points.iter().map(|x| x[axis]).collect();
        places.sort_by(f64::total_cmp);
        if count == 0 { 0.0 } else { places[count - 1 - apart] - places[apart] }
    };
    (0..3).map(along).fold(0.0, f64::max)
}

/// Different units, of which the sizes of the surfaces tell.
pub(super) fn units(inner: &TriangleMesh, outer: &TriangleMesh) -> Option<Refusal> {
    let [endocardium, epicardium] = [inner, outer].map(length);
    let ratio = robust_length(inner) / robust_length(outer);
    let found = UNITS.into_iter().find_map(|(size, [large, small])| {
        match [ratio * size, ratio / size].map(|ratio| LENGTHS.contains(&ratio)) {
            [true, _] => Some((size, [large, small])),
            [_, true] => Some((size, [small, large])),
            _ => None,
        }
    });
    let (ratio, [inner, outer]) = found?;
    Some(Refusal(format!(
        "the endocardium is {endocardium:.3} long and the epicardium {epicardium:.3}, a factor near {ratio} too far apart: the endocardium seems to be in {inner}, the epicardium in {outer}; give both in one unit"
    )))
}

/// One surface in the place of both, each in the place of the other, or both apart.
fn places(inner: &TriangleMesh, outer: &TriangleMesh, trees: &Trees) -> Option<Refusal> {
    let points: Vec<Point> = inner.points.iter().map(|&x| Point::from(x)).collect();
    let [endocardium, epicardium] = [inner, outer].map(length);
    let distance = points.iter().map(|x| trees.epicardium.distance(*x)).fold(0.0, f64::max);
    if distance <= SAME * endocardium {
        return Some(Refusal(format!(
            "the endocardium and the epicardium are the same surface: no point of one is farther than {distance:.1e} from the other; give two surfaces"
        )));
    }
    let [[low, high], [least, most]] =
        [inner, outer].map(|of| bounds(of.points.iter().map(|&x| x.into())));
    let middle = points.iter().sum::<Point>() / points.len() as f64;
    let in_box = |x: &Point| (0..3).all(|i| (least[i]..=most[i]).contains(&x[i]));
    // Seen from the middle of the cavity.
    let is_behind = |x: &&Point| {
        let hits = trees.epicardium.hits(middle, *x - middle);
        hits.last().is_some_and(|way| *way < 1.0 - SAME)
    };
    let behind = points.iter().filter(is_behind).count();
    let of = points.len();
    let slack = 0.01 * endocardium;
    let encloses = (0..3).all(|i| low[i] - slack <= least[i] && most[i] <= high[i] + slack);
    if encloses && 2 * behind > of {
        return Some(Refusal(format!(
            "the epicardium, {epicardium:.3} long, lies inside of the endocardium, {endocardium:.3} long; give each in the place of the other"
        )));
    }
    if in_box(&middle) && behind as f64 <= APART * of as f64 {
        return None;
    }
    let count = points.iter().filter(|x| !in_box(x) || is_behind(x)).count();
    let shift = (low + high - least - most).norm() / 2.0;
    Some(Refusal(format!(
        "{count} of {of} points of the endocardium lie outside of the epicardium, and the middles of the two are {shift:.3} apart; give both in one frame of coordinates"
    )))
}

/// Several pieces without a common point.
fn pieces(surface: &'static str, of: &TriangleMesh) -> Option<Refusal> {
    let place = merged(&of.points, |_| 0.0);
    let cells: Vec<_> = of.cells.iter().map(|cell| cell.map(|node| place[node])).collect();
    let (pieces, [first, second], at) = parts(of, &cells)?;
    Some(Refusal(format!(
        "the {surface} has {pieces} pieces without a common point, the largest of {first} triangles and the next of {second} at {at}; remove the pieces that do not belong to it"
    )))
}

/// Several rims: beside the valves, triangles are missing.
fn holes(surface: &'static str, of: &TriangleMesh) -> Option<Refusal> {
    let (rims, [first, second], at) = parts(of, &rims(of))?;
    Some(Refusal(format!(
        "the {surface} has {rims} rims, the longest of {first} edges and the next of {second} at {at}, and no plane below the valves cuts a whole wall; close the holes, or give the plane of the base: a point and a normal"
    )))
}

/// Number of connected parts of triangles or edges, if there are several: how many the two largest have, and a point of the
/// second.
fn parts<const N: usize>(
    of: &TriangleMesh,
    links: &[[usize; N]],
) -> Option<(usize, [usize; 2], String)> {
    let mut parts = connected_cells(of.points.len(), links);
    parts.sort_by_key(|part| Reverse(part.len()));
    let [first, second, ..] = &parts[..] else { return None };
    let node = *second.as_flattened().iter().min()?;
    Some((parts.len(), [first.len(), second.len()], shown(of.points[node])))
}

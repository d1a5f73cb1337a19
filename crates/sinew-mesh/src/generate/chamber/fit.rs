//! The grid on the endocardium.

use super::axis::{Base, Section, frame, wall};
use super::outside::is_rim;
use super::size::Lengths;
use super::trees::{Point, Result, Trees};
use crate::generate::ventricle::Disk;
use crate::generate::wall::Sheet;
use crate::quality::Spread;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Start of the rays' origins along the axis, as a fraction of the way from the apex to the base; below, all rays
/// leave the same point.
pub(super) const POLE: f64 = 1.0 / 3.0;
/// Rows and columns of the table of points for arc lengths along the surface.
const ROWS: usize = 48;
const COLUMNS: usize = 64;
/// Ray coordinates of the cavity: `q` from 0 at the apex to 1 at the base, and an angle around the axis.
pub(super) struct Fit<'a> {
    trees: &'a Trees,
    pub base: Base,
    pole: Point,
    /// Unit direction from apex to base.
    up: Point,
    /// Direction of angle zero, perpendicular to the axis.
    towards: Point,
    /// `q` of the rays that leave the pole across the axis.
    equator: f64,
    /// Points of the surface, row by row from the apex.
    table: Vec<Vec<Point>>,
    /// Arc lengths along the surface from the apex \[length\], row by row.
    ways: Vec<[f64; COLUMNS]>,
    /// Mean way from the apex to the base \[length\].
    meridian: f64,
}

impl<'a> Fit<'a> {
    pub(super) fn new(trees: &'a Trees, base: Base, towards: Option<Point>) -> Result<Self> {
        let axis = base.centre - base.apex;
        let up = axis.normalize();
        let pole = Section::new(trees, base.apex + axis * POLE, up)?.centre;
        let radius = POLE * axis.norm();
        // Rows are spread evenly over a quarter of a circle and a straight line.
        let equator = FRAC_PI_2 * radius / (FRAC_PI_2 * radius + (base.centre - pole).norm());
        // One for all rows: a second choice could differ.
        let [towards, _] = frame(up, towards.map(|point| point - pole));
        let (table, ways) = (Vec::new(), Vec::new());
        let mut fit = Self { trees, base, pole, up, towards, equator, table, ways, meridian: 0.0 };
        for row in 0..=ROWS {
            let angles = (0..COLUMNS).map(|column| TAU * column as f64 / COLUMNS as f64);
            let points = angles.map(|angle| fit.point(row as f64 / ROWS as f64, angle));
            fit.table.push(points.collect::<Result<_>>()?);
        }
        fit.ways.push([0.0; COLUMNS]);
        for row in 1..=ROWS {
            let step = |k: usize| (fit.table[row][k] - fit.table[row - 1][k]).norm();
            fit.ways.push(std::array::from_fn(|k| fit.ways[row - 1][k] + step(k)));
        }
        fit.meridian = fit.ways[ROWS].iter().sum::<f64>() / COLUMNS as f64;
        Ok(fit)
    }

    fn point(&self, q: f64, angle: f64) -> Result<Point> {
        let (sin, cos) = angle.sin_cos();
        if q < self.equator {
            let [across, along] = frame(self.up, Some(self.towards));
            let (out, down) = (FRAC_PI_2 * q / self.equator).sin_cos();
            let direction = (across * cos + along * sin) * out - self.up * down;
            return wall(self.trees, self.pole, direction);
        }
        let way = (q - self.equator) / (1.0 - self.equator);
        let normal = self.up.lerp(&self.base.normal, way).normalize();
        let [across, along] = frame(normal, Some(self.towards));
        wall(self.trees, self.pole.lerp(&self.base.centre, way), across * cos + along * sin)
    }

    /// Lengths that sizes of cells follow from.
    pub(super) fn lengths(&self) -> Lengths {
        let perimeter = |row: &Vec<Point>| -> f64 {
            (0..COLUMNS).map(|k| (row[k] - row[(k + 1) % COLUMNS]).norm()).sum()
        };
        let around = self.table.iter().map(perimeter).fold(0.0, f64::max);
        Lengths { around, along: self.meridian, thickness: self.thickness() }
    }

    /// Median thickness across the axis in the upper half.
    fn thickness(&self) -> f64 {
        let mut ways = Vec::new();
        for row in &self.table[ROWS / 2..] {
            let middle = row.iter().sum::<Point>() / COLUMNS as f64;
            let outward = row.iter().map(|x| (*x, (x - middle).normalize()));
            ways.extend(outward.filter_map(|(x, way)| Some(self.trees.outside(x, way)?.0)));
        }
        Spread::of(ways).map_or(self.meridian / 10.0, |ways| ways.median)
    }

    /// The points of the endocardium under the nodes of the sheet.
    pub(super) fn inner(&self, sheet: &Sheet, disk: &Disk) -> Result<Vec<Point>> {
        let point = |at: &[f64; 3]| {
            let [x, y] = disk.place([at[0], at[1]]);
            let angle = y.atan2(x).rem_euclid(TAU);
            let q = if is_rim(at) { 1.0 } else { self.row(x.hypot(y), angle) };
            self.point(q, angle)
        };
        sheet.points.iter().map(point).collect()
    }

    /// The `q` at which a part of the way from apex to base is done.
    fn row(&self, part: f64, angle: f64) -> f64 {
        let column = angle / TAU * COLUMNS as f64;
        let (first, share) = (column as usize % COLUMNS, column.fract());
        let second = (first + 1) % COLUMNS;
        let done = |row: usize, column: usize| self.ways[row][column] / self.ways[ROWS][column];
        let way = |row: usize| (1.0 - share) * done(row, first) + share * done(row, second);
        let row = (0..ROWS - 1).take_while(|&row| way(row + 1) < part).count();
        let within = (part - way(row)) / (way(row + 1) - way(row));
        (row as f64 + within.clamp(0.0, 1.0)) / ROWS as f64
    }
}

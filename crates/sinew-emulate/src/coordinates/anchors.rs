//! Interpolation between solved states with their derivatives, and motions that go through them.

use crate::coordinates::{
    Anchor, CoordinateError, Motions, Result, all_terms, ensure, packed, require_count,
    require_finite, terms,
};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// Field over the parameters with given values, first and second derivatives at some places (anchors): interpolation by a Gaussian kernel
/// (gradient-enhanced kriging; Rasmussen & Williams 9.4).
///
/// The kernel is `exp(−½ ‖z − z′‖²)` of `z = B x`. Directions in which the interpolated fields curve more are longer: `Bᵀ B = C / (s² λ)`
/// with the Gram matrix C of their second derivatives, its largest eigenvalue λ, and a length s by the evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Packed", into = "Packed")]
pub struct Anchors {
    /// Places z.
    places: Vec<DVector<f64>>,
    /// B, from standardised parameters to z.
    map: DMatrix<f64>,
    /// Inverse of the covariances of values and derivatives by z, anchor by anchor.
    inverse: DMatrix<f64>,
    /// Inverse times these values and derivatives: weights of the covariances with them, a row for each.
    weights: DMatrix<f64>,
}

/// Variance on the diagonal relative to that of a value: rounding errors of states and of their derivatives by differences.
const NUGGET: f64 = 1e-10;
/// Least eigenvalue of C \[relative to the largest\]: nothing is that much straighter in one direction than in another.
const STRAIGHTEST: f64 = 1e-3;
/// Lengths s that are tried, in deviations of the parameters.
const LENGTHS: [f64; 7] = [0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6];
/// Length where the fields tell none, as those of a single anchor.
const LENGTH: f64 = 2.0;

impl Anchors {
    /// Anchors at standardised parameters, from fields that are given there: at each the value, the first derivatives and those by each two of
    /// the parameters. `curvature` is C.
    ///
    /// # Errors
    /// Numbers that are not finite, anchors that coincide.
    pub(crate) fn through(
        at: &[Vec<f64>],
        fields: &[Vec<Vec<f64>>],
        curvature: &DMatrix<f64>,
    ) -> Result<Self> {
        let apart = (1..at.len()).all(|i| !at[..i].contains(&at[i]));
        ensure(apart, CoordinateError::None("two anchors are at the same parameters"))?;
        let [root, back] = roots(curvature)?;
        let orders = orders(root.ncols());
        let fields: Vec<Vec<f64>> = fields.iter().flat_map(|given| turned(given, &back)).collect();
        fields.iter().try_for_each(|field| require_finite("states of anchors", field))?;
        let matrix = DMatrix::from_fn(fields.len(), fields[0].len(), |i, j| fields[i][j]);
        let products = &matrix * matrix.transpose();
        let factor = |row: usize, length: f64| {
            length.powi(orders[row % orders.len()].iter().sum::<usize>() as i32)
        };
        let fit = |length: f64| {
            let places = at.iter().map(|x| &root * DVector::from_column_slice(x) / length);
            let (places, map) = (places.collect::<Vec<_>>(), &root / length);
            let given = matrix.map_with_location(|i, _, value| factor(i, length) * value);
            let factored = factored(&places, root.ncols())?;
            let spread: f64 = factored.l_dirty().diagonal().iter().map(|l| 2.0 * l.ln()).sum();
            let (inverse, weights) = (factored.inverse(), factored.solve(&given));
            let scaled = products
                .map_with_location(|i, j, value| factor(i, length) * factor(j, length) * value);
            let fit = inverse.component_mul(&scaled).sum();
            let scale: f64 = (0..fields.len()).map(|row| 2.0 * factor(row, length).ln()).sum();
            let evidence = fields.len() as f64 * fit.ln() + spread - scale;
            // Fields of zero tell no length.
            let evidence = if evidence.is_finite() { evidence } else { (length - LENGTH).abs() };
            Some((evidence, Self { places, map, inverse, weights }))
        };
        let fits = LENGTHS.into_iter().filter_map(fit);
        let best = fits.min_by(|(a, _), (b, _)| a.total_cmp(b));
        Ok(best.ok_or(CoordinateError::None("anchors coincide"))?.1)
    }

    /// Standardised parameters of the anchors.
    pub fn parameters(&self) -> Vec<Vec<f64>> {
        let solver = self.map.clone().lu();
        let back = |place: &DVector<f64>| solver.solve(place).map(|x| x.as_slice().to_vec());
        self.places.iter().filter_map(back).collect()
    }

    /// Length of the field.
    pub fn length(&self) -> usize {
        self.weights.ncols()
    }

    /// Fields \[length\] at rows of standardised parameters, one after the other, or their changes along a direction for each row.
    ///
    /// # Errors
    /// Other parameters than those of the anchors, or none.
    pub fn at_parameters(&self, rows: &[f64], along: Option<&[f64]>) -> Result<Vec<f64>> {
        let count = self.map.ncols();
        ensure(!rows.is_empty(), CoordinateError::None("anchors need parameters"))?;
        require_count("entries of directions", along.unwrap_or(rows).len(), rows.len())?;
        let rows = rows.chunks(count.max(1)).enumerate().map(|(row, x)| {
            self.covariances(x, along.map(|along| &along[row * count..(row + 1) * count]))
        });
        let covariances = DMatrix::from_columns(&rows.collect::<Result<Vec<_>>>()?);
        Ok(self.weights.tr_mul(&covariances).as_slice().to_vec())
    }

    /// Variance of the interpolation at standardised parameters, relative to that far from all anchors: zero at them.
    ///
    /// # Errors
    /// As [`Anchors::at_parameters`].
    pub fn variance(&self, x: &[f64]) -> Result<f64> {
        let covariances = self.covariances(x, None)?;
        Ok((1.0 - covariances.dot(&(&self.inverse * &covariances))).max(0.0))
    }

    fn covariances(&self, x: &[f64], along: Option<&[f64]>) -> Result<DVector<f64>> {
        let count = self.map.ncols();
        require_count("parameters of anchors", x.len(), count)?;
        let orders = orders(count);
        let z = &self.map * DVector::from_column_slice(x);
        let none = vec![0; count];
        let rows = self.places.iter().flat_map(|place| {
            let between = &z - place;
            let (orders, none, map) = (&orders, &none, &self.map);
            (0..orders.len()).map(move |row| match along {
                None => covariance(&between, none, &orders[row]),
                Some(along) => {
                    let direction = map * DVector::from_column_slice(along);
                    let by = |p: usize| covariance(&between, &orders[1 + p], &orders[row]);
                    (0..count).map(|p| direction[p] * by(p)).sum()
                }
            })
        });
        Ok(DVector::from_iterator(self.inverse.nrows(), rows))
    }
}

/// Factor of the covariances of values and derivatives at some places; `None` where these are singular.
fn factored(places: &[DVector<f64>], parameters: usize) -> Option<Cholesky<f64, Dyn>> {
    let orders = orders(parameters);
    let rows = orders.len();
    let entry = |i: usize, j: usize| {
        let between = &places[i / rows] - &places[j / rows];
        let nugget = if i == j { NUGGET } else { 0.0 };
        covariance(&between, &orders[i % rows], &orders[j % rows]) + nugget
    };
    let count = places.len() * rows;
    Cholesky::new(DMatrix::from_fn(count, count, entry))
}

/// Orders in each parameter of the value, the first derivatives, and those by two parameters: those with the first, with the second and so on.
fn orders(parameters: usize) -> Vec<Vec<usize>> {
    let count = |by: &[usize], p: usize| by.iter().filter(|&&q| q == p).count();
    let pairs = (0..parameters).flat_map(|p| (p..parameters).map(move |q| vec![p, q]));
    let all = std::iter::once(vec![]).chain((0..parameters).map(|p| vec![p])).chain(pairs);
    all.map(|by: Vec<usize>| (0..parameters).map(|p| count(&by, p)).collect()).collect()
}

/// Covariance of two derivatives so far from each other: products of Hermite polynomials and the kernel.
fn covariance(between: &DVector<f64>, a: &[usize], b: &[usize]) -> f64 {
    let sign = if a.iter().sum::<usize>() % 2 == 1 { -1.0 } else { 1.0 };
    let parts = between.iter().zip(a.iter().zip(b));
    let product: f64 = parts.map(|(r, (a, b))| hermite(a + b, *r)).product();
    sign * product * (-0.5 * between.norm_squared()).exp()
}

/// Hermite polynomials of probability theory, `H_(n+1)(r) = r H_n(r) − n H_(n−1)(r)`.
fn hermite(order: usize, r: f64) -> f64 {
    let next = |(before, now): (f64, f64), n: usize| (now, r * now - n as f64 * before);
    (0..order).fold((0.0, 1.0), next).1
}

/// A root of the curvature relative to its largest eigenvalue, `Rᵀ R`, and its inverse; of the unit matrix where nothing curves.
fn roots(curvature: &DMatrix<f64>) -> Result<[DMatrix<f64>; 2]> {
    require_finite("second derivatives at anchors", curvature.as_slice())?;
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(curvature.clone());
    let largest = eigenvalues.max();
    let part = |value: f64| if largest > 0.0 { (value / largest).max(STRAIGHTEST) } else { 1.0 };
    let root = eigenvalues.map(|value| part(value).sqrt());
    let back = &eigenvectors * DMatrix::from_diagonal(&root.map(|value| 1.0 / value));
    Ok([DMatrix::from_diagonal(&root) * eigenvectors.transpose(), back])
}

/// Place of the product of two parameters among those of `count`, which are ordered as [`terms`] are.
fn product_of(p: usize, q: usize, count: usize) -> usize {
    let (low, high) = (p.min(q), p.max(q));
    low * count - low * (low + 1) / 2 + high
}

/// Value and derivatives by z from those by x, with `x = back z`.
fn turned(given: &[Vec<f64>], back: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let count = back.nrows();
    let second = |p: usize, q: usize| &given[1 + count + product_of(p, q, count)];
    let sum = |parts: &mut dyn Iterator<Item = (f64, &Vec<f64>)>| {
        let mut sum = vec![0.0; given[0].len()];
        parts.for_each(|(part, field)| {
            sum.iter_mut().zip(field).for_each(|(sum, value)| *sum += part * value);
        });
        sum
    };
    let mut all = vec![given[0].clone()];
    for i in 0..count {
        all.push(sum(&mut (0..count).map(|p| (back[(p, i)], &given[1 + p]))));
    }
    for i in 0..count {
        for j in i..count {
            let pairs = (0..count * count).map(|pq| (pq / count, pq % count));
            all.push(sum(&mut pairs.map(|(p, q)| (back[(p, i)] * back[(q, j)], second(p, q)))));
        }
    }
    all
}

/// Stored form of anchors: numbers as bytes, so that they come back the same.
#[derive(Clone, Serialize, Deserialize)]
struct Packed {
    parameters: usize,
    anchors: usize,
    length: usize,
    places: String,
    map: String,
    weights: String,
}

impl From<Anchors> for Packed {
    fn from(Anchors { places, map, weights, .. }: Anchors) -> Self {
        let all: Vec<f64> = places.iter().flat_map(|place| place.iter().copied()).collect();
        Self {
            parameters: map.ncols(),
            anchors: places.len(),
            length: weights.ncols(),
            places: packed::doubles(&all),
            map: packed::doubles(map.as_slice()),
            weights: packed::doubles(weights.as_slice()),
        }
    }
}

impl TryFrom<Packed> for Anchors {
    type Error = String;

    fn try_from(stored: Packed) -> Result<Self, String> {
        let (count, anchors) = (stored.parameters, stored.anchors);
        let places = packed::read_doubles(&stored.places, anchors * count)?;
        let map = packed::read_doubles(&stored.map, count * count)?;
        let chunks = places.chunks(count.max(1));
        let places: Vec<_> = chunks.map(DVector::from_column_slice).collect();
        let factored = factored(&places, count).ok_or("anchors of the outputs coincide")?;
        let (map, inverse) = (DMatrix::from_vec(count, count, map), factored.inverse());
        let weights = packed::read_doubles(&stored.weights, inverse.nrows() * stored.length)?;
        let weights = DMatrix::from_vec(inverse.nrows(), stored.length, weights);
        Ok(Self { places, map, inverse, weights })
    }
}

/// Deviations of the parameters over which the remainder at an anchor is differentiated: half of the digits of a second difference are left.
const STEP: f64 = 1e-3;

impl Motions {
    /// Displacements that go through all of these states with their first and second derivatives: [`Anchors`] interpolate the remainder of the
    /// Taylor expansion and are added after the motions. Rotations that the expansion extrapolates do not turn it.
    ///
    /// # Errors
    /// Another body than the motions', states at the same parameters.
    pub fn through(mut self, states: &[Anchor]) -> Result<Self> {
        let nodes = self.origin().len() / 3;
        let count = states.first().map_or(0, |state| state.at.len());
        let mut curvature = DMatrix::zeros(count, count);
        let mut fields = Vec::with_capacity(states.len());
        for state in states {
            require_count("parameters of an anchor", state.at.len(), count)?;
            require_count("changes at an anchor", state.changes.len(), 1 + all_terms(count))?;
            for change in &state.changes {
                require_count("entries of a change", change.len(), 3 * nodes)?;
            }
            curvature += curvature_of(&state.changes[1 + count..], count);
            fields.push(self.remainder(state)?);
        }
        let at: Vec<_> = states.iter().map(|state| state.at.clone()).collect();
        self.anchors = Some(Anchors::through(&at, &fields, &curvature)?.into());
        Ok(self)
    }

    /// Remainder of the displacement at a state, and its first and second derivatives \[length\].
    fn remainder(&self, state: &Anchor) -> Result<Vec<Vec<f64>>> {
        let count = state.at.len();
        let missing = |axes: &[usize], sign: f64| -> Result<Vec<f64>> {
            let mut away = vec![0.0; count];
            axes.iter().for_each(|&p| away[p] = sign * STEP);
            let mut target = state.changes[0].clone();
            for (change, term) in state.changes[1..].iter().zip(terms(&away)) {
                target.iter_mut().zip(change).for_each(|(u, change)| *u += term * change);
            }
            let at: Vec<f64> = state.at.iter().zip(&away).map(|(x, away)| x + away).collect();
            let expanded = self.expanded(&at)?;
            Ok(target.iter().zip(expanded).map(|(u, expanded)| u - expanded).collect())
        };
        let both = |axes: &[usize]| Ok([missing(axes, 1.0)?, missing(axes, -1.0)?]);
        let here = missing(&[], 0.0)?;
        let alone: Vec<[Vec<f64>; 2]> = (0..count).map(|p| both(&[p])).collect::<Result<_>>()?;
        let combined = |parts: &[(f64, &Vec<f64>)]| -> Vec<f64> {
            let sum = |i: usize| parts.iter().map(|(part, field)| part * field[i]).sum();
            (0..here.len()).map(sum).collect()
        };
        let mut all = vec![here.clone()];
        let half = 0.5 / STEP;
        all.extend(alone.iter().map(|[plus, minus]| combined(&[(half, plus), (-half, minus)])));
        let square = STEP.powi(-2);
        for p in 0..count {
            let [plus, minus] = &alone[p];
            all.push(combined(&[(square, plus), (square, minus), (-2.0 * square, &here)]));
            for q in p + 1..count {
                let ([a, b], [c, d]) = (both(&[p, q])?, &alone[q]);
                let half = 0.5 * square;
                let sums = [(half, &a), (half, &b), (2.0 * half, &here)];
                let less = [plus, minus, c, d].map(|field| (-half, field));
                all.push(combined(&[&sums[..], &less[..]].concat()));
            }
        }
        Ok(all)
    }
}

/// Gram matrix of second derivatives, from the coefficients of a Taylor polynomial.
fn curvature_of(products: &[Vec<f64>], count: usize) -> DMatrix<f64> {
    let second = |p: usize, q: usize| {
        let twice = if p == q { 2.0 } else { 1.0 };
        (twice, &products[product_of(p, q, count)])
    };
    DMatrix::from_fn(count, count, |p, q| {
        let product = |r: usize| {
            let ((a, by_p), (b, by_q)) = (second(p, r), second(q, r));
            a * b * by_p.iter().zip(by_q).map(|(x, y)| x * y).sum::<f64>()
        };
        (0..count).map(product).sum()
    })
}

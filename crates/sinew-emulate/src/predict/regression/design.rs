//! Designs of runs: which are left out together, and what they cannot tell.

use crate::sample::WIDTH;
use nalgebra::DMatrix;
use sinew_num::connected_components;

/// Groups of runs that are left out together.
pub(crate) type Groups = Vec<Vec<usize>>;

/// Distance of values of one level: rounding of a table \[standard deviations of a range\].
const SAME_LEVEL: f64 = 1e-6;
/// Distance of near twins over the spacing of runs that fill the box: of random runs 6 % are as near on a line, fewer in a box.
const NEAR: f64 = 0.03;
/// Values of a parameter that show a curve between them: three are met by a parabola, whatever lies between.
const FEWEST_LEVELS: usize = 4;
/// Part of a column, by its norm, that others leave where they determine it: effects of both are told apart by less than a percent.
const DETERMINED: f64 = 0.01;
/// Part of a column that is rounding.
const ROUNDING: f64 = 1e-8;

/// Runs to leave out in turn, by groups: each run alone; where at least half of the runs share values of a parameter, the runs of each
/// value but that parameter's ends, beyond which nothing is predicted; where at least half have near twins, the twins together.
pub(crate) fn partitions(points: &DMatrix<f64>) -> Vec<Groups> {
    let (runs, variables) = points.shape();
    let are_shared = |groups: &Groups| {
        let lengths = groups.iter().map(Vec::len).filter(|&length| length > 1);
        2 * lengths.sum::<usize>() >= runs
    };
    let inner = |d: usize| {
        let groups = levels(points, d);
        are_shared(&groups).then(|| groups.get(1..groups.len() - 1).unwrap_or_default().to_vec())
    };
    let spacing = WIDTH * (runs as f64).powf(-1.0 / variables as f64);
    // A row of many runs along a line is no cluster of twins.
    let twins = clusters(points, NEAR * spacing);
    let twins = Some(twins).filter(|groups| groups.len() > 2 && are_shared(groups));
    let shared = (0..variables).map(inner).chain([twins]).flatten();
    let alone = (0..runs).map(|run| vec![run]).collect();
    std::iter::once(alone).chain(shared.filter(|groups| !groups.is_empty())).collect()
}

/// Runs of each value of a parameter, in the order of the values.
pub(crate) fn levels(points: &DMatrix<f64>, parameter: usize) -> Groups {
    let mut levels = clusters(&points.columns(parameter, 1).into_owned(), SAME_LEVEL);
    levels.sort_by(|a, b| points[(a[0], parameter)].total_cmp(&points[(b[0], parameter)]));
    levels
}

/// Rows that neighbours within a distance connect.
fn clusters(points: &DMatrix<f64>, near: f64) -> Groups {
    let pairs = (0..points.nrows()).flat_map(|i| (0..i).map(move |j| [i, j]));
    let is_near = |[i, j]: &[usize; 2]| (points.row(*i) - points.row(*j)).norm() < near;
    connected_components(points.nrows(), pairs.filter(is_near))
}

/// Effects of parameters, by their names, that runs do not tell apart, with the runs to add.
pub(crate) fn doubts(points: &DMatrix<f64>, names: &[&str]) -> Vec<String> {
    let count = names.len();
    let column = |d: usize| points.columns(d, 1).into_owned();
    let of_levels = |d: usize| (d, levels(points, d).len());
    let few = (0..count).map(of_levels).filter(|(_, values)| *values < FEWEST_LEVELS);
    let few = few.map(|(d, values)| {
        let own = names[d];
        format!("{own} has {values} values only, and stated errors hold at these; add runs with {own} between")
    });
    let mut found: Vec<String> = few.collect();
    let follows = |&d: &usize| {
        let others = (0..count).filter(|&other| other != d);
        let terms = others.flat_map(|e| {
            let own = column(e);
            let square = own.component_mul(&own);
            [own, square]
        });
        left(terms, column(d)) < DETERMINED || (0..count).any(|e| e != d && rise(points, d, e))
    };
    if count > 1
        && let Some(d) = (0..count).find(follows)
    {
        let own = names[d];
        found.push(format!(
            "{own} follows from the other parameters in these runs, so that effects cannot be told apart; add runs with other {own} beside the same others"
        ));
    }
    for (d, e) in (0..count).flat_map(|d| (0..d).map(move |e| (e, d))) {
        let product = column(d).component_mul(&column(e));
        if left([column(d), column(e)].into_iter(), product) < DETERMINED {
            found.push(format!(
                "no runs tell how {} and {} act together; add runs in which both differ from their usual values",
                names[d], names[e]
            ));
        }
    }
    found
}

/// Whether one parameter rises or falls with another throughout.
fn rise(points: &DMatrix<f64>, one: usize, other: usize) -> bool {
    let pairs = (0..points.nrows()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let by = |(i, j): (usize, usize), d: usize| points[(i, d)] - points[(j, d)];
    let mut products = pairs.map(|pair| by(pair, one) * by(pair, other));
    let first = products.next().unwrap_or_default();
    products.all(|product| product * first > 0.0)
}

/// Part of a column, by its norm about its mean, that a constant and others leave.
fn left(others: impl Iterator<Item = DMatrix<f64>>, column: DMatrix<f64>) -> f64 {
    let constant = DMatrix::from_element(column.nrows(), 1, 1.0);
    let size = column.add_scalar(-column.mean()).norm();
    let columns: Vec<_> = std::iter::once(constant).chain(others).chain([column]).collect();
    if columns.len() > columns[0].nrows() {
        return 0.0;
    }
    let columns: Vec<_> = columns.iter().map(|of| of.column(0)).collect();
    let residuals = DMatrix::from_columns(&columns).qr().r().diagonal();
    residuals[residuals.len() - 1].abs() / size.max(ROUNDING)
}

/// Whether no column is a sum of others.
pub(super) fn are_independent(columns: &DMatrix<f64>) -> bool {
    let residuals = columns.clone().qr().r().diagonal();
    let mut pairs = residuals.iter().zip(columns.column_iter());
    columns.ncols() <= columns.nrows()
        && pairs.all(|(residual, column)| residual.abs() > ROUNDING * column.norm())
}

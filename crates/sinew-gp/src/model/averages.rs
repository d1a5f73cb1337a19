//! Many values as means over cells: what they say of the parameters and of u at the cost of a few.
//!
//! Within a cell far smaller than a lengthscale u is next to linear, so that the mean of its values tells nearly all that they
//! do. A mean is that of u over the cell's places, which points with the same mean and covariance stand for.

use crate::model::data::{Averages, Data, Group, Noise, Role};
use nalgebra::{DMatrix, DVector};

impl<const D: usize> Data<D> {
    /// Data with the values of each measured group in means over about `cells` cells, for tens of thousands of values and more:
    /// [`crate::Model::fit`] then learns the equation's parameters, u and the level of errors from all of them. A cell holds
    /// neighbouring values; the variance of its mean's error is that of one value over their number. What values
    /// differ by from a linear function in their cell tells the level of errors.
    ///
    /// Groups with fewer than four values for a cell, exact ones, and sums stay as they are. 150 cells suffice where u has no
    /// more than a wave or two along each axis; compare with twice as many.
    ///
    /// # Panics
    /// If there is no cell.
    ///
    /// ```
    /// use sinew_gp::{Data, Domain, Noise};
    ///
    /// let places = Domain::interval("x", [0.0, 1.0])?.sample(3000, 1)?;
    /// let data = Data::new().values(&places, &[0.1; 3000], Noise::Learned);
    /// assert_eq!(data.averaged(50).count(), 50);
    /// # Ok::<(), sinew_gp::GpError>(())
    /// ```
    pub fn averaged(&self, cells: usize) -> Self {
        assert!(cells > 0, "values are averaged over one cell at least");
        let average = |group: &Group<D>| {
            let many = group.values.len() >= 4 * (D + 1) * cells;
            let noisy = matches!(group.noise, Noise::Known(_) | Noise::Learned);
            let whole = group.points().len() == group.values.len()
                && group.points().iter().flatten().chain(&group.values).all(|v| v.is_finite());
            let plain = group.role == Role::Observed && group.legs.len() == 1 && noisy;
            match many && plain && whole && group.averages.is_none() {
                true => averaged(group, cells),
                false => group.clone(),
            }
        };
        Self { groups: self.groups.iter().map(average).collect(), ..self.clone() }
    }
}

/// Mean place of some points, and their covariance.
fn moments<const D: usize>(points: &[[f64; D]], cell: &[usize]) -> ([f64; D], DMatrix<f64>) {
    let count = cell.len() as f64;
    let mean: [f64; D] =
        std::array::from_fn(|d| cell.iter().map(|k| points[*k][d]).sum::<f64>() / count);
    let product = |i: usize, j: usize| {
        let each = cell.iter().map(|k| (points[*k][i] - mean[i]) * (points[*k][j] - mean[j]));
        each.sum::<f64>() / count
    };
    (mean, DMatrix::from_fn(D, D, product))
}

/// Cells of neighbours, halved across the axis along which the largest are widest.
fn cells<const D: usize>(points: &[[f64; D]], count: usize) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..points.len()).collect();
    let (_, whole) = moments(points, &all);
    // In units of the deviations of all points.
    let unit: [f64; D] = std::array::from_fn(|d| whole[(d, d)].max(f64::MIN_POSITIVE));
    let widest = |cell: &[usize]| {
        let (_, covariance) = moments(points, cell);
        let width = |d: usize| covariance[(d, d)] / unit[d];
        let axis = (0..D).max_by(|a, b| width(*a).total_cmp(&width(*b))).unwrap_or(0);
        (width(axis), axis)
    };
    let start = widest(&all);
    let mut found = vec![(start, all)];
    while found.len() < count {
        let splits = |cell: &[usize]| cell.len() >= 4 * (D + 2);
        let largest = (0..found.len())
            .filter(|k| splits(&found[*k].1))
            .max_by(|a, b| found[*a].0.0.total_cmp(&found[*b].0.0));
        let Some(largest) = largest else { break };
        let ((_, axis), mut lower) = found.swap_remove(largest);
        lower.sort_by(|a, b| points[*a][axis].total_cmp(&points[*b][axis]).then(a.cmp(b)));
        let upper = lower.split_off(lower.len() / 2);
        found.push((widest(&lower), lower));
        found.push((widest(&upper), upper));
    }
    found.into_iter().map(|(_, cell)| cell).collect()
}

/// Sum of squares of what a linear function leaves of the values of a cell, about their mean place and value.
fn left_by_plane<const D: usize>(
    group: &Group<D>,
    cell: &[usize],
    (mean, covariance): &([f64; D], DMatrix<f64>),
    y: f64,
) -> f64 {
    let off = |k: &usize| group.values[*k] - y;
    let right = DVector::from_fn(D, |d, _| {
        cell.iter().map(|k| (group.points()[*k][d] - mean[d]) * off(k)).sum::<f64>()
    });
    let total: f64 = cell.iter().map(|k| off(k).powi(2)).sum();
    // Places on one line, or one place, have no factor.
    let factor = (covariance * cell.len() as f64).cholesky();
    (total - factor.map_or(0.0, |factor| factor.solve(&right).dot(&right))).max(0.0)
}

fn averaged<const D: usize>(group: &Group<D>, count: usize) -> Group<D> {
    let cells = cells(group.points(), count);
    let (mut values, mut counts, mut squares) = (Vec::new(), Vec::new(), 0.0);
    // Two points along each principal axis of a cell.
    let mut points: Vec<Vec<[f64; D]>> = vec![Vec::new(); 2 * D];
    for cell in &cells {
        let moments = moments(group.points(), cell);
        let y = cell.iter().map(|k| group.values[*k]).sum::<f64>() / cell.len() as f64;
        squares += left_by_plane(group, cell, &moments, y);
        let (mean, covariance) = moments;
        values.push(y);
        counts.push(cell.len() as f64);
        let eigen = covariance.symmetric_eigen();
        for (number, list) in points.iter_mut().enumerate() {
            let (axis, sign) = (number / 2, if number % 2 == 0 { 1.0 } else { -1.0 });
            let length = (D as f64 * eigen.eigenvalues[axis].max(0.0)).sqrt();
            let step = |d: usize| sign * length * eigen.eigenvectors[(d, axis)];
            list.push(std::array::from_fn(|d| mean[d] + step(d)));
        }
    }
    let freedom = (group.values.len() - cells.len() * (D + 1)) as f64;
    let legs = points.into_iter().map(|points| (0.5 / D as f64, points)).collect();
    let places = group.points().into();
    let averages = Some(Averages { places, counts, squares, freedom });
    Group { legs, values, averages, ..group.clone() }
}

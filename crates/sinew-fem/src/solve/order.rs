//! An order of samples in which neighbours follow each other.

/// Nearest-neighbour order of parameter sets, from the first one; distances are in the logarithms of positive entries.
pub fn neighbours(thetas: &[Vec<f64>]) -> Vec<usize> {
    nearest_neighbour_path(&log_coordinates(thetas))
}

/// Entries of θ as coordinates: the logarithm where a column is positive, scaled to [0, 1].
fn log_coordinates(thetas: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let width = thetas.iter().map(Vec::len).max().unwrap_or(0);
    let mut coordinates = vec![vec![0.0; width]; thetas.len()];
    for column in 0..width {
        let entry = |row: &Vec<f64>| row.get(column).copied().unwrap_or(f64::NAN);
        let positive = thetas.iter().all(|row| entry(row) > 0.0);
        let value = |row: &Vec<f64>| if positive { entry(row).ln() } else { entry(row) };
        let finite = || thetas.iter().map(value).filter(|x| x.is_finite());
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        let range = if most > least { most - least } else { 1.0 };
        for (row, theta) in coordinates.iter_mut().zip(thetas) {
            let x = (value(theta) - least) / range;
            // Samples without a sensible value are refused later; they need a place until then.
            row[column] = if x.is_finite() { x } else { 0.0 };
        }
    }
    coordinates
}

/// Starts at the first point and goes on to the nearest unvisited one, the first of equals.
fn nearest_neighbour_path(points: &[Vec<f64>]) -> Vec<usize> {
    let mut left: Vec<_> = (0..points.len()).collect();
    let mut path = Vec::with_capacity(points.len());
    let mut current = 0;
    loop {
        let distance = |&index: &usize| -> f64 {
            points[current].iter().zip(&points[index]).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let distances = left.iter().map(distance).enumerate();
        let Some((place, _)) = distances.min_by(|a, b| a.1.total_cmp(&b.1)) else { return path };
        current = left.remove(place);
        path.push(current);
    }
}

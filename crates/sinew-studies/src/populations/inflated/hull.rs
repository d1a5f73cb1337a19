//! Volumes of convex hulls.

use nalgebra::Vector3;

/// Volume of the convex hull of points, which the thesis calls LVV where they are those of an endocardium \[length³\].
pub(super) fn hull_volume(points: &[[f64; 3]]) -> f64 {
    let points: Vec<Vector3<f64>> = points.iter().map(|x| Vector3::from(*x)).collect();
    let six = |[a, b, c]: [usize; 3], d: usize| {
        let [b, c, d] = [b, c, d].map(|k| points[k] - points[a]);
        b.cross(&c).dot(&d)
    };
    // A tetrahedron to begin with; its faces turn outwards.
    let most = |size: &dyn Fn(usize) -> f64| {
        (0..points.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or_default()
    };
    let from = |k: usize| points[k] - points[0];
    let b = most(&|k| from(k).norm());
    let c = most(&|k| from(b).cross(&from(k)).norm());
    let d = most(&|k| six([0, b, c], k).abs());
    let (b, c) = if six([0, b, c], d) > 0.0 { (c, b) } else { (b, c) };
    let mut faces = vec![[0, b, c], [0, d, b], [b, d, c], [c, d, 0]];
    let rounding = FLAT * six([0, b, c], d).abs();
    for point in 0..points.len() {
        let (seen, kept) = faces.into_iter().partition(|face| six(*face, point) > rounding);
        let seen: Vec<[usize; 3]> = seen;
        let edges: Vec<_> =
            seen.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        let horizon = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a]));
        faces = kept;
        faces.extend(horizon.map(|[a, b]| [*a, *b, point]));
    }
    faces.into_iter().map(|face| -six(face, 0) / 6.0).sum()
}

/// A point this far above a face is on it [relative to the volume to begin with]: rounding of a product of three differences.
const FLAT: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_have_the_volumes_of_a_box_and_of_a_ball() {
        // Many of the grid's points are on a face or an edge of the box.
        let grid = (0..125).map(|k| [k % 5, k / 5 % 5, k / 25].map(|i| f64::from(i) / 4.0));
        let turned = |[x, y, z]: [f64; 3]| [0.6 * x - 0.8 * y + 7.0, 0.8 * x + 0.6 * y, 3.0 * z];
        let grid: Vec<_> = grid.map(turned).collect();
        assert!((hull_volume(&grid) - 3.0).abs() < 1e-12); // rounding
        // Points of a spiral on a sphere; a hull of n of them lacks about 5.5 / n of its volume.
        let spiral = |k: u32| {
            let (z, angle) = (1.0 - (2.0 * f64::from(k) + 1.0) / 500.0, 2.399963 * f64::from(k));
            let r = (1.0 - z * z).sqrt();
            [r * angle.cos(), r * angle.sin(), z]
        };
        let ball = hull_volume(&(0..500).map(spiral).collect::<Vec<_>>());
        let missing = 1.0 - ball / (4.0 / 3.0 * std::f64::consts::PI);
        assert!((0.005..0.02).contains(&missing), "{missing}");
    }
}

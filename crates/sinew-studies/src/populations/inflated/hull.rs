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

//! Deformed surfaces, coloured by error, in orthographic projection.

use std::collections::HashSet;
use std::fmt::Write;

use super::colours::{hex, viridis};
use super::format::{digits, escape, two_digits};
use super::{SurfaceCase, SurfaceCases};

/// Rotation of the view about the vertical axis and above the horizon \[degrees\].
const VIEW: (f64, f64) = (24.0, 18.0);
/// Width of a drawing, margin around it and smallest height \[px\].
const WIDTH: f64 = 470.0;
const MARGIN: f64 = 14.0;
const SCALE_BAR_ROOM: f64 = 26.0;
/// Colours span this many decades below the largest error; smaller errors share the
/// lowest colour, or the clamped nodes would use up the scale.
const DECADES: f64 = 3.0;
/// Steps of the colour bar.
const BAR_STEPS: u32 = 100;
/// Edges between faces that meet at a larger angle than this outline a shape \[degrees\].
const FEATURE_ANGLE: f64 = 30.0;

/// All cases of a scene with one projection and one colour scale, so that they can be
/// compared: a colour bar, then one figure per case. Empty without cases.
pub(super) fn render(surfaces: &SurfaceCases) -> String {
    let Some(colours) = ColourScale::of(surfaces.cases()) else {
        return String::new();
    };
    let camera = Camera::around(surfaces);
    let outline = outline(surfaces.triangles(), surfaces.reference());
    let mut html = colours.bar();
    html.push_str(r#"<div class="grid2">"#);
    for case in surfaces.cases() {
        let largest = case.err_u_mm.iter().copied().fold(0.0, f32::max);
        let _ = write!(
            html,
            "<figure><figcaption><b class=\"m-{}\">{}</b> · {} · largest error {} mm</figcaption>{}</figure>",
            case.method.key(),
            case.method.label(),
            escape(&case.title),
            two_digits(f64::from(largest)),
            draw(surfaces, case, &camera, &colours, &outline)
        );
    }
    html.push_str("</div>");
    html
}

/// Orthographic view that shows the reference and all deformed shapes.
struct Camera {
    /// Smallest projected coordinates \[mm\].
    low: [f64; 2],
    high: [f64; 2],
    /// Pixels per millimetre.
    scale: f64,
}

impl Camera {
    fn around(surfaces: &SurfaceCases) -> Self {
        let deformed = surfaces.cases().iter().flat_map(|case| &case.deformed);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in surfaces.reference().iter().chain(deformed) {
            let seen = project(*point);
            for axis in 0..2 {
                low[axis] = low[axis].min(seen[axis]);
                high[axis] = high[axis].max(seen[axis]);
            }
        }
        let width = (high[0] - low[0]).max(1e-3 * (high[1] - low[1])).max(1e-12);
        let scale = (WIDTH - 2.0 * MARGIN) / width;
        // A tall scene is made smaller so that it is not higher than wide.
        let tall = scale * (high[1] - low[1]) / (WIDTH - 2.0 * MARGIN);
        let scale = scale / tall.max(1.0);
        Self { low, high, scale }
    }

    fn height(&self) -> f64 {
        self.scale * (self.high[1] - self.low[1]) + 2.0 * MARGIN + SCALE_BAR_ROOM
    }

    fn pixel(&self, point: [f32; 3]) -> [f64; 2] {
        let [right, up, _] = project(point);
        [MARGIN + self.scale * (right - self.low[0]), MARGIN + self.scale * (self.high[1] - up)]
    }
}

/// Coordinates to the right, upward and towards the viewer \[mm\]; z is up.
fn project(point: [f32; 3]) -> [f64; 3] {
    let (turn, lift) = (VIEW.0.to_radians(), VIEW.1.to_radians());
    let [x, y, z] = point.map(f64::from);
    let right = x * turn.cos() + y * turn.sin();
    let away = -x * turn.sin() + y * turn.cos();
    [right, z * lift.cos() + away * lift.sin(), z * lift.sin() - away * lift.cos()]
}

/// Painter's algorithm: the farthest triangle first, hidden sides of a closed body left out.
fn draw(
    surfaces: &SurfaceCases,
    case: &SurfaceCase,
    camera: &Camera,
    colours: &ColourScale,
    outline: &[[usize; 2]],
) -> String {
    let height = camera.height();
    let mut svg = format!(
        r#"<svg class="shape" viewBox="0 0 {WIDTH} {height:.0}" role="img" aria-label="Deformed surface, {}">"#,
        escape(&case.title)
    );
    let path = edge_path(outline.iter(), surfaces.reference(), camera);
    let _ = write!(svg, r#"<path class="ghost" d="{path}"/><g class="mesh">"#);
    let depth = |triangle: &[usize; 3]| -> f64 {
        triangle.iter().map(|&node| project(case.deformed[node])[2]).sum()
    };
    let mut order: Vec<&[usize; 3]> = surfaces.triangles().iter().collect();
    let outward = outward_sign(surfaces.triangles(), surfaces.reference());
    if let Some(sign) = outward {
        order.retain(|triangle| {
            let normal = normal(triangle.map(|node| project(case.deformed[node])));
            sign * normal[2] > 0.0
        });
    }
    let visible: HashSet<[usize; 2]> = order.iter().flat_map(|triangle| edges(triangle)).collect();
    order.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    for triangle in order {
        let [a, b, c] = triangle.map(|node| camera.pixel(case.deformed[node]));
        let error = triangle.iter().map(|&node| f64::from(case.err_u_mm[node])).sum::<f64>() / 3.0;
        let _ = write!(
            svg,
            r#"<path color="{}" d="M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}z"/>"#,
            colours.colour(error),
            a[0],
            a[1],
            b[0],
            b[1],
            c[0],
            c[1]
        );
    }
    svg.push_str("</g>");
    // Without a known outside, hidden edges cannot be told from visible ones.
    if outward.is_some() {
        let seen = outline.iter().filter(|edge| visible.contains(*edge));
        let path = edge_path(seen, &case.deformed, camera);
        let _ = write!(svg, r#"<path class="edge" d="{path}"/>"#);
    }
    push_scale_bar(&mut svg, camera);
    svg.push_str("</svg>");
    svg
}

fn edge_path<'a>(
    edges: impl Iterator<Item = &'a [usize; 2]>,
    points: &[[f32; 3]],
    camera: &Camera,
) -> String {
    edges.fold(String::new(), |mut path, edge| {
        let [a, b] = edge.map(|node| camera.pixel(points[node]));
        let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", a[0], a[1], b[0], b[1]);
        path
    })
}

/// The edges of a triangle, lower node first.
fn edges(&[a, b, c]: &[usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
}

/// A bar of 1, 2 or 5 times a power of ten, about a fifth of the width.
fn push_scale_bar(svg: &mut String, camera: &Camera) {
    let wanted = 0.2 * (WIDTH - 2.0 * MARGIN) / camera.scale;
    let power = 10f64.powf(wanted.log10().floor());
    let length = [5.0, 2.0, 1.0]
        .map(|multiple| multiple * power)
        .into_iter()
        .find(|&length| length <= wanted)
        .unwrap_or(power);
    let (y, pixels) = (camera.height() - 9.0, camera.scale * length);
    let _ = write!(
        svg,
        r#"<path class="axis" d="M{MARGIN} {:.1}v6h{pixels:.1}v-6"/><text class="tick" x="{:.1}" y="{:.1}">{} mm</text>"#,
        y - 6.0,
        MARGIN + pixels + 6.0,
        y,
        digits(length, 1)
    );
}

/// Logarithmic colour scale below the largest error of all cases.
struct ColourScale {
    largest: f64,
}

impl ColourScale {
    fn of(cases: &[SurfaceCase]) -> Option<Self> {
        let errors = cases.iter().flat_map(|case| &case.err_u_mm);
        let largest = errors.copied().fold(0.0, f32::max);
        (!cases.is_empty()).then(|| Self { largest: f64::from(largest).max(f64::MIN_POSITIVE) })
    }

    fn colour(&self, error: f64) -> String {
        let position = 1.0 + (error / self.largest).log10() / DECADES;
        hex(viridis(position))
    }

    fn bar(&self) -> String {
        let mut svg = String::from(
            r#"<svg class="bar" viewBox="0 0 480 40" role="img" aria-label="Colour bar">"#,
        );
        // Steps instead of a gradient, whose identifier would repeat in every scene.
        for step in 0..BAR_STEPS {
            let position = f64::from(step) / f64::from(BAR_STEPS - 1);
            let x = 40.0 + 400.0 * f64::from(step) / f64::from(BAR_STEPS);
            let _ = write!(
                svg,
                r#"<path fill="{}" d="M{x:.1} 4H440v12H{x:.1}z"/>"#,
                hex(viridis(position))
            );
        }
        for decade in 0..=DECADES as i32 {
            let x = 40.0 + 400.0 * f64::from(decade) / DECADES;
            let value = self.largest * 10f64.powf(f64::from(decade) - DECADES);
            let sign = if decade == 0 { "≤ " } else { "" };
            let unit = if decade == DECADES as i32 { " mm" } else { "" };
            let _ = write!(
                svg,
                r#"<path class="axis" d="M{x:.1} 16v5"/><text class="tick" x="{x:.1}" y="34" text-anchor="middle">{sign}{}{unit}</text>"#,
                two_digits(value)
            );
        }
        svg.push_str("</svg>");
        svg
    }
}

/// Edges of one triangle only, and edges where faces meet at an angle.
fn outline(triangles: &[[usize; 3]], points: &[[f32; 3]]) -> Vec<[usize; 2]> {
    let mut faces: Vec<([usize; 2], [f64; 3])> = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let normal = unit_normal(triangle.map(|node| points[node].map(f64::from)));
        faces.extend(edges(triangle).map(|edge| (edge, normal)));
    }
    faces.sort_by_key(|face| face.0);
    let flat = FEATURE_ANGLE.to_radians().cos();
    faces
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|faces| match faces {
            // Orientation of the faces may differ, so the sign of the cosine is not used.
            [(_, a), (_, b)] => (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).abs() < flat,
            _ => true,
        })
        .map(|faces| faces[0].0)
        .collect()
}

fn unit_normal(corners: [[f64; 3]; 3]) -> [f64; 3] {
    let normal = normal(corners);
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    normal.map(|x| x / length.max(f64::MIN_POSITIVE))
}

fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// 1 if all normals of a closed surface point outward, −1 if all point inward, `None`
/// if the surface is open or its triangles disagree.
fn outward_sign(triangles: &[[usize; 3]], points: &[[f32; 3]]) -> Option<f64> {
    let mut edges: Vec<[usize; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let twice = edges.windows(2).any(|pair| pair[0] == pair[1]);
    let closed = edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok());
    let volume: f64 = triangles
        .iter()
        .map(|triangle| {
            let corners = triangle.map(|node| points[node].map(f64::from));
            let normal = normal(corners);
            (0..3).map(|axis| corners[0][axis] * normal[axis]).sum::<f64>()
        })
        .sum();
    (closed && !twice).then(|| volume.signum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_outlined_by_its_twelve_edges() {
        let points: Vec<[f32; 3]> =
            (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32)).collect();
        let faces =
            [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles: Vec<[usize; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [c, d, a]]).collect();
        assert_eq!(outline(&triangles, &points).len(), 12);
    }

    #[test]
    fn the_outside_of_a_tetrahedron_is_known_if_its_faces_agree() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert_eq!(outward_sign(&faces, &points), Some(1.0));
        assert_eq!(outward_sign(&faces[1..], &points), None);
        assert_eq!(outward_sign(&faces.map(|[a, b, c]| [a, c, b]), &points), Some(-1.0));
        faces[0].swap(0, 1);
        assert_eq!(outward_sign(&faces, &points), None);
    }

    #[test]
    fn the_view_looks_from_the_front_and_above() {
        let [right, up, near] = project([1.0, 0.0, 0.0]);
        assert!(right > 0.8 && up.abs() < 0.2 && near > 0.0);
        assert!(project([0.0, 0.0, 1.0])[1] > 0.9);
        assert!(project([0.0, 1.0, 0.0])[2] < 0.0);
    }

    #[test]
    fn colours_are_clamped() {
        let scale = ColourScale { largest: 0.1 };
        assert_eq!(scale.colour(0.1), "#fde725");
        assert_eq!(scale.colour(0.0), "#440154");
        assert_eq!(scale.colour(1e-9), "#440154");
        assert_eq!(scale.colour(f64::NAN), "#440154");
    }
}

//! A body to be turned, moved and coloured in a browser, as data and as a page of its own.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;

const SCRIPT: &str = include_str!("viewer/viewer.js");
pub(crate) const STYLE: &str = include_str!("viewer/viewer.css");

/// Surface of a body with what moves and colours it: an emulator with a slider for every parameter, or a list of cases.
///
/// ```
/// use sinew_report::{Packed, Viewer, ViewerCase};
///
/// let viewer = Viewer {
///     title: "A triangle".into(),
///     length: "mm".into(),
///     points: Packed::f32([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
///     triangles: Packed::u32([0, 1, 2]),
///     cases: vec![ViewerCase {
///         title: "as it is".into(),
///         displacement: Packed::f32([0.0; 9]),
///         values: Packed::f32([0.0, 0.5, 1.0]),
///     }],
///     ..Viewer::default()
/// };
/// assert!(viewer.to_html().contains("A triangle"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Viewer {
    /// Title.
    pub title: String,
    /// Subject, in a line.
    pub about: String,
    /// Unit of lengths.
    pub length: String,
    /// Positions of the surface's nodes in the reference configuration \[length\], `f32`, three for each.
    pub points: Packed,
    /// Triangles over the nodes, `u32`, counterclockwise seen from outside.
    pub triangles: Packed,
    /// Fibres.
    pub strokes: Option<LineSegments>,
    /// Quantities that the surface may be coloured by.
    pub quantities: Vec<Quantity>,
    /// Emulator that moves the surface.
    pub emulator: Option<ViewerEmulator>,
    /// Cases to choose from, where there is no emulator.
    pub cases: Vec<ViewerCase>,
    /// Facts in names and values, such as errors that were measured.
    pub facts: Vec<(String, String)>,
    /// Notes to be read with the numbers.
    pub notes: Vec<String>,
}

/// Short lines that lie in triangles and move with them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LineSegments {
    /// Triangle of each, `u32`.
    pub triangles: Packed,
    /// Half of each along the first and the last side from the triangle's first corner \[sides\], `f32`, two for each.
    pub along: Packed,
}

/// Values at the nodes, and how they are coloured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Quantity {
    /// Name.
    pub name: String,
    /// Unit; `"1"` for none.
    pub unit: String,
    /// Source of its values.
    pub source: Source,
    /// Values of the first and the last colour.
    pub scale: [f64; 2],
    /// Whether colours are even in the logarithm.
    pub logarithmic: bool,
    /// The values, where they are a regression of their own.
    pub model: Option<Model>,
}

/// Source of a quantity's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Lengths of the displacements.
    #[default]
    Displacement,
    /// A regression of its own over θ.
    Model,
    /// Logarithms of errors relative to their mean: a regression of its own over θ, times the emulator's error.
    Error,
    /// Values of each case.
    Case,
}

/// Regression `mean + Σ_k c_k mode_k` with `c = φ(x) W`, as `sinew-emulate` defines it (`RegressionParts`).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Model {
    /// Mean, `f64`.
    pub mean: Packed,
    /// Modes, each as long as the mean.
    pub modes: Vec<PackedRow>,
    /// Lengths of the kernels, set after set.
    pub lengths: Vec<f64>,
    /// Points of the kernels, `f64`, row by row.
    pub points: Packed,
    /// Exponents of the monomials.
    pub exponents: Vec<Vec<i32>>,
    /// Weights, for every mode a row of one number per function.
    pub weights: Vec<PackedRow>,
}

/// Emulator of a body's surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ViewerEmulator {
    /// Parameters θ, in their order.
    pub parameters: Vec<Slider>,
    /// Displacement of the nodes \[length\], three components for each.
    pub displacement: Model,
    /// Natural logarithms of the mean and of the largest nodal error \[length\], or that of the half-width of a 95 % interval of its root mean square.
    pub error: Option<Model>,
    /// Line about the error that this one leaves out, that of the mesh.
    pub mesh: String,
    /// Cavities.
    pub cavities: Vec<ViewerCavity>,
    /// Unit of volumes.
    pub volume: String,
    /// One length³ in that unit.
    pub volume_scale: f64,
}

/// A parameter of θ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Slider {
    /// Name.
    pub name: String,
    /// Unit that it is shown in.
    pub unit: String,
    /// Size of the unit in the unit of θ.
    pub size: f64,
    /// Range in the unit of θ.
    pub range: [f64; 2],
    /// Whether its scale is logarithmic.
    pub logarithmic: bool,
    /// Whether it is a pressure in a cavity.
    pub pressure: bool,
}

/// A cavity of the body.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ViewerCavity {
    /// Name.
    pub name: String,
    /// Connected surfaces with the fields of `CavityPart` of `sinew-energy`; `triangles` is [`Packed`], of `u32`.
    pub parts: Vec<serde_json::Value>,
    /// Parameter that is the pressure in it.
    pub pressure: Option<usize>,
    /// Smallest and largest volume over the ranges of θ, in the unit of volumes.
    pub range: [f64; 2],
}

/// A displacement with values.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ViewerCase {
    /// Title.
    pub title: String,
    /// Displacement of the nodes \[length\], `f32`, three components for each.
    pub displacement: Packed,
    /// Values at the nodes, `f32`; NaN for none.
    pub values: Packed,
}

impl Viewer {
    /// The page: one file that loads nothing from outside.
    pub fn to_html(&self) -> String {
        page(&self.title, "viewer-page", [STYLE], &self.embedded(), true).into_string()
    }

    /// The element that the script turns into a view; the script stands once on a page, after all of them.
    pub(crate) fn embedded(&self) -> Markup {
        // A `</script>` in the data would end the script element.
        let data = serde_json::to_string(self).unwrap_or_default().replace('<', "\\u003c");
        html! { div.viewer { script type="application/json" { (PreEscaped(data)) } } }
    }
}

/// A page of one file, with the script where something is to be turned.
pub(crate) fn page<const N: usize>(
    title: &str,
    class: &str,
    styles: [&str; N],
    main: &Markup,
    turned: bool,
) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { (title) }
                style { @for style in styles { (PreEscaped(style)) } }
            }
            body class=(class) {
                main { (main) }
                @if turned { script { (PreEscaped(SCRIPT)) } }
            }
        }
    }
}

/// An array of numbers: little-endian bytes in base64, which a browser reads at once and without rounding.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Packed(String);

impl Packed {
    /// Numbers of 32 bits.
    pub fn f32(values: impl IntoIterator<Item = f32>) -> Self {
        Self::of(values.into_iter().map(f32::to_le_bytes))
    }

    /// Numbers of 64 bits.
    pub fn f64(values: impl IntoIterator<Item = f64>) -> Self {
        Self::of(values.into_iter().map(f64::to_le_bytes))
    }

    /// Indices.
    pub fn u32(values: impl IntoIterator<Item = u32>) -> Self {
        Self::of(values.into_iter().map(u32::to_le_bytes))
    }

    fn of<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> Self {
        let bytes: Vec<u8> = values.flatten().collect();
        Self(STANDARD.encode(bytes))
    }
}

/// Numbers rounded to multiples of a step: integers of as many bytes as they need, the lowest byte first, each raised by the largest one.
///
/// ```
/// let row = sinew_report::PackedRow::new(&[0.5, -1.0], 0.1, 4);
/// assert!(row.values(2).iter().zip([0.5, -1.0]).all(|(rounded, x)| (rounded - x).abs() <= 0.05));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PackedRow {
    step: f64,
    integers: Packed,
}

/// Largest integer of so many bytes, of which one bit is the sign; twice as much is still exact in 64 bits.
fn half(bytes: usize) -> f64 {
    (0.5 * 256f64.powi(bytes as i32)).min(2f64.powi(52)) - 1.0
}

impl PackedRow {
    /// Rounds numbers to multiples of about `step`, with at most so many bytes for each.
    pub fn new(row: &[f64], step: f64, most_bytes: usize) -> Self {
        let largest = row.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let enough = |bytes: &usize| half(*bytes) * step >= largest;
        let bytes = (1..most_bytes).find(enough).unwrap_or(most_bytes);
        let step = (largest / half(bytes)).max(f64::MIN_POSITIVE);
        let integers = row.iter().map(|x| ((x / step).round() + half(bytes)) as u64);
        let all: Vec<u8> = integers.flat_map(|x| x.to_le_bytes().into_iter().take(bytes)).collect();
        Self { step, integers: Packed(STANDARD.encode(all)) }
    }

    /// Rounded numbers, `count` of them, as a page reads them.
    pub fn values(&self, count: usize) -> Vec<f64> {
        let all = STANDARD.decode(&self.integers.0).unwrap_or_default();
        let bytes = all.len() / count.max(1);
        let whole = |x: &[u8]| x.iter().rev().fold(0.0, |sum, byte| 256.0 * sum + f64::from(*byte));
        all.chunks(bytes.max(1)).map(|x| (whole(x) - half(bytes)) * self.step).collect()
    }
}

//! Deformed surfaces coloured by a value, to be turned by the reader.

use crate::Surfaces;
use crate::format::digits;
use crate::viewer::{Packed, Quantity, Source, Viewer, ViewerCase};
use maud::{Markup, html};

/// Colours span this many decades below the largest value; smaller values share the lowest colour, or clamped nodes
/// would use up the scale.
const DECADES: i32 = 3;

/// Whether there is something to be turned, which the page's script draws.
pub(super) fn is_drawn(surfaces: &Surfaces) -> bool {
    !surfaces.cases.is_empty() && !surfaces.reference.is_empty()
}

/// All cases with one view and one scale of colours, so that they can be compared.
pub(super) fn surfaces(surfaces: &Surfaces) -> Markup {
    let values = surfaces.cases.iter().flat_map(|case| case.values.iter().flatten());
    let end = surfaces.scale().unwrap_or(0.0);
    let above = values.clone().filter(|value| f64::from(**value) > end).count();
    let above = 100.0 * above as f64 / values.count().max(1) as f64;
    html! { @if is_drawn(surfaces) {
        h3 { (surfaces.quantity) }
        p.note {
            "Deformed shapes to scale, coloured on one " (if surfaces.linear { "linear" } else { "logarithmic" })
            " scale for all; lines: the body at rest; grey: no value."
            @if above > 0.0 {
                " The scale ends where nearly all values lie below: " (digits(above, 2)) " % are larger and have the last colour."
            }
        }
        (viewer(surfaces, end).embedded())
    } }
}

fn viewer(surfaces: &Surfaces, end: f64) -> Viewer {
    let case = |case: &crate::SurfaceCase| {
        let largest = case.values.iter().flatten().copied().fold(0.0, f32::max);
        let (deformed, rest) = (case.deformed.as_flattened(), surfaces.reference.as_flattened());
        let unit = &surfaces.unit;
        ViewerCase {
            title: format!(
                "{}, {}, largest {} {unit}",
                case.method,
                case.title,
                digits(largest.into(), 2)
            ),
            displacement: Packed::f32(deformed.iter().zip(rest).map(|(x, at)| x - at)),
            values: Packed::f32(case.values.iter().map(|value| value.unwrap_or(f32::NAN))),
        }
    };
    let quantity = Quantity {
        name: surfaces.quantity.clone(),
        unit: surfaces.unit.clone(),
        source: Source::Case,
        scale: [if surfaces.linear { 0.0 } else { end * 10f64.powi(-DECADES) }, end],
        logarithmic: !surfaces.linear && end > 0.0,
        model: None,
    };
    Viewer {
        length: surfaces.length.clone(),
        points: Packed::f32(surfaces.reference.as_flattened().iter().copied()),
        triangles: Packed::u32(surfaces.triangles.as_flattened().iter().map(|&node| node as u32)),
        quantities: vec![quantity],
        cases: surfaces.cases.iter().map(case).collect(),
        ..Viewer::default()
    }
}

//! Names beside the points of a scatter, none on top of another.

use super::Method;
use super::chart::Chart;
use super::plots::class;

/// Height of a line of text and width of a letter, generous for any font \[px\].
const LINE: f64 = 15.0;
const LETTER: f64 = 8.6;
/// Distance of a label from its points \[px\].
const GAP: f64 = 6.0;
/// Share of the line above the baseline.
const ASCENT: f64 = 0.78;

/// A rectangle of the plot \[px\].
#[derive(Clone, Copy)]
pub(super) struct Extent {
    x: (f64, f64),
    y: (f64, f64),
}

impl Extent {
    /// The rectangle that holds markers of a radius at these pixels.
    pub(super) fn around(pixels: impl Iterator<Item = (f64, f64)>, radius: f64) -> Option<Self> {
        pixels.fold(None, |found: Option<Self>, (x, y)| {
            let marker = Self { x: (x - radius, x + radius), y: (y - radius, y + radius) };
            Some(found.map_or(marker, |found| Self {
                x: (found.x.0.min(marker.x.0), found.x.1.max(marker.x.1)),
                y: (found.y.0.min(marker.y.0), found.y.1.max(marker.y.1)),
            }))
        })
    }

    fn overlaps(&self, other: &Self) -> bool {
        let along = |a: (f64, f64), b: (f64, f64)| a.0 < b.1 && b.0 < a.1;
        along(self.x, other.x) && along(self.y, other.y)
    }

    fn is_inside(&self, (right, bottom): (f64, f64)) -> bool {
        self.x.0 > 0.0 && self.x.1 < right && self.y.0 > 0.0 && self.y.1 < bottom
    }
}

/// A place for a label: its box, and how its text is anchored in it.
struct Place {
    extent: Extent,
    anchor: &'static str,
    /// Far from its points, so that a line has to tie it to them.
    tied: bool,
}

impl Place {
    fn new(anchor: &'static str, x: f64, top: f64, width: f64) -> Self {
        let x = match anchor {
            "end" => (x - width, x),
            "middle" => (x - 0.5 * width, x + 0.5 * width),
            _ => (x, x + width),
        };
        let y = (top, top + LINE);
        Self { extent: Extent { x, y }, anchor, tied: false }
    }

    /// Where SVG wants the text.
    fn text_position(&self) -> (f64, f64) {
        let (left, right) = self.extent.x;
        let x = match self.anchor {
            "end" => right,
            "middle" => 0.5 * (left + right),
            _ => left,
        };
        (x, self.extent.y.0 + ASCENT * LINE)
    }
}

/// Places from the best to the last: right, left, above and below of the points, then
/// to the right in other lines.
fn places(points: &Extent, width: f64) -> Vec<Place> {
    let centre = 0.5 * (points.x.0 + points.x.1);
    let beside = 0.5 * (points.y.0 + points.y.1 - LINE);
    let (left, right) = (points.x.0 - GAP, points.x.1 + GAP);
    let mut places = vec![
        Place::new("start", right, beside, width),
        Place::new("end", left, beside, width),
        Place::new("middle", centre, points.y.0 - LINE, width),
        Place::new("middle", centre, points.y.1, width),
    ];
    places.extend([1.2, -1.2, 2.4, -2.4, 3.6, -3.6].map(|lines| Place {
        tied: true,
        ..Place::new("start", right + GAP, beside + lines * LINE, width)
    }));
    places
}

/// Writes the name of every method at its first place that is free.
pub(super) fn place_labels(chart: &mut Chart, labels: Vec<(Method, Extent)>) {
    let mut taken: Vec<Extent> = labels.iter().map(|label| label.1).collect();
    for (method, points) in labels {
        let width = LETTER * method.label().len() as f64;
        let mut places = places(&points, width);
        let free = |place: &Place| {
            place.extent.is_inside(chart.plot_size())
                && !taken.iter().any(|other| other.overlaps(&place.extent))
        };
        let place = places.swap_remove(places.iter().position(free).unwrap_or(0));
        if place.tied {
            let from = (points.x.1, 0.5 * (points.y.0 + points.y.1));
            let to = (place.extent.x.0 - 2.0, place.extent.y.0 + 0.5 * LINE);
            chart.leader(&class(method), from, to);
        }
        let class = format!("label {}", class(method));
        chart.text(&class, place.text_position(), place.anchor, method.label());
        taken.push(place.extent);
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::Axis;
    use super::*;

    #[test]
    fn labels_of_coinciding_points_do_not_overlap() {
        let axis = || Axis::log("x", [1.0, 100.0]);
        let mut chart = Chart::new((900.0, 400.0), "t", axis(), axis());
        let at = |y: f64| Extent::around([(400.0, y)].into_iter(), 4.0).unwrap();
        let labels = Method::ALL.map(|method| (method, at(200.0))).to_vec();
        place_labels(&mut chart, labels);
        let svg = chart.render();
        let mut positions: Vec<&str> = svg
            .split("<text class=\"label")
            .skip(1)
            .map(|text| text.split_once('>').unwrap().0.split_once('x').unwrap().1)
            .collect();
        assert_eq!(positions.len(), Method::ALL.len());
        positions.sort_unstable();
        positions.dedup();
        assert_eq!(positions.len(), Method::ALL.len());
    }
}

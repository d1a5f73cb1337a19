//! One edge of a polygon: the line it lies on, and the distance to it.

use crate::series::Series;

/// An edge, run through anticlockwise, so that the inside is to its left.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    pub start: [f64; 2],
    /// Unit vector along it.
    pub tangent: [f64; 2],
    /// Unit vector to the inside.
    pub normal: [f64; 2],
    pub length: f64,
}

impl Edge {
    pub(crate) fn new([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> Self {
        let length = (bx - ax).hypot(by - ay);
        let tangent = [(bx - ax) / length, (by - ay) / length];
        Self { start: [ax, ay], tangent, normal: [-tangent[1], tangent[0]], length }
    }

    /// The outward normal, which has no components along further axes.
    pub(crate) fn outwards<const D: usize>(&self) -> [f64; D] {
        std::array::from_fn(|d| self.normal.get(d).map_or(0.0, |n| -n))
    }

    /// Distance from a point to the edge, its ends included.
    pub(crate) fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let (x, y) = (x - self.start[0], y - self.start[1]);
        let along = (x * self.tangent[0] + y * self.tangent[1]).clamp(0.0, self.length);
        (x - along * self.tangent[0]).hypot(y - along * self.tangent[1])
    }

    /// Signed distance to the line, positive to the left.
    pub(crate) fn height(&self, x: &Series, y: &Series) -> Series {
        (x - self.start[0]) * self.normal[0] + (y - self.start[1]) * self.normal[1]
    }

    /// Position along the line: 0 at the start, 1 at the end of the edge.
    pub(crate) fn fraction(&self, x: &Series, y: &Series) -> Series {
        ((x - self.start[0]) * self.tangent[0] + (y - self.start[1]) * self.tangent[1])
            / self.length
    }

    /// The line's distance trimmed by the circle over the edge: zero on the edge alone, equal to
    /// the distance to first order there, and smooth but at the ends (Sukumar & Srivastava 2022, eq. 6;
    /// the thesis' φᵢ in 4.56).
    pub(crate) fn trimmed_distance(&self, x: &Series, y: &Series) -> Series {
        let f = self.height(x, y) / self.length;
        let along = self.fraction(x, y);
        // Positive within the circle.
        let t = &along * (along.constant(1.0) - &along) - f.squared();
        let root = (t.squared() + f.powi(4)).sqrt();
        let unit = if t.value() > 0.0 {
            // √(f² + ¼(√(t² + f⁴) − t)²) with |f| taken out of the root, which is smooth on the edge too.
            let rest = f.powi(3) / ((root + t) * 2.0);
            let sign = if f.value() < 0.0 { -1.0 } else { 1.0 };
            f * (rest.squared() + 1.0).sqrt() * sign
        } else {
            (f.squared() + (root - t).squared() * 0.25).sqrt()
        };
        unit * self.length
    }
}

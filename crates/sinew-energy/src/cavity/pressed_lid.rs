//! Lids that the pressure in a cavity acts on.

use super::closing::{Add, Lid, add_projected, projected};
use crate::SurfaceResponse;
use sinew_num::{Mat3, add3, cross, dot3, norm, sub3};

/// A lid over a rim that moves, under the pressure of its cavity. With the surface it encloses the cavity's volume, wherever the origin.
///
/// The volume between lid and origin is `⅓ a·A` with the apex a and the area vector `A = ½ ∮ x × dx` of the rim: that of [`crate::Cavity`].
#[derive(Clone, Debug, PartialEq)]
pub struct PressedLid {
    /// Nodes of the rim, those between two corners too.
    pub nodes: Vec<usize>,
    /// Their reference positions \[length\] from the origin of the surface.
    pub positions: Vec<[f64; 3]>,
    /// The cone, by places in `nodes`.
    pub lid: Lid,
}

impl PressedLid {
    pub(super) fn new(lid: &Lid, points: &[[f64; 3]], origin: &[f64; 3]) -> Self {
        let mut nodes = Vec::new();
        let mut place = |node: usize| {
            nodes.iter().position(|&n| n == node).unwrap_or_else(|| {
                nodes.push(node);
                nodes.len() - 1
            })
        };
        let mut own = lid.clone();
        let chords = own.chords.iter_mut().map(|(chord, _)| chord);
        let pairs = own.edges.iter_mut().chain(chords);
        pairs.for_each(|pair| *pair = pair.map(&mut place));
        own.planes.iter_mut().for_each(|plane| plane.node = place(plane.node));
        let positions = nodes.iter().map(|&node| sub3(&points[node], origin)).collect();
        Self { nodes, positions, lid: own }
    }

    fn motion(&self, displacement: &[f64]) -> impl Fn(usize) -> [f64; 3] {
        |place| std::array::from_fn(|i| displacement[3 * self.nodes[place] + i])
    }

    /// `V(u) − V(0)`, expanded in u, so nothing cancels at small displacement.
    pub(crate) fn change(&self, displacement: &[f64]) -> f64 {
        let u = self.motion(displacement);
        let rest = |place: usize| self.positions[place];
        let at = |place: usize| add3(&rest(place), &u(place));
        let ((mean, _), (_, whole)) = (self.lid.mean(&rest), self.lid.mean(&at));
        let mut shift = [0.0; 3];
        for &[a, b] in &self.lid.edges {
            let [before, after] = [sub3(&rest(b), &rest(a)), sub3(&at(b), &at(a))];
            let (length, both) = (norm(&after), add3(&before, &after));
            let longer =
                dot3(&sub3(&u(b), &u(a)), &both) / (norm(&before) + length).max(f64::MIN_POSITIVE);
            let (place, moved) = (add3(&rest(a), &rest(b)), add3(&u(a), &u(b)));
            for i in 0..3 {
                shift[i] += longer * (0.5 * place[i] - mean[i]) + 0.5 * length * moved[i];
            }
        }
        let shift = shift.map(|x| x / whole.max(f64::MIN_POSITIVE));
        let (shift, apex) = (projected(&self.lid.planes, shift, &u), self.lid.apex(&rest));
        let mut sum = 0.0;
        for &([a, b], weight) in &self.lid.chords {
            let change = add3(&cross(&u(a), &at(b)), &cross(&rest(a), &u(b)));
            sum += weight * (dot3(&shift, &cross(&at(a), &at(b))) + dot3(&apex, &change));
        }
        sum / 6.0
    }

    /// Gradient of [`PressedLid::change`] and, if the response has one, its Hessian.
    pub(crate) fn respond(&self, displacement: &[f64], response: &mut SurfaceResponse) {
        let u = self.motion(displacement);
        let at = |place: usize| add3(&self.positions[place], &u(place));
        let row = |fill: &dyn Fn(&mut Add<'_>)| {
            let mut row = vec![0.0; 3 * self.nodes.len()];
            fill(&mut |place, slope| (0..3).for_each(|i| row[3 * place + i] += slope[i]));
            row
        };
        let axes = Mat3::IDENTITY.0;
        let (apex, mut area) = (self.lid.apex(&at), [0.0; 3]);
        for &([a, b], weight) in &self.lid.chords {
            area = add3(&area, &cross(&at(a), &at(b)).map(|x| 0.5 * weight * x));
        }
        let of_apex = axes.map(|axis| row(&|add| self.lid.add_slopes(axis, &at, add)));
        let of_area = axes.map(|axis| {
            row(&|add| {
                for &([a, b], weight) in &self.lid.chords {
                    add(a, cross(&at(b), &axis).map(|x| 0.5 * weight * x));
                    add(b, cross(&axis, &at(a)).map(|x| 0.5 * weight * x));
                }
            })
        });
        for k in 0..3 {
            let slopes = of_apex[k].iter().zip(&of_area[k]);
            for (g, (of_apex, of_area)) in response.gradient.iter_mut().zip(slopes) {
                *g += (area[k] * of_apex + apex[k] * of_area) / 3.0;
            }
        }
        if !response.has_hessian() {
            return;
        }
        for k in 0..3 {
            response.add_products(1.0 / 3.0, &of_apex[k], &of_area[k]);
        }
        for &([a, b], weight) in &self.lid.chords {
            let axis = apex.map(|x| weight / 6.0 * x);
            response.add_cross(a, b, axis.map(|x| -x));
            response.add_cross(b, a, axis);
        }
        // The mean is Σ length · middle over the whole length.
        let of_mean = add_projected(&self.lid.planes, area, &mut |_, _| {});
        let (mean, whole) = self.lid.mean(&at);
        let of_product = row(&|add| self.lid.add_mean_slopes(of_mean, &at, add));
        let scale = 1.0 / (3.0 * whole.max(f64::MIN_POSITIVE));
        let (size, mut of_whole) = (response.gradient.len(), vec![0.0; response.gradient.len()]);
        for &[a, b] in &self.lid.edges {
            let (along, middle) = (sub3(&at(b), &at(a)), add3(&at(a), &at(b)).map(|x| 0.5 * x));
            let length = norm(&along).max(f64::MIN_POSITIVE);
            let unit = along.map(|x| x / length);
            let turn = dot3(&of_mean, &sub3(&middle, &mean)) / length;
            for (p, node) in [(-1.0, a), (1.0, b)] {
                (0..3).for_each(|i| of_whole[3 * node + i] += p * unit[i]);
                for (q, other) in [(-1.0, a), (1.0, b)] {
                    for (i, k) in (0..9).map(|entry| (entry / 3, entry % 3)) {
                        let across = axes[i][k] - unit[i] * unit[k];
                        let stretch = p * unit[i] * of_mean[k] + q * of_mean[i] * unit[k];
                        response.hessian[(3 * node + i) * size + 3 * other + k] +=
                            scale * (turn * p * q * across + 0.5 * stretch);
                    }
                }
            }
        }
        response.add_products(-scale, &of_product, &of_whole);
    }
}

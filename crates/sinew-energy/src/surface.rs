//! Pressure on the surface of a body: its size, and the thesis' formula for one.

mod response;

pub use response::SurfaceResponse;

use crate::{FacetRule, PressedLid};
use sinew_num::{add3, cross, dot3, sub3};

/// A pressure on facets, lowered to plain arrays. Positive pressure pushes against the solid.
///
/// As a potential it is `p (V(u) − V(0))` with the volume `V = 1/d ∫ x·n da` in `d` dimensions: the sum
/// is that of a follower load where the rim is held or has a lid, and its second derivative is symmetric. As a force it is `p ∫ N_a
/// n da` for any motion of the rim, and its tangent is not symmetric.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureSurface {
    /// Pressure \[stress\].
    pub magnitude: Magnitude,
    /// Whether the potential is that of [`crate::Load::ThesisPressure`], on flat triangles.
    pub thesis: bool,
    /// Shape functions and quadrature of a facet.
    pub rule: FacetRule,
    /// Nodes of the facets, counterclockwise seen from outside the solid, one facet after the other.
    pub nodes: Vec<usize>,
    /// Their reference positions \[length\], from an origin in the planes that the rim slides in.
    pub positions: Vec<[f64; 3]>,
    /// Lids over the rims that the pressure acts on too. They are counted behind the facets.
    pub lids: Vec<PressedLid>,
}

impl PressureSurface {
    /// Number of facets and lids.
    pub fn facets(&self) -> usize {
        self.nodes.len() / self.rule.nodes + self.lids.len()
    }

    /// Nodes of one facet, or of the rim of a lid.
    pub fn facet_nodes(&self, facet: usize) -> &[usize] {
        let facets = || &self.nodes[facet * self.rule.nodes..(facet + 1) * self.rule.nodes];
        self.lid(facet).map_or_else(facets, |lid| &lid.nodes)
    }

    fn lid(&self, facet: usize) -> Option<&PressedLid> {
        self.lids.get(facet.checked_sub(self.nodes.len() / self.rule.nodes)?)
    }

    /// Potential of the load [stress·length³].
    pub fn value(&self, displacement: &[f64], theta: &[f64]) -> f64 {
        let energies = (0..self.facets()).map(|facet| self.facet_energy(facet, displacement));
        self.magnitude.value(theta) * energies.sum::<f64>()
    }

    /// Energy of one facet under unit pressure \[length³\].
    fn facet_energy(&self, facet: usize, displacement: &[f64]) -> f64 {
        match self.lid(facet) {
            Some(lid) => lid.change(displacement),
            None if self.thesis => self.thesis_triangle(facet, displacement).energy(),
            None => self.facet_volume(facet, displacement),
        }
    }

    /// Potential of the load [stress·length³]; its gradient is added to `gradient` [stress·length²].
    pub fn value_and_add_gradient(
        &self,
        displacement: &[f64],
        theta: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let pressure = self.magnitude.value(theta);
        let mut volume = 0.0;
        let mut response = SurfaceResponse::default();
        for facet in 0..self.facets() {
            self.respond(facet, displacement, false, &mut response);
            volume += response.energy;
            for (slot, derivative) in response.gradient.iter().enumerate() {
                gradient[3 * self.facet_nodes(facet)[slot / 3] + slot % 3] += pressure * derivative;
            }
        }
        pressure * volume
    }

    /// Energy, gradient and symmetric Hessian of one facet under unit pressure.
    pub fn facet_response(
        &self,
        facet: usize,
        displacement: &[f64],
        response: &mut SurfaceResponse,
    ) {
        self.respond(facet, displacement, true, response);
    }

    fn respond(
        &self,
        facet: usize,
        displacement: &[f64],
        with_hessian: bool,
        response: &mut SurfaceResponse,
    ) {
        response.clear(self.facet_nodes(facet).len(), with_hessian);
        response.energy = self.facet_energy(facet, displacement);
        if let Some(lid) = self.lid(facet) {
            return lid.respond(displacement, response);
        }
        if self.thesis {
            return self.thesis_triangle(facet, displacement).respond(response);
        }
        let scale = 1.0 / self.rule.dimension as f64;
        self.for_points(facet, displacement, |[x, xs, xt], n, [ns, nt], weight| {
            let weight = weight * scale;
            let (normal, across, along) = (cross(&xs, &xt), cross(&xt, &x), cross(&x, &xs));
            for a in 0..n.len() {
                for i in 0..3 {
                    response.gradient[3 * a + i] +=
                        weight * (n[a] * normal[i] + ns[a] * across[i] + nt[a] * along[i]);
                }
                for b in (0..n.len()).take_while(|_| with_hessian) {
                    let of_t = ns[a] * n[b] - n[a] * ns[b];
                    let of_s = n[a] * nt[b] - nt[a] * n[b];
                    let of_x = nt[a] * ns[b] - ns[a] * nt[b];
                    let axis = |i: usize| weight * (of_t * xt[i] + of_s * xs[i] + of_x * x[i]);
                    response.add_cross(a, b, std::array::from_fn(axis));
                }
            }
        });
    }

    fn thesis_triangle(&self, facet: usize, displacement: &[f64]) -> ThesisTriangle {
        let moved = |node: usize| std::array::from_fn(|i| displacement[3 * node + i]);
        let u = self.nodes.as_chunks::<3>().0[facet].map(moved);
        ThesisTriangle::new(&self.positions.as_chunks().0[facet], &u)
    }

    /// Nodal forces of one facet under unit pressure and their tangent, for any motion of the rim.
    pub fn facet_force(&self, facet: usize, displacement: &[f64], response: &mut SurfaceResponse) {
        if self.lid(facet).is_some() {
            return self.respond(facet, displacement, true, response);
        }
        response.clear(self.rule.nodes, true);
        self.for_points(facet, displacement, |[_, xs, xt], n, [ns, nt], weight| {
            let normal = cross(&xs, &xt);
            for a in 0..n.len() {
                for i in 0..3 {
                    response.gradient[3 * a + i] += weight * n[a] * normal[i];
                }
                for b in 0..n.len() {
                    let axis = |i: usize| weight * n[a] * (nt[b] * xs[i] - ns[b] * xt[i]);
                    response.add_cross(a, b, std::array::from_fn(axis));
                }
            }
        });
    }

    /// `V(u) − V(0)` of one facet, expanded in u, so nothing cancels at small displacement.
    fn facet_volume(&self, facet: usize, displacement: &[f64]) -> f64 {
        let reference = |nodal: &[f64]| self.interpolate(facet, nodal, |row| self.positions[row]);
        let moved = |nodal: &[f64]| {
            self.interpolate(facet, nodal, |row| {
                let node = self.nodes[row];
                std::array::from_fn(|i| displacement[3 * node + i])
            })
        };
        let mut volume = 0.0;
        for point in &self.rule.points {
            let [n, s, t] = [&point.shape, &point.slope[0], &point.slope[1]];
            let (x, u) = (reference(n), moved(n));
            let (xs, us, ut) = (reference(s), moved(s), moved(t));
            let mut xt = reference(t);
            if self.rule.dimension == 2 {
                xt[2] = 1.0;
            }
            let current = [add3(&xs, &us), add3(&xt, &ut)];
            let change = add3(&cross(&us, &current[1]), &cross(&xs, &ut));
            volume +=
                point.weight * (dot3(&u, &cross(&current[0], &current[1])) + dot3(&x, &change));
        }
        volume / self.rule.dimension as f64
    }

    /// Calls `visit` with the deformed position and tangents of a facet at each point, the shape functions, their slopes and the weight.
    fn for_points(
        &self,
        facet: usize,
        displacement: &[f64],
        mut visit: impl FnMut([[f64; 3]; 3], &[f64], [&[f64]; 2], f64),
    ) {
        let current = |row: usize| {
            let node = self.nodes[row];
            std::array::from_fn(|i| self.positions[row][i] + displacement[3 * node + i])
        };
        for point in &self.rule.points {
            let [n, s, t] = [&point.shape, &point.slope[0], &point.slope[1]];
            let mut place = [n, s, t].map(|nodal| self.interpolate(facet, nodal, current));
            if self.rule.dimension == 2 {
                place[2][2] = 1.0;
            }
            visit(place, n, [s, t], point.weight);
        }
    }

    fn interpolate(
        &self,
        facet: usize,
        nodal: &[f64],
        value: impl Fn(usize) -> [f64; 3],
    ) -> [f64; 3] {
        let first = facet * self.rule.nodes;
        nodal.iter().enumerate().fold([0.0; 3], |sum, (a, n)| {
            let value = value(first + a);
            std::array::from_fn(|i| sum[i] + n * value[i])
        })
    }
}

/// Source of a load's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Magnitude {
    /// A fixed size \[stress\].
    Fixed(f64),
    /// Entry of θ with this index; load parameters follow those of the law.
    Theta(usize),
}

impl Magnitude {
    /// The size of the load \[stress\].
    ///
    /// # Panics
    /// If θ is too short; [`crate::Body::check_theta`] tells.
    pub fn value(self, theta: &[f64]) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Theta(index) => theta[index],
        }
    }
}

/// A flat triangle under the thesis' pressure of size one: the potential `−∫ t₀·u dA` with `t₀ = −cof(F)N`, thesis eqs. (3.14)–(3.16). On linear
/// tetrahedra `cof(F)N dA` is the area vector of the deformed facet, so that it is `n·Σu / 6`.
pub(crate) struct ThesisTriangle {
    /// Edges of the deformed triangle, each opposite to its corner.
    edges: [[f64; 3]; 3],
    /// Twice its area vector.
    normal: [f64; 3],
    /// Sum of the corners' displacements.
    motion: [f64; 3],
}

impl ThesisTriangle {
    /// A triangle by its reference positions and displacements.
    pub(crate) fn new(positions: &[[f64; 3]; 3], u: &[[f64; 3]; 3]) -> Self {
        let corner = |a: usize| add3(&positions[a % 3], &u[a % 3]);
        let edges = [0, 1, 2].map(|a| sub3(&corner(a + 2), &corner(a + 1)));
        let normal = cross(&edges[1], &edges[2]);
        Self { edges, normal, motion: add3(&add3(&u[0], &u[1]), &u[2]) }
    }

    pub(crate) fn energy(&self) -> f64 {
        dot3(&self.motion, &self.normal) / 6.0
    }

    /// Gradient of the energy and, if the response has one, its Hessian.
    pub(crate) fn respond(&self, response: &mut SurfaceResponse) {
        let Self { edges, normal, motion } = self;
        let columns = if response.has_hessian() { 3 } else { 0 };
        for a in 0..3 {
            let force = add3(normal, &cross(motion, &edges[a]));
            (0..3).for_each(|i| response.gradient[3 * a + i] = force[i] / 6.0);
            for b in 0..columns {
                let turn = [0.0, -1.0, 1.0][(3 + b - a) % 3];
                let axis = |i: usize| (edges[b][i] - edges[a][i] + turn * motion[i]) / 6.0;
                response.add_cross(a, b, std::array::from_fn(axis));
            }
        }
    }
}

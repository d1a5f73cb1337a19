//! Volume behind a surface and the lids over its rims.

use sinew_num::{Mat3, add3, cross, dot3, norm, sub3};

/// A connected surface with its closing. Its volume is the flux of a field `S (x − o)` of divergence one.
#[derive(Clone, Debug, PartialEq)]
pub struct CavityPart {
    /// Triangles that cover the surface, counterclockwise seen from outside the solid.
    pub triangles: Vec<[usize; 3]>,
    /// Lids, one for each rim.
    pub lids: Vec<Lid>,
    /// Symmetry planes that the origin o lies in: the projection of the first node on them.
    pub planes: Vec<SymmetryPlane>,
    /// The symmetric matrix S, `I/3` without symmetry planes. No flux passes through these.
    pub field: Mat3<f64>,
}

/// A cone over a rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Lid {
    /// Edges of the rim in the order that makes its triangles go on with the surface.
    pub edges: Vec<[usize; 2]>,
    /// Symmetry planes that the rim ends in. The apex is projected on them.
    pub planes: Vec<SymmetryPlane>,
}

/// A plane that moves with a node, among others that it meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetryPlane {
    /// The node.
    pub node: usize,
    /// Unit normal.
    pub normal: [f64; 3],
    /// Vector of a step towards the plane that leaves the distances from the other planes as they are; `dual·normal = 1`.
    pub dual: [f64; 3],
}

/// Position of a node.
pub(super) type At<'a> = dyn Fn(usize) -> [f64; 3] + 'a;
/// Adds to the derivative in the position of a node.
pub(super) type Add<'a> = dyn FnMut(usize, [f64; 3]) + 'a;

/// Position of a node after a displacement.
pub(super) fn moved(points: &[[f64; 3]], u: &[f64]) -> impl Fn(usize) -> [f64; 3] {
    |node| std::array::from_fn(|i| points[node][i] + u[3 * node + i])
}

impl CavityPart {
    /// Volume with its sign, and the derivative in the first node's position that comes from the origin: zero on a closed surface.
    pub(super) fn measure(&self, at: &At<'_>, add: &mut Add<'_>) -> (f64, [f64; 3]) {
        let first = self.triangles[0][0];
        let origin = projected(&self.planes, at(first), at);
        let (mut volume, mut of_origin) = (0.0, [0.0; 3]);
        let mut flux = |corners: [[f64; 3]; 3]| {
            let [a, b, c] = corners.map(|x| sub3(&x, &origin));
            let [bc, ca, ab] = [sub3(&c, &b), sub3(&a, &c), sub3(&b, &a)];
            let area = cross(&ca, &ab).map(|x| 0.5 * x);
            let middle = self.field.apply(&add3(&add3(&a, &b), &c).map(|x| x / 3.0));
            let through = self.field.apply(&area);
            volume += dot3(&middle, &area);
            of_origin = sub3(&of_origin, &through);
            [bc, ca, ab].map(|opposite| {
                let turned = cross(&middle, &opposite);
                std::array::from_fn(|i| through[i] / 3.0 + 0.5 * turned[i])
            })
        };
        for nodes in &self.triangles {
            let slopes = flux(nodes.map(at));
            nodes.iter().zip(slopes).for_each(|(&node, slope)| add(node, slope));
        }
        for lid in &self.lids {
            let (apex, mut of_apex) = (lid.apex(at), [0.0; 3]);
            for &[a, b] in &lid.edges {
                let [of_a, of_b, of_cone] = flux([at(a), at(b), apex]);
                add(a, of_a);
                add(b, of_b);
                of_apex = add3(&of_apex, &of_cone);
            }
            lid.add_slopes(of_apex, at, add);
        }
        let left = add_projected(&self.planes, of_origin, add);
        add(first, left);
        (volume, left)
    }
}

impl Lid {
    pub(super) fn apex(&self, at: &At<'_>) -> [f64; 3] {
        projected(&self.planes, self.mean(at).0, at)
    }

    /// Mean of the rim weighted by lengths of edges, and its whole length.
    pub(super) fn mean(&self, at: &At<'_>) -> ([f64; 3], f64) {
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for &[a, b] in &self.edges {
            let (length, middle) = (norm(&sub3(&at(b), &at(a))), add3(&at(a), &at(b)));
            sum = add3(&sum, &middle.map(|x| 0.5 * length * x));
            whole += length;
        }
        (sum.map(|x| x / whole.max(f64::MIN_POSITIVE)), whole)
    }

    /// Adds the derivatives of a number whose derivative in the apex is given.
    pub(super) fn add_slopes(&self, of_apex: [f64; 3], at: &At<'_>, add: &mut Add<'_>) {
        let of_mean = add_projected(&self.planes, of_apex, add);
        self.add_mean_slopes(of_mean, at, add);
    }

    /// Adds the derivatives of a number whose derivative in the mean of the rim is given.
    pub(super) fn add_mean_slopes(&self, of_mean: [f64; 3], at: &At<'_>, add: &mut Add<'_>) {
        let (mean, whole) = self.mean(at);
        for &[a, b] in &self.edges {
            let (along, middle) = (sub3(&at(b), &at(a)), add3(&at(a), &at(b)).map(|x| 0.5 * x));
            let length = norm(&along);
            if length > 0.0 {
                let stretch = dot3(&of_mean, &sub3(&middle, &mean)) / (length * whole);
                let shift = of_mean.map(|x| 0.5 * length * x / whole);
                add(a, sub3(&shift, &along.map(|x| stretch * x)));
                add(b, add3(&shift, &along.map(|x| stretch * x)));
            }
        }
    }
}

/// Projection of a point on the intersection of planes.
pub(super) fn projected(planes: &[SymmetryPlane], point: [f64; 3], at: &At<'_>) -> [f64; 3] {
    planes.iter().fold(point, |on, &SymmetryPlane { node, normal, dual }| {
        let distance = dot3(&normal, &sub3(&point, &at(node)));
        sub3(&on, &dual.map(|x| distance * x))
    })
}

/// Derivative in the point from that in its projection; the planes' nodes are given theirs.
pub(super) fn add_projected(
    planes: &[SymmetryPlane],
    of_projected: [f64; 3],
    add: &mut Add<'_>,
) -> [f64; 3] {
    planes.iter().fold(of_projected, |of_point, &SymmetryPlane { node, normal, dual }| {
        let share = normal.map(|x| x * dot3(&dual, &of_projected));
        add(node, share);
        sub3(&of_point, &share)
    })
}

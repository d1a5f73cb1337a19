//! Cavities that pressures act in.

mod closing;

use crate::Body;
use closing::components;
pub(crate) use closing::{FLAT, Surroundings, sorted};
use sinew_num::{Mat3, add3, cross, dot3, sub3};

/// The space behind a surface that a pressure acts on, such as the chamber of a ventricle.
///
/// Each rim, a connected loop of boundary edges, has a lid: the cone over it to the mean of the deformed rim, weighted by the lengths
/// of its edges. A rigid motion does not change the volume. Where a rim runs along symmetry planes, in which supports let nodes slide,
/// the planes close the surface, and a lid covers what is left of the rim as if it went on behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Cavity {
    /// The facet set.
    pub name: String,
    /// Its connected surfaces.
    pub parts: Vec<CavityPart>,
}

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

impl Cavity {
    /// Makes a cavity from triangles; `None` where symmetry planes leave the volume undetermined.
    pub(crate) fn new(
        name: &str,
        triangles: &[[usize; 3]],
        around: &Surroundings<'_>,
    ) -> Option<Self> {
        let parts = components(around.points.len(), triangles).into_iter();
        let parts =
            parts.map(|triangles| CavityPart::new(triangles, around)).collect::<Option<_>>();
        Some(Self { name: name.into(), parts: parts? })
    }

    /// Triangles that cover the surface, counterclockwise seen from outside the solid.
    pub fn triangles(&self) -> impl Iterator<Item = &[usize; 3]> {
        self.parts.iter().flat_map(|part| &part.triangles)
    }

    /// Volume at a displacement from the positions of all nodes \[length³\].
    pub fn volume(&self, positions: &[[f64; 3]], displacement: &[f64]) -> f64 {
        self.measure(&moved(positions, displacement), &mut |_, _| {}).abs()
    }

    /// Derivative of [`Cavity::volume`] in the displacement \[length²\].
    pub fn volume_gradient(&self, positions: &[[f64; 3]], displacement: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; displacement.len()];
        let volume = self.measure(&moved(positions, displacement), &mut |node, slope| {
            (0..3).for_each(|i| gradient[3 * node + i] += slope[i]);
        });
        gradient.iter_mut().for_each(|slope| *slope *= volume.signum());
        gradient
    }

    /// Volume with the sign of the triangles' order; its derivatives are added node by node.
    fn measure(&self, at: &dyn Fn(usize) -> [f64; 3], add: &mut Add<'_>) -> f64 {
        self.parts.iter().map(|part| part.measure(at, add).0).sum()
    }
}

/// Adds to the derivative in the position of a node.
type Add<'a> = dyn FnMut(usize, [f64; 3]) + 'a;

fn moved(points: &[[f64; 3]], u: &[f64]) -> impl Fn(usize) -> [f64; 3] {
    |node| std::array::from_fn(|i| points[node][i] + u[3 * node + i])
}

impl CavityPart {
    /// Volume with its sign, and the derivative in the first node's position that comes from the origin: zero on a closed surface.
    fn measure(&self, at: &dyn Fn(usize) -> [f64; 3], add: &mut Add<'_>) -> (f64, [f64; 3]) {
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
    fn apex(&self, at: &dyn Fn(usize) -> [f64; 3]) -> [f64; 3] {
        projected(&self.planes, self.mean(at).0, at)
    }

    /// Mean of the rim weighted by lengths of edges, and its whole length.
    fn mean(&self, at: &dyn Fn(usize) -> [f64; 3]) -> ([f64; 3], f64) {
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for &[a, b] in &self.edges {
            let (length, middle) = (norm(&sub3(&at(b), &at(a))), add3(&at(a), &at(b)));
            sum = add3(&sum, &middle.map(|x| 0.5 * length * x));
            whole += length;
        }
        (sum.map(|x| x / whole.max(f64::MIN_POSITIVE)), whole)
    }

    /// Adds the derivatives of a number whose derivative in the apex is given.
    fn add_slopes(&self, of_apex: [f64; 3], at: &dyn Fn(usize) -> [f64; 3], add: &mut Add<'_>) {
        let of_mean = add_projected(&self.planes, of_apex, add);
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
fn projected(
    planes: &[SymmetryPlane],
    point: [f64; 3],
    at: &dyn Fn(usize) -> [f64; 3],
) -> [f64; 3] {
    planes.iter().fold(point, |on, &SymmetryPlane { node, normal, dual }| {
        let distance = dot3(&normal, &sub3(&point, &at(node)));
        sub3(&on, &dual.map(|x| distance * x))
    })
}

/// Derivative in the point from that in its projection; the planes' nodes are given theirs.
fn add_projected(planes: &[SymmetryPlane], of_projected: [f64; 3], add: &mut Add<'_>) -> [f64; 3] {
    planes.iter().fold(of_projected, |of_point, &SymmetryPlane { node, normal, dual }| {
        let share = normal.map(|x| x * dot3(&dual, &of_projected));
        add(node, share);
        sub3(&of_point, &share)
    })
}

fn norm(vector: &[f64; 3]) -> f64 {
    dot3(vector, vector).sqrt()
}

impl Body {
    /// Volumes of the cavities at a displacement \[length³\].
    pub fn cavity_volumes(&self, displacement: &[f64]) -> Vec<f64> {
        self.cavities.iter().map(|c| c.volume(&self.positions, displacement)).collect()
    }

    /// Derivatives of [`Body::cavity_volumes`], for each cavity as long as the displacement \[length²\]: what an objective in the
    /// volume of a chamber needs, and the right-hand side of its adjoint.
    ///
    /// ```
    /// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_mesh::TruncatedEllipsoid;
    ///
    /// let wall = TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra();
    /// let body = Scene::new(wall, NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Fixed(1.0) })
    ///     .support(Support::clamped("base"))
    ///     .lower()?;
    /// // Scaled about any point a volume grows with the third power, so its slope is three times the volume.
    /// let rest = vec![0.0; 3 * body.nodes];
    /// let gradient = &body.cavity_volume_gradients(&rest)[0];
    /// let slope: f64 = gradient.iter().zip(body.positions.as_flattened()).map(|(g, x)| g * (x + 7.0)).sum();
    /// assert!((slope / body.cavity_volumes(&rest)[0] - 3.0).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    pub fn cavity_volume_gradients(&self, displacement: &[f64]) -> Vec<Vec<f64>> {
        self.cavities.iter().map(|c| c.volume_gradient(&self.positions, displacement)).collect()
    }
}

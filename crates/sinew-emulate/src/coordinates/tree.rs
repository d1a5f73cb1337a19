//! Nested clusters of nodes: their rigid motions, composed from the whole body down to its nodes, and their rotations with derivatives.

use crate::coordinates::{CoordinateError, Result, ensure, require_count};
use sinew_num::{Mat3, Scalar, Slope, add3, ascending};

/// A body whose nodes belong to clusters, which belong to larger clusters, and so on up to one or several roots.
///
/// Each cluster k moves rigidly within its parent, `T_k(x) = X_k + t_k + exp([ω_k]) (x − X_k)`, and a node takes the
/// motions of all clusters that it belongs to after its own displacement: `u = T_root ∘ … ∘ T_parent(X + d) − X`.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionTree {
    /// Cluster of every node.
    pub node_parents: Vec<usize>,
    /// Cluster that every cluster belongs to: a later one, or none for a root.
    pub cluster_parents: Vec<Option<usize>>,
    /// Places X of the nodes at rest \[length\].
    pub positions: Vec<[f64; 3]>,
    /// Centres X_k of the clusters \[length\].
    pub centres: Vec<[f64; 3]>,
    /// Matrices from a node's output to its displacement d within its cluster \[length\].
    pub node_scales: Vec<[[f64; 3]; 3]>,
    /// Matrices from a cluster's output to its translation t \[length\] and rotation vector ω \[rad\].
    pub cluster_scales: Vec<[[f64; 6]; 6]>,
}

/// A cluster's own motion, and that of the clusters it belongs to and its own together: `x ↦ x + a + E (x − X)`.
struct Motion<S> {
    translation: [S; 3],
    turn: Rotation<S>,
    /// a: displacement of the centre \[length\].
    shift: [S; 3],
    /// E: rotation less the identity.
    rotation: Mat3<S>,
}

impl MotionTree {
    /// Number of outputs of all clusters, which come before those of the nodes.
    pub fn of_clusters(&self) -> usize {
        6 * self.cluster_parents.len()
    }

    /// The clusters of all nodes, layer by layer from the smallest on.
    pub(crate) fn ancestors(&self) -> Vec<Vec<usize>> {
        let above = |below: &Vec<usize>| {
            below.iter().map(|&cluster| self.cluster_parents[cluster]).collect::<Option<Vec<_>>>()
        };
        std::iter::successors(Some(self.node_parents.clone()), above).collect()
    }

    /// Motions of all clusters, parents before children.
    fn cluster_motions<S: Number>(&self, outputs: &[S]) -> Vec<Motion<S>> {
        let count = self.cluster_parents.len();
        let mut motions: Vec<Motion<S>> = Vec::with_capacity(count);
        // Stored from the root on: cluster k is at `count − 1 − k`.
        for cluster in (0..count).rev() {
            let [a, b, c, d, e, f] = scale(&self.cluster_scales[cluster], &outputs[6 * cluster..]);
            let (t, turn) = ([a, b, c], Rotation::new([d, e, f]));
            let own =
                Motion { shift: t.clone(), rotation: turn.less_identity(), translation: t, turn };
            motions.push(match self.cluster_parents[cluster] {
                None => own,
                Some(parent) => {
                    let above = &motions[count - 1 - parent];
                    let place = self.place(self.centres[cluster], parent, &own.translation);
                    let moved = above.rotation.apply(&place);
                    let rotated = product(&above.rotation, &own.rotation);
                    Motion {
                        shift: add3(&add3(&own.translation, &above.shift), &moved),
                        rotation: Mat3::from_fn(|i, j| {
                            above.rotation.at(i, j) + own.rotation.at(i, j) + rotated.at(i, j)
                        }),
                        ..own
                    }
                }
            });
        }
        motions.reverse();
        motions
    }

    /// `x + own − X_parent`.
    fn place<S: Number>(&self, x: [f64; 3], parent: usize, own: &[S; 3]) -> [S; 3] {
        let centre = self.centres[parent];
        std::array::from_fn(|i| own[i].clone() + (x[i] - centre[i]))
    }

    fn displacement<S: Number>(&self, outputs: &[S]) -> Vec<S> {
        let (clusters, nodes) = outputs.split_at(self.of_clusters());
        let motions = self.cluster_motions(clusters);
        let rows = nodes.chunks_exact(3).enumerate();
        let displaced = rows.flat_map(|(node, output)| {
            let parent = self.node_parents[node];
            let own = scale(&self.node_scales[node], output);
            let place = self.place(self.positions[node], parent, &own);
            let motion = &motions[parent];
            add3(&add3(&own, &motion.shift), &motion.rotation.apply(&place))
        });
        displaced.collect()
    }

    /// Displacements of outputs, node by node \[length\].
    pub fn moved(&self, outputs: &[f64]) -> Vec<f64> {
        self.displacement(outputs)
    }

    /// Derivative of the displacement at outputs along a change of them, by forward mode.
    pub fn tangent(&self, outputs: &[f64], change: &[f64]) -> Vec<f64> {
        let pairs = outputs.iter().zip(change);
        let duals: Vec<Slope<1>> = pairs
            .map(|(&value, &change)| Slope { value, gradient: [change], hessian: [] })
            .collect();
        self.displacement(&duals).into_iter().map(|u| u.gradient[0]).collect()
    }

    /// Cotangent of the outputs, from that of the displacement.
    pub fn pull_back(&self, outputs: &[f64], cotangent: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; outputs.len()];
        let (clusters, nodes) = outputs.split_at(self.of_clusters());
        let (to_clusters, to_nodes) = gradient.split_at_mut(self.of_clusters());
        let motions = self.cluster_motions(clusters);
        let mut shifts = vec![[0.0; 3]; motions.len()];
        let mut rotations = vec![Mat3::ZERO; motions.len()];
        let rows = cotangent.chunks_exact(3).zip(nodes.chunks_exact(3));
        for (node, ((cotangent, output), to)) in rows.zip(to_nodes.chunks_exact_mut(3)).enumerate()
        {
            let force = [cotangent[0], cotangent[1], cotangent[2]];
            let (parent, scales) = (self.node_parents[node], &self.node_scales[node]);
            let place = self.place(self.positions[node], parent, &scale(scales, output));
            let own = turned_back(&motions[parent].rotation, &force);
            add(&force, &place, &mut shifts[parent], &mut rotations[parent]);
            to.copy_from_slice(&scale_back(scales, &own));
        }
        // Children come before their parents.
        for (cluster, to) in to_clusters.chunks_exact_mut(6).enumerate() {
            let (force, moment) = (shifts[cluster], rotations[cluster]);
            let Motion { translation, turn, .. } = &motions[cluster];
            let (force_within, moment_within) = match self.cluster_parents[cluster] {
                None => (force, moment),
                Some(parent) => {
                    let above = &motions[parent].rotation;
                    let place = self.place(self.centres[cluster], parent, translation);
                    add(&force, &place, &mut shifts[parent], &mut rotations[parent]);
                    let back = product(&moment, &transposed(&turn.less_identity()));
                    let sum = &mut rotations[parent];
                    *sum = Mat3::from_fn(|i, j| sum[i][j] + moment[i][j] + back[i][j]);
                    let within = product(&transposed(above), &moment);
                    let within = Mat3::from_fn(|i, j| moment[i][j] + within[i][j]);
                    (turned_back(above, &force), within)
                }
            };
            let ([a, b, c], [d, e, f]) = (force_within, turn.pull_back(&moment_within));
            to.copy_from_slice(&scale_back(&self.cluster_scales[cluster], &[a, b, c, d, e, f]));
        }
        gradient
    }
}

fn scale<S: Number, const N: usize>(scales: &[[f64; N]; N], output: &[S]) -> [S; N] {
    std::array::from_fn(|i| {
        let terms = (0..N).map(|j| output[j].clone() * scales[i][j]);
        terms.reduce(|sum, term| sum + term).expect("scales have entries")
    })
}

fn scale_back<const N: usize>(scales: &[[f64; N]; N], force: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|j| (0..N).map(|i| scales[i][j] * force[i]).sum())
}

/// `(I + E)ᵀ f`.
fn turned_back(rotation: &Mat3<f64>, force: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|j| force[j] + (0..3).map(|i| rotation[i][j] * force[i]).sum::<f64>())
}

fn transposed(m: &Mat3<f64>) -> Mat3<f64> {
    Mat3::from_fn(|i, j| m[j][i])
}

/// Adds a force at a place to the gradients by a motion's shift and rotation.
fn add(force: &[f64; 3], place: &[f64; 3], shift: &mut [f64; 3], rotation: &mut Mat3<f64>) {
    for i in 0..3 {
        shift[i] += force[i];
        for j in 0..3 {
            rotation.0[i][j] += force[i] * place[j];
        }
    }
}

/// A number, with or without its derivative along a direction.
pub(crate) trait Number: Scalar {
    /// A function of this number whose value and slope there are known.
    fn chain(&self, function: impl Fn(f64) -> [f64; 2]) -> Self;
}

impl Number for f64 {
    fn chain(&self, function: impl Fn(f64) -> [f64; 2]) -> Self {
        function(*self)[0]
    }
}

impl Number for Slope<1> {
    fn chain(&self, function: impl Fn(f64) -> [f64; 2]) -> Self {
        let [value, slope] = function(self.value);
        Self { value, gradient: self.gradient.map(|g| slope * g), hessian: [] }
    }
}

/// `exp([ω]) − I = s(q) [ω] + m(q) [ω]²` with `q = ω·ω`, `s = sin √q / √q` and `m = (1 − cos √q) / q` (Rodrigues).
struct Rotation<S> {
    vector: [S; 3],
    square: S,
}

/// Below it s, m and their slopes are summed as series: the first term left out is below rounding there, and above
/// it the closed forms of the slopes lose no more than three digits.
const SERIES_BELOW: f64 = 0.1;

/// s(q) and its slope.
fn sine_part(q: f64) -> [f64; 2] {
    if q < SERIES_BELOW {
        return series(q, 1.0, 2.0);
    }
    let angle = q.sqrt();
    let s = angle.sin() / angle;
    [s, 0.5 * (angle.cos() - s) / q]
}

/// m(q) and its slope.
fn cosine_part(q: f64) -> [f64; 2] {
    if q < SERIES_BELOW {
        return series(q, 0.5, 3.0);
    }
    let angle = q.sqrt();
    let half = (0.5 * angle).sin() / angle;
    let m = 2.0 * half * half;
    [m, 0.5 * (angle.sin() / angle - 2.0 * m) / q]
}

/// `Σ c_k (−q)^k` with `c_0 = first` and `c_k = c_(k−1) / ((n + 2k − 2)(n + 2k − 1))`, and its slope.
fn series(q: f64, first: f64, n: f64) -> [f64; 2] {
    const TERMS: usize = 8;
    let (mut coefficient, mut power) = (first, 1.0);
    let (mut sum, mut slope) = (first, 0.0);
    for k in 1..=TERMS {
        let k = k as f64;
        coefficient /= -(n + 2.0 * k - 2.0) * (n + 2.0 * k - 1.0);
        slope += k * coefficient * power;
        power *= q;
        sum += coefficient * power;
    }
    [sum, slope]
}

impl<S: Number> Rotation<S> {
    /// Rotation by the angle `‖ω‖` \[rad\] about the axis along ω.
    fn new(vector: [S; 3]) -> Self {
        let [x, y, z] = vector.clone();
        Self { square: x.squared() + y.squared() + z.squared(), vector }
    }

    /// `[ω]`, with `[ω] x = ω × x`.
    fn skew(&self) -> Mat3<S> {
        let [x, y, z] = self.vector.clone();
        let zero = x.constant(0.0);
        Mat3([[zero.clone(), -z.clone(), y.clone()], [z, zero.clone(), -x.clone()], [-y, x, zero]])
    }

    /// `exp([ω]) − I`.
    fn less_identity(&self) -> Mat3<S> {
        let (s, m) = (self.square.chain(sine_part), self.square.chain(cosine_part));
        let w = self.skew();
        let w2 = product(&w, &w);
        Mat3::from_fn(|i, j| s.clone() * w.at(i, j) + m.clone() * w2.at(i, j))
    }
}

impl Rotation<f64> {
    /// Gradient by ω of what has the gradient `moment` by `exp([ω]) − I`.
    fn pull_back(&self, moment: &Mat3<f64>) -> [f64; 3] {
        let ([s, s_slope], [m, m_slope]) = (sine_part(self.square), cosine_part(self.square));
        let w = self.skew();
        let w2 = product(&w, &w);
        let along = |direction: &Mat3<f64>| -> f64 {
            (0..3).flat_map(|i| (0..3).map(move |j| moment[i][j] * direction[i][j])).sum()
        };
        let slope = 2.0 * (s_slope * along(&w) + m_slope * along(&w2));
        // ⟨M, [e] [ω] + [ω] [e]⟩ = −⟨M [ω] + [ω] M, [e]⟩, because [ω] is skew.
        let (left, right) = (product(&w, moment), product(moment, &w));
        let both = Mat3::from_fn(|i, j| s * moment[i][j] - m * (left[i][j] + right[i][j]));
        let axial = [both[2][1] - both[1][2], both[0][2] - both[2][0], both[1][0] - both[0][1]];
        std::array::from_fn(|i| axial[i] + slope * self.vector[i])
    }
}

fn product<S: Scalar>(a: &Mat3<S>, b: &Mat3<S>) -> Mat3<S> {
    Mat3::from_fn(|i, j| {
        a.at(i, 0) * b.at(0, j) + a.at(i, 1) * b.at(1, j) + a.at(i, 2) * b.at(2, j)
    })
}

/// Nested clusters of nodes by recursive coordinate bisection, from two to four nodes each up to the whole body. A cluster
/// is halved across the longest side of its bounding box.
///
/// Entry `[l][i]` is the cluster of leaf `i`. Leaves of layer 0 are the nodes, leaves of layer `l` the clusters of layer
/// `l − 1`. Coordinates decide ties of distance by the index of the node, so that the same positions give the same clusters.
///
/// ```
/// let row: Vec<_> = (0..8).map(|i| [f64::from(i), 0.0, 0.0]).collect();
/// let clusters = sinew_emulate::coordinates::halves(&row);
/// assert_eq!(clusters, [vec![0, 0, 1, 1, 2, 2, 3, 3], vec![0, 0, 1, 1], vec![0, 0]]);
/// ```
pub fn halves(positions: &[[f64; 3]]) -> Vec<Vec<usize>> {
    let depth = (positions.len() / 2).max(1).ilog2();
    let mut lowest = vec![0; positions.len()];
    let mut nodes: Vec<usize> = (0..positions.len()).collect();
    halve(positions, &mut nodes, 0..1 << depth, &mut lowest);
    let above = (1..=depth).rev().map(|layer| (0..1 << layer).map(|cluster| cluster / 2).collect());
    std::iter::once(lowest).chain(above).collect()
}

/// Gives nodes the clusters of a range, half of the nodes the lower half of it.
fn halve(
    positions: &[[f64; 3]],
    nodes: &mut [usize],
    clusters: std::ops::Range<usize>,
    lowest: &mut [usize],
) {
    if clusters.len() == 1 {
        return nodes.iter().for_each(|&node| lowest[node] = clusters.start);
    }
    let extent = |axis: usize| {
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for &node in &*nodes {
            (low, high) = (low.min(positions[node][axis]), high.max(positions[node][axis]));
        }
        high - low
    };
    let longest = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let half = nodes.len() / 2;
    let along = |&a: &usize, &b: &usize| {
        positions[a][longest].total_cmp(&positions[b][longest]).then(a.cmp(&b))
    };
    nodes.select_nth_unstable_by(half, along);
    let middle = clusters.start + clusters.len() / 2;
    let (lower, upper) = nodes.split_at_mut(half);
    halve(positions, lower, clusters.start..middle, lowest);
    halve(positions, upper, middle..clusters.end, lowest);
}

/// Number of clusters in each layer.
pub(crate) fn cluster_counts(clusters: &[Vec<usize>], nodes: usize) -> Result<Vec<usize>> {
    let mut leaves = nodes;
    let count = |layer: &Vec<usize>| {
        require_count("leaves of clusters", layer.len(), leaves)?;
        let used = ascending(layer.iter().copied());
        let count = used.last().map_or(0, |last| last + 1);
        ensure(count <= leaves, CoordinateError::None("more clusters than leaves"))?;
        ensure(used.len() == count, CoordinateError::None("a cluster without leaves"))?;
        leaves = count;
        Ok(count)
    };
    clusters.iter().map(count).collect()
}

/// Means of the leaves of each cluster.
pub(crate) fn cluster_centres(
    leaves: &[[f64; 3]],
    clusters: &[usize],
    count: usize,
) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); count];
    for (leaf, &cluster) in leaves.iter().zip(clusters) {
        let (sum, size) = &mut sums[cluster];
        sum.iter_mut().zip(leaf).for_each(|(sum, x)| *sum += x);
        *size += 1.0;
    }
    sums.into_iter().map(|(sum, size)| sum.map(|sum| sum / size)).collect()
}

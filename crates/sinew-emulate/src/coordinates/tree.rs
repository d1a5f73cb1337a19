//! Rigid motions of nested clusters, composed from the whole body down to its nodes.

use crate::coordinates::{Number, Rotation, product};
use sinew_num::{Mat3, Slope};

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
                        shift: std::array::from_fn(|i| {
                            own.translation[i].clone() + above.shift[i].clone() + moved[i].clone()
                        }),
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
            let moved = motion.rotation.apply(&place);
            let sum = own.into_iter().zip(motion.shift.clone()).zip(moved);
            sum.map(|((own, shift), moved)| own + shift + moved)
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

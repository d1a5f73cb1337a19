//! Map from the outputs of a network to displacements.

use std::sync::Arc;

use crate::fused::rigid_motions;
use burn::tensor::{Device, Tensor, TensorData};
use sinew_emulate::coordinates::{Anchors, Coordinates, MOST, MotionTree};

use crate::arrays::matrix;
use crate::data::Geometry;
use crate::graph_network::Output;
use crate::supports::Supports;
use sinew_emulate::coordinates::OutputScale;

/// Map from network outputs to displacements, prescribed ones written over them.
#[derive(Debug, Clone)]
pub(crate) struct OutputMap {
    /// Displacement of a zero output, `[1, real nodes, D]`.
    origin: Tensor<3>,
    rule: Rule,
    supports: Supports,
    /// Outputs with a Taylor polynomial in the parameters.
    slopes: Option<Slopes>,
    /// Further solved states, whose displacements are added.
    anchors: Option<Arc<Anchors>>,
}

/// Outputs per unit of each term of the standardised parameters, see [`terms`].
#[derive(Debug, Clone)]
struct Slopes {
    /// `[terms, 6 × clusters]`.
    clusters: Tensor<2>,
    /// `[terms, 3 × real nodes]`.
    nodes: Tensor<2>,
    /// `[terms of the parameters, 1]`: rates of the logarithm of an amplitude a, which multiplies the terms. The last term
    /// is then 1 − a.
    rates: Option<Tensor<2>>,
}

impl Slopes {
    fn new(coordinates: &Coordinates, of_clusters: usize, device: &Device) -> Option<Self> {
        let (slopes, rates) = (coordinates.slopes(), coordinates.rates());
        let part = |range: fn(&[f64], usize) -> &[f64]| {
            let rows: Vec<f64> =
                slopes.iter().flat_map(|row| range(row, of_clusters)).copied().collect();
            matrix(&rows, slopes.len(), device)
        };
        (!slopes.is_empty()).then(|| Self {
            clusters: part(|row, at| &row[..at]),
            nodes: part(|row, at| &row[at..]),
            rates: (!rates.is_empty()).then(|| matrix(rates, rates.len(), device)),
        })
    }

    /// Taylor terms at parameters, a row for each sample.
    fn terms(&self, parameters: Tensor<2>) -> Tensor<2> {
        let plain = Tensor::cat(terms(parameters.clone()), 1);
        match &self.rates {
            None => plain.slice_dim(1, 0..self.nodes.dims()[0]),
            Some(rates) => {
                let bounded = (plain.clone().matmul(rates.clone()) / MOST).tanh();
                let amplitude = (bounded * MOST).exp();
                Tensor::cat(vec![plain * amplitude.clone(), amplitude.neg() + 1.0], 1)
            }
        }
    }

    /// Derivatives of these along a direction of the parameters in each row.
    fn terms_along(&self, parameters: Tensor<2>, direction: Tensor<2>) -> Tensor<2> {
        let change = Tensor::cat(terms_along(parameters.clone(), direction.clone()), 1);
        match &self.rates {
            None => change.slice_dim(1, 0..self.nodes.dims()[0]),
            Some(rates) => {
                let plain = Tensor::cat(terms(parameters.clone()), 1);
                let bounded = (plain.clone().matmul(rates.clone()) / MOST).tanh();
                let slope = (bounded.clone() * bounded.clone()).neg() + 1.0;
                let amplitude = (bounded * MOST).exp();
                let of_amplitude = amplitude.clone() * slope * change.clone().matmul(rates.clone());
                let change = change * amplitude + plain * of_amplitude.clone();
                Tensor::cat(vec![change, of_amplitude.neg()], 1)
            }
        }
    }

    /// Adds the Taylor polynomial of `terms` to `output`, a row for each sample.
    fn add_to(&self, output: Output, terms: Tensor<2>) -> Output {
        let expanded = |outputs: Tensor<3>, slopes: &Tensor<2>| {
            let polynomial = terms.clone().matmul(slopes.clone()).reshape(outputs.dims());
            outputs + polynomial
        };
        Output {
            nodes: expanded(output.nodes, &self.nodes),
            clusters: output.clusters.map(|clusters| expanded(clusters, &self.clusters)),
            added: output.added,
        }
    }
}

/// The parameters, then their products `p_i p_j` with `j ≥ i`, ordered by i.
fn terms(parameters: Tensor<2>) -> Vec<Tensor<2>> {
    let count = parameters.dims()[1];
    let part = |range| parameters.clone().slice_dim(1, range);
    let products = (0..count).map(|i| part(i..i + 1) * part(i..count));
    std::iter::once(parameters.clone()).chain(products).collect()
}

/// Derivatives of the terms along a direction of the parameters in each row.
fn terms_along(parameters: Tensor<2>, direction: Tensor<2>) -> Vec<Tensor<2>> {
    let count = parameters.dims()[1];
    let part = |of: &Tensor<2>, range| of.clone().slice_dim(1, range);
    let products = (0..count).map(|i| {
        part(&direction, i..i + 1) * part(&parameters, i..count)
            + part(&parameters, i..i + 1) * part(&direction, i..count)
    });
    std::iter::once(direction.clone()).chain(products).collect()
}

/// Map from outputs to displacements beyond those of zero outputs.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "there is one of them per geometry")]
enum Rule {
    /// Times `[1, real nodes, D]`.
    Scale(Tensor<3>),
    /// Applied from the right, one after the other, to outputs flattened over nodes and components.
    Matrices(Vec<Tensor<2>>),
    Motions(Arc<MotionTree>),
}

impl OutputMap {
    pub(crate) fn new(
        geometry: &Geometry,
        scales: &OutputScale,
        [nodes, dimensions]: [usize; 2],
        device: &Device,
    ) -> Self {
        // Per component or per degree of freedom.
        let field = |values: &[f64]| {
            let values: Vec<f64> =
                values.iter().copied().cycle().take(nodes * dimensions).collect();
            matrix(&values, nodes, device).unsqueeze_dim::<3>(0)
        };
        let rule = match &geometry.coordinates {
            Coordinates::Components => Rule::Scale(field(&scales.scale)),
            Coordinates::Motions(motions) => Rule::Motions(motions.tree().clone()),
            Coordinates::Principal(directions) => {
                let matrix = |(entries, columns): (&[f32], usize)| {
                    let shape = [entries.len() / columns.max(1), columns];
                    Tensor::from_data(TensorData::new(entries.to_vec(), shape), device)
                };
                Rule::Matrices(directions.matrices().map(matrix).collect())
            }
        };
        let clusters = match &rule {
            Rule::Motions(tree) => tree.centres.len(),
            Rule::Scale(_) | Rule::Matrices(_) => 0,
        };
        Self {
            slopes: Slopes::new(&geometry.coordinates, 6 * clusters, device),
            origin: field(geometry.coordinates.origin().unwrap_or(&scales.mean)),
            rule,
            supports: Supports::new(&geometry.dirichlet, dimensions, device),
            anchors: geometry.coordinates.anchors().cloned(),
        }
    }

    /// The outputs at standardised parameters, one row per sample, from the network's.
    pub(crate) fn complete(&self, output: Output, parameters: Tensor<2>) -> Output {
        let added = self.of_anchors(&parameters, None);
        let output = match &self.slopes {
            Some(slopes) => {
                let terms = slopes.terms(parameters);
                slopes.add_to(output, terms)
            }
            None => output,
        };
        Output { added, ..output }
    }

    /// Displacements of anchors, a row for each sample, or their changes along directions. They are computed in double precision and are
    /// constants of a training: nothing is learned through them.
    fn of_anchors(&self, parameters: &Tensor<2>, along: Option<&Tensor<2>>) -> Option<Tensor<3>> {
        let anchors = self.anchors.as_ref()?;
        let numbers = |x: &Tensor<2>| -> Vec<f64> {
            x.clone().into_data().iter::<f32>().map(f64::from).collect()
        };
        let ([rows, _], [nodes, dimensions]) = (parameters.dims(), self.dims());
        let found = anchors.at_parameters(&numbers(parameters), along.map(numbers).as_deref());
        // A surrogate is assembled with as many parameters as its anchors have.
        let found = found.unwrap_or_else(|_| vec![f64::NAN; rows * nodes * dimensions]);
        Some(matrix(&found, rows, &parameters.device()).reshape([rows, nodes, dimensions]))
    }

    /// Complete outputs at standardised parameters where a network adds nothing.
    pub(crate) fn without_network(&self, parameters: Tensor<2>) -> Output {
        let ([nodes, dimensions], samples) = (self.dims(), parameters.dims()[0]);
        let zeros = |rows, columns| Tensor::zeros([samples, rows, columns], &parameters.device());
        let clusters = match &self.rule {
            Rule::Motions(tree) => Some(zeros(tree.centres.len(), 6)),
            Rule::Scale(_) | Rule::Matrices(_) => None,
        };
        let nodes = zeros(nodes, dimensions);
        self.complete(Output { nodes, clusters, added: None }, parameters)
    }

    /// Completes derivatives of the outputs in the standardised parameters, those of all samples by the first before those by
    /// the second.
    pub(crate) fn complete_tangents(&self, change: Output, parameters: Tensor<2>) -> Output {
        let Some(slopes) = &self.slopes else { return change }; // anchors come with slopes
        let [rows, count] = parameters.dims();
        let units = Tensor::eye(count, &parameters.device()).reshape([count, 1, count]);
        let directions = units.repeat_dim(1, rows).reshape([count * rows, count]);
        let parameters = parameters.repeat_dim(0, count);
        let added = self.of_anchors(&parameters, Some(&directions));
        let terms = slopes.terms_along(parameters, directions);
        Output { added, ..slopes.add_to(change, terms) }
    }

    /// Displacements `[batch, real nodes, D]` of complete outputs.
    pub(crate) fn displacement(&self, output: Output) -> Tensor<3> {
        let increment = match (&self.rule, output.clusters) {
            (Rule::Motions(tree), Some(clusters)) => rigid_motions(clusters, output.nodes, tree),
            _ => self.linear(output.nodes),
        };
        let increment = output.added.into_iter().fold(increment, |sum, added| sum + added);
        self.supports.write_over(increment + self.origin.clone())
    }

    /// Change of the displacements `[directions · batch, real nodes, D]` along changes of the outputs, samples fastest.
    pub(crate) fn tangent(&self, output: &Output, change: Output) -> Tensor<3> {
        let added = change.added;
        let change = match (&self.rule, &output.clusters, change.clusters) {
            (Rule::Motions(tree), Some(clusters), Some(cluster_change)) => {
                let shape = change.nodes.dims();
                let numbers =
                    |x: &Tensor<3>| -> Vec<f32> { x.clone().into_data().iter::<f32>().collect() };
                let at = (&numbers(clusters)[..], &numbers(&output.nodes)[..]);
                let along = (&numbers(&cluster_change)[..], &numbers(&change.nodes)[..]);
                let tangent = tree.tangent(at, along);
                let tangent: Vec<f32> = tangent.into_iter().map(|t| t as f32).collect();
                Tensor::from_data(TensorData::new(tangent, shape), &change.nodes.device())
            }
            _ => self.linear(change.nodes),
        };
        self.supports.project(added.into_iter().fold(change, |sum, added| sum + added))
    }

    fn linear(&self, output: Tensor<3>) -> Tensor<3> {
        match &self.rule {
            Rule::Scale(scale) => output * scale.clone(),
            Rule::Matrices(matrices) => {
                let [batch, nodes, dimensions] = output.dims();
                let flat = output.reshape([batch, nodes * dimensions]);
                let mapped = matrices.iter().fold(flat, |row, matrix| row.matmul(matrix.clone()));
                mapped.reshape([batch, nodes, dimensions])
            }
            // Without outputs of clusters, the clusters stay at rest.
            Rule::Motions(tree) => {
                let [batch, ..] = output.dims();
                let clusters = Tensor::zeros([batch, tree.centres.len(), 6], &output.device());
                rigid_motions(clusters, output, tree)
            }
        }
    }

    /// Map on the device of an automatically differentiated network.
    pub(crate) fn lifted(&self) -> Self {
        Self {
            origin: Tensor::from_inner(self.origin.clone()),
            rule: match &self.rule {
                Rule::Scale(scale) => Rule::Scale(Tensor::from_inner(scale.clone())),
                Rule::Matrices(all) => {
                    Rule::Matrices(all.iter().cloned().map(Tensor::from_inner).collect())
                }
                Rule::Motions(tree) => Rule::Motions(tree.clone()),
            },
            supports: self.supports.lifted(),
            slopes: self.slopes.as_ref().map(|slopes| Slopes {
                clusters: Tensor::from_inner(slopes.clusters.clone()),
                nodes: Tensor::from_inner(slopes.nodes.clone()),
                rates: slopes.rates.clone().map(Tensor::from_inner),
            }),
            anchors: self.anchors.clone(),
        }
    }

    /// Nodes and components of a displacement.
    pub(crate) fn dims(&self) -> [usize; 2] {
        self.supports.dims()
    }
}

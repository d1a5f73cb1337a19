//! Storage of motions.

use super::Motions;
use crate::coordinates::{Anchors, MotionTree, packed};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Motions with their numbers as bytes, so that they are read to the bit.
#[derive(Serialize, Deserialize)]
pub(super) struct Packed {
    unknowns: usize,
    node_parents: Vec<usize>,
    cluster_parents: Vec<Option<usize>>,
    origin: String,
    positions: String,
    centres: String,
    node_scales: String,
    cluster_scales: String,
    #[serde(default)]
    slopes: Vec<String>,
    #[serde(default)]
    rates: Vec<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    anchors: Option<Anchors>,
}

impl From<Motions> for Packed {
    fn from(motions: Motions) -> Self {
        let tree = &motions.tree;
        Self {
            unknowns: motions.unknowns,
            node_parents: tree.node_parents.clone(),
            cluster_parents: tree.cluster_parents.clone(),
            origin: packed::doubles(&motions.origin),
            positions: packed::doubles(tree.positions.as_flattened()),
            centres: packed::doubles(tree.centres.as_flattened()),
            node_scales: packed::doubles(tree.node_scales.as_flattened().as_flattened()),
            cluster_scales: packed::doubles(tree.cluster_scales.as_flattened().as_flattened()),
            slopes: motions.slopes.iter().map(|slope| packed::doubles(slope)).collect(),
            rates: motions.rates.to_vec(),
            anchors: motions.anchors.as_deref().cloned(),
        }
    }
}

impl TryFrom<Packed> for Motions {
    type Error = String;

    fn try_from(packed: Packed) -> std::result::Result<Self, String> {
        let (nodes, clusters) = (packed.node_parents.len(), packed.cluster_parents.len());
        let read = |text: &str, count: usize| packed::read_doubles(text, count);
        let known = packed.node_parents.iter().all(|&parent| parent < clusters);
        let ascending = packed.cluster_parents.iter().enumerate();
        if !known || !ascending.clone().all(|(k, p)| p.is_none_or(|p| p > k && p < clusters)) {
            return Err("clusters of the outputs do not form a tree".into());
        }
        let tree = MotionTree {
            positions: read(&packed.positions, 3 * nodes)?.as_chunks().0.to_vec(),
            centres: read(&packed.centres, 3 * clusters)?.as_chunks().0.to_vec(),
            node_scales: read(&packed.node_scales, 9 * nodes)?.as_chunks().0.as_chunks().0.to_vec(),
            cluster_scales: read(&packed.cluster_scales, 36 * clusters)?
                .as_chunks()
                .0
                .as_chunks()
                .0
                .to_vec(),
            node_parents: packed.node_parents,
            cluster_parents: packed.cluster_parents,
        };
        let origin: Arc<[f64]> = read(&packed.origin, 3 * nodes)?.into();
        let slopes = packed.slopes.iter().map(|slope| read(slope, 6 * clusters + 3 * nodes));
        let slopes: Arc<[Vec<f64>]> = slopes.collect::<std::result::Result<_, _>>()?;
        let rates: Arc<[f64]> = packed.rates.into();
        if !rates.is_empty() && rates.len() + 1 != slopes.len() {
            return Err("the amplitude of the outputs has other terms than they".into());
        }
        if packed.anchors.as_ref().is_some_and(|anchors| anchors.length() != origin.len()) {
            return Err("the anchors of the outputs have other nodes than they".into());
        }
        let (unknowns, anchors) = (packed.unknowns, packed.anchors.map(Arc::new));
        Ok(Self { origin, unknowns, tree: tree.into(), slopes, rates, anchors })
    }
}

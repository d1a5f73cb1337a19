//! Options for the mesh of a wall, and numbers of its cells.

use super::trees::Result;
use crate::Refusal;

/// Factor between the edge sizes tried for a given number of nodes.
const FINER: f64 = 0.98;
/// Largest aspect ratio along the axis to meet a given number of nodes, and its weight relative to that of the number.
const LONGER: f64 = 1.25;
const STRETCHED: f64 = 0.2;
/// Numbers of nodes and layers that are made.
const NODES: std::ops::RangeInclusive<usize> = 60..=3_000_000;
const LAYERS: std::ops::RangeInclusive<usize> = 1..=100;
/// Shortest edges relative to the way around.
const SHORTEST: f64 = 1e-4;

/// Options for the mesh of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallOptions {
    /// Fineness of the mesh.
    pub size: Size,
    /// Layers of cells; by default as many as make cells about as thick as wide, but at least two.
    pub layers: Option<usize>,
    /// Base.
    pub trim: Trim,
}

impl Default for WallOptions {
    fn default() -> Self {
        Self { size: Size::Nodes(1500), layers: None, trim: Trim::Auto }
    }
}

/// Fineness of a mesh, by its nodes or by its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Approximate number of nodes.
    Nodes(usize),
    /// Edges about this long \[length\].
    Edge(f64),
}

/// Base of a ventricle: cells beyond it are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trim {
    /// The highest plane normal to the axis that is below the rims of the endocardium (its valves) and cuts a wall of
    /// at least half its median thickness; the plane of the rims itself if they are plane and it does.
    Auto,
    /// The plane across the axis at this fraction of the way from the apex to the middle of the rims.
    Fraction(f64),
    /// A plane.
    Plane {
        /// A point of it \[length\].
        point: [f64; 3],
        /// Normal of the plane, either way round.
        normal: [f64; 3],
    },
}

/// Lengths of a wall.
pub(super) struct Lengths {
    /// The longest way around.
    pub around: f64,
    /// The way from the apex to the base.
    pub along: f64,
    pub thickness: f64,
}

/// Layers, cells around and cells from the apex to the base.
type Cells = [usize; 3];

impl Lengths {
    pub(super) fn cells(&self, options: &WallOptions) -> Result<Cells> {
        let fail = |what: String| {
            Err(Refusal(format!(
                "{what}; give 60 to 3000000 nodes, or a positive length of edges, and at least one layer"
            )))
        };
        if let Some(layers) = options.layers.filter(|layers| !LAYERS.contains(layers)) {
            return fail(format!("{layers} layers cannot be made"));
        }
        match options.size {
            Size::Edge(edge) if edge.is_finite() && edge > SHORTEST * self.around => {
                let cells = self.even(edge, options.layers);
                match nodes(cells) {
                    count if count > *NODES.end() => fail(format!("these are {count} nodes")),
                    _ => Ok(cells),
                }
            }
            Size::Edge(edge) => fail(format!("edges cannot be {edge} long")),
            Size::Nodes(wanted) if NODES.contains(&wanted) => {
                let few = || fail(format!("{wanted} nodes are too few for so many layers"));
                self.about(wanted, options.layers).map_or_else(few, Ok)
            }
            Size::Nodes(wanted) => fail(format!("{wanted} nodes cannot be made")),
        }
    }

    /// Cells as long as wide and, where layers are not given, as thick.
    fn even(&self, edge: f64, layers: Option<usize>) -> Cells {
        let count = |length: f64| (length / edge).round().max(1.0) as usize;
        let half = count(self.around / 8.0);
        let layers = layers.unwrap_or_else(|| count(self.thickness).clamp(2, *LAYERS.end()));
        [layers, 8 * half, count(self.along).max(half + 2)]
    }

    /// Nearly even cells that make about so many nodes.
    fn about(&self, wanted: usize, layers: Option<usize>) -> Option<Cells> {
        let sizes = std::iter::successors(Some(self.around / 4.0), |edge| Some(edge * FINER));
        let even = sizes.map(|edge| self.even(edge, layers));
        let tried = even.take_while(|&cells| nodes(cells) < 2 * wanted);
        // Layers and cells around come in steps, those along the axis make up for them.
        let exact = |[layers, around, along]: Cells| {
            let (half, even) = (around / 8, along as f64);
            let rings = (wanted / (layers + 1)).saturating_sub((2 * half + 1).pow(2));
            let along = half as f64 + rings as f64 / around as f64;
            let along = along.clamp(even / LONGER, even * LONGER).round() as usize;
            [layers, around, along.max(half + 2)]
        };
        let apart = |(even, cells): &(Cells, Cells)| {
            let off = nodes(*cells) as f64 / wanted as f64;
            let stretched = cells[2] as f64 / even[2] as f64;
            off.ln().abs() + STRETCHED * stretched.ln().abs()
        };
        let tried = tried.map(|even| (even, exact(even)));
        tried.min_by(|a, b| apart(a).total_cmp(&apart(b))).map(|(_, cells)| cells)
    }
}

fn nodes([layers, around, along]: Cells) -> usize {
    let half = around / 8;
    (layers + 1) * ((2 * half + 1).pow(2) + around * (along - half))
}

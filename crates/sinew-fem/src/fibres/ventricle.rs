//! Depth in the wall and direction to the base of any ventricle, by Laplace problems.

use crate::fibres::potential::Laplacian;
use crate::fibres::rule::Layer;
use crate::fibres::{FibreError, FibreRule, Frame, Result};
use nalgebra::Vector3;
use sinew_mesh::{Facet, TetMesh};
use sinew_num::connected_components;

/// Coordinates in the wall of a ventricle, and its fibres: the Laplace–Dirichlet rule of J. D. Bayer et al., Ann.
/// Biomed. Eng. 40 (2012), for one ventricle.
///
/// With one ventricle the rule's interpolation between the frames of two surfaces is a rotation by an angle
/// linear in the depth. It differs from the paper where closed forms favour it (the ellipsoid of Land et al., six
/// layers of cells):
///
/// - Fibres lie in the layers of equal thickness exactly; the direction to the base is projected on the layer.
///   The paper projects the other way round; its sheets are up to 18° off, ours 3°.
/// - The apex, where the longitudinal potential is 0, is a pair of nodes, one on each surface: the farthest from
///   the base in the sense of `−Δh = 1`, h = 0 on the base, which does not depend on coordinates.
/// - The depth is the share of the thickness: the solution of `∇·(|∇φ| ∇d) = 0`, φ the harmonic potential between the
///   surfaces. The paper takes φ itself, which rises more steeply at the endocardium the more the wall is curved:
///   half-way through a sphere with radii 1 : 1.5 it is 0.6, so that fibres of the ellipsoid are 4° to 8° off.
///
/// # The apex
/// Around the line between the two apexes the circumferential direction turns once, so no field is continuous
/// there. Fibres remain unit vectors in their layers; where the way to the base vanishes to rounding, it is
/// taken along the longest edge of a cell, which the order of cells and nodes decides on a symmetric mesh ([`Self::axis`]).
#[derive(Clone, Debug)]
pub struct VentricleCoordinates {
    /// Fraction of the wall's thickness between endocardium and node, 0 on the endocardium and 1 on the epicardium.
    pub thickness: Vec<f64>,
    /// The harmonic function that is 0 at the apexes and 1 on the base, at each node.
    pub longitudinal: Vec<f64>,
    /// The nodes of the apexes, on the endocardium and the epicardium.
    pub apexes: [usize; 2],
    /// Nodes without a way to the base: on the axis of a symmetric wall.
    pub axis: Vec<usize>,
    cells: Vec<[usize; 4]>,
    cell_layers: Vec<Layer>,
    node_layers: Vec<Layer>,
}

impl VentricleCoordinates {
    /// Solves for the potentials.
    ///
    /// # Errors
    /// Surfaces that are missing, empty or touching, and cells or parts of the mesh that they do not bound.
    pub fn new(mesh: &TetMesh, surfaces: &Surfaces<'_>) -> Result<Self> {
        mesh.check()?;
        if mesh.cells.is_empty() {
            return Err(FibreError::Unfit("the mesh has no tetrahedra".into()));
        }
        let bounds = Bounds::new(mesh, surfaces)?;
        let laplacian = Laplacian::new(mesh)?;

        let walls = bounds.prescribe(&[(&bounds.endocardium, 0.0), (&bounds.epicardium, 1.0)]);
        let across = || {
            let gradients = laplacian.gradients(&laplacian.solve(&walls, 0.0, None)?);
            // Bounded from below for cells with all their nodes on one surface.
            let least = NO_DIRECTION * mean_length(&gradients);
            let conductivity: Vec<_> =
                gradients.iter().map(|slope| slope.norm().max(least)).collect();
            laplacian.solve(&walls, 0.0, Some(&conductivity))
        };
        let along = || {
            let distance = laplacian.solve(&bounds.prescribe(&[(&bounds.base, 0.0)]), 1.0, None)?;
            let apexes = bounds.apexes(&distance)?;
            let ends = bounds.prescribe(&[(&bounds.base, 1.0), (&apexes, 0.0)]);
            Ok::<_, FibreError>((laplacian.solve(&ends, 0.0, None)?, apexes))
        };
        let (thickness, along) = rayon::join(across, along);
        let (thickness, (longitudinal, apexes)) = (thickness?, along?);

        let outward = directions(&laplacian, &thickness);
        let to_base = directions(&laplacian, &longitudinal);
        let cell_layer = |(cell, nodes): (usize, &[usize; 4])| {
            let outward = at_centre(nodes, &outward);
            let mut ways = std::iter::once(at_centre(nodes, &to_base)).chain(edges(mesh, cell));
            ways.find_map(|way| Layer::new(outward, way)).ok_or_else(|| FibreError::Unfit(format!("cell {cell} and its neighbours have all their nodes on one surface of the wall; refine the mesh across the wall")))
        };
        let cell_layers = mesh.cells.iter().enumerate().map(cell_layer);
        let cell_layers = cell_layers.collect::<Result<Vec<_>>>()?;
        let node_layers = layers_of_nodes(mesh, &outward, &to_base, &cell_layers);
        let lost = |&node: &usize| Layer::new(outward[node], to_base[node]).is_none();
        let axis = (0..mesh.points.len()).filter(lost).collect();
        let cells = mesh.cells.clone();
        Ok(Self { thickness, longitudinal, apexes, axis, cells, cell_layers, node_layers })
    }

    /// The frame at the centre of each cell.
    pub fn cell_frames(&self, rule: &FibreRule) -> Vec<Frame> {
        let depth = |&node: &usize| self.thickness[node];
        let centre = |nodes: &[usize; 4]| nodes.iter().map(depth).sum::<f64>() / 4.0;
        let cells = self.cells.iter().zip(&self.cell_layers);
        cells.map(|(nodes, layer)| rule.frame(centre(nodes), layer)).collect()
    }

    /// The frame at each node.
    pub fn node_frames(&self, rule: &FibreRule) -> Vec<Frame> {
        let nodes = self.thickness.iter().zip(&self.node_layers);
        nodes.map(|(&depth, layer)| rule.frame(depth, layer)).collect()
    }
}

/// A gradient below this, relative to the mean of all cells, has no direction.
const NO_DIRECTION: f64 = 1e-6;

fn mean_length(gradients: &[Vector3<f64>]) -> f64 {
    gradients.iter().map(Vector3::norm).sum::<f64>() / gradients.len() as f64
}

/// Gradients of a potential at the nodes, zero where they have no direction: means over the adjacent cells, more
/// accurate than the gradient of one cell (sheets to 0.2° instead of 1.7°).
fn directions(laplacian: &Laplacian<'_>, potential: &[f64]) -> Vec<Vector3<f64>> {
    let of_cells = laplacian.gradients(potential);
    let least = NO_DIRECTION * mean_length(&of_cells);
    let mut of_nodes = laplacian.around_nodes(&of_cells);
    of_nodes.iter_mut().filter(|g| g.norm() <= least).for_each(|g| *g = Vector3::zeros());
    of_nodes
}

/// Mean of a field over the nodes of a cell.
fn at_centre(nodes: &[usize; 4], of_nodes: &[Vector3<f64>]) -> Vector3<f64> {
    nodes.iter().map(|&node| of_nodes[node]).sum::<Vector3<f64>>() / 4.0
}

/// Edges of a cell, the longest first. They are not all parallel to any direction.
fn edges(mesh: &TetMesh, cell: usize) -> Vec<Vector3<f64>> {
    let corners = mesh.corners(cell);
    let pairs = (0..4).flat_map(|a| (0..a).map(move |b| (a, b)));
    let mut edges: Vec<_> = pairs.map(|(a, b)| corners[a] - corners[b]).collect();
    edges.sort_by(|a, b| b.norm_squared().total_cmp(&a.norm_squared()));
    edges
}

/// Directions at nodes; a node without one takes that of the first cell around it.
fn layers_of_nodes(
    mesh: &TetMesh,
    outward: &[Vector3<f64>],
    to_base: &[Vector3<f64>],
    of_cells: &[Layer],
) -> Vec<Layer> {
    let mut first_cell = vec![0; mesh.points.len()];
    for (cell, nodes) in mesh.cells.iter().enumerate().rev() {
        nodes.iter().for_each(|&node| first_cell[node] = cell);
    }
    let layer = |node: usize| {
        let cell = of_cells[first_cell[node]];
        Layer::new(outward[node], to_base[node])
            .or_else(|| Layer::new(outward[node], cell.longitudinal))
            .unwrap_or(cell)
    };
    (0..mesh.points.len()).map(layer).collect()
}

/// Names of the facet sets that bound a ventricle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surfaces<'a> {
    /// The inner surface.
    pub endocardium: &'a str,
    /// The outer surface.
    pub epicardium: &'a str,
    /// The rim at the valves.
    pub base: &'a str,
}

/// Nodes of the surfaces.
struct Bounds {
    endocardium: Vec<usize>,
    epicardium: Vec<usize>,
    base: Vec<usize>,
    nodes: usize,
}

impl Bounds {
    /// # Errors
    /// Surfaces that are missing, empty or touching, and parts of the mesh that do not reach one.
    fn new(mesh: &TetMesh, names: &Surfaces<'_>) -> Result<Self> {
        let nodes_of = |name: &str| facets(mesh, name).map(|facets| mesh.nodes_of_facets(facets));
        let bounds = Self {
            endocardium: nodes_of(names.endocardium)?,
            epicardium: nodes_of(names.epicardium)?,
            base: nodes_of(names.base)?,
            nodes: mesh.points.len(),
        };
        let inner = |node: &&usize| bounds.endocardium.binary_search(node).is_ok();
        let mut shared = bounds.epicardium.iter().filter(inner);
        if let Some(&node) = shared.next() {
            return Err(FibreError::Unfit(format!(
                "endocardium and epicardium share {} nodes, the first is node {node}; facets of the base belong to a set of their own",
                1 + shared.count()
            )));
        }
        // Each connected part of the mesh has a node on each surface.
        let parts = connected_components(mesh.points.len(), &mesh.cells);
        for (nodes, name) in [
            (&bounds.endocardium, names.endocardium),
            (&bounds.epicardium, names.epicardium),
            (&bounds.base, names.base),
        ] {
            let apart = |part: &&Vec<usize>| part.iter().all(|n| nodes.binary_search(n).is_err());
            if let Some(part) = parts.iter().find(apart) {
                let (node, nodes) = (part[0], part.len());
                return Err(FibreError::Unfit(format!(
                    "the part of the mesh with node {node} ({nodes} nodes) has no node on `{name}`; remove it, or mesh the ventricle in one piece"
                )));
            }
        }
        Ok(bounds)
    }

    /// Values at sets of nodes; later sets override earlier ones.
    fn prescribe(&self, sets: &[(&[usize], f64)]) -> Vec<Option<f64>> {
        let mut prescribed = vec![None; self.nodes];
        for (set, value) in sets {
            set.iter().for_each(|&node| prescribed[node] = Some(*value));
        }
        prescribed
    }

    /// The nodes of endocardium and epicardium farthest from the base.
    ///
    /// # Errors
    /// A surface of which each node is on the base.
    fn apexes(&self, distance: &[f64]) -> Result<[usize; 2]> {
        let farthest = |nodes: &[usize]| {
            let apex = nodes.iter().copied().max_by(|&a, &b| distance[a].total_cmp(&distance[b]));
            let apex = apex.filter(|&node| distance[node] > 0.0);
            apex.ok_or_else(|| FibreError::Unfit(format!("there is no apex: all {} nodes of a surface of the wall are on the base; keep its facets out of the base", nodes.len())))
        };
        Ok([farthest(&self.endocardium)?, farthest(&self.epicardium)?])
    }
}

fn facets<'m>(mesh: &'m TetMesh, name: &str) -> Result<&'m [Facet]> {
    match mesh.facet_sets.get(name).map(Vec::as_slice) {
        None => {
            let known = mesh.facet_sets.keys().cloned().collect();
            Err(FibreError::UnknownSurface { name: name.into(), known })
        }
        Some([]) => Err(FibreError::EmptySurface { name: name.into() }),
        Some(facets) => Ok(facets),
    }
}

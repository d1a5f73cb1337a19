//! A scene: what is computed, by name.

use crate::Magnitude;
use sinew_mesh::Mesh;

/// A body, its material, loads and supports, named the way a person names them.
///
/// [`Scene::lower`] turns it into the plain arrays of a [`crate::TotalPotential`]. θ lists the
/// parameters of the law in the order of [`crate::Law::PARAMETERS`], then those of the loads.
///
/// The number `N` of nodes of a cell chooses the element, see [`crate::Nodes`]: 4 are linear tetrahedra.
/// Triangles (3 or 6 nodes) are a slice of unit thickness in plane strain.
#[derive(Clone, Debug)]
pub struct Scene<L, const D: usize, const N: usize = 4> {
    /// Name of the scene, for reports.
    pub name: String,
    /// Units of all numbers of the scene.
    pub units: Units,
    /// The reference configuration, with the named sets that loads and supports refer to.
    pub mesh: Mesh<N>,
    /// Strain-energy law.
    pub law: L,
    /// Unit material directions, one row per cell, per quadrature point or per node, told apart by their
    /// number in this order; empty for an isotropic law (`D = 0`).
    pub directions: Vec<[[f64; 3]; D]>,
    /// Names, units and ranges of θ.
    pub parameters: Vec<Parameter>,
    /// What acts on the body.
    pub loads: Vec<Load>,
    /// Where the body is held.
    pub supports: Vec<Support>,
}

/// A consistent system of units; the others follow, such as force = stress·length².
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Units {
    /// Unit of length, such as `"mm"`.
    pub length: String,
    /// Unit of stress and of elastic moduli, such as `"kPa"`.
    pub stress: String,
}

impl Units {
    /// Millimetres and kilopascals, the units of the thesis' scenes.
    pub fn mm_kpa() -> Self {
        Self { length: "mm".into(), stress: "kPa".into() }
    }
}

/// One entry of θ.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, such as `"mu"`.
    pub name: String,
    /// Unit, such as `"kPa"`.
    pub unit: String,
    /// Smallest and largest value of interest.
    pub range: [f64; 2],
    /// How samples are spread over the range.
    pub sampling: Sampling,
}

/// How samples of a parameter are spread over its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Uniform in the logarithm.
    Log,
    /// Uniform.
    Linear,
}

/// A load.
#[derive(Clone, Debug, PartialEq)]
pub enum Load {
    /// Force per reference volume [stress/length], the same everywhere: gravity.
    BodyForce([f64; 3]),
    /// Dead force per reference area \[stress\].
    Traction {
        /// Named facet set.
        facets: String,
        /// Force per reference area \[stress\].
        value: [f64; 3],
    },
    /// An elastic foundation (Robin condition): the force per reference area `−normal (u·n)n −
    /// tangential (u − (u·n)n)` with the outward normal n at rest.
    Foundation {
        /// Named facet set.
        facets: String,
        /// Stiffness against motion along the normal [stress/length].
        normal: f64,
        /// Stiffness against motion in the surface [stress/length].
        tangential: f64,
    },
    /// A true follower pressure, see [`crate::PressureForm::Follower`].
    ///
    /// Each edge of the surface's rim must be held, or slide in a coordinate plane.
    Pressure {
        /// Named facet set.
        facets: String,
        /// Pressure against the solid \[stress\].
        magnitude: Magnitude,
    },
    /// The thesis' stand-in for a pressure, see [`crate::PressureForm::Thesis`]: to reproduce its numbers only.
    ThesisPressure {
        /// Named facet set.
        facets: String,
        /// Pressure against the solid \[stress\].
        magnitude: Magnitude,
    },
}

/// A support: prescribed displacements of a named node set.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Named node set.
    pub nodes: String,
    /// Prescribed displacement.
    pub displacement: Prescribed,
}

/// Prescribed displacement components \[length\], `None` where the node is free.
#[derive(Clone, Debug, PartialEq)]
pub enum Prescribed {
    /// The same at every node.
    Uniform([Option<f64>; 3]),
    /// One row per node of the set, in its order.
    PerNode(Vec<[Option<f64>; 3]>),
}

impl Support {
    /// All nodes of the set held in place.
    pub fn clamped(nodes: impl Into<String>) -> Self {
        Self::uniform(nodes, [Some(0.0); 3])
    }

    /// The same components \[length\] prescribed at all nodes of the set, `None` where they are free.
    pub fn uniform(nodes: impl Into<String>, components: [Option<f64>; 3]) -> Self {
        Self { nodes: nodes.into(), displacement: Prescribed::Uniform(components) }
    }

    /// Nodes of the set moved by `motion(X)` \[length\], a function of the reference position.
    ///
    /// A set that the mesh lacks is reported when the scene is lowered.
    pub fn moved<const N: usize>(
        nodes: impl Into<String>,
        mesh: &Mesh<N>,
        motion: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Self {
        let nodes = nodes.into();
        let members = mesh.node_sets.get(&nodes).map_or(&[][..], Vec::as_slice);
        let rows = members.iter().filter_map(|&node| mesh.points.get(node));
        let displacement = Prescribed::PerNode(rows.map(|&x| motion(x).map(Some)).collect());
        Self { nodes, displacement }
    }
}

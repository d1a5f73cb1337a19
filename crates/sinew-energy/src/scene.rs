//! Scenes: bodies with material, loads and supports by name.

use crate::discretisation::{Discretisation, Elements};
use crate::{IntoMaterial, Magnitude, Material, Unit};
use sinew_mesh::{AnyMesh, Mesh};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Cells of a patch of linear tetrahedra: enough for less than one volume constraint per node.
const CELLS_OF_PATCH: usize = 8;

/// A body with its material, loads and supports, addressed by names.
///
/// [`Scene::lower`] turns it into the plain arrays of a [`crate::Body`]. θ lists the
/// parameters of the law in the order of [`crate::Law::PARAMETERS`] and by these names, then those of the loads, whose names are free.
///
/// The cells of the mesh choose the element, see [`sinew_mesh::Mesh`].
/// Triangles (3 or 6 nodes) are a slice of unit thickness in plane strain.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the scene, for reports.
    pub name: String,
    /// Units of all numbers of the scene.
    pub units: Units,
    /// The reference configuration, with the named sets that loads and supports refer to.
    pub mesh: AnyMesh,
    /// Strain-energy law with its unit material directions, one row per cell, per quadrature point or per node
    /// ([`crate::Law::along`]).
    pub material: Arc<dyn Material>,
    /// Names, units and ranges of θ.
    pub parameters: Vec<Parameter>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Supports.
    pub supports: Vec<Support>,
    /// Choice of finite elements.
    pub discretisation: Discretisation,
}

impl Scene {
    /// A scene in millimetres and kilopascals without parameters, loads and supports, to be added by the calls below.
    ///
    /// ```
    /// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    ///
    /// let beam = Scene::new(sinew_mesh::box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
    ///     .support(Support::clamped("x_min"));
    /// assert_eq!(beam.lower()?.theta_len(), 2);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    ///
    /// A law with fibres is given with them, `law.along(fibres)`; by itself it does not compile:
    ///
    /// ```compile_fail,E0277
    /// # use sinew_energy::{Scene, laws::HolzapfelOgden};
    /// let mesh = sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]);
    /// Scene::new(mesh, HolzapfelOgden.nearly_incompressible(25.0));
    /// ```
    pub fn new(mesh: impl Into<AnyMesh>, material: impl IntoMaterial) -> Self {
        Self {
            name: "body".into(),
            units: Units { length: "mm".into(), stress: "kPa".into() },
            mesh: mesh.into(),
            material: material.into_material(),
            parameters: Vec::new(),
            loads: Vec::new(),
            supports: Vec::new(),
            discretisation: Discretisation::default(),
        }
    }

    /// Names the scene.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Adds an entry of θ.
    pub fn parameter(mut self, parameter: Parameter) -> Self {
        self.parameters.push(parameter);
        self
    }

    /// Adds a load.
    pub fn load(mut self, load: Load) -> Self {
        self.loads.push(load);
        self
    }

    /// Adds a support.
    pub fn support(mut self, support: Support) -> Self {
        self.supports.push(support);
        self
    }

    /// Elements without volumetric locking: one averaged volume ratio per hexahedron, or per patch of about
    /// eight linear tetrahedra.
    #[doc(alias("F-bar", "locking"))]
    pub fn averaged(self) -> Self {
        self.averaged_over(CELLS_OF_PATCH)
    }

    /// Elements of [`Scene::averaged`] with about `cells` linear tetrahedra per patch.
    pub fn averaged_over(mut self, cells: usize) -> Self {
        self.discretisation.elements = Elements::Averaged { cells };
        self
    }

    /// Mixed elements of Taylor and Hood, in a quadratic mesh: quadratic displacement, and a continuous linear
    /// field of pressure that makes the body incompressible, whatever the law's own bulk modulus.
    ///
    /// The law's own volumetric energy stays: it does not change the incompressible solution, and stabilises Newton's
    /// method. Pressures may act on surfaces with a loose rim. The body has no potential, see [`crate::Body::has_potential`].
    ///
    /// ```
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookeanShape};
    /// let mesh = sinew_mesh::box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]).quadratic();
    /// let block = Scene::new(mesh, NeoHookeanShape.nearly_incompressible(10.0))
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
    ///     .support(Support::clamped("x_min"));
    /// assert!(block.lower()?.has_potential());
    /// let body = block.mixed().lower()?;
    /// assert!(!body.has_potential() && body.pressure_field.is_some());
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    #[doc(alias("Taylor-Hood", "mixed formulation"))]
    pub fn mixed(mut self) -> Self {
        self.discretisation = Discretisation { elements: Elements::Mixed, loose_rims: true };
        self
    }

    /// Lets pressures act on surfaces with a loose rim: they have no potential, see [`crate::Body::has_potential`].
    #[doc(alias = "follower load")]
    pub fn loose_rims(mut self) -> Self {
        self.discretisation.loose_rims = true;
        self
    }
}

/// A consistent system of units; the others follow, such as force = stress·length².
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Units {
    /// Unit of length, such as `"mm"`.
    pub length: String,
    /// Unit of stress and of elastic moduli, such as `"kPa"`.
    pub stress: String,
}

/// One entry of θ.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name, such as `"mu"`.
    pub name: String,
    /// Unit that people write and read its values in, such as `"kPa"`.
    pub unit: Unit,
    /// Smallest and largest value of interest, in the unit of the scene.
    pub range: [f64; 2],
    /// Distribution of samples over the range.
    pub sampling: Sampling,
}

impl Parameter {
    /// A parameter whose samples are uniform in the logarithm, such as a stiffness.
    pub fn log(name: impl Into<String>, unit: impl Into<Unit>, range: RangeInclusive<f64>) -> Self {
        Self { sampling: Sampling::Log, ..Self::linear(name, unit, range) }
    }

    /// A parameter whose samples are uniform, such as a pressure.
    pub fn linear(
        name: impl Into<String>,
        unit: impl Into<Unit>,
        range: RangeInclusive<f64>,
    ) -> Self {
        let range = [*range.start(), *range.end()];
        Self { name: name.into(), unit: unit.into(), range, sampling: Sampling::Linear }
    }

    /// The value at a share of the range, on the scale of the sampling: the middle at one half.
    pub fn at_share(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        match self.sampling {
            Sampling::Log => low * (high / low).powf(share),
            Sampling::Linear => low + (high - low) * share,
        }
    }
}

/// Distribution of a parameter's samples over its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
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
    #[doc(alias = "gravity")]
    BodyForce([f64; 3]),
    /// Dead force on each node [stress·length²]: point loads, and loads that vary from place to place, integrated by other code.
    #[doc(alias("point load", "concentrated force"))]
    NodalForces(Vec<[f64; 3]>),
    /// Dead force per reference area \[stress\].
    #[doc(alias("Neumann", "dead load"))]
    Traction {
        /// Named facet set.
        facets: String,
        /// Force per reference area \[stress\].
        value: [f64; 3],
    },
    /// An elastic foundation (Robin condition): the force per reference area `−normal (u·n)n −
    /// tangential (u − (u·n)n)` with the outward normal n at rest. Its energy is integrated over the facets.
    #[doc(alias("Robin", "spring"))]
    Foundation {
        /// Named facet set.
        facets: String,
        /// Stiffness against motion along the normal [stress/length].
        normal: f64,
        /// Stiffness against motion in the surface [stress/length].
        tangential: f64,
    },
    /// A true follower pressure: the potential `p (V(u) − V(0))` with the volume V that the surface encloses, counted along the outward normal of the solid.
    ///
    /// Each edge of the surface's rim must be held, or slide in a coordinate plane; where it moves freely, [`Load::CavityPressure`]
    /// has a potential.
    #[doc(alias = "follower load")]
    Pressure {
        /// Named facet set.
        facets: String,
        /// Pressure against the solid \[stress\].
        magnitude: Magnitude,
    },
    /// A true follower pressure in the whole cavity behind a surface: it acts on the surface and on a lid over each rim, which
    /// moves with it. Its potential is −p times the volume of [`crate::Cavity`], however the rims move.
    ///
    /// ```
    /// use sinew_energy::{Load, Magnitude, Parameter, Scene, laws::NeoHookean};
    ///
    /// let tube = sinew_mesh::TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra();
    /// let body = Scene::new(tube, NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .load(Load::CavityPressure { facets: "endo".into(), magnitude: Magnitude::Fixed(2.0) })
    ///     .load(Load::Foundation { facets: "epi".into(), normal: 1.0, tangential: 0.1 })
    ///     .lower()?;
    /// let rest = vec![0.0; 3 * body.nodes];
    /// let wider: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.1 * x[1], 0.0]).collect();
    /// let growth = body.cavity_volumes(&wider)[0] - body.cavity_volumes(&rest)[0];
    /// assert!((body.load_value(&wider, &[1.0, 1.0]) / (-2.0 * growth) - 1.0).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    #[doc(alias("chamber pressure", "cap"))]
    CavityPressure {
        /// Named facet set.
        facets: String,
        /// Pressure against the solid \[stress\].
        magnitude: Magnitude,
    },
    /// The thesis' formula for a pressure, eqs. (3.14)–(3.16), on linear tetrahedra; only to reproduce its numbers.
    ///
    /// It is the potential of no pressure. Its derivative equals the follower load at u = 0 only,
    /// and on an inflated ventricle the load comes out about 1.3 times too large.
    ThesisPressure {
        /// Named facet set.
        facets: String,
        /// Pressure against the solid \[stress\].
        magnitude: Magnitude,
    },
}

impl Load {
    /// Name of the facet set that the load acts on; `None` for forces on volumes and nodes.
    pub(crate) fn facets(&self) -> Option<&str> {
        match self {
            Self::BodyForce(_) | Self::NodalForces(_) => None,
            Self::Traction { facets, .. }
            | Self::Foundation { facets, .. }
            | Self::Pressure { facets, .. }
            | Self::CavityPressure { facets, .. }
            | Self::ThesisPressure { facets, .. } => Some(facets),
        }
    }

    /// Facet set and size of a pressure; `None` for other loads.
    pub(crate) fn pressure(&self) -> Option<(&str, Magnitude)> {
        match self {
            Self::Pressure { facets, magnitude }
            | Self::CavityPressure { facets, magnitude }
            | Self::ThesisPressure { facets, magnitude } => Some((facets, *magnitude)),
            Self::BodyForce(_)
            | Self::NodalForces(_)
            | Self::Traction { .. }
            | Self::Foundation { .. } => None,
        }
    }
}

/// A support: prescribed displacements of a named node set.
#[doc(alias("Dirichlet", "essential boundary condition"))]
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Named node set.
    pub nodes: String,
    /// Prescribed displacement.
    pub displacement: Prescribed,
}

/// Prescribed displacements \[length\]; components are `None` where the node is free.
///
/// A node may be in several supports that hold it along any directions, as long as they agree where these
/// depend on each other.
#[derive(Clone, Debug, PartialEq)]
pub enum Prescribed {
    /// One value at every node.
    Uniform([Option<f64>; 3]),
    /// One row per node of the set, in its order.
    PerNode(Vec<[Option<f64>; 3]>),
    /// Along one direction; free across it.
    Along {
        /// The direction, of any length but zero.
        direction: [f64; 3],
        /// Displacement along it \[length\].
        displacement: f64,
    },
    /// Free along the radius from an axis; held along the axis and around it.
    Radial {
        /// A point on the axis \[length\].
        point: [f64; 3],
        /// Direction of the axis, of any length but zero.
        axis: [f64; 3],
    },
}

impl Support {
    /// All nodes of the set held in place.
    pub fn clamped(nodes: impl Into<String>) -> Self {
        Self::uniform(nodes, [Some(0.0); 3])
    }

    /// Equal components \[length\] prescribed at all nodes of the set, `None` where they are free.
    pub fn uniform(nodes: impl Into<String>, components: [Option<f64>; 3]) -> Self {
        Self { nodes: nodes.into(), displacement: Prescribed::Uniform(components) }
    }

    /// Nodes of the set moved by a displacement \[length\] along a direction of any length, and free across it.
    ///
    /// A direction without length is reported when the scene is lowered.
    pub fn along(nodes: impl Into<String>, direction: [f64; 3], displacement: f64) -> Self {
        Self { nodes: nodes.into(), displacement: Prescribed::Along { direction, displacement } }
    }

    /// Nodes of the set that stay in their plane with this normal, of any length: rollers on an inclined plane.
    ///
    /// ```
    /// use sinew_energy::Support;
    /// let slope = Support::roller_on_plane("x_min", [1.0, 0.0, 0.2]);
    /// assert_eq!(slope, Support::along("x_min", [1.0, 0.0, 0.2], 0.0));
    /// ```
    #[doc(alias = "symmetry")]
    pub fn roller_on_plane(nodes: impl Into<String>, normal: [f64; 3]) -> Self {
        Self::along(nodes, normal, 0.0)
    }

    /// Nodes of the set that move only along their radius from an axis, given by a point \[length\] and a
    /// direction of any length: the base of a ventricle that may widen but neither lift nor turn.
    ///
    /// A node on the axis, which has no radius, is reported when the scene is lowered.
    ///
    /// ```
    /// use sinew_energy::Support;
    /// let base = Support::radial("base", [0.0; 3], [0.0, 0.0, 1.0]);
    /// ```
    pub fn radial(nodes: impl Into<String>, point: [f64; 3], axis: [f64; 3]) -> Self {
        Self { nodes: nodes.into(), displacement: Prescribed::Radial { point, axis } }
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

//! Choice of finite elements, and of pressures without a potential.

use crate::Scene;
use crate::elements::{Nodes, TaylorHoodElement};

/// Cells of a patch of linear tetrahedra: enough for less than one volume constraint per node.
const CELLS_OF_PATCH: usize = 8;

/// Finite elements and pressures that [`Scene::lower`] makes of a scene; by default those of displacements alone, and pressures
/// that have a potential.
///
/// Chosen by [`Scene::averaged`], [`Scene::mixed`] and [`Scene::loose_rims`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Discretisation {
    pub(crate) elements: Elements,
    pub(crate) loose_rims: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Elements {
    #[default]
    Displacement,
    /// Volume ratios are averaged over this number of tetrahedra.
    Averaged {
        cells: usize,
    },
    Mixed,
}

impl<L, const D: usize, const N: usize> Scene<L, D, N> {
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

    /// Mixed elements of Taylor and Hood: quadratic displacement, and a continuous linear
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
    pub fn mixed(mut self) -> Self
    where
        Nodes<N>: TaylorHoodElement<N>,
    {
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

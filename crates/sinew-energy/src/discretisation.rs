//! Choice of finite elements, and of pressures without a potential.

/// Finite elements and pressures that [`crate::Scene::lower`] makes of a scene; by default those of displacements alone, and pressures
/// that have a potential.
///
/// Chosen by [`crate::Scene::averaged`], [`crate::Scene::mixed`] and [`crate::Scene::loose_rims`].
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

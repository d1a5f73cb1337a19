//! Stands in for the body without type parameters until that lands.

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Parameter, Scene, TotalPotential};
use sinew_mesh::TetMesh;
use std::ops::Deref;

/// A body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name.
    pub name: String,
    /// θ.
    pub parameters: Vec<Parameter>,
    /// Mesh.
    pub mesh: TetMesh,
    potential: TotalPotential<NeoHookean, 0>,
}

impl Deref for Body {
    type Target = TotalPotential<NeoHookean, 0>;
    fn deref(&self) -> &Self::Target {
        &self.potential
    }
}

impl Body {
    /// Lowers.
    pub fn new(scene: &Scene<NeoHookean, 0>) -> Self {
        Self {
            name: scene.name.clone(),
            parameters: scene.parameters.clone(),
            mesh: scene.mesh.clone(),
            potential: scene.lower().unwrap(),
        }
    }
    /// Middle.
    pub fn centre(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| (p.range[0] * p.range[1]).sqrt()).collect()
    }
    /// Free nodes.
    pub fn free_nodes(&self) -> Vec<usize> {
        let rows = self.prescribed.chunks_exact(3).enumerate();
        rows.filter(|(_, row)| row.contains(&None)).map(|(node, _)| node).collect()
    }
    /// Volumes.
    pub fn cavity_volumes(&self, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}

/// With barriers.
pub type Guarded = TotalPotential<NeoHookean, 0, sinew_energy::Barriers>;

impl Body {
    /// With barriers.
    pub fn with_barriers(self, barriers: sinew_energy::Barriers) -> Guarded {
        self.potential.with_guard(barriers)
    }
}

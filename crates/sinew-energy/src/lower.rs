//! From names to plain arrays.

mod directions;
mod geometry;
mod loads;
mod overlaps;

use crate::balance::{ForceBalance, PressureField};
use crate::elements::{FiniteElement, Nodes, QuadraturePoint, TaylorHoodElement};
use crate::{
    Exact, Law, Load, Magnitude, Prescribed, PressureSurface, Sampling, Scene, SceneError,
    TotalPotential,
};
use geometry::shape_functions;
use overlaps::check_overlaps;
use sinew_mesh::{Facet, Mesh};
use std::collections::{BTreeMap, HashSet};

impl<L: Law<D>, const D: usize, const N: usize> Scene<L, D, N>
where
    Nodes<N>: FiniteElement<N>,
{
    /// Checks the scene and lowers it to plain arrays.
    ///
    /// # Errors
    /// The first thing found wrong, with advice.
    pub fn lower(&self) -> Result<TotalPotential<L, D, Exact, N>, SceneError> {
        let (potential, followers) = self.lower_by(Nodes::<N>::QUADRATURE, false)?;
        debug_assert!(followers.is_empty());
        Ok(potential)
    }

    /// Lowers a scene whose pressures may act on surfaces with a loose rim, so that they have no potential.
    ///
    /// # Errors
    /// The first thing found wrong, with advice.
    pub fn lower_follower(&self) -> Result<ForceBalance<L, D, N>, SceneError> {
        let (potential, followers) = self.lower_by(Nodes::<N>::QUADRATURE, true)?;
        Ok(ForceBalance { potential, followers, pressure_field: None })
    }

    /// Lowers to the mixed formulation of Taylor and Hood: quadratic displacement, and a continuous linear
    /// field of pressure that makes the body incompressible, whatever the law's own bulk modulus.
    ///
    /// The law's own volumetric energy stays: it changes no incompressible solution and keeps Newton's
    /// method alive. Pressures may act on surfaces with a loose rim.
    ///
    /// # Errors
    /// The first thing found wrong, with advice.
    pub fn lower_mixed(&self) -> Result<ForceBalance<L, D, N>, SceneError>
    where
        Nodes<N>: TaylorHoodElement<N>,
    {
        let rule = Nodes::<N>::FINE_QUADRATURE;
        let (potential, followers) = self.lower_by(rule, true)?;
        let pressure_field = Some(PressureField::new::<N>(rule, &self.mesh));
        Ok(ForceBalance { potential, followers, pressure_field })
    }

    /// The potential under one quadrature rule, and the pressures that have none.
    fn lower_by(
        &self,
        rule: &[QuadraturePoint],
        loose_rims: bool,
    ) -> Result<(TotalPotential<L, D, Exact, N>, Vec<PressureSurface>), SceneError> {
        self.mesh.check()?;
        if self.mesh.cells.is_empty() {
            return Err(SceneError::EmptyMesh);
        }
        self.check_parameters()?;
        let (shape_gradients, volumes) = shape_functions(&self.mesh, rule)?;
        check_overlaps(&self.mesh)?;
        let directions = self.directions_at(rule)?;
        let prescribed = self.prescribed()?;
        let nodal_force = self.nodal_force(rule, &volumes)?;
        let springs = self.springs()?;
        let pressures = self.pressures(&prescribed, loose_rims)?;
        let potential = TotalPotential {
            law: self.law.clone(),
            guard: Exact,
            nodes: self.mesh.points.len(),
            positions: self.mesh.points.clone(),
            cells: self.mesh.cells.clone(),
            points_per_cell: rule.len(),
            shape_gradients,
            volumes,
            directions,
            patches: Vec::new(),
            nodal_force,
            springs,
            pressures: pressures.flat,
            surfaces: pressures.surfaces,
            prescribed,
        };
        Ok((potential, pressures.followers))
    }

    fn check_parameters(&self) -> Result<(), SceneError> {
        // Written so that a NaN is an error as well.
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if let Some((name, value)) = self.law.constants().into_iter().find(|c| !positive(c.1)) {
            return Err(SceneError::Constant { name, value });
        }
        let (first, count) = (L::PARAMETERS.len(), self.parameters.len());
        let mut loads = 0;
        for load in &self.loads {
            let (Load::Pressure { magnitude, .. } | Load::ThesisPressure { magnitude, .. }) = load
            else {
                continue;
            };
            match *magnitude {
                Magnitude::Fixed(value) => finite(value, || "a pressure".into())?,
                Magnitude::Theta(index) if (first..count).contains(&index) => {
                    loads = loads.max(index + 1 - first);
                }
                Magnitude::Theta(index) => {
                    return Err(SceneError::LoadParameter { index, first, count });
                }
            }
        }
        if count != first + loads {
            return Err(SceneError::ParameterCount { given: count, names: L::PARAMETERS, loads });
        }
        for parameter in &self.parameters {
            let [least, most] = parameter.range;
            let ordered = least.is_finite() && most.is_finite() && least <= most;
            if !ordered || (parameter.sampling == Sampling::Log && least <= 0.0) {
                let name = parameter.name.clone();
                return Err(SceneError::Range { name, range: parameter.range });
            }
        }
        Ok(())
    }

    fn prescribed(&self) -> Result<Vec<Option<f64>>, SceneError> {
        let mut prescribed = vec![None; 3 * self.mesh.points.len()];
        if Mesh::<N>::ELEMENT.dimension == 2 {
            prescribed.iter_mut().skip(2).step_by(3).for_each(|u| *u = Some(0.0));
        }
        for support in &self.supports {
            let name = &support.nodes;
            let nodes = self.mesh.node_sets.get(name).ok_or_else(|| {
                let known = names(&self.mesh.node_sets);
                SceneError::UnknownNodeSet { name: name.clone(), known }
            })?;
            let row = match &support.displacement {
                Prescribed::PerNode(rows) if rows.len() != nodes.len() => {
                    let (name, given) = (name.clone(), rows.len());
                    return Err(SceneError::SupportLength { name, given, nodes: nodes.len() });
                }
                Prescribed::PerNode(rows) => Box::new(|i: usize| rows[i]) as Box<dyn Fn(_) -> _>,
                Prescribed::Uniform(components) => Box::new(|_| *components),
            };
            for (i, &node) in nodes.iter().enumerate() {
                prescribe(&mut prescribed, node, row(i), name)?;
            }
        }
        // Springs may hold what supports do not; the solver checks the rigid motions.
        let foundation = self.loads.iter().any(|load| matches!(load, Load::Foundation { .. }));
        let held = |axis: usize| prescribed.iter().skip(axis).step_by(3).any(Option::is_some);
        let free: Vec<_> = ["x", "y", "z"].into_iter().enumerate().filter(|a| !held(a.0)).collect();
        if !free.is_empty() && !foundation {
            let axes = free.iter().map(|a| a.1).collect::<Vec<_>>().join(", ");
            return Err(SceneError::FreeToMove { axes });
        }
        check_loose_nodes(&self.mesh, &prescribed)?;
        Ok(prescribed)
    }

    fn facets(&self, name: &str) -> Result<&[Facet], SceneError> {
        match self.mesh.facet_sets.get(name).map(Vec::as_slice) {
            None => {
                let known = names(&self.mesh.facet_sets);
                Err(SceneError::UnknownFacetSet { name: name.into(), known })
            }
            Some([]) => Err(SceneError::EmptyFacetSet { name: name.into() }),
            Some(facets) => {
                let mut seen = HashSet::with_capacity(facets.len());
                match facets.iter().find(|&facet| !seen.insert(facet)) {
                    None => Ok(facets),
                    Some(&Facet { cell, opposite }) => {
                        Err(SceneError::RepeatedFacet { name: name.into(), cell, opposite })
                    }
                }
            }
        }
    }
}

fn names<T>(sets: &BTreeMap<String, T>) -> Vec<String> {
    sets.keys().cloned().collect()
}

fn finite(value: f64, what: impl Fn() -> String) -> Result<(), SceneError> {
    if value.is_finite() { Ok(()) } else { Err(SceneError::NotFinite { what: what(), value }) }
}

fn prescribe(
    prescribed: &mut [Option<f64>],
    node: usize,
    components: [Option<f64>; 3],
    set: &str,
) -> Result<(), SceneError> {
    for (component, second) in components.into_iter().enumerate() {
        let Some(second) = second else { continue };
        finite(second, || format!("the displacement prescribed on {set:?}"))?;
        match prescribed[3 * node + component].replace(second) {
            Some(first) if first != second => {
                return Err(SceneError::Contradiction { node, component, first, second });
            }
            _ => {}
        }
    }
    Ok(())
}

fn check_loose_nodes<const N: usize>(
    mesh: &Mesh<N>,
    prescribed: &[Option<f64>],
) -> Result<(), SceneError> {
    let mut loose: Vec<bool> = prescribed.chunks(3).map(|u| u.contains(&None)).collect();
    mesh.cells.as_flattened().iter().for_each(|&node| loose[node] = false);
    match loose.iter().position(|&l| l) {
        None => Ok(()),
        Some(first) => {
            let count = loose.iter().filter(|&&l| l).count();
            Err(SceneError::LooseNodes { count, first })
        }
    }
}

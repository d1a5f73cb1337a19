//! Lowering of a scene to a body: from names to plain arrays.

mod directions;
pub(crate) mod geometry;
mod loads;
mod overlaps;
mod supports;

use crate::discretisation::Elements;
use crate::elements::{FiniteElement, Nodes, QuadraturePoint};
use crate::patches::patches;
use crate::{
    Body, BodyArrays, Law, Load, Magnitude, Material, Parameter, PressureField, Sampling, Scene,
    SceneError, Support, Units, at_points,
};
use geometry::shape_functions;
use overlaps::check_overlaps;
use sinew_mesh::{Facet, Mesh, boundary_facets};
use std::any::Any;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;
pub(crate) use supports::Held;

/// Largest error of the sum of quadrature weights \[relative to the measure of the element\]: tables are printed to ten
/// digits.
const QUADRATURE_TOLERANCE: f64 = 1e-9;

impl<L: Law<D>, const D: usize, const N: usize> Scene<L, D, N>
where
    Nodes<N>: FiniteElement<N>,
{
    /// Checks the scene and lowers it to plain arrays.
    ///
    /// # Errors
    /// The first thing found wrong, with advice.
    pub fn lower(&self) -> Result<Body, SceneError> {
        self.lower_by(match self.discretisation.elements {
            Elements::Mixed => Nodes::<N>::FINE_QUADRATURE,
            Elements::Displacement | Elements::Averaged { .. } => Nodes::<N>::QUADRATURE,
        })
    }

    /// Lowers as [`Scene::lower`] does, integrated by a rule of one's choice instead of [`FiniteElement::QUADRATURE`].
    ///
    /// ```
    /// # use sinew_energy::{Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_energy::{FiniteElement, Nodes};
    ///
    /// let mesh = sinew_mesh::box_tetrahedra([2.0, 1.0, 1.0], [2, 1, 1]).quadratic();
    /// let cells = mesh.cells.len();
    /// let block = Scene::new(mesh, NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .support(Support::clamped("x_min"));
    /// // Degree five instead of two, for curved cells or laws with exponentials.
    /// let rule = Nodes::<10>::FINE_QUADRATURE;
    /// let (usual, fine) = (block.lower()?, block.lower_with(rule)?);
    /// assert_eq!((usual.points_per_cell, fine.points_per_cell), (4, rule.len()));
    /// assert!((fine.volumes.iter().sum::<f64>() - 2.0).abs() < 1e-12);
    /// # Ok::<(), sinew_energy::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Scene::lower`], and [`SceneError::Quadrature`].
    pub fn lower_with(&self, rule: &[QuadraturePoint]) -> Result<Body, SceneError> {
        let measure = |rule: &[QuadraturePoint]| rule.iter().map(|p| p.weight).sum::<f64>();
        let (sum, needed) = (measure(rule), measure(Nodes::<N>::QUADRATURE));
        let positive = rule.iter().all(|p| p.weight > 0.0 && p.at.iter().all(|x| x.is_finite()));
        // Written so that a NaN is an error as well.
        let exact = (sum - needed).abs() <= QUADRATURE_TOLERANCE * needed;
        if !(positive && exact) {
            return Err(SceneError::Quadrature { points: rule.len(), sum, needed });
        }
        self.lower_by(rule)
    }

    fn lower_by(&self, rule: &[QuadraturePoint]) -> Result<Body, SceneError> {
        let Self { name, units, mesh, parameters, loads, supports, discretisation, .. } = self;
        if L::PLANE && !matches!(N, 3 | 6) {
            return Err(SceneError::PlaneLaw { law: L::NAME, nodes: N });
        }
        let law_parameters = L::PARAMETERS;
        let loose_rims = discretisation.loose_rims;
        let setup =
            Setup { name, units, mesh, parameters, loads, supports, law_parameters, loose_rims };
        let mut body = lowering::<N>()(&setup, rule, self.law.constants(), &|| {
            Ok(at_points(self.law.clone(), setup.directions_at(rule, &self.directions)?))
        })?;
        match discretisation.elements {
            Elements::Displacement => {}
            Elements::Averaged { cells } => body.0.patches = patches(mesh, rule.len(), cells),
            Elements::Mixed => body.0.pressure_field = Some(PressureField::new::<N>(rule, mesh)),
        }
        Ok(body)
    }
}

/// Differences of z in a plane mesh that have no effect \[relative to its size\]: their squares are rounding errors.
/// Rounding of coordinates to single precision is allowed too.
const FLAT: f64 = 1e-6;

/// Lowering of scenes of cells with `N` nodes.
type Lowering<const N: usize> = fn(
    &Setup<'_, N>,
    &[QuadraturePoint],
    Vec<(&'static str, f64)>,
    &dyn Fn() -> Result<Arc<dyn Material>, SceneError>,
) -> Result<Body, SceneError>;

/// The instance of [`lowered`] that this crate has compiled, so that a crate with scenes of its own need not.
fn lowering<const N: usize>() -> Lowering<N> {
    static LINEAR: (Lowering<3>, Lowering<4>, Lowering<8>) = (lowered, lowered, lowered);
    static QUADRATIC: (Lowering<6>, Lowering<10>) = (lowered, lowered);
    let all: [&dyn Any; 5] = [&LINEAR.0, &LINEAR.1, &LINEAR.2, &QUADRATIC.0, &QUADRATIC.1];
    *all.into_iter().find_map(|lowering| lowering.downcast_ref()).expect("a finite element")
}

/// A scene without its law, so that all laws are lowered by the same code.
struct Setup<'a, const N: usize> {
    name: &'a str,
    units: &'a Units,
    mesh: &'a Mesh<N>,
    parameters: &'a [Parameter],
    loads: &'a [Load],
    supports: &'a [Support],
    law_parameters: &'static [&'static str],
    loose_rims: bool,
}

/// The body under one quadrature rule.
fn lowered<const N: usize>(
    setup: &Setup<'_, N>,
    rule: &[QuadraturePoint],
    constants: Vec<(&'static str, f64)>,
    material: &dyn Fn() -> Result<Arc<dyn Material>, SceneError>,
) -> Result<Body, SceneError>
where
    Nodes<N>: FiniteElement<N>,
{
    setup.mesh.check()?;
    if setup.mesh.cells.is_empty() {
        return Err(SceneError::EmptyMesh);
    }
    // Written so that a NaN is an error as well.
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if let Some((name, value)) = constants.into_iter().find(|c| !positive(c.1)) {
        return Err(SceneError::Constant { name, value });
    }
    setup.check_parameters()?;
    if Mesh::<N>::ELEMENT.dimension == 2 {
        setup.check_plane()?;
    }
    let (shape_gradients, volumes) = shape_functions(setup.mesh, rule)?;
    check_overlaps(setup.mesh)?;
    let material = material()?;
    let held = setup.held()?;
    setup.check_loads_on_boundary()?;
    let reference_loads = setup.reference_loads(rule)?;
    let (cells, points) = (setup.mesh.cells.as_flattened(), &setup.mesh.points);
    let nodal_force = setup.nodal_force(&reference_loads, &volumes)?;
    let springs = reference_loads.springs(points);
    let (pressures, followers) = setup.pressures(&held)?;
    let cavities = setup.cavities(&held)?;
    Ok(Body(BodyArrays {
        name: setup.name.into(),
        units: setup.units.clone(),
        parameters: setup.parameters.to_vec(),
        known: Vec::new(),
        mesh: Arc::new(Nodes::<N>::any(setup.mesh.clone())),
        material,
        barriers: None,
        nodes: setup.mesh.points.len(),
        positions: points.clone(),
        nodes_per_cell: N,
        cells: cells.to_vec(),
        points_per_cell: rule.len(),
        shape_gradients: shape_gradients.into_flattened(),
        volumes,
        patches: Vec::new(),
        reference_loads,
        nodal_force,
        springs,
        pressures,
        followers,
        pressure_field: None,
        cavities,
        prescribed: held.prescribed,
        frames: held.frames,
    }))
}

impl<const N: usize> Setup<'_, N>
where
    Nodes<N>: FiniteElement<N>,
{
    fn check_parameters(&self) -> Result<(), SceneError> {
        let (first, count) = (self.law_parameters.len(), self.parameters.len());
        let mut loads = 0;
        for (_, _, magnitude) in self.loads.iter().filter_map(Load::pressure) {
            match magnitude {
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
            let names = self.law_parameters;
            return Err(SceneError::ParameterCount { given: count, names, loads });
        }
        self.check_parameter_names()?;
        for parameter in self.parameters {
            let [least, most] = parameter.range;
            let ordered = least.is_finite() && most.is_finite() && least <= most;
            if !ordered || (parameter.sampling == Sampling::Log && least <= 0.0) {
                let name = parameter.name.clone();
                return Err(SceneError::Range { name, range: parameter.range });
            }
        }
        Ok(())
    }

    /// Checks that the law's parameters come first, in its order and by its names.
    fn check_parameter_names(&self) -> Result<(), SceneError> {
        let given = self.parameters.iter().map(|p| p.name.as_str());
        let mut seen = HashSet::new();
        if let Some(name) = given.clone().find(|&name| !seen.insert(name)) {
            return Err(SceneError::ParameterTwice { name: name.into() });
        }
        let names = self.law_parameters;
        if given.clone().zip(names).any(|(given, name)| given != *name) {
            let given = given.take(names.len()).map(String::from).collect();
            return Err(SceneError::ParameterNames { given, names });
        }
        Ok(())
    }

    /// Checks that a plane body lies in one plane of constant z, and its dead loads in that plane.
    fn check_plane(&self) -> Result<(), SceneError> {
        let refuse = |what: String, value| Err(SceneError::OutOfPlane { what, value });
        let points = &self.mesh.points;
        let largest = |from: [f64; 3]| {
            let away = points.iter().flat_map(|x| (0..3).map(move |i| (x[i] - from[i]).abs()));
            away.fold(0.0, f64::max)
        };
        let most = FLAT * largest(points[0]) + f64::from(f32::EPSILON) * largest([0.0; 3]);
        let height = |point: &[f64; 3]| point[2] - points[0][2];
        if let Some(node) = points.iter().position(|x| height(x).abs() > most) {
            return Err(SceneError::NotFlat { node, height: height(&points[node]) });
        }
        for load in self.loads {
            match load {
                Load::BodyForce([.., across]) if *across != 0.0 => {
                    return refuse("a body force along z".into(), *across);
                }
                Load::NodalForces(forces) => {
                    if let Some([.., across]) = forces.iter().find(|force| force[2] != 0.0) {
                        return refuse("a nodal force along z".into(), *across);
                    }
                }
                Load::Traction { facets, value: [.., across] } if *across != 0.0 => {
                    return refuse(format!("the traction on `{facets}` along z"), *across);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Checks that loads act on the surface. On a facet between two cells, the outward normal would depend on the cell
    /// that the set names.
    fn check_loads_on_boundary(&self) -> Result<(), SceneError> {
        let sets = self.loads.iter().filter_map(Load::facets);
        let loaded = sets.map(|name| Ok((name, self.facets(name)?)));
        let loaded = loaded.collect::<Result<Vec<_>, SceneError>>()?;
        if loaded.is_empty() {
            return Ok(());
        }
        let boundary: HashSet<_> = boundary_facets(self.mesh).into_iter().collect();
        for (name, facets) in loaded {
            if let Some(&Facet { cell, opposite }) = facets.iter().find(|f| !boundary.contains(f)) {
                return Err(SceneError::InnerFacet { name: name.into(), cell, opposite });
            }
        }
        Ok(())
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

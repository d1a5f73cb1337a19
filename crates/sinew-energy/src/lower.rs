//! Lowering of a scene to a body: from names to plain arrays.

pub(crate) mod geometry;
mod loads;
mod supports;

use crate::discretisation::Elements;
use crate::error::listed;
use crate::patches::patches;
use crate::{Body, BodyArrays, Load, Magnitude, PressureField, Sampling, Scene, SceneError};
use geometry::{check_overlaps, places, shape_functions};
use sinew_mesh::{Facet, Mesh, QuadraturePoint, boundary_facets, with_cells};
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

impl Scene {
    /// Checks the scene and lowers it to plain arrays.
    ///
    /// # Errors
    /// The first thing found wrong, with advice.
    pub fn lower(&self) -> Result<Body, SceneError> {
        with_cells!(&self.mesh, mesh => lowered(self, mesh))
    }

    /// Places of the quadrature points of [`Scene::lower`] \[length\], cell by cell: one row of directions may be given for each.
    ///
    /// ```
    /// use sinew_energy::{Law, Scene, laws::HolzapfelOgden};
    ///
    /// let law = HolzapfelOgden.nearly_incompressible(25.0);
    /// let mesh = sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]).quadratic();
    /// let mut block = Scene::new(mesh, law.along(vec![]));
    /// let fibre = |[x, _, _]: [f64; 3]| [[x.cos(), x.sin(), 0.0]];
    /// block.material = law.along(block.quadrature_points().into_iter().map(fibre).collect());
    /// assert_eq!(block.material.points(), Some(6 * 4)); // six tetrahedra, four points each
    /// ```
    pub fn quadrature_points(&self) -> Vec<[f64; 3]> {
        with_cells!(&self.mesh, mesh => places(self, mesh))
    }
}

/// Differences of z in a plane mesh that have no effect \[relative to its size\]: their squares are rounding errors.
/// Rounding of coordinates to single precision is allowed too.
const FLAT: f64 = 1e-6;

/// A scene with the type of its mesh, and the quadrature rule.
struct Setup<'a, const N: usize> {
    scene: &'a Scene,
    mesh: &'a Mesh<N>,
    rule: &'static [QuadraturePoint],
    boundary: OnceCell<Vec<Facet>>,
}

/// The rule that a scene is integrated with.
fn own_rule<const N: usize>(scene: &Scene) -> &'static [QuadraturePoint] {
    match scene.discretisation.elements {
        Elements::Mixed => Mesh::<N>::FINE_QUADRATURE,
        Elements::Displacement | Elements::Averaged { .. } => Mesh::<N>::QUADRATURE,
    }
}

/// The body under the scene's quadrature rule.
fn lowered<const N: usize>(scene: &Scene, mesh: &Mesh<N>) -> Result<Body, SceneError> {
    let setup = Setup { scene, mesh, rule: own_rule::<N>(scene), boundary: OnceCell::new() };
    let (rule, law, points) = (setup.rule, scene.material.law(), &mesh.points);
    setup.check_elements()?;
    mesh.check()?;
    if mesh.cells.is_empty() {
        return Err(SceneError::Body(
            "the mesh has no cells; read or generate one that has".into(),
        ));
    }
    // Written so that a NaN is an error as well.
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if let Some((name, value)) = law.constants.into_iter().find(|c| !positive(c.1)) {
        return Err(SceneError::Law(format!(
            "the law's {name} is {value}; give a positive, finite number"
        )));
    }
    setup.check_parameters()?;
    if Mesh::<N>::ELEMENT.dimension == 2 {
        setup.check_plane()?;
    }
    let (shape_gradients, volumes) = shape_functions(mesh, rule)?;
    check_overlaps(mesh)?;
    let material = setup.material()?;
    let held = setup.held()?;
    setup.check_loads_on_boundary()?;
    let reference_loads = setup.reference_loads()?;
    let nodal_force = setup.nodal_force(&reference_loads, &volumes)?;
    let springs = reference_loads.springs(points);
    let (pressures, followers) = setup.pressures(&held)?;
    let cavities = setup.cavities(&held)?;
    let (patches, pressure_field) = match scene.discretisation.elements {
        Elements::Displacement => (Vec::new(), None),
        Elements::Averaged { cells } => (patches(mesh, rule.len(), cells), None),
        Elements::Mixed => (Vec::new(), Some(PressureField::new::<N>(rule, mesh))),
    };
    Ok(Body(BodyArrays {
        name: scene.name.clone(),
        units: scene.units.clone(),
        parameters: scene.parameters.clone(),
        known: Vec::new(),
        mesh: Arc::new(scene.mesh.clone()),
        material,
        barriers: None,
        nodes: points.len(),
        positions: points.clone(),
        nodes_per_cell: N,
        cells: mesh.cells.as_flattened().to_vec(),
        points_per_cell: rule.len(),
        shape_gradients: shape_gradients.into_flattened(),
        volumes,
        patches,
        reference_loads,
        nodal_force,
        springs,
        pressures,
        followers,
        pressure_field,
        cavities,
        prescribed: held.prescribed,
        frames: held.frames,
    }))
}

impl<const N: usize> Setup<'_, N> {
    /// Checks the cells against the formulation.
    fn check_elements(&self) -> Result<(), SceneError> {
        let element = Mesh::<N>::ELEMENT;
        if self.scene.discretisation.elements == Elements::Mixed && !element.is_quadratic() {
            return Err(SceneError::Body(format!(
                "mixed elements have quadratic tetrahedra or triangles, but the mesh is made of {}; make it quadratic",
                element.plural
            )));
        }
        Ok(())
    }

    fn check_parameters(&self) -> Result<(), SceneError> {
        let parameters = &self.scene.parameters;
        let names = self.scene.material.parameters();
        let (first, count) = (names.len(), parameters.len());
        let mut loads = 0;
        for (_, magnitude) in self.scene.loads.iter().filter_map(Load::pressure) {
            match magnitude {
                Magnitude::Fixed(value) => finite(value, || "a pressure".into())?,
                Magnitude::Theta(index) if (first..count).contains(&index) => {
                    loads = loads.max(index + 1 - first);
                }
                Magnitude::Theta(index) => {
                    return Err(SceneError::Parameters(format!(
                        "a load reads entry {index} of theta, but {}",
                        entries_of_loads(first, count)
                    )));
                }
            }
        }
        if count != first + loads {
            return Err(SceneError::Parameters(format!(
                "the scene lists {count} parameters, but the law reads {} and the loads {loads} more; list those of the law first",
                listed(names)
            )));
        }
        self.check_parameter_names()?;
        for parameter in parameters {
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
        let given = self.scene.parameters.iter().map(|p| p.name.as_str());
        let mut seen = HashSet::new();
        if let Some(name) = given.clone().find(|&name| !seen.insert(name)) {
            return Err(SceneError::Loads(format!(
                "the scene lists two parameters `{name}`; law and loads read entries of theta of their own: rename one"
            )));
        }
        let names = self.scene.material.parameters();
        if given.clone().zip(names).any(|(given, name)| given != *name) {
            let given: Vec<_> = given.take(names.len()).collect();
            return Err(SceneError::Body(format!(
                "the law reads {} in this order, but the scene lists {}; list the law's parameters first, in its order and by its names",
                listed(names),
                listed(&given)
            )));
        }
        Ok(())
    }

    /// Checks that a plane body lies in one plane of constant z, and its dead loads in that plane.
    fn check_plane(&self) -> Result<(), SceneError> {
        let points = &self.mesh.points;
        let largest = |from: [f64; 3]| {
            let away = points.iter().flat_map(|x| (0..3).map(move |i| (x[i] - from[i]).abs()));
            away.fold(0.0, f64::max)
        };
        let most = FLAT * largest(points[0]) + f64::from(f32::EPSILON) * largest([0.0; 3]);
        let height = |point: &[f64; 3]| point[2] - points[0][2];
        if let Some(node) = points.iter().position(|x| height(x).abs() > most) {
            return Err(SceneError::Body(format!(
                "node {node} lies {:e} above node 0 along z, but triangles are a plane section in the x-y plane; flatten the mesh, or give a mesh of solid cells",
                height(&points[node])
            )));
        }
        for load in &self.scene.loads {
            let (what, across) = match load {
                Load::BodyForce([.., z]) => ("a body force along z".into(), *z),
                Load::NodalForces(forces) => {
                    let across = forces.iter().map(|force| force[2]).find(|z| *z != 0.0);
                    ("a nodal force along z".into(), across.unwrap_or(0.0))
                }
                Load::Traction { facets, value: [.., z] } => {
                    (format!("the traction on `{facets}` along z"), *z)
                }
                _ => continue,
            };
            if across != 0.0 {
                return Err(SceneError::Loads(format!(
                    "{what} is {across}, but a mesh of triangles is a plane section, whose nodes move in x and y only; give 0, or a mesh of solid cells"
                )));
            }
        }
        Ok(())
    }

    /// Checks that loads act on the surface. On a facet between two cells, the outward normal would depend on the cell
    /// that the set names.
    fn check_loads_on_boundary(&self) -> Result<(), SceneError> {
        let sets = self.scene.loads.iter().filter_map(Load::facets);
        let loaded = sets.map(|name| Ok((name, self.facets(name)?)));
        let loaded = loaded.collect::<Result<Vec<_>, SceneError>>()?;
        if loaded.is_empty() {
            return Ok(());
        }
        let inner = |facet: &&Facet| self.boundary().binary_search(facet).is_err();
        for (name, facets) in loaded {
            if let Some(&Facet { cell, opposite }) = facets.iter().find(inner) {
                return Err(SceneError::Loads(format!(
                    "facet set `{name}` names the facet of cell {cell} opposite to its vertex {opposite}, which lies inside the body; loads act on its surface: leave inner facets out"
                )));
            }
        }
        Ok(())
    }

    /// The facets of the surface, ascending.
    fn boundary(&self) -> &[Facet] {
        self.boundary.get_or_init(|| boundary_facets(self.mesh))
    }

    fn facets(&self, name: &str) -> Result<&[Facet], SceneError> {
        let facets = named_set("facet", name, &self.mesh.facet_sets).map_err(SceneError::Loads)?;
        if facets.is_empty() {
            return Err(SceneError::Loads(format!(
                "facet set `{name}` is empty, so its load acts on nothing; remove the load or name the facets"
            )));
        }
        let mut seen = HashSet::with_capacity(facets.len());
        if let Some(&Facet { cell, opposite }) = facets.iter().find(|&facet| !seen.insert(facet)) {
            return Err(SceneError::Loads(format!(
                "facet set `{name}` lists the facet of cell {cell} opposite to its vertex {opposite} twice; list it once"
            )));
        }
        Ok(facets)
    }
}

/// Members of a set of nodes or facets; the reason where there is none of the name.
fn named_set<'a, T>(
    kind: &str,
    name: &str,
    sets: &'a BTreeMap<String, Vec<T>>,
) -> Result<&'a [T], String> {
    sets.get(name).map(Vec::as_slice).ok_or_else(|| {
        let known = listed(&sets.keys().collect::<Vec<_>>());
        format!("there is no {kind} set `{name}`; the mesh has {known}")
    })
}

fn finite(value: f64, what: impl Fn() -> String) -> Result<(), SceneError> {
    if value.is_finite() { Ok(()) } else { Err(SceneError::NotFinite { what: what(), value }) }
}

/// Entries of θ that a load may read.
fn entries_of_loads(first: usize, count: usize) -> String {
    match count.saturating_sub(first) {
        0 => format!(
            "all {count} parameters belong to the law; list one for the load after them, which becomes entry {first}"
        ),
        1 => format!("only entry {first} is free for loads: the law reads those before it"),
        _ => format!(
            "only entries {first} to {} are free for loads: the law reads those before them",
            count - 1
        ),
    }
}

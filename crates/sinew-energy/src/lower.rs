//! From names to plain arrays.

use crate::rim::rim_origin;
use crate::{
    Exact, Law, Load, Magnitude, Prescribed, PressureForm, PressureLoad, Sampling, Scene,
    SceneError, TotalPotential,
};
use sinew_mesh::{Facet, TetMesh};
use std::collections::{BTreeMap, HashSet};

/// How far a unit vector's length may be from 1, and the product of perpendicular ones from 0: wide
/// enough for directions written to files in single precision.
const DIRECTION_TOLERANCE: f64 = 1e-5;

impl<L: Law<D>, const D: usize> Scene<L, D> {
    /// Checks the scene and lowers it to plain arrays.
    ///
    /// # Errors
    /// The first thing found wrong, with advice.
    pub fn lower(&self) -> Result<TotalPotential<L, D>, SceneError> {
        self.mesh.check()?;
        if self.mesh.cells.is_empty() {
            return Err(SceneError::EmptyMesh);
        }
        self.check_parameters()?;
        let (shape_gradients, volumes) = shape_functions(&self.mesh)?;
        check_overlaps(&self.mesh)?;
        let directions = self.checked_directions()?;
        let prescribed = self.prescribed()?;
        let nodal_force = self.nodal_force(&volumes)?;
        let pressures = self.pressures(&prescribed)?;
        Ok(TotalPotential {
            law: self.law.clone(),
            guard: Exact,
            nodes: self.mesh.points.len(),
            cells: self.mesh.cells.clone(),
            shape_gradients,
            volumes,
            directions,
            nodal_force,
            pressures,
            prescribed,
        })
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

    fn checked_directions(&self) -> Result<Vec<[[f64; 3]; D]>, SceneError> {
        let (cells, given) = (self.mesh.cells.len(), self.directions.len());
        if D == 0 {
            return Ok(vec![[[0.0; 3]; D]; cells]);
        }
        if given != cells {
            return Err(SceneError::DirectionCount { needed: D, cells, given });
        }
        for (cell, directions) in self.directions.iter().enumerate() {
            for (direction, d) in directions.iter().enumerate() {
                let length = dot(d, d).sqrt();
                // Written so that a NaN is an error as well.
                let unit = (length - 1.0).abs() <= DIRECTION_TOLERANCE;
                if !unit {
                    return Err(SceneError::NotUnit { cell, direction, length });
                }
                for other in 0..direction {
                    let product = dot(d, &directions[other]);
                    if product.abs() > DIRECTION_TOLERANCE {
                        let pair = [other, direction];
                        return Err(SceneError::NotPerpendicular { cell, pair, product });
                    }
                }
            }
        }
        Ok(self.directions.clone())
    }

    fn prescribed(&self) -> Result<Vec<Option<f64>>, SceneError> {
        let mut prescribed = vec![None; 3 * self.mesh.points.len()];
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
        let held = |axis: usize| prescribed.iter().skip(axis).step_by(3).any(Option::is_some);
        let free: Vec<_> = ["x", "y", "z"].into_iter().enumerate().filter(|a| !held(a.0)).collect();
        if !free.is_empty() {
            let axes = free.iter().map(|a| a.1).collect::<Vec<_>>().join(", ");
            return Err(SceneError::FreeToMove { axes });
        }
        check_loose_nodes(&self.mesh, &prescribed)?;
        Ok(prescribed)
    }

    fn nodal_force(&self, volumes: &[f64]) -> Result<Vec<f64>, SceneError> {
        let mut force = vec![0.0; 3 * self.mesh.points.len()];
        for load in &self.loads {
            match load {
                Load::BodyForce(density) => {
                    density.iter().try_for_each(|&b| finite(b, || "a body force".into()))?;
                    for (nodes, volume) in self.mesh.cells.iter().zip(volumes) {
                        spread(&mut force, nodes, density, volume / 4.0);
                    }
                }
                Load::Traction { facets, value } => {
                    let what = || format!("the traction on {facets:?}");
                    value.iter().try_for_each(|&t| finite(t, what))?;
                    for &facet in self.facets(facets)? {
                        let nodes = self.mesh.facet_nodes(facet);
                        let area = facet_area(nodes.map(|node| self.mesh.points[node]));
                        spread(&mut force, &nodes, value, area / 3.0);
                    }
                }
                Load::Pressure { .. } | Load::ThesisPressure { .. } => {}
            }
        }
        let of_node = |i: usize| move || format!("the sum of the loads on node {}", i / 3);
        force.iter().enumerate().try_for_each(|(i, &f)| finite(f, of_node(i)))?;
        Ok(force)
    }

    fn pressures(&self, prescribed: &[Option<f64>]) -> Result<Vec<PressureLoad>, SceneError> {
        let mut pressures = Vec::new();
        for load in &self.loads {
            let (form, name, magnitude) = match load {
                Load::Pressure { facets, magnitude } => {
                    (PressureForm::Follower, facets, *magnitude)
                }
                Load::ThesisPressure { facets, magnitude } => {
                    (PressureForm::Thesis, facets, *magnitude)
                }
                Load::BodyForce(_) | Load::Traction { .. } => continue,
            };
            let points = &self.mesh.points;
            let facets: Vec<_> =
                self.facets(name)?.iter().map(|&f| self.mesh.facet_nodes(f)).collect();
            let origin = match form {
                PressureForm::Follower => rim_origin(name, &facets, points, prescribed)?,
                PressureForm::Thesis => [0.0; 3],
            };
            let place = |node: usize| std::array::from_fn(|i| points[node][i] - origin[i]);
            let positions = facets.iter().map(|nodes| nodes.map(place)).collect();
            pressures.push(PressureLoad { form, magnitude, facets, positions });
        }
        Ok(pressures)
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

/// Adds `weight × density` to the force on each node.
fn spread(force: &mut [f64], nodes: &[usize], density: &[f64; 3], weight: f64) {
    for node in nodes {
        for i in 0..3 {
            force[3 * node + i] += weight * density[i];
        }
    }
}

fn check_loose_nodes(mesh: &TetMesh, prescribed: &[Option<f64>]) -> Result<(), SceneError> {
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

/// Checks that no two cells lie on the same side of a facet: neighbours run around it in opposite senses.
fn check_overlaps(mesh: &TetMesh) -> Result<(), SceneError> {
    let mut sides = Vec::with_capacity(4 * mesh.cells.len());
    for cell in 0..mesh.cells.len() {
        for opposite in 0..4 {
            let [a, b, c] = mesh.facet_nodes(Facet { cell, opposite });
            // The same sense from the smallest node on.
            let from_smallest = [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
            sides.push((from_smallest, cell));
        }
    }
    sides.sort_unstable();
    match sides.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(&[(Some(mut facet), first), (_, second)]) => {
            facet.sort_unstable();
            Err(SceneError::OverlappingCells { cells: [first, second], facet })
        }
        _ => Ok(()),
    }
}

/// Gradients of the four shape functions in each cell, and the volumes of the cells.
#[expect(clippy::type_complexity, reason = "the two arrays of TotalPotential")]
fn shape_functions(mesh: &TetMesh) -> Result<(Vec<[[f64; 3]; 4]>, Vec<f64>), SceneError> {
    let mut gradients = Vec::with_capacity(mesh.cells.len());
    let mut volumes = Vec::with_capacity(mesh.cells.len());
    for (cell, nodes) in mesh.cells.iter().enumerate() {
        let [o, a, b, c] = nodes.map(|node| mesh.points[node]);
        let [a, b, c] = [a, b, c].map(|x| sub(&x, &o));
        let six_volumes = dot(&a, &cross(&b, &c));
        // Written so that a NaN is an error as well.
        let positive = six_volumes > 0.0 && six_volumes.is_finite();
        if !positive {
            return Err(SceneError::InvertedCell { cell, volume: six_volumes / 6.0 });
        }
        let others =
            [cross(&b, &c), cross(&c, &a), cross(&a, &b)].map(|g| g.map(|x| x / six_volumes));
        let first = std::array::from_fn(|i| -(others[0][i] + others[1][i] + others[2][i]));
        gradients.push([first, others[0], others[1], others[2]]);
        volumes.push(six_volumes / 6.0);
    }
    Ok((gradients, volumes))
}

fn facet_area([o, a, b]: [[f64; 3]; 3]) -> f64 {
    let normal = cross(&sub(&a, &o), &sub(&b, &o));
    0.5 * dot(&normal, &normal).sqrt()
}

fn sub(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

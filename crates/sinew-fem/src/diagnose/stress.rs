//! Stress and strain of the cells of a body, and forces on its supports.

use crate::Result;
use crate::elements::{Followers, check_fields, held_part, inadmissible};
use crate::linear::{add, dot};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use sinew_energy::metrics::volume_ratios;
use sinew_energy::{Body, Mat3, PressureSurface};
use std::slice::from_ref;

/// Stress and strain of a cell: means over its quadrature points by volume.
#[doc(alias = "Cauchy stress")]
#[derive(Clone, Debug, PartialEq)]
pub struct CellStress {
    /// Volume in the current configuration \[length³\].
    pub volume: f64,
    /// Volume ratio J that the law has: of averaged cells that of their patches.
    pub volume_ratio: f64,
    /// Green–Lagrange strain `½ (FᵀF − 1)`.
    pub green_lagrange: [[f64; 3]; 3],
    /// Cauchy stress `P Fᵀ / J` \[stress\].
    pub cauchy: [[f64; 3]; 3],
    /// Principal values of the Cauchy stress, largest first \[stress\].
    pub principal_stresses: [f64; 3],
    /// Principal stretches `√(1 + 2 E)` of the principal strains E, largest first.
    pub principal_stretches: [f64; 3],
    /// Fibre; `None` for an isotropic law.
    pub fibre: Option<Fibre>,
}

/// Fibre of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibre {
    /// Unit direction in the current configuration.
    pub direction: [f64; 3],
    /// Stretch along the fibre.
    pub stretch: f64,
    /// Cauchy stress along the fibre \[stress\].
    pub stress: f64,
}

/// Stress and strain of every cell at a displacement \[length\], in the order of the cells.
///
/// A body with averaged volume ratios has the stress of its law at the averaged ratio. Strain and volume ratio of a thin plate are those in
/// its plane.
///
/// ```
/// use sinew_energy::{Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::cell_stresses;
///
/// let body = Scene::new(sinew_mesh::box_tetrahedra([10.0, 1.0, 1.0], [4, 1, 1]), NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
///     .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
///     .support(Support::clamped("x_min"))
///     .lower()?;
/// // Uniaxial strain: a tenth longer along x; from a solution, this is its displacement.
/// let u: Vec<f64> = body.positions.iter().flat_map(|x| [0.1 * x[0], 0.0, 0.0]).collect();
/// let found = cell_stresses(&body, &u, &[30.0, 70.0])?;
/// // σ = μ/J (F Fᵀ − 1) + λ ln J/J 1
/// let (j, ln_j) = (1.1_f64, 1.1_f64.ln());
/// let [along, across] = [(30.0 * (j * j - 1.0) + 70.0 * ln_j) / j, 70.0 * ln_j / j];
/// for cell in found {
///     assert!((cell.principal_stresses[0] - along).abs() < 1e-12);
///     assert!((cell.principal_stresses[2] - across).abs() < 1e-12);
///     assert!((cell.green_lagrange[0][0] - 0.5 * (j * j - 1.0)).abs() < 1e-14);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A displacement or θ of another body, or not finite; an inverted cell; a body with a field of pressure, which
/// [`mixed_stresses`] takes.
pub fn cell_stresses(body: &Body, displacement: &[f64], theta: &[f64]) -> Result<Vec<CellStress>> {
    mixed_stresses(body, displacement, &[], theta)
}

/// [`cell_stresses`] of a body with a field of pressure \[stress\], which adds to the stress of the law.
///
/// ```
/// use sinew_energy::{Parameter, Scene, Support, laws::NeoHookeanShape};
/// use sinew_fem::mixed_stresses;
///
/// let mesh = sinew_mesh::box_tetrahedra([10.0, 1.0, 1.0], [4, 1, 1]).quadratic();
/// let body = Scene::new(mesh, NeoHookeanShape.nearly_incompressible(1.0))
///     .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
///     .support(Support::clamped("x_min"))
///     .mixed()
///     .lower()?;
/// let pressures = body.pressure_field.as_ref().map_or(0, |field| field.unknowns);
/// // Uniaxial tension of an incompressible bar: σ = μ (λ² − 1/λ) along it, and nothing across by the pressure p = −μ (1/λ − tr b/3).
/// let stretch = 1.1_f64;
/// let (along, across) = (stretch - 1.0, 1.0 / stretch.sqrt() - 1.0);
/// let u: Vec<f64> =
///     body.positions.iter().flat_map(|x| [along * x[0], across * x[1], across * x[2]]).collect();
/// let (mu, trace) = (30.0, stretch * stretch + 2.0 / stretch);
/// let pressure = vec![-mu * (1.0 / stretch - trace / 3.0); pressures];
/// for cell in mixed_stresses(&body, &u, &pressure, &[mu])? {
///     assert!((cell.principal_stresses[0] - mu * (stretch * stretch - 1.0 / stretch)).abs() < 1e-12);
///     assert!(cell.principal_stresses[2].abs() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`cell_stresses`], and pressures that are not those of the field.
pub fn mixed_stresses(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<Vec<CellStress>> {
    check_fields(body, displacement, pressure, theta)?;
    let field = body.pressure_field.as_ref();
    let field_at = |point| field.map_or(0.0, |field| field.at(point, pressure));
    let gradients = body.law_gradients(displacement);
    let gradients = gradients.ok_or_else(|| inadmissible(body, displacement))?;
    let parameters = body.law_parameters(theta);
    let points: Vec<Point> = (gradients.iter().enumerate())
        .map(|(point, h)| {
            let (_, piola) = body.material.stress(point, parameters, h, None);
            let direction = body.material.directions(point).first();
            let mut found = Point::new(h, &piola, direction);
            found.cauchy += Matrix3::identity() * field_at(point);
            found
        })
        .collect();
    let volumes = body.volumes.chunks(body.points_per_cell);
    let ratios = volume_ratios(body, displacement);
    let own = volumes.zip(ratios.chunks(body.points_per_cell));
    let found: Vec<CellStress> = points
        .chunks(body.points_per_cell)
        .zip(own)
        .map(|(p, (v, j))| cell(p, v, dot(v, j)))
        .collect();
    let finite = |cell: &CellStress| cell.cauchy.as_flattened().iter().all(|s| s.is_finite());
    if found.iter().all(finite) { Ok(found) } else { Err(inadmissible(body, displacement)) }
}

/// Stress and strain of a quadrature point.
struct Point {
    volume_ratio: f64,
    strain: Matrix3<f64>,
    cauchy: Matrix3<f64>,
    /// Fibre in the current configuration, not of unit length.
    fibre: Option<Vector3<f64>>,
}

impl Point {
    fn new(h: &Mat3<f64>, piola: &Mat3<f64>, direction: Option<&[f64; 3]>) -> Self {
        let h = Matrix3::from_fn(|i, j| h[i][j]);
        let f = Matrix3::identity() + h;
        let volume_ratio = f.determinant();
        // Without the square of F, whose small strains would be rounding errors.
        let strain = 0.5 * (h + h.transpose() + h.transpose() * h);
        let cauchy = Matrix3::from_fn(|i, j| piola[i][j]) * f.transpose() / volume_ratio;
        let fibre = direction.map(|&direction| f * Vector3::from(direction));
        Self { volume_ratio, strain, cauchy: 0.5 * (cauchy + cauchy.transpose()), fibre }
    }
}

/// Means over the quadrature points of a cell.
fn cell(points: &[Point], volumes: &[f64], volume: f64) -> CellStress {
    let whole: f64 = volumes.iter().sum();
    let weighted = || points.iter().zip(volumes.iter().map(move |v| v / whole));
    let strain: Matrix3<f64> = weighted().map(|(point, w)| w * point.strain).sum();
    let cauchy: Matrix3<f64> = weighted().map(|(point, w)| w * point.cauchy).sum();
    let fibre: Option<Vector3<f64>> = weighted().map(|(point, w)| Some(w * point.fibre?)).sum();
    let fibre = fibre.map(|fibre| {
        let (stretch, along) = (fibre.norm(), fibre.normalize());
        Fibre { direction: along.into(), stretch, stress: along.dot(&(cauchy * along)) }
    });
    CellStress {
        volume,
        volume_ratio: weighted().map(|(point, w)| w * point.volume_ratio).sum(),
        green_lagrange: strain.into(),
        principal_stresses: principal_values(&cauchy.into()),
        principal_stretches: principal_stretches(&strain.into()),
        cauchy: cauchy.into(),
        fibre,
    }
}

/// Eigenvalues of a symmetric tensor, largest first.
pub fn principal_values(tensor: &[[f64; 3]; 3]) -> [f64; 3] {
    let tensor = Matrix3::from_fn(|i, j| tensor[i][j]);
    let mut values: [f64; 3] = SymmetricEigen::new(tensor).eigenvalues.into();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// Principal stretches `√(1 + 2 E)` of a Green–Lagrange strain with the eigenvalues E, largest first.
pub fn principal_stretches(strain: &[[f64; 3]; 3]) -> [f64; 3] {
    principal_values(strain).map(|e| (1.0 + 2.0 * e).max(0.0).sqrt())
}

/// Forces of the supports on the body \[stress·length²\], for each of [`held_sets`]; `pressure` is that of mixed elements, else empty.
///
/// A node of two sets counts in both, so that the forces on sets with common nodes do not add up to the load.
/// A pressed surface loads its rim with pressure times area; where a lid closes it, with the pressure on the lid as well.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_fem::{Options, Solver, reactions};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let (beam, theta) = (scene.lower()?, [75.0, 75.0]);
/// let solution = Solver::new(&beam)?.solve(&theta, &Options::default())?;
/// let found = reactions(&beam, &solution.displacement, &[], &theta)?;
/// assert!(found.len() == 1 && (found[0][2] - 98.0).abs() < 1e-6); // its weight, at x_min
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Arrays of other lengths than the body's.
pub fn reactions(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<Vec<[f64; 3]>> {
    Ok(energy_and_reactions(body, displacement, pressure, theta)?.1)
}

/// The energy [`Body::value`] \[stress·length³\] and the [`reactions`] \[stress·length²\], in one pass over the cells.
///
/// ```
/// use sinew_energy::{Load, Parameter, Scene, Support, laws::LinearElastic};
/// use sinew_fem::energy_and_reactions;
///
/// let block = Scene::new(sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]), LinearElastic)
///     .parameter(Parameter::log("mu", "kPa", 1.0..=100.0))
///     .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
///     .load(Load::BodyForce([0.0, 0.0, -0.5]))
///     .support(Support::clamped("z_min"))
///     .lower()?;
/// let rest = vec![0.0; 3 * block.nodes];
/// let (energy, forces) = energy_and_reactions(&block, &rest, &[], &[1.0, 1.0])?;
/// assert!(energy == 0.0 && forces.len() == 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`reactions`].
pub fn energy_and_reactions(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<(f64, Vec<[f64; 3]>)> {
    check_fields(body, displacement, pressure, theta)?;
    let (energy, total) = forces(body, displacement, pressure, theta);
    let sum = |nodes: &[usize]| {
        nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + force_on(body, node, &total)).into()
    };
    Ok((energy, held_sets(body).map(|(_, nodes)| sum(nodes)).collect()))
}

/// Node sets of a body's mesh whose nodes are all held, with their names.
pub fn held_sets(body: &Body) -> impl Iterator<Item = (&String, &Vec<usize>)> {
    let all_held = |nodes: &[usize]| !nodes.is_empty() && nodes.iter().all(|&n| held(body, n));
    body.mesh.node_sets().iter().filter(move |(_, nodes)| all_held(nodes))
}

/// Whether a support holds a node; the third direction of a body in two dimensions does not count.
fn held(body: &Body, node: usize) -> bool {
    (0..body.element().dimension).any(|i| body.prescribed[3 * node + i].is_some())
}

/// Force of the supports on a node.
fn force_on(body: &Body, node: usize, forces: &[f64]) -> Vector3<f64> {
    let held = held_part(body, node, [0, 1, 2].map(|i| forces[3 * node + i]));
    Vector3::from_fn(|i, _| if i < body.element().dimension { held[i] } else { 0.0 })
}

/// Energy, and forces on every degree of freedom: derivative of the energy, with pressures themselves in place of their potentials, and with
/// the field of pressure; at prescribed ones it is the reaction.
fn forces(body: &Body, displacement: &[f64], pressure: &[f64], theta: &[f64]) -> (f64, Vec<f64>) {
    let mut total = vec![0.0; displacement.len()];
    let energy = body.value_and_gradient(displacement, theta, &mut total);
    Followers::new(&body.followers).add_forces(displacement, theta, &mut total);
    // A potential that is that of the pressure only while the rim is held: its derivative at the rim is not the force there, and depends on
    // the origin of coordinates.
    let is_open = |surface: &&PressureSurface| !surface.thesis && surface.lids.is_empty();
    for surface in body.pressures.iter().filter(is_open) {
        let mut derivative = vec![0.0; displacement.len()];
        surface.value_and_add_gradient(displacement, theta, &mut derivative);
        add(&mut total, -1.0, &derivative);
        Followers::new(from_ref(surface)).add_forces(displacement, theta, &mut total);
    }
    if let Some(field) = &body.pressure_field {
        // ∫ p cof F ∇N dV
        let law = |point: usize, h: &Mat3<f64>| {
            let (p, cofactor) = (field.at(point, pressure), h.plus_identity().cofactors());
            Some((0.0, Mat3::from_fn(|i, j| p * cofactor[i][j])))
        };
        body.add_stress_forces(displacement, law, &mut total);
    }
    (energy, total)
}

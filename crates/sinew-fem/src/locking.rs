//! Linear elements that are too stiff: how much is told before a solve, from mesh and material alone.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use sinew_energy::{Guard, Law, ThetaError, TotalPotential};
use sinew_mesh::{Mesh, boundary_facets};
use sinew_num::Mat3;
use std::fmt;

/// Linear elements whose K/μ exceeds this lock when nothing averages the volume ratio: from here on, the
/// deflections of [`MEASURED_TETRAHEDRA`] are off by the volume more than by the bending.
pub const LARGEST_BULK_TO_SHEAR: f64 = 10.0;
/// Bodies this many times as long as thick bend rather than shear or stretch.
pub const SLENDER: f64 = 5.0;
/// Fewer linear elements than this through the thickness of a slender body bend too little: with 2.9 of them
/// the deflection of a beam was 35 % too small, with 5.8 it was 9 %.
pub const FEWEST_THROUGH_THICKNESS: f64 = 4.0;

/// Elements that are too stiff for this body, with the numbers that say so.
///
/// Its `Display` says how far off such elements were on a beam, and what to use instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LockingWarning {
    /// Name of the elements.
    pub elements: &'static str,
    /// Number of their nodes.
    pub nodes_per_cell: usize,
    /// Whether patches of them share one volume ratio.
    pub averaged: bool,
    /// Ratio K/μ of bulk and shear modulus at rest if it exceeds [`LARGEST_BULK_TO_SHEAR`]; +∞ when the
    /// material resists changes of volume only.
    pub bulk_to_shear: Option<f64>,
    /// The body's proportions if it is slender and has too few elements through its thickness.
    pub bending: Option<Bending>,
}

/// Proportions of a slender body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bending {
    /// Largest extent over thickness.
    pub slenderness: f64,
    /// Thickness over the mean size of the elements.
    pub elements_through_thickness: f64,
}

/// Whether the elements of a body are too stiff for it at θ: linear tetrahedra and triangles, and hexahedra
/// without an averaged volume ratio. Quadratic elements never are.
///
/// - K and μ are estimated from the tangent at rest, `K = I:A:I/9` and `10 μ = tr A − 3K`, which is exact for
///   isotropic laws.
/// - The thickness is twice the volume over the surface of a plate's two sides, and four times the volume
///   over the surface of a thin rod, but no more than the least principal extent.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Sampling, Scene, Support, Units, laws::NeoHookean};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter { name: name.into(), unit: "kPa".into(), range: [1.0, 1e6], sampling: Sampling::Log };
/// # let scene = Scene { name: "beam".into(), units: Units::mm_kpa(), mesh: box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]),
/// #     law: NeoHookean, directions: vec![], parameters: vec![parameter("mu"), parameter("lambda")],
/// #     loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])], supports: vec![Support::clamped("x_min")] };
/// let warning = sinew_fem::locking(&scene.lower()?, &[75.0, 7500.0])?.expect("linear tetrahedra lock");
/// assert!((warning.bulk_to_shear.unwrap() - (100.0 + 2.0 / 3.0)).abs() < 1e-9);
/// eprintln!("{warning}"); // names Scene::lower_averaged() and others
///
/// assert_eq!(sinew_fem::locking(&Scene { mesh: scene.mesh.quadratic(), ..scene }.lower()?, &[75.0, 7500.0])?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// θ that makes no sense.
pub fn locking<L: Law<D>, G: Guard, const D: usize, const N: usize>(
    potential: &TotalPotential<L, D, G, N>,
    theta: &[f64],
) -> Result<Option<LockingWarning>, ThetaError> {
    potential.check_theta(theta)?;
    let element = Mesh::<N>::ELEMENT;
    let averaged = !potential.patches.is_empty();
    let hexahedra = element.corners == 8;
    if element.is_quadratic() || (hexahedra && averaged) {
        return Ok(None);
    }
    let bulk_to_shear =
        bulk_to_shear(potential, theta).filter(|&ratio| !averaged && ratio > LARGEST_BULK_TO_SHEAR);
    let bending = bending(potential).filter(|bending| {
        bending.slenderness > SLENDER
            && bending.elements_through_thickness < FEWEST_THROUGH_THICKNESS
    });
    let warning = LockingWarning {
        elements: element.plural,
        nodes_per_cell: N,
        averaged,
        bulk_to_shear,
        bending,
    };
    Ok((bulk_to_shear.is_some() || bending.is_some()).then_some(warning))
}

/// K/μ of the tangent at rest; `None` without resistance to changes of volume.
fn bulk_to_shear<L: Law<D>, G: Guard, const D: usize, const N: usize>(
    potential: &TotalPotential<L, D, G, N>,
    theta: &[f64],
) -> Option<f64> {
    let parameters = TotalPotential::<L, D, G, N>::law_parameters(theta);
    // Turning the directions changes neither K nor the trace: one point speaks for all.
    let response = potential.law.response(parameters, &Mat3::ZERO, potential.directions.first()?);
    let tangent = &response.tangent;
    let bulk = [0, 4, 8].map(|i| tangent[i][0] + tangent[i][4] + tangent[i][8]);
    let bulk = bulk.iter().sum::<f64>() / 9.0;
    let trace: f64 = (0..9).map(|i| tangent[i][i]).sum();
    let shear = (trace - 3.0 * bulk) / 10.0;
    // Below rounding there is no shear modulus: an ideal fluid.
    let fluid = shear <= f64::EPSILON * bulk;
    (bulk > 0.0 && trace.is_finite()).then_some(if fluid { f64::INFINITY } else { bulk / shear })
}

/// Proportions of a body; `None` where it has no size.
fn bending<L: Law<D>, G: Guard, const D: usize, const N: usize>(
    potential: &TotalPotential<L, D, G, N>,
) -> Option<Bending> {
    let element = Mesh::<N>::ELEMENT;
    let mesh = Mesh::<N> {
        points: potential.positions.clone(),
        cells: potential.cells.clone(),
        ..Mesh::default()
    };
    let [longest, least] = principal_extents(&mesh.points, element.dimension)?;
    let volume: f64 = potential.volumes.iter().sum();
    let surface = boundary_facets(&mesh).into_iter().map(|facet| {
        let at: Vec<_> =
            mesh.nodes_of_facet(facet).map(|n| Vector3::from(mesh.points[n])).collect();
        match at[..] {
            [a, b] => (b - a).norm(),
            [a, b, c] => 0.5 * (b - a).cross(&(c - a)).norm(),
            // A quadrilateral by its diagonals.
            [a, b, c, d] => 0.5 * (c - a).cross(&(d - b)).norm(),
            _ => 0.0,
        }
    });
    let surface = surface.sum::<f64>();
    let sides = if element.dimension == 2 { 2.0 } else { 4.0 };
    let thickness = f64::min(least, sides * volume / surface);
    // A box of two triangles, of six tetrahedra, or the hexahedron itself.
    let cells_of_box = [2.0, 6.0, 1.0][match element.corners {
        3 => 0,
        4 => 1,
        _ => 2,
    }];
    let size = volume * cells_of_box / mesh.cells.len() as f64;
    let size = size.powf(1.0 / element.dimension as f64);
    let positive = thickness > 0.0 && size > 0.0 && size.is_finite();
    positive.then_some(Bending {
        slenderness: longest / thickness,
        elements_through_thickness: thickness / size,
    })
}

/// Largest and least extent of points along the principal axes of their scatter, without the third axis in
/// two dimensions.
fn principal_extents(points: &[[f64; 3]], dimension: usize) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let centre = points.iter().fold(Vector3::zeros(), |sum, &p| sum + Vector3::from(p)) / count;
    let arms = || points.iter().map(|&p| Vector3::from(p) - centre);
    let scatter = arms().fold(Matrix3::zeros(), |sum, arm| sum + arm * arm.transpose());
    let axes = SymmetricEigen::new(scatter).eigenvectors;
    let extents = (0..3).map(|axis| {
        let along = || arms().map(|arm| arm.dot(&axes.column(axis)));
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    });
    let mut extents: Vec<f64> = extents.collect();
    extents.sort_by(|a, b| b.total_cmp(a));
    let (longest, least) = (extents[0], extents[dimension - 1]);
    (longest.is_finite() && least > 0.0).then_some([longest, least])
}

/// Deflection of the tip over that of quadratic tetrahedra, for K/μ: a beam of 100 × 10 × 10 mm and 12 × 4 × 5
/// boxes under its own weight with μ = 75 kPa and λ = 75, 7500 and 750 000 kPa; deflections of the quadratic
/// ones 55.6, 47.0 and 45.3 mm. See the example `locking`.
const MEASURED_TETRAHEDRA: [(f64, f64); 3] =
    [(5.0 / 3.0, 36.1 / 55.6), (302.0 / 3.0, 12.5 / 47.0), (30_002.0 / 3.0, 2.7 / 45.3)];

/// The same of tetrahedra in patches of eight with one volume ratio.
const MEASURED_PATCHES: [(f64, f64); 3] =
    [(5.0 / 3.0, 37.3 / 55.6), (302.0 / 3.0, 33.4 / 47.0), (30_002.0 / 3.0, 33.3 / 45.3)];

impl LockingWarning {
    /// Part of the deflection of quadratic tetrahedra that linear ones reached at this K/μ on the measured
    /// beam, which is 10 times as long as thick with 2.9 elements through its thickness; `None` for elements
    /// that were not measured.
    pub fn measured_deflection(&self) -> Option<f64> {
        let table = match (self.nodes_per_cell, self.averaged) {
            (4, false) => &MEASURED_TETRAHEDRA,
            (4, true) => &MEASURED_PATCHES,
            _ => return None,
        };
        let at = self.bulk_to_shear.unwrap_or(table[0].0).clamp(table[0].0, table[2].0);
        let [(from, start), (to, end)] =
            if at < table[1].0 { [table[0], table[1]] } else { [table[1], table[2]] };
        Some(start + (end - start) * (at / from).ln() / (to / from).ln())
    }
}

impl fmt::Display for LockingWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "linear {} are too stiff here:", self.elements)?;
        if let Some(ratio) = self.bulk_to_shear {
            write!(f, " K/mu = {ratio:.4} is above {LARGEST_BULK_TO_SHEAR}")?;
        }
        if let Some(Bending { slenderness, elements_through_thickness: across }) = self.bending {
            let and = if self.bulk_to_shear.is_some() { ", and" } else { "" };
            write!(
                f,
                "{and} the body is {slenderness:.1} times as long as thick with {across:.1} elements "
            )?;
            write!(f, "through its thickness (at least {FEWEST_THROUGH_THICKNESS} are needed)")?;
        }
        if let Some(part) = self.measured_deflection() {
            let percent = 100.0 * part;
            write!(f, "; on a beam such elements reached {percent:.0} % of the deflection")?;
        }
        let averaged = match self.bulk_to_shear {
            Some(_) if self.nodes_per_cell == 4 => {
                "lower by Scene::lower_averaged() (33 of 47 mm at K/mu = 100), "
            }
            Some(_) => "lower by Scene::lower_averaged(), ",
            None => "",
        };
        let better = match self.nodes_per_cell {
            8 => {
                "use quadratic tetrahedra, mixed by Scene::lower_mixed() when nearly incompressible"
            }
            _ => "use mesh.quadratic(), lowered by Scene::lower_mixed() when nearly incompressible",
        };
        write!(f, "; {averaged}{better}, or refine")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_are_along_the_principal_axes() {
        // A plate of 4 × 2 × 1, turned about the third axis by 30°.
        let (s, c) = 30f64.to_radians().sin_cos();
        let plate = sinew_mesh::box_hexahedra([4.0, 2.0, 1.0], [1; 3]);
        let turned: Vec<_> =
            plate.points.iter().map(|[x, y, z]| [c * x - s * y, s * x + c * y, *z]).collect();
        let [longest, least] = principal_extents(&turned, 3).unwrap();
        assert!((longest - 4.0).abs() < 1e-12 && (least - 1.0).abs() < 1e-12);
        let [_, least] = principal_extents(&turned[..4], 2).unwrap();
        assert!((least - 2.0).abs() < 1e-12, "{least}");
        assert_eq!(principal_extents(&[], 3), None);
    }
}

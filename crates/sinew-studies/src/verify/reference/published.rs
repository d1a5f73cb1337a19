//! Numbers of other programs and of the literature.

use crate::verify::case::Formulation;

/// Deflection \[mm\] of the tip's centre of the thesis' OnceClampedBeam at μ = λ = 75 kPa in the limit of fine
/// meshes: Richardson extrapolation of FEniCS runs with quadratic tetrahedra on 12×4×5 and 24×8×10 boxes
/// (−57.1370 and −57.3256 mm); −57.36 ± 0.02.
pub(crate) const BEAM_TIP: f64 = -57.36;
/// Energy Π \[kPa mm³\] of the same beam with quadratic tetrahedra on 12×4×5 boxes and quadrature of degree 2 (FEniCS,
/// `fixtures/beam/PROVENANCE.md`).
pub(crate) const BEAM_ENERGY_DEGREE_2: f64 = -1316.53294;
/// Deformed z \[mm\] of (10, ½, 1) in problem 1 of S. Land et al., Proc. R. Soc. A 471 (2015) 20150641: 4.16 ± 0.01
/// by FEniCS, quadratic–linear incompressible elements on 20×2×2 (4.14169) and 30×3×3 (4.15503) boxes.
pub(crate) const LAND_BAR: f64 = 4.16;
/// Values of that program on as many boxes; elements without a field of pressure have ½κ(J − 1)², κ = 1000 kPa. The
/// linear ones lose nine tenths of the deflection.
pub(crate) const LAND_BAR_BY_MESH: [(Formulation, [usize; 3], f64); 4] = [
    (Formulation::Mixed, [20, 2, 2], 4.14169),
    (Formulation::Mixed, [30, 3, 3], 4.15503),
    (Formulation::P2, [20, 2, 2], 4.04878),
    (Formulation::P1, [30, 3, 3], 1.30082),
];
/// z \[mm\] of the apex inside and outside in problem 2 of Land et al.: FEniCS on the axisymmetric problem in two
/// dimensions, exact geometry, quadratic–linear incompressible elements, up to 14 853 unknowns; ± 0.001.
pub(crate) const LAND_VENTRICLE: [f64; 2] = [-26.612, -28.280];
/// Values of problem 3: a converged axisymmetric computation of our own; two published codes spread by 3 %.
pub(crate) const LAND_ACTIVE: [f64; 2] = [-12.335, -15.465];
/// u_y \[mm\] of (48, 60) of Cook's membrane in plane strain with μ = 80.1938, κ = 400942 and a shear of 6.25 per area
/// in the limit of fine meshes: 6.93 ± 0.01, from [`COOK_BY_MESH`].
pub(crate) const COOK_LIMIT: f64 = 6.93;
/// u_y \[mm\] of the same point of the linear elastic membrane with E = 70 MPa, ν = 1/3, 6.25 MPa, plane strain: CalculiX,
/// Code_Aster and Elmer between 32.20 and 32.28 (solids4foam tutorial "Cook's membrane").
pub(crate) const COOK_LINEAR: f64 = 32.24;
/// u_y \[mm\] of (48, 60) and (48, 52) of the first by FEniCS, quadratic–linear elements on crossed meshes of as many squares per side.
pub(crate) const COOK_BY_MESH: [(usize, [f64; 2]); 2] =
    [(16, [6.919165, 6.951970]), (32, [6.927076, 6.957365])];

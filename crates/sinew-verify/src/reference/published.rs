//! Numbers of other programs and of the literature.

/// Deflection \[mm\] of the tip's centre of the thesis' OnceClampedBeam at μ = λ = 75 kPa in the limit of fine
/// meshes: Richardson extrapolation of FEniCS runs with quadratic tetrahedra on 12×4×5 and 24×8×10 boxes
/// (−57.1370 and −57.3256 mm); −57.36 ± 0.02.
pub const BEAM_TIP: f64 = -57.36;
/// Energy Π \[kPa mm³\] of the same beam with quadratic tetrahedra on 12×4×5 boxes and quadrature of degree 2 (FEniCS,
/// `fixtures/beam/PROVENANCE.md`).
pub const BEAM_ENERGY_DEGREE_2: f64 = -1316.53294;
/// Deformed z \[mm\] of (10, ½, 1) in problem 1 of S. Land et al., Proc. R. Soc. A 471 (2015) 20150641: 4.16 ± 0.01
/// by FEniCS, quadratic–linear incompressible elements on 20×2×2 (4.14169) and 30×3×3 (4.15503) boxes.
pub const LAND_BAR: f64 = 4.16;
/// The same with quadratic–linear elements on 20×2×2 boxes.
pub const LAND_BAR_20: f64 = 4.14169;
/// The same with quadratic–linear elements on 30×3×3 boxes.
pub const LAND_BAR_30: f64 = 4.15503;
/// The same with linear tetrahedra and ½κ(J − 1)², κ = 1000 kPa, on 30×3×3 boxes: nine tenths of the deflection
/// are lost.
pub const LAND_BAR_LOCKED: f64 = 1.30082;
/// z \[mm\] of the apex inside and outside in problem 2 of Land et al.: FEniCS on the axisymmetric problem in two
/// dimensions, exact geometry, quadratic–linear incompressible elements, up to 14 853 unknowns; ± 0.001.
pub const LAND_VENTRICLE: [f64; 2] = [-26.612, -28.280];
/// u_y \[mm\] of (48, 60) of Cook's membrane in plane strain with μ = 80.1938, κ = 400942 and a shear of 6.25 per area:
/// FEniCS, quadratic–linear elements on a crossed mesh of 32×32 squares (4096 triangles); the limit is 6.93 ± 0.01.
pub const COOK: f64 = 6.927076;
/// u_y \[mm\] of (48, 60) and (48, 52) by the same program on crossed meshes of as many squares per side.
pub const COOK_BY_MESH: [(usize, [f64; 2]); 2] =
    [(16, [6.919165, 6.951970]), (32, [6.927076, 6.957365])];

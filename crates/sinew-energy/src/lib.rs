//! Strain-energy laws, loads and the total potential energy of a mesh.
//!
//! A beam that bends under its own weight:
//!
//! ```
//! use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
//! use sinew_mesh::box_tetrahedra;
//!
//! let body = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
//!     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
//!     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
//!     .support(Support::clamped("x_min"))
//!     .lower()?;
//! let theta = body.centre(); // μ, λ \[kPa\]
//! body.check_theta(&theta)?;
//!
//! let mut displacement = vec![0.0; 3 * body.nodes];
//! assert_eq!(body.value(&displacement, &theta), 0.0);
//!
//! // The gradient at rest is minus the weight: 10⁴ mm³ · 9.8e-3 kPa/mm.
//! let mut gradient = displacement.clone();
//! body.value_and_gradient(&displacement, &theta, &mut gradient);
//! let weight: f64 = gradient.iter().skip(2).step_by(3).sum();
//! assert!((weight - 98.0).abs() < 1e-10);
//!
//! // The energy of an inverted cell is infinite.
//! displacement[3] = -1000.0;
//! assert_eq!(body.value(&displacement, &theta), f64::INFINITY);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Equations
//!
//! Total potential energy of a displacement u with body force b, dead traction t, elastic foundation S and cavity pressure p (thesis (3.12);
//! Bonet & Wood, *Nonlinear Continuum Mechanics*, chapter 8):
//!
//! ```math
//! \Pi(u;\theta) = \int_{\Omega_0}\!\Psi(F;\theta)\,\mathrm dV - \int_{\Omega_0}\! b\cdot u\,\mathrm dV - \int_{\Gamma_t}\! t\cdot u\,\mathrm dA
//!   + \tfrac12\int_{\Gamma_s}\! u\cdot S\,u\,\mathrm dA - p\,\bigl(V(u)-V_0\bigr), \qquad F = I + \nabla u
//! ```
//!
//! First Piola–Kirchhoff stress, its tangent and the Cauchy stress (Bonet & Wood, 5.5 and 6.2), with J = det F:
//!
//! ```math
//! P = \frac{\partial\Psi}{\partial F}, \qquad \mathbb A = \frac{\partial^2\Psi}{\partial F\,\partial F}, \qquad \sigma = J^{-1} P F^{\mathsf T}
//! ```
//!
//! Weak form, for every virtual displacement v that vanishes at Dirichlet nodes; N is the outward normal in the reference configuration (Bonet & Wood, 8.2 and 8.5):
//!
//! ```math
//! r(u)\cdot v = \int_{\Omega_0}\! P:\nabla v\,\mathrm dV - \int_{\Omega_0}\! b\cdot v\,\mathrm dV - \int_{\Gamma_t}\! t\cdot v\,\mathrm dA
//!   + \int_{\Gamma_s}\! v\cdot S\,u\,\mathrm dA + p\int_{\Gamma_p}\! J F^{-\mathsf T} N\cdot v\,\mathrm dA = 0
//! ```
//!
//! Tangent stiffness of the internal forces (Bonet & Wood, 9.4), and averaged volume ratios (de Souza Neto et al. 1996, 2005), with the mean J̄ of a patch:
//!
//! ```math
//! v^{\mathsf T} K\,w = \int_{\Omega_0}\! \nabla v : \mathbb A : \nabla w\,\mathrm dV, \qquad \Psi\bigl((\bar J/J)^{1/3} F\bigr)
//! ```

mod body;
mod cavity;
pub mod conformance;
mod discretisation;
mod error;
mod facet;
mod frames;
mod guard;
mod invariants;
mod known;
mod law;
pub mod laws;
mod lower;
mod mapped;
mod material;
pub mod metrics;
mod mixed;
mod moved;
mod patches;
mod pressure_field;
mod reference_loads;
mod rim;
mod scene;
mod solid;
mod stiffened;
mod surface;
mod unit;

pub use body::{Body, BodyArrays};
pub use cavity::{Cavity, CavityPart, Lid, PressedLid, SymmetryPlane};
pub use discretisation::Discretisation;
pub use error::{SceneError, ThetaError, listed, requirement};
pub use facet::{FacetPoint, FacetRule};
pub use frames::Frames;
pub use guard::{Barriers, Exact, Guard};
pub use invariants::{InvariantLaw, Invariants};
pub use law::{Law, Response, response_by_jets, stress_by_slopes};
pub use material::{IntoMaterial, LawFacts, Material};
pub use moved::Fibres;
pub use patches::PatchKinematics;
pub use pressure_field::PressureField;
pub use reference_loads::{ReferenceLoads, ReferenceSurface, Spring};
pub use scene::{Load, Parameter, Prescribed, Sampling, Scene, Support, Units};
/// Numbers that a law of one's own is written in, see [`Law`].
pub use sinew_num::{Mat3, Scalar};
pub use solid::{
    ActiveStress, NearlyIncompressible, Passive, ShapeEnergy, Solid, Strain, VolumeEnergy,
};
pub use surface::{Magnitude, PressureSurface, SurfaceResponse};
pub use unit::Unit;

//! Model of the displacement that linear elements lose.
//!
//! The missing compliance relative to that of the elements is X = (b + c K/μ) / n² under mild locking, with n elements
//! through the thickness. A constant strain misses the linear strain of bending by the squared element size, and a
//! change of volume costs K/μ times as much energy. Under severe locking X saturates, because some motions of the
//! elements change no volume.

use super::Proportions;
use sinew_mesh::Element;

/// Constants of an element.
pub(super) struct Model {
    /// b: of bending.
    bending: f64,
    /// c: of the volume; none where volume ratios are averaged.
    volume: f64,
    kind: Kind,
}

/// Element kind, by the dependence of the loss on proportions and its saturation.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Tetrahedra and triangles.
    Simplices,
    Hexahedra,
    AveragedHexahedra,
}

/// Largest X of beams of linear tetrahedra: 15 to 17 at K/μ = 1e4 with one to six elements across.
const BEAM: f64 = 15.0;
/// Largest X of a cube, measured at K/μ = 500.
const CUBE: f64 = 0.6;
/// Slenderness of a cube by its principal extents, which may lie along its diagonals.
const OF_A_CUBE: f64 = 2.0;
/// Constant a of the loss X / (1 + a √X) of hexahedra; it grows as √X beyond 1, as an alternating mode bends without
/// change of volume.
const ROOT: f64 = 1.6;

impl Model {
    pub(super) fn of(element: &Element, averaged: bool) -> Self {
        let (kind, bending, volume) = match (element.corners == 8, averaged) {
            (false, _) => (Kind::Simplices, 2.2, 0.85),
            (true, false) => (Kind::Hexahedra, 0.5, 0.13),
            (true, true) => (Kind::AveragedHexahedra, 0.18, 0.0),
        };
        Self { bending, volume: if averaged { 0.0 } else { volume }, kind }
    }

    /// Part of the displacement that is lost, at K/μ where the volume counts.
    pub(super) fn share(&self, body: &Proportions, bulk_to_shear: Option<f64>) -> f64 {
        let Proportions { slenderness, elements_through_thickness: across, lengthwise } = *body;
        // Long hexahedra bend by shear, in proportion to their length.
        let across = match self.kind {
            Kind::Simplices => across,
            Kind::Hexahedra => (across * lengthwise).sqrt(),
            Kind::AveragedHexahedra => lengthwise,
        };
        let volume = bulk_to_shear.map_or(0.0, |ratio| self.volume * ratio.max(0.0));
        let mild = (self.bending + volume) / across.powi(2);
        let lacking = match self.kind {
            Kind::Simplices => {
                // Stout bodies shear and stretch besides.
                let bends = (0.2 * slenderness).min(1.0);
                let most = (CUBE * (slenderness / OF_A_CUBE).powi(4)).clamp(CUBE, BEAM);
                1.0 / (1.0 / (bends * mild) + 1.0 / most)
            }
            _ if mild.is_finite() => mild / (1.0 + ROOT * mild.sqrt()),
            _ => mild,
        };
        if lacking.is_finite() { lacking / (1.0 + lacking) } else { 1.0 }
    }
}

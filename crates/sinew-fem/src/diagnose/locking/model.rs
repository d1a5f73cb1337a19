//! How much of a displacement linear elements lose, as a function of few numbers.
//!
//! The compliance that elements lack, relative to the one they have, is X = (b + c K/μ) / n² where they lock mildly, n being
//! the number of elements through the thickness: strains that are constant in an element miss those that are linear
//! through the thickness by its squared size, and a change of volume costs K/μ times as much. Where they lock
//! severely it saturates, for elements keep some motions that cost nothing.

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

/// How the loss depends on proportions and saturates.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Tetrahedra and triangles.
    Simplices,
    Hexahedra,
    AveragedHexahedra,
}

/// Beams of linear tetrahedra never lose more than this times the displacement that they keep: 15 to 17 at K/μ = 1e4
/// with one to six elements across.
const BEAM: f64 = 15.0;
/// Compliance that a cube loses, at K/μ = 500.
const CUBE: f64 = 0.6;
/// Slenderness of a cube by its principal extents, which may lie along its diagonals.
const OF_A_CUBE: f64 = 2.0;
/// The loss of hexahedra grows as the root of X beyond 1: an alternating mode bends without change of volume.
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
        // Long hexahedra bend by shear the more, the longer they are.
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

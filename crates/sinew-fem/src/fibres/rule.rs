//! Rotation of fibres and sheets across the wall.

use super::{FibreError, Result};
use nalgebra::Vector3;

/// Unit fibre, sheet and normal, perpendicular to each other and right-handed: `normal = fibre × sheet`.
pub type Frame = [[f64; 3]; 3];

/// Angles \[degrees\] of fibres and sheets, linear in the depth from endocardium to epicardium.
///
/// - The fibre lies in the layer of equal depth. Its angle counts from the circumferential direction
///   (counterclockwise seen from the base) towards the base, so a positive angle is a right-handed helix.
/// - The sheet direction is the outward normal of the layer at 0°, turned about the fibre by the
///   sheet angle, positive towards the base for a circumferential fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreRule {
    fibre: [f64; 2],
    sheet: [f64; 2],
}

impl FibreRule {
    /// The rule of thesis chapter 2: +60° at the endocardium to −60° at the epicardium.
    pub const SIXTY: Self = Self { fibre: [60.0, -60.0], sheet: [0.0; 2] };
    /// Problem 3 of Land et al., Proc. R. Soc. A 471:20150641 (2015): +90° to −90°.
    pub const NINETY: Self = Self { fibre: [90.0, -90.0], sheet: [0.0; 2] };

    /// Fibres turn from `endocardium` to `epicardium` \[degrees\]; sheets stand across the wall.
    ///
    /// # Errors
    /// An angle that is not finite.
    pub fn new(endocardium: f64, epicardium: f64) -> Result<Self> {
        let fibre = checked("fibre", [endocardium, epicardium])?;
        Ok(Self { fibre, sheet: [0.0; 2] })
    }

    /// These fibres with sheets that turn from `endocardium` to `epicardium` \[degrees\].
    ///
    /// # Errors
    /// An angle that is not finite.
    pub fn with_sheets(self, endocardium: f64, epicardium: f64) -> Result<Self> {
        Ok(Self { sheet: checked("sheet", [endocardium, epicardium])?, ..self })
    }

    /// Angle \[degrees\] of the fibre at a depth: 0 is the endocardium, 1 the epicardium; beyond, the angle
    /// is that of the surface.
    pub fn fibre_angle(&self, depth: f64) -> f64 {
        between(self.fibre, depth)
    }

    /// Angle \[degrees\] of the sheet at a depth.
    pub fn sheet_angle(&self, depth: f64) -> f64 {
        between(self.sheet, depth)
    }

    /// The frame at a depth.
    pub(super) fn frame(&self, depth: f64, layer: &Layer) -> Frame {
        let Layer { circumferential, longitudinal, outward } = layer;
        let (sin, cos) = self.fibre_angle(depth).to_radians().sin_cos();
        let fibre = circumferential * cos + longitudinal * sin;
        let across = longitudinal * cos - circumferential * sin;
        let (sin, cos) = self.sheet_angle(depth).to_radians().sin_cos();
        let sheet = outward * cos + across * sin;
        let normal = outward * sin - across * cos;
        [fibre, sheet, normal].map(Into::into)
    }
}

fn checked(what: &'static str, angles: [f64; 2]) -> Result<[f64; 2]> {
    match angles.into_iter().find(|angle| !angle.is_finite()) {
        Some(degrees) => Err(FibreError::Unfit(format!(
            "the {what} angle is {degrees} degrees; give a finite one"
        ))),
        None => Ok(angles),
    }
}

fn between([start, end]: [f64; 2], depth: f64) -> f64 {
    let depth = depth.clamp(0.0, 1.0);
    (1.0 - depth) * start + depth * end
}

/// The local axes of the wall: orthonormal, `circumferential × longitudinal = outward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layer {
    pub circumferential: Vector3<f64>,
    pub longitudinal: Vector3<f64>,
    pub outward: Vector3<f64>,
}

/// Least tangential part of a direction that still defines the direction to the base.
const ALONG: f64 = 1e-6;

impl Layer {
    /// Local axes from the outward normal and a direction towards the base, both of any length.
    ///
    /// `None` where one of them vanishes or they are parallel.
    pub(super) fn new(outward: Vector3<f64>, to_base: Vector3<f64>) -> Option<Self> {
        let outward = outward.try_normalize(f64::MIN_POSITIVE)?;
        let to_base = to_base.try_normalize(f64::MIN_POSITIVE)?;
        let along = to_base - outward * outward.dot(&to_base);
        let along = along.try_normalize(ALONG)?;
        // Orthogonalised twice: the first difference cancels when the directions are nearly parallel.
        let longitudinal = (along - outward * outward.dot(&along)).normalize();
        let circumferential = longitudinal.cross(&outward);
        Some(Self { circumferential, longitudinal, outward })
    }
}

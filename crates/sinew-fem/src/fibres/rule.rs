//! Rotation of fibres and sheets across the wall, and the wall of a truncated ellipsoid, whose layers are known in closed form; errors of rules.

use nalgebra::Vector3;
use sinew_energy::listed;
use sinew_mesh::{Refusal, TruncatedEllipsoid};
use thiserror::Error;

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

    /// The frame at a depth: 0 is the endocardium, 1 the epicardium; beyond, angles are those of the surface.
    pub(super) fn frame(&self, depth: f64, layer: &Layer) -> Frame {
        let Layer { circumferential, longitudinal, outward } = layer;
        let (sin, cos) = between(self.fibre, depth).to_radians().sin_cos();
        let fibre = circumferential * cos + longitudinal * sin;
        let across = longitudinal * cos - circumferential * sin;
        let (sin, cos) = between(self.sheet, depth).to_radians().sin_cos();
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

/// The wall between two ellipsoids of revolution around the z axis, apex at the bottom, cut off by a plane:
/// the ventricle of Land et al., Proc. R. Soc. A 471:20150641 (2015).
///
/// The layer at depth t has semi-axes linear in t, `x = r sin u cos v, y = r sin u sin v, z = l cos u`. With
/// n(·) the unit vector, its fibre at the angle α(t) is `f = n(∂x/∂u) sin α + n(∂x/∂v) cos α`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipsoidWall {
    ellipsoid: TruncatedEllipsoid,
}

/// Rounding of a point on a surface, as a fraction of the wall's thickness.
const ROUNDING: f64 = 1e-9;
/// Bisections of a depth: it has 52 digits, and the wall with its slack is up to three thicknesses wide.
const BISECTIONS: usize = 54;

impl EllipsoidWall {
    /// Problems 2 and 3 of Land et al. (2015) \[mm\].
    pub const LAND: Self = Self { ellipsoid: TruncatedEllipsoid::LAND };

    /// The wall with these semi-axes and base.
    ///
    /// # Errors
    /// Semi-axes that do not ascend, or a base that does not cut the inner ellipsoid.
    pub fn new(ellipsoid: TruncatedEllipsoid) -> Result<Self> {
        let TruncatedEllipsoid { short, long, base } = ellipsoid;
        for (which, axes) in [("short", short), ("long", long)] {
            let ascending = 0.0 < axes[0] && axes[0] < axes[1] && axes[1].is_finite();
            if !ascending {
                return Err(FibreError::Unfit(format!(
                    "the {which} semi-axes ({}) must be positive, finite and ascending from endocardium to epicardium",
                    listed(&axes)
                )));
            }
        }
        let height = long[0];
        match base.abs() < height {
            true => Ok(Self { ellipsoid }),
            false => Err(FibreError::Unfit(format!(
                "the base at z = {base} does not cut the inner ellipsoid of half-height {height}"
            ))),
        }
    }

    /// Depth of a point \[length\] in the wall: 0 on the endocardium, 1 on the epicardium.
    ///
    /// A point up to `slack` of the thickness beyond a surface counts as in the wall: facets of a linear mesh
    /// cut the corner into the cavity.
    ///
    /// # Errors
    /// [`FibreError::Outside`].
    pub fn depth(&self, point: [f64; 3], slack: f64) -> Result<f64> {
        let slack = slack.clamp(ROUNDING, 1.0);
        let outside = FibreError::Outside { point, slack };
        let TruncatedEllipsoid { short: [inner, outer], base, .. } = self.ellipsoid;
        let (mut low, mut high) = (self.innermost().max(-slack), 1.0 + slack);
        // Written so that a NaN is outside as well.
        let inside = point[2] <= base + slack * (outer - inner)
            && self.level(point, low) >= 0.0
            && self.level(point, high) <= 0.0;
        if !inside {
            return Err(outside);
        }
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(low, high);
            // The level falls with the depth.
            let outside = self.level(point, middle) <= 0.0;
            (low, high) = if outside { (low, middle) } else { (middle, high) };
        }
        Ok(f64::midpoint(low, high))
    }

    /// Fibre, sheet and normal at a point \[length\] in the wall; `slack` as for [`EllipsoidWall::depth`].
    ///
    /// On the axis, where no direction is circumferential, it is the one that a point beside it along x has.
    ///
    /// # Errors
    /// [`FibreError::Outside`].
    pub fn frame(&self, point: [f64; 3], rule: &FibreRule, slack: f64) -> Result<Frame> {
        let depth = self.depth(point, slack)?;
        let [short, long] = self.semi_axes(depth);
        let [x, y, z] = point;
        let outward = Vector3::new(x / (short * short), y / (short * short), z / (long * long));
        let radius = x.hypot(y);
        let [cos, sin] = if radius > 0.0 { [x / radius, y / radius] } else { [1.0, 0.0] };
        // ∂x/∂u with sin u < 0, as the apex is at u = −π.
        let across = -z * short / long;
        let to_base = Vector3::new(across * cos, across * sin, radius * long / short);
        let layer = Layer::new(outward, to_base).ok_or(FibreError::Outside { point, slack })?;
        Ok(rule.frame(depth, &layer))
    }

    /// A depth at which the semi-axes are still positive.
    fn innermost(&self) -> f64 {
        let vanishes = |[inner, outer]: [f64; 2]| -inner / (outer - inner);
        0.5 * vanishes(self.ellipsoid.short).max(vanishes(self.ellipsoid.long))
    }

    fn semi_axes(&self, depth: f64) -> [f64; 2] {
        [self.ellipsoid.short, self.ellipsoid.long]
            .map(|[inner, outer]| inner + depth * (outer - inner))
    }

    /// `(x² + y²)/r² + z²/l² − 1` at a depth.
    fn level(&self, [x, y, z]: [f64; 3], depth: f64) -> f64 {
        let [short, long] = self.semi_axes(depth);
        (x * x + y * y) / (short * short) + z * z / (long * long) - 1.0
    }
}

/// A result whose error is that of fibres.
pub(super) type Result<T, E = FibreError> = std::result::Result<T, E>;

/// A wall or a rule that gives no fibres.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FibreError {
    /// The mesh breaks a rule of every mesh.
    #[error(transparent)]
    Mesh(#[from] Refusal),
    /// No facet set has this name.
    #[error("the mesh has no facet set `{name}`; it has {}", listed(known))]
    UnknownSurface { name: String, known: Vec<String> },
    /// A surface without facets.
    #[error("the facet set `{name}` is empty; put the facets of that surface into it")]
    EmptySurface { name: String },
    /// A point that is farther from the wall than this fraction of its thickness.
    #[error(
        "({}, {}, {}) is farther from the wall than {slack:.2e} of its thickness; \
         allow more slack where facets cut corners",
        point[0], point[1], point[2]
    )]
    Outside { point: [f64; 3], slack: f64 },
    /// A mesh, an angle or an ellipsoid that a rule has no fibres for.
    #[error("{0}")]
    Unfit(String),
}

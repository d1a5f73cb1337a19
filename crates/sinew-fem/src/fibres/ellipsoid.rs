//! Fibres in the wall between two ellipsoids, in closed form.

use super::rule::Layer;
use super::{FibreError, FibreRule, Frame};
use nalgebra::Vector3;
use sinew_energy::listed;
use sinew_mesh::TruncatedEllipsoid;

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
/// Newton's method for the depth ends at steps below this; it is exact to rounding then, as it converges
/// quadratically.
const DEPTH_STEP: f64 = 1e-12;
/// Newton and bisection together need fewer steps than this for the 52 digits of a depth.
const MOST_STEPS: usize = 80;

impl EllipsoidWall {
    /// Problems 2 and 3 of Land et al. (2015) \[mm\].
    pub const LAND: Self = Self { ellipsoid: TruncatedEllipsoid::LAND };

    /// The wall with these semi-axes and base.
    ///
    /// # Errors
    /// Semi-axes that do not ascend, or a base that does not cut the inner ellipsoid.
    pub fn new(ellipsoid: TruncatedEllipsoid) -> Result<Self, FibreError> {
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
    pub fn depth(&self, point: [f64; 3], slack: f64) -> Result<f64, FibreError> {
        let slack = slack.clamp(ROUNDING, 1.0);
        let outside = FibreError::Outside { point, slack };
        let TruncatedEllipsoid { short: [inner, outer], base, .. } = self.ellipsoid;
        let (mut low, mut high) = (self.innermost().max(-slack), 1.0 + slack);
        // Written so that a NaN is outside as well.
        let inside = point[2] <= base + slack * (outer - inner)
            && self.level(point, low).0 >= 0.0
            && self.level(point, high).0 <= 0.0;
        if !inside {
            return Err(outside);
        }
        let mut depth = 0.5;
        for _ in 0..MOST_STEPS {
            let (value, slope) = self.level(point, depth);
            // The level falls with the depth.
            if value > 0.0 {
                low = depth
            } else {
                high = depth
            }
            let newton = depth - value / slope;
            let next =
                if (low..=high).contains(&newton) { newton } else { f64::midpoint(low, high) };
            let step = (next - depth).abs();
            depth = next;
            if step < DEPTH_STEP {
                break;
            }
        }
        Ok(depth)
    }

    /// Fibre, sheet and normal at a point \[length\] in the wall; `slack` as for [`EllipsoidWall::depth`].
    ///
    /// On the axis, where no direction is circumferential, it is the one that a point beside it along x has.
    ///
    /// # Errors
    /// [`FibreError::Outside`].
    pub fn frame(
        &self,
        point: [f64; 3],
        rule: &FibreRule,
        slack: f64,
    ) -> Result<Frame, FibreError> {
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

    /// `(x² + y²)/r² + z²/l² − 1` at a depth, and its slope.
    fn level(&self, [x, y, z]: [f64; 3], depth: f64) -> (f64, f64) {
        let [short, long] = self.semi_axes(depth);
        let (across, along) = ((x * x + y * y) / (short * short), z * z / (long * long));
        let growth =
            [self.ellipsoid.short, self.ellipsoid.long].map(|[inner, outer]| outer - inner);
        let slope = -2.0 * (across * growth[0] / short + along * growth[1] / long);
        (across + along - 1.0, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const LAND: EllipsoidWall = EllipsoidWall::LAND;

    fn wall(short: [f64; 2], long: [f64; 2], base: f64) -> Result<EllipsoidWall, FibreError> {
        EllipsoidWall::new(TruncatedEllipsoid { short, long, base })
    }

    /// The parametrisation of Land et al.: position, n(∂x/∂u) and n(∂x/∂v).
    fn land(t: f64, u: f64, v: f64) -> [Vector3<f64>; 3] {
        let (r, l) = (7.0 + 3.0 * t, 17.0 + 3.0 * t);
        let position = Vector3::new(r * u.sin() * v.cos(), r * u.sin() * v.sin(), l * u.cos());
        let du = Vector3::new(r * u.cos() * v.cos(), r * u.cos() * v.sin(), -l * u.sin());
        let dv = Vector3::new(-r * u.sin() * v.sin(), r * u.sin() * v.cos(), 0.0);
        [position, du.normalize(), dv.normalize()]
    }

    #[test]
    fn fibres_are_those_of_the_benchmark() {
        for t in [0.0_f64, 0.1, 0.5, 0.77, 1.0] {
            let end = -(5.0 / (17.0 + 3.0 * t)).acos();
            for step in 1..=20 {
                let u = -PI + (end + PI) * f64::from(step) / 20.0;
                for v in [-3.0, -1.5, 0.0, 0.4, 2.2] {
                    let [x, du, dv] = land(t, u, v);
                    let depth = LAND.depth(x.into(), 0.0).unwrap();
                    assert!((depth - t).abs() < 1e-13, "{depth} at {t}");
                    let (sin, cos) = (90.0 - 180.0 * t).to_radians().sin_cos();
                    let expected = du * sin + dv * cos;
                    let [fibre, sheet, normal] =
                        LAND.frame(x.into(), &FibreRule::NINETY, 0.0).unwrap().map(Vector3::from);
                    assert!((fibre - expected).norm() < 1e-13, "{t} {u} {v}");
                    assert!(sheet.dot(&du).abs() < 1e-13 && sheet.dot(&dv).abs() < 1e-13);
                    assert!((fibre.cross(&sheet) - normal).norm() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn the_axis_has_a_frame_too() {
        let [fibre, sheet, _] = LAND.frame([0.0, 0.0, -18.0], &FibreRule::SIXTY, 0.0).unwrap();
        let beside = LAND.frame([1e-9, 0.0, -18.0], &FibreRule::SIXTY, 0.0).unwrap();
        assert_eq!(sheet, [0.0, 0.0, -1.0]);
        assert!((Vector3::from(fibre) - Vector3::from(beside[0])).norm() < 1e-8);
    }

    #[test]
    fn points_beside_the_wall_are_refused() {
        let nowhere = [[0.0, 0.0, 0.0], [6.9, 0.0, 0.0], [0.0, 10.1, 0.0], [8.0, 0.0, 5.1]];
        for point in nowhere.into_iter().chain([[f64::NAN, 8.0, 0.0], [f64::INFINITY, 0.0, 0.0]]) {
            let error = LAND.frame(point, &FibreRule::SIXTY, 0.0).unwrap_err();
            assert!(matches!(error, FibreError::Outside { .. }), "{point:?}");
        }
        // A tenth of the thickness is 0.3 mm.
        assert!((LAND.depth([6.9, 0.0, 0.0], 0.1).unwrap() + 1.0 / 30.0).abs() < 1e-13);
        assert!(LAND.depth([0.0, 10.1, 0.0], 0.1).is_ok());
        assert!(LAND.depth([6.6, 0.0, 0.0], 0.1).is_err());
        assert!(LAND.depth([6.6, 0.0, 0.0], f64::NAN).is_err());
    }

    #[test]
    fn thick_walls_are_no_harder() {
        let wall = wall([0.1, 10.0], [0.2, 20.0], 0.0).unwrap();
        for t in [0.0, 1e-3, 0.3, 1.0] {
            let point = [0.0, -(0.1 + 9.9 * t), 0.0];
            assert!((wall.depth(point, 0.5).unwrap() - t).abs() < 1e-12);
        }
    }

    #[test]
    fn walls_without_thickness_or_base_are_refused() {
        let error = wall([7.0, 7.0], [17.0, 20.0], 5.0).unwrap_err();
        assert_eq!(
            error,
            FibreError::Unfit(
                "the short semi-axes (7, 7) must be positive, finite and ascending from endocardium to epicardium"
                    .into()
            )
        );
        assert!(wall([7.0, 10.0], [17.0, f64::NAN], 5.0).is_err());
        let error = wall([7.0, 10.0], [17.0, 20.0], 18.0).unwrap_err();
        assert_eq!(
            error,
            FibreError::Unfit(
                "the base at z = 18 does not cut the inner ellipsoid of half-height 17".into()
            )
        );
    }
}

//! Coordinates of a left ventricle's wall: height along the axis, depth, and the angle from the septum.

use crate::error::PatientError;
use crate::observable::Direction;
use crate::segments::Segments;
use nalgebra::Vector3;
use sinew_fem::fibres::{Depth, FibreRule, Frame, Surfaces, VentricleCoordinates};
use sinew_mesh::TetMesh;

/// Least angle \[degrees\] between the axis and the direction of the septum.
const ACROSS: f64 = 5.0;

/// Coordinates of the cells of a left ventricle, at their centres.
///
/// The long axis goes from the apex of the endocardium to the middle of the base. Heights are 0 at that apex and 1 at the middle of the base, so
/// that they are negative in the cap of the apex. Depths go from 0 on the endocardium to 1 on the epicardium. Angles count from the
/// middle of the septum, counterclockwise seen from the apex, so that they go on to the inferior wall.
///
/// ```
/// use sinew_calibrate::WallCoordinates;
/// use sinew_fem::fibres::Surfaces;
///
/// let mesh = sinew_mesh::TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra();
/// let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
/// let wall = WallCoordinates::new(&mesh, &surfaces)?.with_septum([-1.0, 0.0, 0.0])?;
/// let segments = wall.aha17()?;
/// assert_eq!(segments.names().len(), 17);
/// // The lateral wall is opposite to the septum.
/// let lateral = segments.cells_of("16")?;
/// assert!(lateral.iter().all(|&cell| mesh.corners(cell).iter().any(|x| x[0] > 0.0)));
/// # Ok::<(), sinew_calibrate::PatientError>(())
/// ```
#[derive(Clone, Debug)]
pub struct WallCoordinates {
    /// Height of each cell along the axis [relative to the way from apex to base].
    pub heights: Vec<f64>,
    /// Depth of each cell in the wall.
    pub depths: Vec<f64>,
    /// Angle of each cell about the axis from the middle of the septum, from 0 to 360 \[degrees\]; empty without a septum.
    pub angles: Vec<f64>,
    /// Circumferential, radial and (minus) longitudinal unit vectors of each cell.
    frames: Vec<Frame>,
    /// Vector from the axis to the centre of each cell \[length\].
    from_axis: Vec<Vector3<f64>>,
    /// Unit vector from the apex to the base.
    axis: Vector3<f64>,
}

impl WallCoordinates {
    /// Coordinates without angles.
    ///
    /// # Errors
    /// Surfaces that do not bound a ventricle.
    pub fn new(mesh: &TetMesh, surfaces: &Surfaces<'_>) -> Result<Self, PatientError> {
        let coordinates = VentricleCoordinates::new(mesh, surfaces)?;
        let place = |node: usize| Vector3::from(mesh.points[node]);
        let base = mesh.nodes_of_facets(&mesh.facet_sets[surfaces.base]);
        let middle = base.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / base.len() as f64;
        let apex = place(coordinates.apexes[0]);
        let length = (middle - apex).norm();
        let axis = (middle - apex) / length;
        let centres = || {
            mesh.cells
                .iter()
                .map(|cell| cell.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / 4.0 - apex)
        };
        let heights = centres().map(|centre| centre.dot(&axis) / length).collect();
        let from_axis = centres().map(|centre| centre - axis * centre.dot(&axis)).collect();
        let depth = |cell: &[usize; 4]| {
            cell.iter().map(|&node| coordinates.thickness[node]).sum::<f64>() / 4.0
        };
        let depths = mesh.cells.iter().map(depth).collect();
        let frames = coordinates.cell_frames(&FibreRule::new(0.0, 0.0)?, Depth::Thickness);
        Ok(Self { heights, depths, angles: Vec::new(), frames, from_axis, axis })
    }

    /// Coordinates with angles, counted from the middle of the septum. `direction` points from the cavity to it.
    ///
    /// # Errors
    /// A direction without length or along the axis.
    pub fn with_septum(mut self, direction: [f64; 3]) -> Result<Self, PatientError> {
        let septum = Vector3::from(direction);
        let length = septum.norm();
        // Written so that a NaN is refused as well.
        let usable = length > 0.0 && length.is_finite();
        if !usable {
            return Err(PatientError::Input(format!(
                "({}, {}, {}) is no direction; give a vector of finite length",
                direction[0], direction[1], direction[2]
            )));
        }
        let across = septum / length - self.axis * self.axis.dot(&septum) / length;
        let degrees = across.norm().min(1.0).asin().to_degrees();
        if degrees < ACROSS {
            return Err(PatientError::Input(format!(
                "the direction of the septum is {degrees:.2} degrees off the long axis, so it marks no angle; give a vector across the axis"
            )));
        }
        let first = across.normalize();
        // Counterclockwise for an eye at the apex, which the axis points away from.
        let second = first.cross(&self.axis);
        let angle = |place: &Vector3<f64>| {
            place.dot(&second).atan2(place.dot(&first)).to_degrees().rem_euclid(360.0)
        };
        self.angles = self.from_axis.iter().map(angle).collect();
        Ok(self)
    }

    /// Number of cells.
    pub(crate) fn cell_count(&self) -> usize {
        self.frames.len()
    }

    /// A unit vector of a cell.
    ///
    /// # Panics
    /// At a fibre, which is the law's.
    pub fn direction(&self, cell: usize, direction: Direction) -> [f64; 3] {
        let [circumferential, radial, longitudinal] = self.frames[cell];
        match direction {
            Direction::Circumferential => circumferential,
            Direction::Radial => radial,
            Direction::Longitudinal => longitudinal,
            Direction::Fibre => panic!("fibres are directions of the law"),
        }
    }

    /// The 17 segments of the American Heart Association (M. D. Cerqueira et al., Circulation 105, 2002), named by their numbers: six basal, six
    /// in the middle and four apical ones in thirds of the height, and the cap of the apex.
    ///
    /// # Errors
    /// No septum, and a segment without cells.
    pub fn aha17(&self) -> Result<Segments, PatientError> {
        // Segment numbers of the sectors, from the middle of the septum on.
        const BASAL: [usize; 6] = [3, 4, 5, 6, 1, 2];
        const APICAL: [usize; 4] = [14, 15, 16, 13];
        let segment = |height: f64, angle: f64| match (3.0 * height).floor() {
            third if third >= 2.0 => BASAL[sector(angle, 6)],
            1.0 => 6 + BASAL[sector(angle, 6)],
            0.0 => APICAL[sector(angle + 45.0, 4)],
            _ => 17,
        };
        let names = (1..=17).map(|number| number.to_string()).collect();
        self.divided(names, |height, angle| segment(height, angle) - 1)
    }

    /// Levels of equal height from the base (1) to the apex, each divided into sectors from the septum's middle on; the cap of the apex belongs to
    /// the lowest. Names are like `2-5`, level and sector.
    ///
    /// # Errors
    /// No septum, and a segment without cells.
    pub fn levels(&self, levels: usize, sectors: usize) -> Result<Segments, PatientError> {
        let pairs = (1..=levels).flat_map(|l| (1..=sectors).map(move |s| format!("{l}-{s}")));
        let level = |height: f64| {
            let from_base = ((1.0 - height) * levels as f64).floor();
            from_base.clamp(0.0, levels as f64 - 1.0) as usize
        };
        self.divided(pairs.collect(), |height, angle| {
            level(height) * sectors + sector(angle, sectors)
        })
    }

    fn divided(
        &self,
        names: Vec<String>,
        segment: impl Fn(f64, f64) -> usize,
    ) -> Result<Segments, PatientError> {
        if self.angles.is_empty() {
            return Err(PatientError::Input("the division in segments counts angles from the septum, but its direction is not given: give a vector from the left cavity to the middle of the septum".into()));
        }
        let places = self.heights.iter().zip(&self.angles);
        Segments::new(names, places.map(|(&h, &a)| Some(segment(h, a))).collect())
    }
}

/// Sector of an angle \[degrees\] among some of equal width.
fn sector(angle: f64, sectors: usize) -> usize {
    let at = angle.rem_euclid(360.0) / 360.0 * sectors as f64;
    (at as usize).min(sectors.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_mesh::TruncatedEllipsoid;

    const SURFACES: Surfaces<'static> =
        Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };

    fn centre(mesh: &TetMesh, cell: usize) -> [f64; 3] {
        std::array::from_fn(|i| {
            mesh.cells[cell].iter().map(|&node| mesh.points[node][i]).sum::<f64>() / 4.0
        })
    }

    #[test]
    fn coordinates_of_an_ellipsoid_are_those_of_its_formula() {
        let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
        let wall = WallCoordinates::new(&mesh, &SURFACES).unwrap().with_septum([-2.0, 0.0, 0.3]);
        let wall = wall.unwrap();
        for cell in 0..mesh.cells.len() {
            let [x, y, z] = centre(&mesh, cell);
            // The base is at z = 5, the apex of the endocardium at −17.
            assert!((wall.heights[cell] - (z + 17.0) / 22.0).abs() < 1e-9);
            // From −x on; an eye at the apex looks up, so that y is on the left of −x as it turns counterclockwise.
            let angle = y.atan2(-x).to_degrees().rem_euclid(360.0);
            let off = (wall.angles[cell] - angle).rem_euclid(360.0);
            assert!(off.min(360.0 - off) < 1e-6, "{} is not {angle}", wall.angles[cell]);
            assert!((0.0..=1.0).contains(&wall.depths[cell]));
            let radial = wall.direction(cell, Direction::Radial);
            let around = wall.direction(cell, Direction::Circumferential);
            if wall.heights[cell] > 0.3 {
                assert!(radial[0] * x + radial[1] * y > 0.0, "{radial:?} at {x}, {y}");
                assert!((around[0] * x + around[1] * y).abs() < 0.35 * x.hypot(y), "{around:?}");
            }
        }
    }

    /// M. D. Cerqueira et al. (2002): seen from the apex with the septum on the left, the anterior wall is up and the lateral one on the right.
    #[test]
    fn segments_lie_as_in_the_polar_map() {
        let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
        let wall = WallCoordinates::new(&mesh, &SURFACES).unwrap();
        let segments = wall.with_septum([-1.0, 0.0, 0.0]).unwrap().aha17().unwrap();
        let mean = |name: &str, axis: usize| {
            let cells = segments.cells_of(name).unwrap();
            cells.iter().map(|&cell| centre(&mesh, cell)[axis]).sum::<f64>() / cells.len() as f64
        };
        // Seen from below with −x on the left, −y is up.
        for (anterior, inferior) in [("1", "4"), ("7", "10"), ("13", "15")] {
            assert!(mean(anterior, 1) < -2.0 && mean(inferior, 1) > 2.0, "{anterior}");
        }
        for septal in ["2", "3", "8", "9", "14"] {
            assert!(mean(septal, 0) < -1.5, "{septal}");
        }
        assert!(mean("2", 1) < 0.0 && mean("3", 1) > 0.0);
        assert!(mean("5", 1) > 0.0 && mean("6", 1) < 0.0 && mean("5", 0) > 1.0);
        assert!(mean("1", 2) > mean("7", 2) && mean("7", 2) > mean("13", 2));
        assert!(mean("17", 2) < -17.0);
    }
}

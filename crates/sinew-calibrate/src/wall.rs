//! Coordinates of a left ventricle's wall: height along the axis, depth, and the angle from the septum; segments of a wall.

use crate::Direction;
use crate::error::{PatientError, Result, length_of, place_of, require};
use nalgebra::Vector3;
use sinew_energy::listed;
use sinew_fem::fibres::{FibreRule, Frame, Surfaces, VentricleCoordinates};
use sinew_mesh::{AnyMesh, TetMesh};
use sinew_num::ascending;

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
    pub fn new(mesh: &TetMesh, surfaces: &Surfaces<'_>) -> Result<Self> {
        let coordinates = VentricleCoordinates::new(mesh, surfaces)?;
        let place = |node: usize| Vector3::from(mesh.points[node]);
        let base = mesh.nodes_of_facets(&mesh.facet_sets[surfaces.base]);
        let middle = base.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / base.len() as f64;
        let apex = place(coordinates.apexes[0]);
        let length = (middle - apex).norm();
        let axis = (middle - apex) / length;
        let centre = |cell: &[usize; 4]| cell.map(place).iter().sum::<Vector3<f64>>() / 4.0 - apex;
        let centres = || mesh.cells.iter().map(centre);
        let heights = centres().map(|centre| centre.dot(&axis) / length).collect();
        let from_axis = centres().map(|centre| centre - axis * centre.dot(&axis)).collect();
        let thickness = |node: usize| coordinates.thickness[node];
        let depth = |cell: &[usize; 4]| cell.map(thickness).iter().sum::<f64>() / 4.0;
        let depths = mesh.cells.iter().map(depth).collect();
        let frames = coordinates.cell_frames(&FibreRule::new(0.0, 0.0)?);
        Ok(Self { heights, depths, angles: Vec::new(), frames, from_axis, axis })
    }

    /// Coordinates with angles, counted from the middle of the septum. `direction` points from the cavity to it.
    ///
    /// # Errors
    /// A direction without length or along the axis.
    pub fn with_septum(mut self, direction: [f64; 3]) -> Result<Self> {
        let length = length_of(direction)?;
        let septum = Vector3::from(direction);
        let across = septum / length - self.axis * self.axis.dot(&septum) / length;
        let degrees = across.norm().min(1.0).asin().to_degrees();
        require(degrees >= ACROSS, || {
            format!(
                "the direction of the septum is {degrees:.2} degrees off the long axis, so it marks no angle; give a vector across the axis"
            )
        })?;
        let first = across.normalize();
        // Counterclockwise for an eye at the apex, which the axis points away from.
        let second = first.cross(&self.axis);
        let angle = |place: &Vector3<f64>| {
            place.dot(&second).atan2(place.dot(&first)).to_degrees().rem_euclid(360.0)
        };
        self.angles = self.from_axis.iter().map(angle).collect();
        Ok(self)
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
    pub fn aha17(&self) -> Result<Segments> {
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
    pub fn levels(&self, levels: usize, sectors: usize) -> Result<Segments> {
        let pairs = (1..=levels).flat_map(|l| (1..=sectors).map(move |s| format!("{l}-{s}")));
        let level = |height: f64| {
            let from_base = ((1.0 - height) * levels as f64).floor();
            from_base.clamp(0.0, levels as f64 - 1.0) as usize
        };
        self.divided(pairs.collect(), |height, angle| {
            level(height) * sectors + sector(angle, sectors)
        })
    }

    fn divided(&self, names: Vec<String>, segment: impl Fn(f64, f64) -> usize) -> Result<Segments> {
        require(!self.angles.is_empty(), || {
            "the division in segments counts angles from the septum, but its direction is not given: give a vector from the left cavity to the middle of the septum".into()
        })?;
        let places = self.heights.iter().zip(&self.angles);
        Segments::new(names, places.map(|(&h, &a)| Some(segment(h, a))).collect())
    }
}

/// Segments of a mesh: each cell belongs to one or to none.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    names: Vec<String>,
    of_cell: Vec<Option<usize>>,
}

impl Segments {
    /// Segments from their names and the segment of each cell.
    ///
    /// # Errors
    /// A segment without cells.
    ///
    /// # Panics
    /// Where a cell is of a segment without name.
    pub fn new(names: Vec<String>, of_cell: Vec<Option<usize>>) -> Result<Self> {
        assert!(of_cell.iter().flatten().all(|&segment| segment < names.len()), "each has a name");
        for (place, segment) in names.iter().enumerate() {
            require(of_cell.contains(&Some(place)), || {
                format!(
                    "segment {segment} has no cells of {}: the mesh is too coarse for this division, or the wall does not reach there; take fewer segments",
                    of_cell.len()
                )
            })?;
        }
        Ok(Self { names, of_cell })
    }

    /// Segments by an integer field of the cells, named by its values; cells with a negative value belong to none.
    ///
    /// # Errors
    /// A field that is not there, has more than one component, or values that are no integers.
    pub fn by_field(mesh: &AnyMesh, field: &str) -> Result<Self> {
        let refuse = |problem: &str| {
            PatientError::Input(format!(
                "the cell field `{field}` {problem}; the mesh has {}",
                listed(&mesh.cell_fields().keys().collect::<Vec<_>>())
            ))
        };
        let found = mesh.cell_fields().get(field).ok_or_else(|| refuse("is not there"))?;
        let rows = found.to_vectors::<1>().ok_or_else(|| refuse("has more than one component"))?;
        let whole = |[value]: &[f64; 1]| value.fract() == 0.0 && value.abs() < f64::from(i32::MAX);
        if let Some([value]) = rows.iter().find(|row| !whole(row)) {
            return Err(refuse(&format!("has the value {value}, which is no integer")));
        }
        let values: Vec<i64> = rows.iter().map(|[value]| *value as i64).collect();
        let present = ascending(values.iter().copied().filter(|value| *value >= 0));
        if present.is_empty() {
            return Err(refuse("has no value that is not negative"));
        }
        let of_cell = values.iter().map(|value| present.binary_search(value).ok()).collect();
        Self::new(present.iter().map(i64::to_string).collect(), of_cell)
    }

    /// Names of the segments.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Segment of each cell, if it belongs to one.
    pub fn of_cell(&self) -> &[Option<usize>] {
        &self.of_cell
    }

    /// Cells of a segment, ascending.
    ///
    /// # Errors
    /// A name that no segment has.
    pub fn cells_of(&self, name: &str) -> Result<Vec<usize>> {
        let fault = || format!("there is no segment `{name}`; there are");
        let segment = place_of(name, &self.names, fault)?;
        let cells = 0..self.of_cell.len();
        Ok(cells.filter(|&cell| self.of_cell[cell] == Some(segment)).collect())
    }
}

/// Sector of an angle \[degrees\] among some of equal width.
fn sector(angle: f64, sectors: usize) -> usize {
    let at = angle.rem_euclid(360.0) / 360.0 * sectors as f64;
    (at as usize).min(sectors.saturating_sub(1))
}

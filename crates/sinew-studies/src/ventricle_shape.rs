//! Left ventricles of random size, thickness and form, that differ by a few numbers, drawn independently.

use nalgebra::{Cholesky, SMatrix, SVector, Vector3};
use sinew_mesh::{HexMesh, Mesh, Refusal, TetMesh, TruncatedEllipsoid};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::LazyLock;

fn within(what: &str, value: f64, [least, most]: [f64; 2]) -> Result<(), Refusal> {
    let advice = format!("is not between {least} and {most}: draw other numbers");
    let inside = (least..=most).contains(&value);
    inside.then_some(()).ok_or(Refusal(format!("the {what} of {value:.3} {advice}")))
}

/// A left ventricle between two smooth surfaces: a truncated ellipsoid and smooth modes of its endocardium and epicardium.
///
/// Its numbers are independent, of mean zero and variance one. They move the nodes as much as the principal components
/// of 1093 hearts (root mean square over the nodes 3.1, 2.0, 1.5, 1.25, 1.1, 0.8, 0.7, 0.6, 0.5, 0.5 mm and so on). The
/// modes are size, length, thickness and skew, then the Laplacian's eigenfunctions `J_m(k r) cos m φ` on the disk
/// unrolled from the apex, with zero slope at the base. These move both surfaces along the normal, together or against
/// each other. Each mode is orthogonal to those before it. The base stays in its plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VentricleShape {
    /// Amplitude of every mode of the table.
    amounts: SVector<f64, { Self::NUMBERS }>,
}

/// Effect of a mode.
#[derive(Clone, Copy, Debug)]
enum Effect {
    Size,
    Length,
    /// Along x (0) or y (1).
    Skew,
    /// Both surfaces along the normal by an eigenfunction.
    Bulge,
    /// The surfaces against each other.
    Thickness,
}

/// An effect, with its eigenfunction where it has one: `J_m(k r)` times `cos m φ`, or `sin m φ`.
#[derive(Clone, Copy, Debug)]
struct Mode {
    effect: Effect,
    m: usize,
    k: f64,
    of_sine: bool,
}

/// Root mean square displacement of the nodes by the first modes \[mm\]; the others fall by a constant factor.
const SPECTRUM: [f64; 10] = [3.1, 2.0, 1.5, 1.25, 1.1, 0.8, 0.7, 0.6, 0.5, 0.5];
const FALL: f64 = 0.93;

/// Zeros of the derivatives of Bessel functions, row by row `k` of `J_m(k r)` without slope at r = 1.
const ZEROS: [&[f64]; 5] = [
    &[0.0, 3.831705970207512, 7.015586669815619],
    &[1.841183781340659, 5.331442773525033, 8.536316366346286],
    &[3.05423692822714, 6.706133194158459],
    &[4.201188941210528, 8.015236598375951],
    &[5.317553126083994],
];

/// Effects with m and the place of k among its zeros. Where m is not zero they are two modes, of the cosine and the sine.
const EFFECTS: [(Effect, usize, usize); 20] = {
    use Effect::{Bulge, Length, Size, Skew, Thickness};
    [
        (Size, 0, 0),
        (Length, 0, 0),
        (Thickness, 0, 0),
        (Bulge, 2, 0),
        (Skew, 1, 0),
        (Bulge, 0, 1),
        (Thickness, 1, 0),
        (Thickness, 0, 1),
        (Bulge, 1, 1),
        (Bulge, 3, 0),
        (Thickness, 2, 0),
        (Bulge, 2, 1),
        (Bulge, 0, 2),
        (Thickness, 1, 1),
        (Bulge, 4, 0),
        (Thickness, 3, 0),
        (Thickness, 0, 2),
        (Thickness, 2, 1),
        (Bulge, 1, 2),
        (Bulge, 3, 1),
    ]
};

static MODES: LazyLock<Vec<Mode>> = LazyLock::new(|| {
    let both = |(effect, m, zero): (Effect, usize, usize)| {
        let waves = [false, true].into_iter().take(1 + m.min(1));
        waves.map(move |of_sine| Mode { effect, m, k: ZEROS[m][zero], of_sine })
    };
    EFFECTS.into_iter().flat_map(both).take(VentricleShape::NUMBERS).collect()
});

/// The ventricle of all zeros \[mm\].
const MEAN: TruncatedEllipsoid =
    TruncatedEllipsoid { short: [24.0, 35.0], long: [60.0, 71.0], base: 0.0 };
/// Ranges of a population \[mm\]: least and largest thickness anywhere, length of the cavity, width at the base.
const THICKNESS: [f64; 2] = [4.5, 22.0];
const LENGTH: [f64; 2] = [40.0, 85.0];
const WIDTH: [f64; 2] = [28.0, 75.0];
/// Points from apex to base and around at which shapes are measured.
const GRID: [usize; 2] = [12, 24];

impl VentricleShape {
    /// Numbers of a shape.
    pub(crate) const NUMBERS: usize = 32;

    /// Shape of at most [`Self::NUMBERS`] numbers; those left out are zero.
    ///
    /// # Errors
    /// A wall that is too thin or thick, a cavity too short, long, narrow or wide.
    pub(crate) fn new(numbers: &[f64]) -> Result<Self, Refusal> {
        let all: [f64; Self::NUMBERS] =
            std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0));
        let shape = Self { amounts: ORTHOGONAL.tr_mul(&SVector::from(all)) };
        for (r, angle) in grid() {
            let [inner, outer] = [0.0, 1.0].map(|depth| shape.place(r, angle, depth));
            within("thickness of the wall", (inner - outer).norm(), THICKNESS)?;
        }
        within("length of the cavity", -shape.place(0.0, 0.0, 0.0).z, LENGTH)?;
        for angle in [0.0, 0.25 * PI, 0.5 * PI, 0.75 * PI] {
            let [a, b] = [angle, angle + PI].map(|angle| shape.place(1.0, angle, 0.0));
            within("width of the cavity", (a - b).norm(), WIDTH)?;
        }
        Ok(shape)
    }

    /// The wall as linear tetrahedra; `cells`, sets and fields as in [`TruncatedEllipsoid::wall`].
    ///
    /// # Errors
    /// A wall that folds over itself.
    pub(crate) fn tetrahedra(&self, cells: [usize; 3]) -> Result<TetMesh, Refusal> {
        let mesh = self.placed(MEAN.wall(cells).tetrahedra());
        let mut volumes = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).enumerate();
        match volumes.find(|(_, volume)| volume.is_nan() || *volume <= 0.0) {
            Some((cell, volume)) => Err(Refusal(format!(
                "cell {cell} has a volume of {volume:.3e}: the shape is folded; draw other numbers"
            ))),
            None => Ok(mesh),
        }
    }

    /// The wall as hexahedra.
    ///
    /// # Errors
    /// As [`VentricleShape::tetrahedra`].
    pub(crate) fn hexahedra(&self, cells: [usize; 3]) -> Result<HexMesh, Refusal> {
        self.tetrahedra(cells)?;
        Ok(self.placed(MEAN.wall(cells).hexahedra()))
    }

    fn placed<const N: usize>(&self, mut mesh: Mesh<N>) -> Mesh<N> {
        let depths = mesh.point_fields["depth"].to_f64().into_owned();
        for (x, depth) in mesh.points.iter_mut().zip(depths) {
            let long = MEAN.long[0] + depth * (MEAN.long[1] - MEAN.long[0]);
            let r = (-x[2] / long).clamp(0.0, 1.0).acos() / FRAC_PI_2;
            *x = self.place(r, x[1].atan2(x[0]), depth).into();
        }
        mesh
    }

    /// The place of a point of the disk, r = 0 the apex and r = 1 the base, at a depth.
    fn place(&self, r: f64, angle: f64, depth: f64) -> Vector3<f64> {
        let point = Point::new(r, angle, depth);
        let moved =
            MODES.iter().zip(&self.amounts).map(|(mode, amount)| mode.moves(&point) * *amount);
        moved.fold(point.mean, |x, moved| x + moved)
    }
}

fn grid() -> impl Iterator<Item = (f64, f64)> {
    let [along, around] = GRID;
    let at = move |i, j| (i as f64 / (along - 1) as f64, TAU * j as f64 / around as f64);
    (0..along).flat_map(move |i| (0..around).map(move |j| at(i, j)))
}

/// A point of the mean ventricle.
struct Point {
    /// Radius on the disk, with angle and depth \[0 inside, 1 outside\].
    r: f64,
    angle: f64,
    depth: f64,
    /// Position of the point.
    mean: Vector3<f64>,
    /// Normal of a sphere there.
    outward: Vector3<f64>,
}

impl Point {
    fn new(r: f64, angle: f64, depth: f64) -> Self {
        let axis = |[inner, outer]: [f64; 2]| inner + depth * (outer - inner);
        let (across, along) = (axis(MEAN.short), axis(MEAN.long));
        let (sin, cos) = (FRAC_PI_2 * r).sin_cos();
        // At r = 1 the cosine is a rounding error; the base is a plane.
        let down = if r < 1.0 { cos } else { 0.0 };
        let outward = Vector3::new(sin * angle.cos(), sin * angle.sin(), -down);
        let mean = outward.component_mul(&Vector3::new(across, across, along));
        Self { r, angle, depth, mean, outward }
    }
}

/// Modes, one per row, as combinations of those of the table.
type Modes = SMatrix<f64, { VentricleShape::NUMBERS }, { VentricleShape::NUMBERS }>;

/// Orthogonal modes (Gram–Schmidt over both surfaces), scaled by the spectrum.
static ORTHOGONAL: LazyLock<Modes> = LazyLock::new(|| {
    let (mut products, mut area) = (Modes::zeros(), 0.0);
    for (r, angle) in grid() {
        let weight = (FRAC_PI_2 * r).sin();
        for depth in [0.0, 1.0] {
            let point = Point::new(r, angle, depth);
            let moved: Vec<_> = MODES.iter().map(|mode| mode.moves(&point)).collect();
            let moved = SMatrix::<f64, 3, { VentricleShape::NUMBERS }>::from_columns(&moved);
            products += weight * moved.transpose() * moved;
            area += weight;
        }
    }
    let factor = Cholesky::new(products / area).expect("the modes of the table are independent");
    let mut orthogonal = Modes::identity();
    assert!(factor.l().solve_lower_triangular_mut(&mut orthogonal), "a factor has a diagonal");
    let last = SPECTRUM.len() - 1;
    for (k, mut row) in orthogonal.row_iter_mut().enumerate() {
        row *= SPECTRUM[k.min(last)] * FALL.powi(k.saturating_sub(last) as i32);
    }
    orthogonal
});

impl Mode {
    /// Displacement of a point, not normalised.
    fn moves(self, point: &Point) -> Vector3<f64> {
        let &Point { mean, outward, depth, .. } = point;
        match self.effect {
            Effect::Size => mean,
            Effect::Length => Vector3::ith(2, mean.z),
            Effect::Skew => {
                Vector3::ith(usize::from(self.of_sine), (mean.z / MEAN.long[1]).powi(2))
            }
            Effect::Bulge => outward * self.wave(point),
            Effect::Thickness => outward * ((2.0 * depth - 1.0) * self.wave(point)),
        }
    }

    fn wave(self, &Point { r, angle, .. }: &Point) -> f64 {
        let turn = self.m as f64 * angle;
        let around = if self.of_sine { turn.sin() } else { turn.cos() };
        libm::jn(self.m as i32, self.k * r) * around
    }
}

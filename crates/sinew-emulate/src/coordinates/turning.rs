//! Rotations by a vector, less the identity.

use sinew_num::{Mat3, Scalar, Slope};

/// A number, with or without its derivative along a direction.
pub(crate) trait Number: Scalar {
    /// A function of this number whose value and slope there are known.
    fn chain(&self, function: impl Fn(f64) -> [f64; 2]) -> Self;
}

impl Number for f64 {
    fn chain(&self, function: impl Fn(f64) -> [f64; 2]) -> Self {
        function(*self)[0]
    }
}

impl Number for Slope<1> {
    fn chain(&self, function: impl Fn(f64) -> [f64; 2]) -> Self {
        let [value, slope] = function(self.value);
        Self { value, gradient: self.gradient.map(|g| slope * g), hessian: [] }
    }
}

/// `exp([ω]) − I = s(q) [ω] + m(q) [ω]²` with `q = ω·ω`, `s = sin √q / √q` and `m = (1 − cos √q) / q` (Rodrigues).
pub(crate) struct Rotation<S> {
    vector: [S; 3],
    square: S,
}

/// Below it s, m and their slopes are summed as series: the first term left out is below rounding there, and above
/// it the closed forms of the slopes lose no more than three digits.
const SERIES_BELOW: f64 = 0.1;

/// s(q) and its slope.
fn sine_part(q: f64) -> [f64; 2] {
    if q < SERIES_BELOW {
        return series(q, 1.0, 2.0);
    }
    let angle = q.sqrt();
    let s = angle.sin() / angle;
    [s, 0.5 * (angle.cos() - s) / q]
}

/// m(q) and its slope.
fn cosine_part(q: f64) -> [f64; 2] {
    if q < SERIES_BELOW {
        return series(q, 0.5, 3.0);
    }
    let angle = q.sqrt();
    let half = (0.5 * angle).sin() / angle;
    let m = 2.0 * half * half;
    [m, 0.5 * (angle.sin() / angle - 2.0 * m) / q]
}

/// `Σ c_k (−q)^k` with `c_0 = first` and `c_k = c_(k−1) / ((n + 2k − 2)(n + 2k − 1))`, and its slope.
fn series(q: f64, first: f64, n: f64) -> [f64; 2] {
    const TERMS: usize = 8;
    let (mut coefficient, mut power) = (first, 1.0);
    let (mut sum, mut slope) = (first, 0.0);
    for k in 1..=TERMS {
        let k = k as f64;
        coefficient /= -(n + 2.0 * k - 2.0) * (n + 2.0 * k - 1.0);
        slope += k * coefficient * power;
        power *= q;
        sum += coefficient * power;
    }
    [sum, slope]
}

impl<S: Number> Rotation<S> {
    /// Rotation by the angle `‖ω‖` \[rad\] about the axis along ω.
    pub(crate) fn new(vector: [S; 3]) -> Self {
        let [x, y, z] = vector.clone();
        Self { square: x.squared() + y.squared() + z.squared(), vector }
    }

    /// `[ω]`, with `[ω] x = ω × x`.
    fn skew(&self) -> Mat3<S> {
        let [x, y, z] = self.vector.clone();
        let zero = x.constant(0.0);
        Mat3([[zero.clone(), -z.clone(), y.clone()], [z, zero.clone(), -x.clone()], [-y, x, zero]])
    }

    /// `exp([ω]) − I`.
    pub(crate) fn less_identity(&self) -> Mat3<S> {
        let (s, m) = (self.square.chain(sine_part), self.square.chain(cosine_part));
        let w = self.skew();
        let w2 = product(&w, &w);
        Mat3::from_fn(|i, j| s.clone() * w.at(i, j) + m.clone() * w2.at(i, j))
    }
}

impl Rotation<f64> {
    /// Gradient by ω of what has the gradient `moment` by `exp([ω]) − I`.
    pub(crate) fn pull_back(&self, moment: &Mat3<f64>) -> [f64; 3] {
        let ([s, s_slope], [m, m_slope]) = (sine_part(self.square), cosine_part(self.square));
        let w = self.skew();
        let w2 = product(&w, &w);
        let along = |direction: &Mat3<f64>| -> f64 {
            (0..3).flat_map(|i| (0..3).map(move |j| moment[i][j] * direction[i][j])).sum()
        };
        let slope = 2.0 * (s_slope * along(&w) + m_slope * along(&w2));
        // ⟨M, [e] [ω] + [ω] [e]⟩ = −⟨M [ω] + [ω] M, [e]⟩, because [ω] is skew.
        let (left, right) = (product(&w, moment), product(moment, &w));
        let both = Mat3::from_fn(|i, j| s * moment[i][j] - m * (left[i][j] + right[i][j]));
        let axial = [both[2][1] - both[1][2], both[0][2] - both[2][0], both[1][0] - both[0][1]];
        std::array::from_fn(|i| axial[i] + slope * self.vector[i])
    }
}

pub(crate) fn product<S: Scalar>(a: &Mat3<S>, b: &Mat3<S>) -> Mat3<S> {
    Mat3::from_fn(|i, j| {
        a.at(i, 0) * b.at(0, j) + a.at(i, 1) * b.at(1, j) + a.at(i, 2) * b.at(2, j)
    })
}

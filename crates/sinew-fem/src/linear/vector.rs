//! Products and norms of vectors.

pub(crate) use sinew_num::{difference, dot};

/// Root of a sum of squares, which overflows or vanishes only where the root does.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Norm {
    largest: f64,
    /// Sum of the squares in units of the largest.
    squares: f64,
}

impl Norm {
    pub(crate) fn add(&mut self, value: f64) {
        let size = value.abs();
        if size > self.largest {
            let ratio = self.largest / size;
            (self.largest, self.squares) = (size, 1.0 + self.squares * ratio * ratio);
        } else if size != 0.0 {
            let ratio = size / self.largest;
            self.squares += ratio * ratio;
        }
    }

    pub(crate) fn value(self) -> f64 {
        self.largest * self.squares.sqrt()
    }
}

impl FromIterator<f64> for Norm {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut norm = Self::default();
        values.into_iter().for_each(|value| norm.add(value));
        norm
    }
}

/// Norm of a vector, by plain squares where they neither overflow nor underflow.
pub(crate) fn norm(x: &[f64]) -> f64 {
    /// Squares between these bounds lose nothing to overflow or underflow.
    const PLAIN: std::ops::Range<f64> = 1e-140..1e150;
    let plain = dot(x, x).sqrt();
    if PLAIN.contains(&plain) { plain } else { x.iter().copied().collect::<Norm>().value() }
}

/// Adds a multiple of a vector.
pub(crate) fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
}

/// Residual relative to a force; zero for 0/0.
pub(crate) fn relative(residual: f64, force: f64) -> f64 {
    if residual == 0.0 { 0.0 } else { residual / force }
}

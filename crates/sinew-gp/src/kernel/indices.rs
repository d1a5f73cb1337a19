//! The powers that a set of derivatives needs.

use sinew_num::MOST_VARIABLES;

/// A power of each variable.
pub(super) type Powers = [u8; MOST_VARIABLES];

/// All powers of which some derivative asked for is a multiple: with one they hold every smaller
/// one, so that products cut off to them are exact. In ascending order, zero first.
#[derive(Debug)]
pub(super) struct Indices {
    powers: Vec<Powers>,
    degrees: Powers,
    /// Position in `powers` by position in the box of all powers up to `degrees`.
    positions: Vec<Option<usize>>,
}

impl Indices {
    pub fn below(orders: &[Powers]) -> Self {
        let degrees: Powers =
            std::array::from_fn(|d| orders.iter().map(|order| order[d]).max().unwrap_or(0));
        let size: usize = degrees.iter().map(|degree| usize::from(*degree) + 1).product();
        let within = |powers: &Powers| {
            orders.iter().any(|order| std::iter::zip(powers, order).all(|(n, most)| n <= most))
        };
        let mut indices = Self { powers: Vec::new(), degrees, positions: vec![None; size] };
        for number in 0..size {
            let mut rest = number;
            let mut powers = [0; MOST_VARIABLES];
            for (power, degree) in powers.iter_mut().zip(degrees).rev() {
                let base = usize::from(degree) + 1;
                *power = (rest % base) as u8;
                rest /= base;
            }
            if within(&powers) {
                indices.positions[number] = Some(indices.powers.len());
                indices.powers.push(powers);
            }
        }
        // Without derivatives asked for there is still the value.
        if indices.powers.is_empty() {
            indices.positions[0] = Some(0);
            indices.powers.push([0; MOST_VARIABLES]);
        }
        indices
    }

    pub fn count(&self) -> usize {
        self.powers.len()
    }

    pub fn powers(&self, index: usize) -> &Powers {
        &self.powers[index]
    }

    pub fn position(&self, powers: &Powers) -> Option<usize> {
        let mut number = 0;
        for (power, degree) in powers.iter().zip(self.degrees) {
            if *power > degree {
                return None;
            }
            number = number * (usize::from(degree) + 1) + usize::from(*power);
        }
        self.positions[number]
    }

    /// Where the product of two powers is, if it is kept.
    pub fn sum(&self, a: usize, b: usize) -> Option<usize> {
        let (a, b) = (&self.powers[a], &self.powers[b]);
        self.position(&std::array::from_fn(|d| a[d] + b[d]))
    }

    /// Where a quotient is, if there is one.
    pub fn difference(&self, a: usize, b: usize) -> Option<usize> {
        let (a, b) = (&self.powers[a], &self.powers[b]);
        let possible = std::iter::zip(a, b).all(|(a, b)| a >= b);
        possible.then(|| self.position(&std::array::from_fn(|d| a[d] - b[d])))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_powers_below_an_order_are_kept() {
        let order = |x: u8, y: u8| {
            let mut powers = [0; MOST_VARIABLES];
            (powers[0], powers[1]) = (x, y);
            powers
        };
        let indices = Indices::below(&[order(2, 0), order(0, 2), order(1, 1)]);
        let kept: Vec<[u8; 2]> =
            (0..indices.count()).map(|index| indices.powers(index)).map(|p| [p[0], p[1]]).collect();
        assert_eq!(kept, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [2, 0]]);
        assert_eq!(indices.sum(1, 3), Some(4));
        assert_eq!(indices.sum(1, 4), None, "x y² is not needed");
        assert_eq!(indices.difference(4, 3), Some(1));
        assert_eq!(indices.difference(3, 4), None);
        assert_eq!(Indices::below(&[]).count(), 1);
    }
}

//! Running moments of gradients, the inner loops of Adam and of momentum.

use crate::fused::simd::{multiply_add, vectorised};

/// Rule that turns a gradient into a direction of change, for one step of Adam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdamRule {
    /// Decay of the first moment.
    pub beta1: f32,
    /// Decay of the second moment.
    pub beta2: f32,
    /// Factor of the first moment in the direction: the bias correction.
    pub of_first: f32,
    /// Factor of the gradient itself in the direction; zero without Nesterov's look ahead.
    pub of_gradient: f32,
    /// Factor of the second moment under the root: the bias correction.
    pub of_second: f32,
}

/// Added to the root of Adam's second moment.
const EPSILON: f32 = 1e-8;

vectorised! {
    /// Updates both moments and replaces `gradient` by the direction of change
    /// `(of_first m + of_gradient g) / (√(of_second v) + 1e-8)`.
    ///
    /// ```
    /// use sinew_gnn::fused::{AdamRule, adam_direction};
    ///
    /// let rule = AdamRule { beta1: 0.9, beta2: 0.999, of_first: 10.0, of_gradient: 0.0, of_second: 1e3 };
    /// let (mut m, mut v, mut g) = ([0.0], [0.0], [-3.0]);
    /// adam_direction(rule, &mut m, &mut v, &mut g);
    /// assert!((g[0] + 1.0).abs() < 1e-4); // the first step has the gradient's sign
    /// ```
    pub fn adam_direction<FUSED>(rule: AdamRule, first: &mut [f32], second: &mut [f32], gradient: &mut [f32]) {
        let AdamRule { beta1, beta2, of_first, of_gradient, of_second } = rule;
        for ((m, v), g) in first.iter_mut().zip(second).zip(gradient) {
            *m = multiply_add::<FUSED>(beta1, *m, (1.0 - beta1) * *g);
            *v = multiply_add::<FUSED>(beta2, *v, (1.0 - beta2) * *g * *g);
            let ahead = multiply_add::<FUSED>(of_first, *m, of_gradient * *g);
            *g = ahead / ((of_second * *v).sqrt() + EPSILON);
        }
    }

    /// `momentum = decay · momentum + (1 − decay) gradient`, and replaces `gradient` by
    /// `of_momentum · momentum + of_gradient · gradient`.
    pub fn momentum_direction<FUSED>(
        decay: f32,
        of_momentum: f32,
        of_gradient: f32,
        momentum: &mut [f32],
        gradient: &mut [f32],
    ) {
        for (m, g) in momentum.iter_mut().zip(gradient) {
            *m = multiply_add::<FUSED>(decay, *m, (1.0 - decay) * *g);
            *g = multiply_add::<FUSED>(of_momentum, *m, of_gradient * *g);
        }
    }

    /// `x = x − step · direction`.
    pub fn descend<FUSED>(step: f32, direction: &[f32], x: &mut [f32]) {
        for (x, d) in x.iter_mut().zip(direction) {
            *x -= step * *d;
        }
    }
}

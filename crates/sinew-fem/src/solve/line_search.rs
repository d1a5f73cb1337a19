//! Line search of Newton's method.

use crate::elements::{PredictedStress, State, System, at_points, is_short, volume_ratios_along};
use crate::linear::difference;
use crate::solve::{Search, Watchdog};
use sinew_energy::Body;
use sinew_num::Mat3;

/// Constant of the sufficient decrease (Armijo) condition (Nocedal & Wright, 3.1).
pub(crate) const SUFFICIENT: f64 = 1e-4;
/// Largest rotation \[rad\] of a cell in a step that raises the energy. Measured over the range of both beams:
/// 0.45–0.55 need 6–7 iterations everywhere, 0.4 and 0.7 up to 14 at some θ.
const MOST_ROTATION: f64 = 0.5;
/// Steps in a row that may raise the energy.
const MOST_RISES: usize = 2;
/// Largest rise of the energy in such a step, as a multiple of the decrease that the slope predicts. Beams take more
/// iterations below 20, and no fewer above. Without a bound, a first step into the exponential of a fibre law reaches
/// 1e113 times the energy, and most iterations return from there.
const MOST_RISE: f64 = 20.0;
/// Least volume ratio after such a step \[relative to the one before\]: cells crushed further cost more iterations to restore.
const LEAST_VOLUME_OF_RISE: f64 = 0.5;
/// Least volume of a cell along a step \[relative to the smaller of its volumes before and after\].
const FLAT: f64 = 1e-3;
/// Least ratio of actual to promised decrease without a second-order correction.
const POOR: f64 = 0.25;
/// Most corrections of a step: a third one gains little.
const MOST_CORRECTIONS: usize = 2;
/// Steps shorter than this end the line search: the energy does not fall along the direction.
const SHORTEST_STEP: f64 = 1e-8;
/// Steps are doubled up to this while the energy falls.
const LONGEST_STEP: f64 = 64.0;
/// Least volume ratio after a step without a potential \[relative to the one before\].
const LEAST_VOLUME: f64 = 0.3;
/// Shortest step without a potential.
const SHORTEST_BALANCE_STEP: f64 = 1e-2;

impl Search<'_> {
    /// Whether a full step may still raise the energy.
    fn relaxed(&self) -> bool {
        self.rises < MOST_RISES
    }
}

impl System<'_> {
    /// Energy at the end of a step, with the displacement there: +∞ where a cell is flat on the way.
    fn reach(&self, search: &Search<'_>, direction: &[f64], length: f64) -> (f64, Vec<f64>) {
        let moved = search.at.displacement.iter().zip(direction).map(|(u, d)| u + length * d);
        let trial: Vec<_> = moved.collect();
        let mut reached = State { displacement: &trial, ..search.state() }.energy(self.body);
        if reached.is_finite() && self.passes_flat(&search.theta, direction, length) {
            reached = f64::INFINITY;
        }
        (reached, trial)
    }

    /// Takes a step along `direction`; returns its length, 0 if the search returned to the watchdog's state.
    ///
    /// Steps with a `shifted` stiffness, and those after a `slow` one, may be too short: they are doubled while the energy falls. Second-order corrections follow
    /// where it falls too little.
    pub(crate) fn line_search(
        &self,
        search: &mut Search<'_>,
        direction: &[f64],
        promised: f64,
        [shifted, slow]: [bool; 2],
    ) -> Option<f64> {
        let (energy, noise) = (self.assembly.energy, self.assembly.energy_noise);
        let mut length = 1.0;
        while length >= SHORTEST_STEP {
            let (mut reached, mut trial) = self.reach(search, direction, length);
            let mut lowered = reached <= energy - SUFFICIENT * length * promised + noise;
            while lowered && (shifted || slow) && length < LONGEST_STEP {
                let (farther, next) = self.reach(search, direction, 2.0 * length);
                match farther < reached - noise {
                    true => (length, reached, trial) = (2.0 * length, farther, next),
                    false => break,
                }
            }
            let mut predicted = None;
            let poor = reached > energy - POOR * length * promised + noise;
            if poor && reached.is_finite() && length <= 1.0 && self.assembly.nearly_incompressible {
                predicted = self.predicted(direction, length);
                (reached, trial) = self.corrected(search, predicted.as_ref(), (reached, trial));
                lowered |= reached <= energy - SUFFICIENT * length * promised + noise;
            }
            if !lowered && search.relaxed() && length == 1.0 {
                let rotation = self.largest_rotation(direction);
                if rotation > MOST_ROTATION {
                    length = MOST_ROTATION / rotation;
                    continue;
                }
            }
            let bearable = reached.is_finite() && reached - energy <= MOST_RISE * promised;
            // At a higher energy no cell may be crushed.
            let least = LEAST_VOLUME_OF_RISE * self.assembly.least_volume_ratio.min(1.0);
            let keeps_volume = || self.least_volume_ratio(&trial) >= least;
            if lowered || (search.relaxed() && bearable && keeps_volume()) {
                let displacement = std::mem::replace(&mut search.at.displacement, trial);
                if !lowered {
                    search.rises += 1;
                    search.watchdog.get_or_insert(Watchdog { displacement, energy });
                } else if search.watchdog.as_ref().is_some_and(|watch| reached < watch.energy) {
                    (search.rises, search.watchdog) = (0, None);
                }
                // By the linear model, exponential stresses change their sign over twice an unshifted step.
                let beyond = length > 1.0 && !shifted;
                let predict = || self.predicted(direction, length);
                search.predicted = if beyond { None } else { predicted.or_else(predict) };
                return Some(length);
            }
            if let Some(watch) = search.watchdog.take() {
                // The next step must lower the energy.
                search.rises = MOST_RISES;
                search.at.displacement = watch.displacement;
                search.predicted = None;
                return Some(0.0);
            }
            length *= 0.5;
        }
        None
    }

    fn least_volume_ratio(&self, displacement: &[f64]) -> f64 {
        let ratio = |p| 1.0 + self.body.displacement_gradient(p, displacement).volume_change();
        at_points(self.body.volumes.len(), ratio).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Predicted stress after a step.
    fn predicted(&self, direction: &[f64], length: f64) -> Option<PredictedStress> {
        self.predict_stress(&direction.iter().map(|d| length * d).collect::<Vec<_>>())
    }

    /// Second-order corrections of a step (Nocedal & Wright, 15.6) while they lower the energy.
    ///
    /// A step with δJ = 0 changes J to second order. The energy rises by the bulk modulus times the square of this change, which would shorten steps
    /// to a hundredth: the Maratos effect. A correction lowers the difference between actual and predicted pressure. It costs an evaluation of
    /// stresses and a solve with the present factor.
    fn corrected(
        &self,
        search: &Search<'_>,
        predicted: Option<&PredictedStress>,
        (mut reached, mut trial): (f64, Vec<f64>),
    ) -> (f64, Vec<f64>) {
        let Some(predicted) = predicted else { return (reached, trial) };
        for _ in 0..MOST_CORRECTIONS {
            let state = (&trial[..], &search.theta[..]);
            let Some(forces) = self.assembly.pressure_defect(self.body, state, predicted) else {
                break;
            };
            let mut moved = trial.clone();
            self.add_newton_step(&forces, &mut moved);
            let step = difference(&moved, &search.at.displacement);
            match self.reach(search, &step, 1.0) {
                better if better.0 < reached => (reached, trial) = better,
                _ => break,
            }
        }
        (reached, trial)
    }

    /// Takes the longest of the steps 1, ½, ¼, … that keeps the volume of all cells, for a balance without a potential.
    pub(crate) fn take(
        &self,
        search: &mut Search<'_>,
        motion: &[f64],
        pressures: &[f64],
    ) -> Option<f64> {
        let least = LEAST_VOLUME * self.assembly.least_volume_ratio.min(1.0);
        let mut length = 1.0;
        while length >= SHORTEST_BALANCE_STEP {
            let moved = search.at.displacement.iter().zip(motion).map(|(u, m)| u + length * m);
            let displacement: Vec<f64> = moved.collect();
            let safe = self.least_volume_ratio(&displacement) > least;
            let state = State { displacement: &displacement, load_factor: 0.0, ..search.state() };
            if safe && state.energy(self.body).is_finite() {
                search.at.displacement = displacement;
                let at = search.at.pressure.iter_mut().zip(pressures);
                at.for_each(|(p, step)| *p += length * step);
                return Some(length);
            }
            length *= 0.5;
        }
        None
    }

    /// Whether a cell becomes nearly flat along a step from the assembled state. A step through flat may end with J >
    /// 0: a bar stretched in one step may come out turned inside out.
    pub(crate) fn passes_flat(&self, theta: &[f64], direction: &[f64], length: f64) -> bool {
        let passes = |point: usize| {
            let step = self.body.displacement_gradient(point, direction);
            flattens(&self.assembly.points[point].h, &step, length)
        };
        at_points(self.body.volumes.len(), passes).contains(&true)
            && minds_turned_cells(self.body, theta)
    }

    /// Largest rotation \[rad\] of a cell along `direction`, to first order.
    fn largest_rotation(&self, direction: &[f64]) -> f64 {
        let rotation = |point| {
            let h = self.body.displacement_gradient(point, direction);
            let twice = [h[0][1] - h[1][0], h[0][2] - h[2][0], h[1][2] - h[2][1]];
            0.5 * twice.iter().map(|w| w * w).sum::<f64>().sqrt()
        };
        at_points(self.body.volumes.len(), rotation).into_iter().fold(0.0, f64::max)
    }
}

/// Whether a cell becomes nearly flat between `h` and `h + length·step`.
pub(crate) fn flattens(h: &Mat3<f64>, step: &Mat3<f64>, length: f64) -> bool {
    let flat = || {
        let [start, least, end] = volume_ratios_along(h, step, length);
        least <= FLAT * start.min(end)
    };
    !is_short(h, step, length) && flat()
}

/// Whether the law forbids inverted cells; linear elasticity does not.
pub(crate) fn minds_turned_cells(body: &Body, theta: &[f64]) -> bool {
    let parameters = body.law_parameters(theta);
    let mirrored = Mat3::from_fn(|i, j| if (i, j) == (0, 0) { -2.0 } else { 0.0 });
    body.material.energy(0, parameters, &mirrored, None) == f64::INFINITY
}

//! Formulas over series, written down step by step.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Series;

/// One step of a [`Recording`]; operands are the numbers of earlier steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The input with this number.
    Input(usize),
    /// A number.
    Number(f64),
    /// `a + b`
    Add(usize, usize),
    /// `a − b`
    Subtract(usize, usize),
    /// `a · b`
    Multiply(usize, usize),
    /// `scale · a + shift`
    Affine {
        /// a
        of: usize,
        /// Factor.
        scale: f64,
        /// Summand.
        shift: f64,
    },
    /// A real power of `a`.
    Power(usize, f64),
    /// Exponential.
    Exp(usize),
    /// Natural logarithm.
    Ln(usize),
    /// Sine.
    Sin(usize),
    /// Cosine.
    Cos(usize),
    /// Hyperbolic tangent.
    Tanh(usize),
}

/// What a formula over series does, so that it can be evaluated for many points at once.
///
/// ```
/// use sinew_num::{Recording, Step};
///
/// let product = Recording::of(&[2.0, 3.0], |inputs| &inputs[0] * &inputs[1] + 1.0);
/// let steps = product.map(|recording| recording.steps);
/// let sum = Step::Affine { of: 2, scale: 1.0, shift: 1.0 };
/// assert_eq!(steps, Some(vec![Step::Input(0), Step::Input(1), Step::Multiply(0, 1), sum]));
///
/// // What depends on values beyond arithmetic cannot be written down.
/// let branch = Recording::of(&[2.0], |inputs| match inputs[0].value() {
///     value if value > 0.0 => inputs[0].clone(),
///     _ => inputs[0].constant(0.0),
/// });
/// assert!(branch.is_none());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// In the order in which they were taken; the inputs come first.
    pub steps: Vec<Step>,
    /// Which step the result is.
    pub result: usize,
}

impl Recording {
    /// Of `formula`, called once with plain numbers.
    ///
    /// None if it asks for values or derivatives on its way, takes functions that have no
    /// [`Step`], or brings along series that vary: then another point may take another way.
    pub fn of(inputs: &[f64], formula: impl FnOnce(&[Series]) -> Series) -> Option<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(1);
        if is_active() {
            return None;
        }
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let escapes = ESCAPES.load(Ordering::Relaxed);
        let plain: Vec<Series> = inputs
            .iter()
            .enumerate()
            .map(|(step, value)| {
                let [mut input] = Series::plain([*value]);
                input.place = Place { recording: number, step };
                input
            })
            .collect();
        let guard = Guard::start(Steps {
            number,
            steps: (0..inputs.len()).map(Step::Input).collect(),
            complete: true,
        });
        let result = formula(&plain);
        let result = note(|steps| steps.operand(&result)).flatten();
        let recorded = guard.finish()?;
        let escaped = ESCAPES.load(Ordering::Relaxed) != escapes
            && ESCAPED.lock().map_or(true, |mut escaped| escaped.remove(&number));
        let complete = recorded.complete && !escaped;
        let result = result.filter(|_| complete)?;
        Some(Self { steps: recorded.steps, result })
    }
}

/// How often series of a recording were used outside it, by another thread or later, and which
/// recordings these were of.
static ESCAPES: AtomicU64 = AtomicU64::new(0);
static ESCAPED: Mutex<BTreeSet<u64>> = Mutex::new(BTreeSet::new());

/// Where a series stands in a recording; recordings count from one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    recording: u64,
    step: usize,
}

/// A recording under way.
pub(super) struct Steps {
    number: u64,
    steps: Vec<Step>,
    complete: bool,
}

impl Steps {
    /// The step that `series` is; what comes from outside must be a number.
    fn operand(&mut self, series: &Series) -> Option<usize> {
        let Place { recording, step } = series.place;
        if recording == self.number {
            return Some(step);
        }
        if recording == 0 && series.coefficients.len() == 1 {
            return Some(self.push(Step::Number(series.coefficients[0])));
        }
        self.complete = false;
        series.escape();
        None
    }

    fn push(&mut self, step: Step) -> usize {
        self.steps.push(step);
        self.steps.len() - 1
    }
}

thread_local! {
    static ACTIVE: Cell<bool> = const { Cell::new(false) };
    static CURRENT: RefCell<Option<Steps>> = const { RefCell::new(None) };
}

/// Ends a recording even where the formula panics.
struct Guard;

impl Guard {
    fn start(steps: Steps) -> Self {
        CURRENT.set(Some(steps));
        ACTIVE.set(true);
        Self
    }

    fn finish(self) -> Option<Steps> {
        CURRENT.take()
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        ACTIVE.set(false);
        CURRENT.take();
    }
}

#[inline]
fn is_active() -> bool {
    ACTIVE.get()
}

#[cold]
fn note<T>(what: impl FnOnce(&mut Steps) -> T) -> Option<T> {
    CURRENT.with_borrow_mut(|current| current.as_mut().map(what))
}

impl Series {
    /// Notes a use outside the recording that it belongs to, if it belongs to one.
    fn escape(&self) {
        if self.place.recording != 0 {
            if let Ok(mut escaped) = ESCAPED.lock() {
                escaped.insert(self.place.recording);
            }
            ESCAPES.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Notes that a formula looked at its value, or did what no step says.
    #[inline]
    pub(super) fn observed(&self) {
        match is_active() {
            true => {
                note(|steps| {
                    steps.complete = false;
                    if self.place.recording != steps.number {
                        self.escape();
                    }
                });
            }
            false => self.escape(),
        }
    }

    /// Itself as the outcome of a step, if a recording is under way.
    #[inline]
    pub(super) fn noted<const N: usize>(
        mut self,
        operands: [&Series; N],
        step: impl FnOnce([usize; N]) -> Step,
    ) -> Self {
        self.place = Place::default();
        if is_active() {
            self.place = note(|steps| {
                let numbers = operands.map(|operand| steps.operand(operand));
                match numbers.iter().all(Option::is_some) {
                    true => {
                        let step = steps.push(step(numbers.map(Option::unwrap_or_default)));
                        Place { recording: steps.number, step }
                    }
                    false => Place::default(),
                }
            })
            .unwrap_or_default();
        } else {
            operands.into_iter().for_each(Self::escape);
        }
        self
    }
}

//! Formulas compiled to products of Taylor coefficients, evaluated for many pairs at once.
//!
//! Every function in a formula obeys a differential equation by which its Taylor coefficients
//! follow from earlier ones (Griewank & Walther 2008, §13.2): of e = exp f, say,
//! kᵢ e_k = Σ_j jᵢ f_j e_{k−j} for any variable i. So a formula becomes a list of products
//! `out += factor · a · b` of coefficients, between which a few functions of values are taken. The
//! list holds only coefficients that are not zero by structure and that some derivative needs;
//! backwards it gives the gradient in all hyperparameters together.

use crate::simd::vectorised;

/// Pairs taken together: a vector register.
pub(super) const LANES: usize = 8;

/// A coefficient for each pair.
type Lane = [f64; LANES];

/// `out += factor · a · b`, by the numbers of slots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Product {
    pub out: u32,
    pub a: u32,
    pub b: u32,
    pub factor: f64,
}

/// Functions of values, with coefficients by products.
#[derive(Clone, Copy, Debug)]
pub(super) enum Function {
    Exp,
    Ln,
    Power(f64),
    /// Sine, and cosine beside it.
    Circular,
    /// Hyperbolic tangent, and 1 less its square beside it.
    Tanh,
}

/// What comes before the products of a step.
#[derive(Clone, Debug)]
pub(super) enum Head {
    Nothing,
    /// Input number `input`, of slope one where that is needed.
    Input {
        input: usize,
        slot: u32,
        slope: Option<u32>,
    },
    /// A function of the slot `of`, written to `to`, and its companion to `beside`; coefficients
    /// divided by the value go from the first to the second of each pair in `quotients`.
    Function {
        function: Function,
        of: u32,
        to: u32,
        beside: u32,
        quotients: Vec<[u32; 2]>,
    },
}

#[derive(Clone, Debug)]
pub(super) struct Phase {
    pub head: Head,
    pub forward: Vec<Product>,
    /// Products of cotangents that undo `forward`; empty where no hyperparameter is involved.
    pub backward: Vec<Product>,
    pub active: bool,
}

/// A compiled formula.
#[derive(Debug)]
pub(super) struct Program {
    pub phases: Vec<Phase>,
    /// Number of slots of values; those of cotangents follow.
    pub slots: usize,
    /// For each derivative asked for, its slot if it is not zero, and the factorials.
    pub results: Vec<(Option<u32>, f64)>,
    /// Where each input's value is.
    pub inputs: Vec<u32>,
}

/// The slot that holds one.
pub(super) const ONE: u32 = 0;

vectorised! {
    fn multiply_add(products: &[Product], slots: &mut [[f64; LANES]]) {
        for product in products {
            let (a, b) = (slots[product.a as usize], slots[product.b as usize]);
            let out = &mut slots[product.out as usize];
            for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
                *out += product.factor * a * b;
            }
        }
    }
}

impl Function {
    /// Values, and what stands beside them; none where coefficients do not follow from products.
    fn values(self, of: &Lane) -> Option<[Lane; 2]> {
        let usable = match self {
            Self::Ln => of.iter().all(|x| *x > 0.0),
            Self::Power(_) => of.iter().all(|x| *x != 0.0),
            Self::Exp | Self::Circular | Self::Tanh => true,
        };
        let both = |f: &dyn Fn(f64) -> (f64, f64)| {
            let pairs = of.map(f);
            [pairs.map(|(value, _)| value), pairs.map(|(_, beside)| beside)]
        };
        usable.then(|| match self {
            Self::Exp => both(&|x| (x.exp(), 0.0)),
            Self::Ln => both(&|x| (x.ln(), 0.0)),
            Self::Power(-1.0) => both(&|x| (x.recip(), 0.0)),
            Self::Power(power) => both(&|x| (x.powf(power), 0.0)),
            Self::Circular => both(&|x| x.sin_cos()),
            Self::Tanh => both(&|x| (x.tanh(), 1.0 - x.tanh() * x.tanh())),
        })
    }

    /// Cotangent of the argument's value from those of the outcome's values.
    fn cotangent(self, of: f64, [to, beside]: [f64; 2], [by_to, by_beside]: [f64; 2]) -> f64 {
        match self {
            Self::Exp => by_to * to,
            Self::Ln => by_to / of,
            Self::Power(power) => by_to * power * to / of,
            Self::Circular => by_to * beside - by_beside * to,
            Self::Tanh => beside * (by_to - 2.0 * to * by_beside),
        }
    }
}

/// Memory of an evaluation, used again.
#[derive(Default)]
pub(super) struct Workspace(Vec<Lane>);

impl Program {
    /// Derivatives of [`LANES`] pairs at the inputs `input(number, lane)`; afterwards
    /// [`Program::result`] and [`Program::pull_back`] tell them.
    ///
    /// False where a function has no Taylor series at a value, or none by products.
    #[must_use]
    pub fn run(&self, workspace: &mut Workspace, input: impl Fn(usize, usize) -> f64) -> bool {
        let slots = &mut workspace.0;
        slots.clear();
        slots.resize(2 * self.slots, [0.0; LANES]);
        slots[ONE as usize] = [1.0; LANES];
        for phase in &self.phases {
            match &phase.head {
                Head::Nothing => {}
                Head::Input { input: number, slot, slope } => {
                    slots[*slot as usize] = std::array::from_fn(|lane| input(*number, lane));
                    if let Some(slope) = slope {
                        slots[*slope as usize] = [1.0; LANES];
                    }
                }
                Head::Function { function, of, to, beside, quotients } => {
                    let of = slots[*of as usize];
                    let Some([value, companion]) = function.values(&of) else { return false };
                    slots[*to as usize] = value;
                    slots[*beside as usize] = companion;
                    for [from, quotient] in quotients {
                        let from = slots[*from as usize];
                        slots[*quotient as usize] = std::array::from_fn(|l| from[l] / of[l]);
                    }
                }
            }
            multiply_add(&phase.forward, slots);
        }
        true
    }

    /// Derivative number `order` of pair `lane`.
    pub fn result(&self, workspace: &Workspace, order: usize, lane: usize) -> f64 {
        let (slot, factor) = self.results[order];
        slot.map_or(0.0, |slot| factor * workspace.0[slot as usize][lane])
    }

    /// Adds to `gradient` the slopes of Σ weight(order, lane) · derivative in the hyperparameters.
    pub fn pull_back(
        &self,
        workspace: &mut Workspace,
        weight: impl Fn(usize, usize) -> f64,
        gradient: &mut [f64],
    ) {
        let slots = &mut workspace.0;
        for (order, (slot, factor)) in self.results.iter().enumerate() {
            if let Some(slot) = slot {
                let cotangent = &mut slots[*slot as usize + self.slots];
                for (lane, cotangent) in cotangent.iter_mut().enumerate() {
                    *cotangent += factor * weight(order, lane);
                }
            }
        }
        for phase in self.phases.iter().rev().filter(|phase| phase.active) {
            multiply_add(&phase.backward, slots);
            if let Head::Function { function, of, to, beside, quotients } = &phase.head {
                self.pull_function(slots, *function, [*of, *to, *beside], quotients);
            }
        }
        for (slope, input) in gradient.iter_mut().zip(&self.inputs) {
            *slope += slots[*input as usize + self.slots].iter().sum::<f64>();
        }
    }

    fn pull_function(
        &self,
        slots: &mut [Lane],
        function: Function,
        [of, to, beside]: [u32; 3],
        quotients: &[[u32; 2]],
    ) {
        let cotangent = |slot: u32| slot as usize + self.slots;
        for lane in 0..LANES {
            let value = |slot: u32| slots[slot as usize][lane];
            let by = |slot: u32| slots[cotangent(slot)][lane];
            let x = value(of);
            let mut slope = function.cotangent(x, [value(to), value(beside)], [by(to), by(beside)]);
            for [from, quotient] in quotients {
                let share = slots[cotangent(*quotient)][lane] / x;
                slope -= share * slots[*quotient as usize][lane];
                slots[cotangent(*from)][lane] += share;
            }
            slots[cotangent(of)][lane] += slope;
        }
    }
}

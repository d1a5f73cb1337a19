//! From a recorded formula to products of Taylor coefficients.

use sinew_num::{Recording, Step};

use super::indices::{Indices, Powers};
use super::program::{Function, Head, ONE, Phase, Product, Program};

/// Coefficients of one step: where each power's is, if it is not zero.
#[derive(Clone, Debug)]
struct Node {
    slots: Vec<Option<u32>>,
    active: bool,
}

impl Node {
    /// Powers with coefficients, and where these are.
    fn support(&self) -> impl Iterator<Item = (usize, u32)> {
        self.slots.iter().enumerate().filter_map(|(index, slot)| Some((index, (*slot)?)))
    }

    /// The same without the value.
    fn increments(&self) -> impl Iterator<Item = (usize, u32)> {
        self.support().skip(1)
    }

    fn value(&self) -> u32 {
        self.slots[0].expect("every step has a value")
    }
}

struct Compiler<'a> {
    indices: &'a Indices,
    /// Whether each slot depends on hyperparameters.
    active: Vec<bool>,
    products: Vec<Product>,
}

impl Compiler<'_> {
    fn slot(&mut self, active: bool) -> u32 {
        self.active.push(active);
        u32::try_from(self.active.len() - 1).expect("formulas are short")
    }

    /// A node with a value and nothing else yet.
    fn node(&mut self, active: bool) -> Node {
        let mut slots = vec![None; self.indices.count()];
        slots[0] = Some(self.slot(active));
        Node { slots, active }
    }

    /// Adds `factor · a · b` to the coefficient of power `index`.
    fn add(&mut self, node: &mut Node, index: usize, [a, b]: [u32; 2], factor: f64) {
        if factor == 0.0 {
            return;
        }
        let out = match node.slots[index] {
            Some(slot) => slot,
            None => *node.slots[index].insert(self.slot(node.active)),
        };
        self.products.push(Product { out, a, b, factor });
    }

    fn linear(&mut self, terms: &[(&Node, f64)], shift: f64) -> Node {
        let mut node = self.node(terms.iter().any(|(term, _)| term.active));
        for (term, factor) in terms {
            for (index, slot) in term.support() {
                self.add(&mut node, index, [slot, ONE], *factor);
            }
        }
        self.add(&mut node, 0, [ONE; 2], shift);
        node
    }

    fn multiply(&mut self, left: &Node, right: &Node) -> Node {
        let mut node = self.node(left.active || right.active);
        for (i, a) in left.support() {
            for (j, b) in right.support() {
                if let Some(sum) = self.indices.sum(i, j) {
                    self.add(&mut node, sum, [a, b], 1.0);
                }
            }
        }
        node
    }

    /// Adds Σ_j weight(jᵢ / kᵢ) f_j g_{k−j} over the increments of f to the coefficient of power k,
    /// for the first variable i that k has.
    fn convolve(
        &mut self,
        node: &mut Node,
        k: usize,
        increments: &[(usize, u32)],
        other: &Node,
        weight: impl Fn(f64) -> f64,
    ) {
        let powers = *self.indices.powers(k);
        let variable = powers.iter().position(|n| *n > 0).expect("k is an increment");
        for (j, f) in increments {
            let Some(rest) = self.indices.difference(k, *j) else { continue };
            let Some(g) = other.slots[rest] else { continue };
            let share = self.indices.powers(*j)[variable];
            let share = f64::from(share) / f64::from(powers[variable]);
            self.add(node, k, [*f, g], weight(share));
        }
    }

    fn function(&mut self, function: Function, of: &Node) -> (Head, [Node; 2]) {
        let mut node = self.node(of.active);
        let mut beside = self.node(of.active);
        let mut increments: Vec<(usize, u32)> = of.increments().collect();
        let mut quotients = Vec::new();
        if let Function::Ln | Function::Power(_) = function {
            for (_, slot) in &mut increments {
                let quotient = self.slot(of.active);
                quotients.push([*slot, quotient]);
                *slot = quotient;
            }
        }
        for k in 1..self.indices.count() {
            match function {
                Function::Exp => {
                    let so_far = node.clone();
                    self.convolve(&mut node, k, &increments, &so_far, |share| share);
                }
                Function::Power(power) => {
                    let so_far = node.clone();
                    let weight = |share: f64| power * share - (1.0 - share);
                    self.convolve(&mut node, k, &increments, &so_far, weight);
                }
                Function::Ln => {
                    // The term j = k is not of the sum.
                    let mut so_far = node.clone();
                    so_far.slots[0] = None;
                    if let Some((_, own)) = increments.iter().find(|(j, _)| *j == k) {
                        self.add(&mut node, k, [*own, ONE], 1.0);
                    }
                    self.convolve(&mut node, k, &increments, &so_far, |share| share - 1.0);
                }
                Function::Circular => {
                    self.convolve(&mut node, k, &increments, &beside, |share| share);
                    self.convolve(&mut beside, k, &increments, &node, |share| -share);
                }
                Function::Tanh => {
                    self.convolve(&mut node, k, &increments, &beside, |share| share);
                    let tanh: Vec<(usize, u32)> = node.support().collect();
                    for (i, a) in &tanh {
                        let rest = self.indices.difference(k, *i);
                        if let Some(b) = rest.and_then(|rest| node.slots[rest]) {
                            self.add(&mut beside, k, [*a, b], -1.0);
                        }
                    }
                }
            }
        }
        let (of, to, companion) = (of.value(), node.value(), beside.value());
        let head = Head::Function { function, of, to, beside: companion, quotients };
        (head, [node, beside])
    }

    fn input(&mut self, input: usize, hyperparameters: usize) -> (Head, Node) {
        let mut node = self.node(input < hyperparameters);
        let mut slope = None;
        if let Some(variable) = input.checked_sub(hyperparameters) {
            let mut unit = Powers::default();
            unit[variable] = 1;
            if let Some(index) = self.indices.position(&unit) {
                slope = Some(self.slot(false));
                node.slots[index] = slope;
            }
        }
        (Head::Input { input, slot: node.value(), slope }, node)
    }

    /// One of the two nodes of a function.
    fn outcome(&mut self, function: Function, of: &Node, which: usize, head: &mut Head) -> Node {
        let (own, nodes) = self.function(function, of);
        *head = own;
        let [node, beside] = nodes;
        if which == 0 { node } else { beside }
    }
}

/// Whether each step leads to the result.
fn needed(recording: &Recording) -> Vec<bool> {
    let mut needed = vec![false; recording.steps.len()];
    needed[recording.result] = true;
    for (number, step) in recording.steps.iter().enumerate().rev() {
        if !needed[number] {
            continue;
        }
        match *step {
            Step::Input(_) | Step::Number(_) => {}
            Step::Add(a, b) | Step::Subtract(a, b) | Step::Multiply(a, b) => {
                needed[a] = true;
                needed[b] = true;
            }
            Step::Affine { of, .. }
            | Step::Power(of, _)
            | Step::Exp(of)
            | Step::Ln(of)
            | Step::Sin(of)
            | Step::Cos(of)
            | Step::Tanh(of) => needed[of] = true,
        }
    }
    needed
}

/// Whole powers up to this one are products, which also hold at zero.
const MOST_FACTORS: f64 = 8.0;

impl Program {
    /// Of a formula whose first `hyperparameters` inputs are numbers and whose other ones are
    /// variables, for the derivatives `orders` in these.
    pub fn new(recording: &Recording, hyperparameters: usize, orders: &[Powers]) -> Self {
        let indices = Indices::below(orders);
        // The slot ONE.
        let mut compiler =
            Compiler { indices: &indices, active: vec![false], products: Vec::new() };
        let needed = needed(recording);
        let mut nodes: Vec<Option<Node>> = Vec::new();
        let mut phases = Vec::new();
        let mut inputs = Vec::new();
        for (step, needed) in recording.steps.iter().zip(needed) {
            if !needed && !matches!(step, Step::Input(_)) {
                nodes.push(None);
                continue;
            }
            let at = |number: usize| nodes[number].as_ref().expect("a step that is needed");
            let mut head = Head::Nothing;
            let node = match *step {
                Step::Input(input) => {
                    let (own, node) = compiler.input(input, hyperparameters);
                    inputs.push(node.value());
                    head = own;
                    node
                }
                Step::Number(value) => compiler.linear(&[], value),
                Step::Add(a, b) => compiler.linear(&[(at(a), 1.0), (at(b), 1.0)], 0.0),
                Step::Subtract(a, b) => compiler.linear(&[(at(a), 1.0), (at(b), -1.0)], 0.0),
                Step::Multiply(a, b) => compiler.multiply(at(a), at(b)),
                Step::Affine { of, scale, shift } => compiler.linear(&[(at(of), scale)], shift),
                Step::Power(of, power)
                    if power.fract() == 0.0 && (1.0..=MOST_FACTORS).contains(&power) =>
                {
                    (1..power as usize)
                        .fold(at(of).clone(), |product, _| compiler.multiply(&product, at(of)))
                }
                Step::Power(of, power) => {
                    compiler.outcome(Function::Power(power), at(of), 0, &mut head)
                }
                Step::Exp(of) => compiler.outcome(Function::Exp, at(of), 0, &mut head),
                Step::Ln(of) => compiler.outcome(Function::Ln, at(of), 0, &mut head),
                Step::Sin(of) => compiler.outcome(Function::Circular, at(of), 0, &mut head),
                Step::Cos(of) => compiler.outcome(Function::Circular, at(of), 1, &mut head),
                Step::Tanh(of) => compiler.outcome(Function::Tanh, at(of), 0, &mut head),
            };
            let forward = std::mem::take(&mut compiler.products);
            phases.push(Phase { head, forward, backward: Vec::new(), active: node.active });
            nodes.push(Some(node));
        }
        let active = compiler.active;
        phases.iter_mut().for_each(|phase| phase.reverse(&active));
        let result = nodes[recording.result].as_ref().expect("the result is needed");
        let results = orders.iter().map(|order| {
            let slot = indices.position(order).and_then(|index| result.slots[index]);
            (slot, order.iter().flat_map(|n| 1..=*n).map(f64::from).product())
        });
        Self { results: results.collect(), phases, slots: active.len(), inputs }
    }
}

impl Phase {
    /// The products of cotangents, which lie `slots` behind their values.
    fn reverse(&mut self, active: &[bool]) {
        let cotangent = |slot: u32| slot + active.len() as u32;
        for Product { out, a, b, factor } in self.forward.iter().rev().copied() {
            for (to, other) in [(a, b), (b, a)] {
                if active[out as usize] && active[to as usize] {
                    let (out, a) = (cotangent(to), cotangent(out));
                    self.backward.push(Product { out, a, b: other, factor });
                }
            }
        }
    }
}

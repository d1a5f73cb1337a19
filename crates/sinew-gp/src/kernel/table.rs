//! Tables of derivatives of any formula, by Taylor series in the coordinates of a pair.
//!
//! A formula is recorded once per call, compiled once for the derivatives asked for (see
//! [`super::program`]), and evaluated for several pairs at once. Formulas that look at values on
//! their way are evaluated over series, pair by pair.

use std::cell::RefCell;

use sinew_num::{MOST_VARIABLES, Recording, Series};

use super::indices::Powers;
use super::program::{LANES, Program, Workspace};
use super::{Kernel, Orders, Pairs};

/// What a program was compiled from.
#[derive(PartialEq)]
struct Source {
    recording: Recording,
    hyperparameters: usize,
    orders: Vec<Powers>,
}

/// Programs of this thread, last used first, and the memory that they work in.
#[derive(Default)]
struct Compiled {
    programs: Vec<(Source, Program)>,
    workspace: Workspace,
}

/// Programs kept: those of a model with a few parts and operators.
const MOST_PROGRAMS: usize = 32;

thread_local! {
    static COMPILED: RefCell<Compiled> = RefCell::default();
}

impl Compiled {
    fn find(&mut self, source: Source) -> (&Program, &mut Workspace) {
        match self.programs.iter().position(|(known, _)| *known == source) {
            Some(position) => self.programs[..=position].rotate_right(1),
            None => {
                let Source { recording, hyperparameters, orders } = &source;
                let program = Program::new(recording, *hyperparameters, orders);
                self.programs.truncate(MOST_PROGRAMS - 1);
                self.programs.insert(0, (source, program));
            }
        }
        (&self.programs[0].1, &mut self.workspace)
    }
}

/// A kernel's formula between pairs.
struct Formula<'a, K: ?Sized, const D: usize> {
    kernel: &'a K,
    hyperparameters: &'a [f64],
    pairs: &'a Pairs<'a, D>,
    orders: &'a [Orders<D>],
}

impl<K: Kernel<D> + ?Sized, const D: usize> Formula<'_, K, D> {
    /// Input of the program: the hyperparameters, x and x′, one after the other.
    fn input(&self, number: usize, lane: usize) -> f64 {
        let count = self.hyperparameters.len();
        match number.checked_sub(count) {
            None => self.hyperparameters[number],
            Some(axis) if axis < D => self.pairs.first[axis][lane],
            Some(axis) => self.pairs.second[axis - D],
        }
    }

    fn source(&self) -> Option<Source> {
        let hyperparameters = self.hyperparameters.len();
        // More coordinates than a series may have variables: no derivatives either.
        if 2 * D > MOST_VARIABLES || self.pairs.count() == 0 {
            return None;
        }
        let inputs: Vec<f64> =
            (0..hyperparameters + 2 * D).map(|number| self.input(number, 0)).collect();
        let recording = Recording::of(&inputs, |inputs| {
            let (hyperparameters, coordinates) = inputs.split_at(hyperparameters);
            let x = std::array::from_fn(|d| coordinates[d].clone());
            let y = std::array::from_fn(|d| coordinates[D + d].clone());
            self.kernel.formula(hyperparameters, &x, &y)
        })?;
        let powers = |order: &Orders<D>| {
            let mut powers = Powers::default();
            for (power, n) in powers.iter_mut().zip(order.first.iter().chain(&order.second)) {
                *power = u8::try_from(*n).ok()?;
            }
            Some(powers)
        };
        let orders = self.orders.iter().map(powers).collect::<Option<_>>()?;
        Some(Source { recording, hyperparameters, orders })
    }

    /// Runs the program for all pairs, and hands it over after each group of lanes, with the first
    /// pair of the group; false where the formula must go over series.
    fn run(&self, mut visit: impl FnMut(&Program, &mut Workspace, usize)) -> bool {
        let Some(source) = self.source() else { return false };
        let last = self.pairs.count() - 1;
        COMPILED.with_borrow_mut(|compiled| {
            let (program, workspace) = compiled.find(source);
            (0..=last).step_by(LANES).all(|start| {
                // Lanes beyond the last pair repeat it.
                let input =
                    |number: usize, lane: usize| self.input(number, (start + lane).min(last));
                let defined = program.run(workspace, input);
                if defined {
                    visit(program, workspace, start);
                }
                defined
            })
        })
    }
}

/// [`Kernel::derivatives`] from the formula.
pub(super) fn from_formula<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    hyperparameters: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    table: &mut [f64],
) {
    let count = pairs.count();
    let formula = Formula { kernel, hyperparameters, pairs, orders };
    let complete = formula.run(|program, workspace, start| {
        for order in 0..orders.len() {
            let row = &mut table[order * count..(order + 1) * count];
            for (lane, entry) in row[start..].iter_mut().take(LANES).enumerate() {
                *entry = program.result(workspace, order, lane);
            }
        }
    });
    if !complete {
        by_series(kernel, hyperparameters, pairs, orders, table);
    }
}

/// [`Kernel::pull_back`] from the formula.
pub(super) fn pull_back_from_formula<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    hyperparameters: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    weights: &[f64],
    gradient: &mut [f64],
) {
    let count = pairs.count();
    let formula = Formula { kernel, hyperparameters, pairs, orders };
    let mut slopes = vec![0.0; gradient.len()];
    let complete = formula.run(|program, workspace, start| {
        let weight = |order: usize, lane: usize| match start + lane {
            pair if pair < count => weights[order * count + pair],
            _ => 0.0,
        };
        program.pull_back(workspace, weight, &mut slopes);
    });
    if complete {
        for ((sum, slope), value) in gradient.iter_mut().zip(&slopes).zip(hyperparameters) {
            *sum += slope * value;
        }
    } else {
        pull_back_by_series(kernel, hyperparameters, pairs, orders, weights, gradient);
    }
}

/// Highest order asked for in each of the 2 D coordinates of a pair.
fn degrees<const D: usize>(orders: &[Orders<D>]) -> Vec<usize> {
    let most = |pick: &dyn Fn(&Orders<D>) -> usize| orders.iter().map(pick).max().unwrap_or(0);
    let first = (0..D).map(|d| most(&|o| o.first[d]));
    let second = (0..D).map(|d| most(&|o| o.second[d]));
    first.chain(second).collect()
}

/// Coordinates of a pair as variables, followed by further ones of degree one.
fn variables<const D: usize>(
    x: [f64; D],
    y: [f64; D],
    degrees: &[usize],
) -> ([Series; D], [Series; D]) {
    (
        std::array::from_fn(|d| Series::variable(x[d], d, degrees)),
        std::array::from_fn(|d| Series::variable(y[d], D + d, degrees)),
    )
}

fn plain(value: f64) -> Series {
    let [plain] = Series::plain([value]);
    plain
}

/// [`Kernel::derivatives`] from the formula over series, pair by pair.
pub(super) fn by_series<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    hyperparameters: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    table: &mut [f64],
) {
    let degrees = degrees(orders);
    let count = pairs.count();
    let constants: Vec<Series> = hyperparameters.iter().map(|h| plain(*h)).collect();
    for lane in 0..count {
        let (x, y) = variables(pairs.point(lane), pairs.second, &degrees);
        let value = kernel.formula(&constants, &x, &y) + x[0].constant(0.0);
        for (entry, order) in orders.iter().enumerate() {
            let order = [order.first.as_slice(), order.second.as_slice()].concat();
            table[entry * count + lane] = value.derivative(&order);
        }
    }
}

/// [`Kernel::pull_back`] from the formula over series, one hyperparameter at a time.
fn pull_back_by_series<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    hyperparameters: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    weights: &[f64],
    gradient: &mut [f64],
) {
    let mut degrees = degrees(orders);
    degrees.push(1);
    let count = pairs.count();
    for lane in 0..count {
        let (x, y) = variables(pairs.point(lane), pairs.second, &degrees);
        for (number, slope) in gradient.iter_mut().enumerate() {
            let numbers: Vec<Series> = hyperparameters
                .iter()
                .enumerate()
                .map(|(other, value)| match other == number {
                    true => Series::variable(*value, 2 * D, &degrees),
                    false => plain(*value),
                })
                .collect();
            let value = kernel.formula(&numbers, &x, &y) + x[0].constant(0.0);
            for (entry, order) in orders.iter().enumerate() {
                let order = [order.first.as_slice(), order.second.as_slice(), &[1]].concat();
                *slope += weights[entry * count + lane]
                    * value.derivative(&order)
                    * hyperparameters[number];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{
        Hyperparameter, Linear, Measure, Periodic, Product, SquaredExponential, Sum,
    };

    /// Every step that a recording knows.
    #[derive(Debug)]
    struct Everything;

    impl Kernel<2> for Everything {
        fn name(&self) -> String {
            "everything".into()
        }
        fn hyperparameters(&self) -> Vec<Hyperparameter> {
            let number = Hyperparameter {
                name: "number",
                measure: Measure::Number { lower: 0.1, upper: 9.0 },
            };
            vec![number.clone(), number]
        }
        fn on_axes(&self, _: &[usize]) -> Box<dyn Kernel<2>> {
            Box::new(Self)
        }
        fn formula(&self, h: &[Series], x: &[Series; 2], y: &[Series; 2]) -> Series {
            let phase = (&x[0] * &h[0] - &y[1]) * 2.0;
            let waves = phase.sin() * (&x[1] + &y[0]).cos() + (-&phase).tanh() / 3.0;
            let grown = ((&x[0] - &y[0]).squared() / &h[1] + 1.0).ln() * (&x[1] * &y[1]).exp();
            let roots = (&x[0] + &y[1] * &h[1] + 2.0).sqrt() - 1.0 / (&x[1] + &h[0]);
            let powers = (&x[0] - &y[0]).powf(2.0) * (&y[0] + &h[1]).powf(-1.5) + x[0].powi(3);
            waves + grown * 0.5 + roots - powers + x[0].constant(0.3) * &h[0]
        }
    }

    /// A formula that looks at a value.
    #[derive(Debug)]
    struct Branching;

    impl Kernel<2> for Branching {
        fn name(&self) -> String {
            "branching".into()
        }
        fn hyperparameters(&self) -> Vec<Hyperparameter> {
            Everything.hyperparameters()
        }
        fn on_axes(&self, _: &[usize]) -> Box<dyn Kernel<2>> {
            Box::new(Self)
        }
        fn formula(&self, h: &[Series], x: &[Series; 2], y: &[Series; 2]) -> Series {
            let far = x[0].value() > y[0].value() + 0.2;
            Everything.formula(h, x, y) * if far { 1.0 } else { 2.0 }
        }
    }

    /// A root whose argument is zero at one of the pairs' points.
    #[derive(Debug)]
    struct Rooted;

    impl Kernel<2> for Rooted {
        fn name(&self) -> String {
            "rooted".into()
        }
        fn hyperparameters(&self) -> Vec<Hyperparameter> {
            Everything.hyperparameters()
        }
        fn on_axes(&self, _: &[usize]) -> Box<dyn Kernel<2>> {
            Box::new(Self)
        }
        fn formula(&self, h: &[Series], x: &[Series; 2], y: &[Series; 2]) -> Series {
            (&x[0] * &h[0]).powf(4.5) * &y[1] * &h[1]
        }
    }

    fn all_orders(first: [usize; 2], second: [usize; 2]) -> Vec<Orders<2>> {
        let below = |[m, n]: [usize; 2]| (0..=m).flat_map(move |i| (0..=n).map(move |j| [i, j]));
        let pairs = below(first).flat_map(|first| below(second).map(move |second| (first, second)));
        pairs.map(|(first, second)| Orders { first, second }).collect()
    }

    /// Largest difference of table and gradient from series, in units of a derivative's largest value.
    fn difference(kernel: &dyn Kernel<2>, orders: &[Orders<2>]) -> [f64; 2] {
        // Eleven pairs: one full group of lanes, and one that is not.
        let axes: [Vec<f64>; 2] =
            [0.0, 0.7].map(|phase| (0..11).map(|k| (f64::from(k) * 0.37 + phase) % 1.0).collect());
        let pairs = Pairs { first: axes.each_ref().map(Vec::as_slice), second: [0.0, 0.35] };
        let values: Vec<f64> =
            (0..kernel.hyperparameters().len()).map(|k| 0.8 + 0.3 * k as f64).collect();
        let size = orders.len() * pairs.count();
        let [mut table, mut expected] = [vec![0.0; size], vec![0.0; size]];
        from_formula(kernel, &values, &pairs, orders, &mut table);
        by_series(kernel, &values, &pairs, orders, &mut expected);
        let weights: Vec<f64> = (0..size).map(|k| ((k * 7 + 3) % 11) as f64 / 11.0 - 0.4).collect();
        let [mut gradient, mut slopes] = [vec![0.5; values.len()], vec![0.5; values.len()]];
        pull_back_from_formula(kernel, &values, &pairs, orders, &weights, &mut gradient);
        pull_back_by_series(kernel, &values, &pairs, orders, &weights, &mut slopes);
        let apart = |found: &[f64], expected: &[f64]| {
            let scale = expected.iter().fold(1e-2_f64, |most, e| most.max(e.abs()));
            let apart = std::iter::zip(found, expected).map(|(f, e)| (f - e).abs() / scale);
            apart.fold(0.0, f64::max)
        };
        let rows = std::iter::zip(table.chunks(pairs.count()), expected.chunks(pairs.count()));
        let tables = rows.map(|(found, expected)| apart(found, expected)).fold(0.0, f64::max);
        [tables, apart(&gradient, &slopes)]
    }

    #[test]
    fn programs_equal_series() {
        let periodic = Sum::new(Linear::new(), Periodic::new(1, 0.9).unwrap());
        let product = Product::new(Linear::new(), SquaredExponential::new());
        let kernels: [&dyn Kernel<2>; 6] =
            [&Everything, &Branching, &Rooted, &periodic, &product, &Linear::new()];
        let some = vec![
            Orders { first: [2, 0], second: [0, 1] },
            Orders { first: [0, 1], second: [2, 0] },
            Orders { first: [1, 1], second: [0, 0] },
        ];
        let sets = [
            all_orders([0; 2], [0; 2]),
            some,
            all_orders([2, 1], [1, 2]),
            all_orders([3, 0], [0, 2]),
            all_orders([4, 0], [4, 0]),
        ];
        for kernel in kernels {
            for orders in &sets {
                let [table, gradient] = difference(kernel, orders);
                println!("{}, {} orders: {table:.0e} {gradient:.0e}", kernel.name(), orders.len());
                // Rounding of some hundred terms, summed in another order.
                assert!(table < 1e-13 && gradient < 1e-13, "{}: {table} {gradient}", kernel.name());
            }
        }
    }

    #[test]
    fn programs_are_found_again() {
        COMPILED.with_borrow_mut(|compiled| compiled.programs.clear());
        let count = || COMPILED.with_borrow(|compiled| compiled.programs.len());
        for orders in [[2, 1], [1, 1], [2, 1], [1, 1]] {
            difference(&Everything, &all_orders(orders, [0, 0]));
        }
        assert_eq!(count(), 2);
        for period in 1..100 {
            difference(&Periodic::new(0, f64::from(period)).unwrap(), &all_orders([1, 0], [0, 0]));
        }
        assert_eq!(count(), MOST_PROGRAMS);
    }
}

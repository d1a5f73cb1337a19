//! Answers at many parameter sets: predictions and Newton steps that contract, a regression of these answers where they do not, the solver
//! for the rest.

use crate::answer::{Answer, MOST_STEPS, confirmed, converged, is_far};
use crate::parameters::extrapolation;
use crate::plan::{Centre, FEW, Method, Plan};
use crate::progress::{Counter, Observer};
use crate::sampling::share_of;
use crate::{Body, Emulator, Error, PodRegression, Result};
use rayon::prelude::*;
use sinew_fem::{CHAIN, Options, Solver, neighbours, sweep};
use std::ops::ControlFlow;
use std::time::Instant;

/// Answers between two signs of progress: some chains of neighbours that a sweep solves.
const AT_ONCE: usize = 100;
/// Answers that a regression is made of: its time grows with their third power.
const LEARNED: usize = 50;
/// Open sets below which the solver answers sooner than a regression is fitted.
const FEWEST_OPEN: usize = 10;
/// Predictions of which a smaller part contracts are given up: those that do not cost some Newton steps, as a solve does.
const WORTH_IT: f64 = 0.5;

/// Answers to all parameter sets, with the plan that they were made by.
#[derive(Debug)]
pub struct Answers {
    /// Expected costs.
    pub plan: Plan,
    /// Answers in the order of the parameter sets, or why there is none.
    pub answers: Vec<Result<Answer>>,
    /// Wall time of plan, preparation and answers \[s\].
    pub seconds: f64,
}

impl Answers {
    /// Displacements of a body at each of `thetas` to a relative `accuracy`, by the method that costs least; every answer is checked.
    ///
    /// An `emulator` of the body is one of the methods, and may give the start of the solve that an expansion is about: that of
    /// [`FrozenStiffness::on`](crate::FrozenStiffness::on) answers for a body that nothing was solved or trained on.
    ///
    /// ```
    /// # use sinew_emulate::{Answers, Design};
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// # let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    /// #     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    /// #     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    /// #     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    /// #     .support(Support::clamped("x_min"))
    /// #     .lower()?;
    /// let thetas = Design::LatinHypercube.sample(&beam.parameters, 30, 1)?;
    /// let found = Answers::to(&beam, &thetas, 1e-3, None, &mut ())?;
    /// assert!(found.answers.iter().flatten().filter(|answer| answer.is_within(1e-3)).count() == 30);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Plan::new`], a body that cannot be solved for any θ, an observer that breaks. Sets without an answer are no error.
    pub fn to<'b>(
        body: &'b Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        emulator: Option<&Emulator<'b>>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let start = Instant::now();
        let (plan, centre) = Plan::quick(body, thetas, accuracy, emulator)?;
        let expansion = match (plan.method(), centre) {
            (Method::Expansion, Some(Centre { solver, displacement })) => {
                Some(Emulator::series_about(solver, body, &displacement, 1)?)
            }
            _ => None,
        };
        let emulator = match plan.method() {
            Method::Emulator => emulator,
            _ => expansion.as_ref(),
        };
        let answers = thetas.iter().map(|_| None).collect();
        let mut found = Found { body, thetas, accuracy, answers };
        let mut counter = Counter::new(observer, "answer", 0, thetas.len());
        if let Some(emulator) = emulator {
            let predict =
                |theta: &Vec<f64>| Ok(emulator.predict(std::slice::from_ref(theta))?.displacement);
            found.confirm(emulator, (plan.method(), &predict), &mut counter)?;
            found.learn(emulator, &mut counter)?;
            if found.open().len() > 2 * AT_ONCE {
                found.solve(AT_ONCE, &mut counter)?;
                found.learn(emulator, &mut counter)?;
            }
        }
        found.solve(usize::MAX, &mut counter)?;
        let none = || Err(Error::Unanswered);
        let answers = found.answers.into_iter().map(|answer| answer.unwrap_or_else(none)).collect();
        Ok(Self { plan, answers, seconds: start.elapsed().as_secs_f64() })
    }
}

/// Answers so far.
struct Found<'a> {
    body: &'a Body,
    thetas: &'a [Vec<f64>],
    accuracy: f64,
    answers: Vec<Option<Result<Answer>>>,
}

/// A method and its predictions.
type Predictions<'a> = (Method, &'a (dyn Fn(&Vec<f64>) -> Result<Vec<f64>> + Sync));

impl Found<'_> {
    /// Parameter sets without an answer.
    fn open(&self) -> Vec<usize> {
        (0..self.thetas.len()).filter(|&case| self.answers[case].is_none()).collect()
    }

    /// Answers where steps from predictions contract; other sets stay open. Neighbours follow each other in chains, each with the stiffness of the
    /// last that needed a Newton step. Ends early where few of some sets contract.
    fn confirm(
        &mut self,
        emulator: &Emulator<'_>,
        predictions: Predictions<'_>,
        counter: &mut Counter<'_>,
    ) -> Result<()> {
        let open = self.open();
        let thetas: Vec<_> = open.iter().map(|&case| self.thetas[case].clone()).collect();
        let ordered: Vec<usize> =
            neighbours(&thetas).into_iter().map(|place| open[place]).collect();
        // Few at first: where these do not contract, others would not either.
        let (first, rest) = ordered.split_at(CHAIN.min(ordered.len()));
        for cases in std::iter::once(first).chain(rest.chunks(AT_ONCE)) {
            let chain = |cases: &[usize]| self.chain(cases, emulator, predictions);
            let found: Vec<_> = cases.par_chunks(CHAIN).map(chain).collect::<Result<_>>()?;
            let mut count = 0;
            for (case, answer) in found.into_iter().flatten() {
                count += usize::from(answer.is_some());
                self.answers[case] = answer;
            }
            step(counter, count)?;
            if (count as f64) < WORTH_IT * cases.len() as f64 {
                break;
            }
        }
        Ok(())
    }

    /// Answers to neighbours, one after the other; `None` where steps do not contract.
    fn chain(
        &self,
        cases: &[usize],
        emulator: &Emulator<'_>,
        (method, predict): Predictions<'_>,
    ) -> Result<Vec<(usize, Option<Result<Answer>>)>> {
        emulator.with_solver(|solver| {
            let descends = emulator.predictor.newton_steps() > 0.0;
            let (mut held, mut found) = (false, Vec::with_capacity(cases.len()));
            for &case in cases {
                let (start, theta) = (Instant::now(), &self.thetas[case]);
                // A prediction that is not finite is one that does not contract.
                let answer = match predict(theta) {
                    Ok(predicted) => {
                        self.stepped(solver, &predicted, theta, (&mut held, descends))?
                    }
                    Err(_) => None,
                };
                let told = |mut answer: Answer| {
                    if answer.method != Method::Solver {
                        answer.method = method;
                        answer.warnings = extrapolation(self.body, theta);
                    }
                    answer.seconds = start.elapsed().as_secs_f64();
                    answer
                };
                found.push((case, answer.map(|answer| answer.map(told))));
            }
            Ok(found)
        })
    }

    /// An answer by steps from a prediction: quasi-Newton steps where a neighbour's stiffness is held, or Newton steps. One of a few sets that these do
    /// not contract for is solved from rest, at once where its prediction is far; from the prediction where it came from a descent.
    fn stepped(
        &self,
        solver: &mut Solver<'_>,
        predicted: &[f64],
        theta: &[f64],
        (held, descends): (&mut bool, bool),
    ) -> Result<Option<Result<Answer>>> {
        if *held && let Some(answer) = converged(solver, predicted, theta, self.accuracy)? {
            return Ok(Some(Ok(answer)));
        }
        let few = self.thetas.len() < FEW;
        let (mut taken, mut start) = (0, vec![0.0; predicted.len()]);
        if !(few && is_far(self.body, predicted, theta)) {
            let within = (self.accuracy, if few { 1 } else { MOST_STEPS });
            let (answer, steps) = confirmed(solver, predicted, theta, within)?;
            (*held, taken) = (answer.is_some(), steps);
            if answer.is_some() || !few {
                return Ok(answer.map(Ok));
            }
            // Steps that lowered the energy of this very body led there.
            if descends {
                start.copy_from_slice(predicted);
            }
        }
        let solved = solver.solve_from(&start, theta, &Options::default()).map(Answer::from);
        let solved = solved.map(|answer| Answer { steps: answer.steps + taken, ..answer });
        Ok(Some(solved.map_err(Error::from)))
    }

    /// Answers from regressions of answers, each round's one of those to the rounds before, while a round answers enough of what is open.
    fn learn(&mut self, emulator: &Emulator<'_>, counter: &mut Counter<'_>) -> Result<()> {
        while let Some(regression) = self.regression() {
            let open = self.open().len();
            let predict = |theta: &Vec<f64>| Ok(regression.predict(theta)?);
            self.confirm(emulator, (Method::Regression, &predict), counter)?;
            if ((open - self.open().len()) as f64) < WORTH_IT * open as f64 {
                break;
            }
        }
        Ok(())
    }

    /// A regression of the answers that are nearest to the open sets; `None` where nothing is open or too little is known.
    fn regression(&self) -> Option<PodRegression> {
        let place = |case: usize| -> Vec<f64> {
            let values = self.body.parameters.iter().zip(&self.thetas[case]);
            values.map(|(parameter, &value)| share_of(parameter, value)).collect()
        };
        let open: Vec<Vec<f64>> = self.open().into_iter().map(place).collect();
        if open.len() < FEWEST_OPEN {
            return None;
        }
        let far = |case: usize| {
            let at = place(case);
            let to = |other: &Vec<f64>| at.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum();
            open.iter().map(to).fold(f64::INFINITY, f64::min)
        };
        let answered = (0..self.thetas.len()).filter_map(|case| match &self.answers[case] {
            Some(Ok(answer)) => Some((far(case), case, &answer.displacement)),
            _ => None,
        });
        let mut near: Vec<_> = answered.filter(|(far, ..)| far.is_finite()).collect();
        if near.len() < LEARNED {
            return None;
        }
        near.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        near.truncate(LEARNED);
        let thetas: Vec<_> = near.iter().map(|(_, case, _)| self.thetas[*case].clone()).collect();
        let fields: Vec<_> = near.iter().map(|(.., field)| field.to_vec()).collect();
        PodRegression::fit(&self.body.parameters, &thetas, &fields).ok()
    }

    /// Solves at most so many of the open sets, neighbours one after the other.
    fn solve(&mut self, most: usize, counter: &mut Counter<'_>) -> Result<()> {
        let open = self.open();
        for cases in open[..most.min(open.len())].chunks(AT_ONCE) {
            let thetas: Vec<_> = cases.iter().map(|&case| self.thetas[case].clone()).collect();
            let solved = sweep(self.body, &thetas, &Options::default(), || ())?.results;
            for (&case, solution) in cases.iter().zip(solved) {
                self.answers[case] = Some(solution.map(Answer::from).map_err(Error::from));
            }
            step(counter, cases.len())?;
        }
        Ok(())
    }
}

fn step(counter: &mut Counter<'_>, answers: usize) -> Result<()> {
    match counter.step(answers, "") {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted { stage: "answer".into() }),
    }
}

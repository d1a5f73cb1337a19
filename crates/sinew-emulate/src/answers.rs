//! Answers at many parameter sets: predictions and Newton steps that contract, a regression of these answers where they do not, the solver
//! for the rest.

use crate::answer::{Answer, confirmed, converged};
use crate::parameters::extrapolation;
use crate::plan::{Centre, Method, Plan};
use crate::progress::{Counter, Observer};
use crate::sampling::share_of;
use crate::{Body, Emulator, Error, PodRegression, Result};
use rayon::prelude::*;
use sinew_fem::{CHAIN, Options, SolveError, neighbours, sweep};
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

/// Answers to all parameter sets, and how they were come by.
#[derive(Debug)]
pub struct Answers {
    /// Expected costs.
    pub plan: Plan,
    /// Answers in the order of the parameter sets, or why there is none.
    pub answers: Vec<std::result::Result<Answer, String>>,
    /// Wall time of plan, preparation and answers \[s\].
    pub seconds: f64,
}

impl Answers {
    /// Displacements of a body at each of `thetas` to a relative `accuracy`, by the method that costs least; every answer is checked.
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
        trained: Option<&Emulator<'b>>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let start = Instant::now();
        let planned = Plan::quick(body, thetas, accuracy, trained)?;
        Self::by(planned, body, thetas, trained, observer, start)
    }

    fn by<'b>(
        (plan, centre): (Plan, Option<Centre<'b>>),
        body: &'b Body,
        thetas: &[Vec<f64>],
        trained: Option<&Emulator<'b>>,
        observer: &mut dyn Observer,
        start: Instant,
    ) -> Result<Self> {
        let expansion = match (plan.method(), centre) {
            (Method::Expansion, Some(Centre { solver, displacement })) => {
                Some(Emulator::series_about(solver, body, &displacement, 1)?)
            }
            _ => None,
        };
        let emulator = match plan.method() {
            Method::Emulator => trained,
            Method::Expansion | Method::Solver => expansion.as_ref(),
        };
        let mut found = Found {
            body,
            thetas,
            accuracy: plan.accuracy,
            answers: thetas.iter().map(|_| None).collect(),
        };
        let mut counter = Counter::new(observer, "answer", 0, thetas.len());
        if let Some(emulator) = emulator {
            let predict =
                |theta: &Vec<f64>| Ok(emulator.predict(std::slice::from_ref(theta))?.displacement);
            found.confirm(emulator, predict, &mut counter)?;
            found.learn(emulator, &mut counter)?;
            if found.open().len() > 2 * AT_ONCE {
                found.solve(AT_ONCE, &mut counter)?;
                found.learn(emulator, &mut counter)?;
            }
        }
        found.solve(usize::MAX, &mut counter)?;
        let none = || Err("no answer".to_string());
        let answers = found.answers.into_iter().map(|answer| answer.unwrap_or_else(none)).collect();
        Ok(Self { plan, answers, seconds: start.elapsed().as_secs_f64() })
    }
}

/// Answers so far.
struct Found<'a> {
    body: &'a Body,
    thetas: &'a [Vec<f64>],
    accuracy: f64,
    answers: Vec<Option<std::result::Result<Answer, String>>>,
}

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
        predict: impl Fn(&Vec<f64>) -> Result<Vec<f64>> + Sync,
        counter: &mut Counter<'_>,
    ) -> Result<()> {
        let open = self.open();
        let thetas: Vec<_> = open.iter().map(|&case| self.thetas[case].clone()).collect();
        let ordered: Vec<usize> =
            neighbours(&thetas).into_iter().map(|place| open[place]).collect();
        // Few at first: where these do not contract, others would not either.
        let (first, rest) = ordered.split_at(CHAIN.min(ordered.len()));
        for cases in std::iter::once(first).chain(rest.chunks(AT_ONCE)) {
            let chain = |cases: &[usize]| self.chain(cases, emulator, &predict);
            let found: Vec<_> = cases.par_chunks(CHAIN).map(chain).collect::<Result<_>>()?;
            let mut count = 0;
            for (case, answer) in found.into_iter().flatten() {
                count += usize::from(answer.is_some());
                self.answers[case] = answer.map(Ok);
            }
            step(counter, count)?;
            if (count as f64) < WORTH_IT * cases.len() as f64 {
                break;
            }
        }
        Ok(())
    }

    /// Answers to neighbours, one after the other.
    fn chain(
        &self,
        cases: &[usize],
        emulator: &Emulator<'_>,
        predict: impl Fn(&Vec<f64>) -> Result<Vec<f64>>,
    ) -> Result<Vec<(usize, Option<Answer>)>> {
        emulator.with_solver(|solver| {
            let (mut held, mut found) = (false, Vec::with_capacity(cases.len()));
            for &case in cases {
                let (start, theta) = (Instant::now(), &self.thetas[case]);
                // A prediction that is not finite is one that does not contract.
                let Ok(predicted) = predict(theta) else {
                    found.push((case, None));
                    continue;
                };
                let near = match held {
                    true => converged(solver, &predicted, theta, self.accuracy)?,
                    false => None,
                };
                let answer = match near {
                    Some(answer) => Some(answer),
                    None => {
                        let own = confirmed(solver, &predicted, theta, self.accuracy)?;
                        held = own.is_some();
                        own
                    }
                };
                found.push((
                    case,
                    answer.map(|mut answer| {
                        answer.warnings = extrapolation(self.body, theta);
                        answer.seconds = start.elapsed().as_secs_f64();
                        answer
                    }),
                ));
            }
            Ok(found)
        })
    }

    /// Answers from regressions of answers, each round's one of those to the rounds before, while a round answers enough of what is open.
    fn learn(&mut self, emulator: &Emulator<'_>, counter: &mut Counter<'_>) -> Result<()> {
        while let Some(regression) = self.regression() {
            let open = self.open().len();
            self.confirm(emulator, |theta| Ok(regression.predict(theta)?), counter)?;
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
                let told = |error: SolveError| error.to_string();
                self.answers[case] = Some(solution.map(Answer::from).map_err(told));
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

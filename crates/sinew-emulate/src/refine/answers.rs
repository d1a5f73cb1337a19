//! Answers at many parameter sets: by Newton steps from predictions, by a regression of the answers so far, or by the
//! solver.

use crate::parameters::extrapolation;
use crate::recipe::progress::{Counter, Observer};
use crate::refine::defects::{Defect, corrected, is_finite, place};
use crate::refine::plan::{Counted, FEW, Method, Plan, SWEPT, has_branches};
use crate::refine::{Answer, confirmed, is_far};
use crate::{Body, Emulator, Error, PodRegression, Result};
use sinew_fem::{CHAIN, Options, Pairs, Refined, SolveError, Solver, Stop, neighbours, sweep};
use sinew_num::{difference, try_in_parallel};
use std::time::Instant;

/// Answers between two progress reports: several chains of neighbours.
const AT_ONCE: usize = 100;
/// Quasi-Newton steps with a neighbour's stiffness at most, of small and of large bodies. They cost about as much as one Newton step.
const QUASI_NEWTON: [usize; 2] = [9, 27];
/// Largest error that quasi-Newton steps are to leave. The length of a linear step tells less of larger ones: a thin strip that rotates had
/// an error of 2.4e-2 for an estimate of 1.4e-2.
const LINEAR: f64 = 2e-3;
/// Unknowns of a large body.
const LARGE_SYSTEM: usize = 20_000;
/// Residual \[relative to loads and reactions\] at which Newton's method leaves the rest to quasi-Newton steps with its last stiffness.
/// With 1e-9, answers of large bodies take 0.97 instead of 0.75 of a sweep at 1e-4, and those of a small ventricle 5 % longer; errors are the same.
const RESIDUAL: f64 = 1e-4;

/// Parameter sets and displacement components from which on a regression of the answers pays. Its fit costs about as much
/// as a hundred answers of a ventricle with 1500 nodes.
const MANY: usize = 1000;
const LARGE: usize = 1500;
/// Answers that the regression is fitted to, at first and at most.
const FIRST: usize = 100;
const MOST_LEARNED: usize = 400;
/// Tolerance of these answers relative to the prescribed one, and its lower bound. Predictions from them shall be within an
/// eighth of the prescribed tolerance.
const SHARP: f64 = 0.03;
const SHARPEST: f64 = 1e-9;
/// Quasi-Newton steps that check the contraction, and the number of neighbours that then skip the check.
const CHECKED: usize = 2;
const TRUSTED: usize = 10;
/// Answers that tell what an expansion is worth, at least.
const LEAST_FIRST: usize = 8;

/// Answers to all parameter sets, with the plan that they were made by.
#[derive(Debug)]
pub struct Answers {
    /// Expected costs.
    pub plan: Plan,
    /// Answers in the order of the parameter sets, or the reason for a missing one.
    pub answers: Vec<Result<Answer>>,
    /// Wall time of plan, preparation and answers \[s\].
    pub seconds: f64,
}

impl Answers {
    /// Displacements of a body at each of `thetas` to a relative `accuracy`, by the method that costs least; every answer is checked.
    ///
    /// An `emulator` of the body is one of the methods. It may also give the initial guess of the solve behind a Taylor
    /// expansion. The one of [`Emulator::frozen_stiffness`] needs neither training nor an earlier
    /// solve of the body.
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
    /// As [`Plan::for_counts`], a body that cannot be solved for any θ, an observer that breaks. Sets without an answer are no error.
    pub fn to<'b>(
        body: &'b Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        emulator: Option<&Emulator<'b>>,
        observer: &mut dyn Observer,
    ) -> Result<Self> {
        let start = Instant::now();
        let mut counter = Counter::new(observer, "answer", 0, thetas.len());
        let (plan, counted) = Plan::quick(body, thetas, accuracy, emulator, &mut counter)?;
        let mut answers: Vec<_> = thetas.iter().map(|_| None).collect();
        let (mut expansion, mut centre_jumped) = (None, false);
        if let Some(Counted { solver, displacement, first, jumped, .. }) = counted {
            // The solver begins at rest, not at a state of an emulator.
            if emulator.is_none() || plan.method() != Method::Solver {
                answers[0] = Some(Ok(Answer::from(first).descended(jumped)));
                counter.keep(1);
            }
            if plan.method() == Method::Expansion {
                expansion = Some(Emulator::taylor_about(solver, &displacement, 1)?);
                centre_jumped = jumped;
            }
        }
        let emulator = match plan.method() {
            Method::Emulator => emulator,
            _ => expansion.as_ref(),
        };
        let mut found = Found { body, thetas, accuracy, answers };
        counter.begin();
        if let Some(emulator) = emulator {
            let predict =
                |theta: &Vec<f64>| Ok(emulator.predict(std::slice::from_ref(theta))?.displacement);
            let jumped = centre_jumped || has_branches(emulator);
            let method = plan.method();
            let guess = Guess { emulator, method, predict: &predict, accuracy, jumped };
            if thetas.len() >= MANY && thetas.len() * body.prescribed.len() >= MANY * LARGE {
                found.grow(&guess, &mut counter)?;
            }
            found.confirm(&found.open(), &guess, &mut counter)?;
        }
        found.solve(&mut counter)?;
        let answered = |answer: Option<_>| answer.expect("an answer or a reason for each set");
        let answers = found.answers.into_iter().map(answered).collect();
        Ok(Self { plan, answers, seconds: start.elapsed().as_secs_f64() })
    }
}

impl Emulator<'_> {
    /// The displacement at `theta` to a relative accuracy: [`Answers::to`] for one parameter set.
    ///
    /// Newton steps from the prediction are taken until two simplified steps contract and the error estimate is below the
    /// tolerance. If the first step does not contract, or the prediction is far from equilibrium, the solver starts from
    /// rest. This takes at most one Newton step more than a solve alone. [`Answer::is_within`] shows whether the tolerance
    /// was met.
    ///
    /// ```
    /// # use sinew_emulate::Emulator;
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// # let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    /// #     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    /// #     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    /// #     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    /// #     .support(Support::clamped("x_min"))
    /// #     .lower()?;
    /// let emulator = Emulator::taylor(&beam, 1)?; // one solve, no training
    /// let answer = emulator.answer(&[60.0, 90.0], 1e-4)?;
    /// assert!(answer.is_within(1e-4) && answer.steps == 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// θ of the wrong length, an accuracy outside 1e-10 to 0.5, no equilibrium.
    pub fn answer(&self, theta: &[f64], accuracy: f64) -> Result<Answer> {
        let one = [theta.to_vec()];
        Answers::to(self.body, &one, accuracy, Some(self), &mut ())?.answers.remove(0)
    }
}

/// Answers so far.
struct Found<'a> {
    body: &'a Body,
    thetas: &'a [Vec<f64>],
    accuracy: f64,
    answers: Vec<Option<Result<Answer>>>,
}

/// State of the steps along a chain of neighbours.
struct Stepping {
    accuracy: f64,
    /// Whether predictions come from a descent.
    descends: bool,
    /// Parameters of the factor that the solver holds, if steps with it contracted.
    held: Option<Vec<f64>>,
    /// Sets for which quasi-Newton steps with it still skip the contraction check.
    seen: usize,
    /// Curvature pairs of steps with it.
    pairs: Pairs,
}

/// Answers of a chain, and the errors of their predictions.
type Chained = (Vec<(usize, Result<Answer>)>, Vec<Defect>);

/// Initial guesses by a method, and the tolerance of the answers that begin at them.
#[derive(Clone, Copy)]
struct Guess<'a, 'b> {
    emulator: &'a Emulator<'b>,
    method: Method,
    /// Displacement at θ.
    predict: &'a (dyn Fn(&Vec<f64>) -> Result<Vec<f64>> + Sync),
    accuracy: f64,
    /// Whether its predictions descend from a solution of a body with several stable equilibria.
    jumped: bool,
}

impl Guess<'_, '_> {
    /// Whether other answers may be predicted from an answer: one that jumped would lead them to its branch, without a word.
    fn learns_from(&self, answer: &Answer) -> bool {
        self.jumped || !answer.has_jumped()
    }
}

impl Found<'_> {
    /// Parameter sets without an answer.
    fn open(&self) -> Vec<usize> {
        (0..self.thetas.len()).filter(|&case| self.answers[case].is_none()).collect()
    }

    /// The parameters of some sets.
    fn thetas(&self, cases: &[usize]) -> Vec<Vec<f64>> {
        cases.iter().map(|&case| self.thetas[case].clone()).collect()
    }

    /// Answers sets by steps from predictions, which the errors at sets before correct. Each chain of neighbours reuses the stiffness of its
    /// last Newton step. An expansion that takes more steps than a sweep leaves the rest to the solver.
    fn confirm(
        &mut self,
        cases: &[usize],
        guess: &Guess<'_, '_>,
        counter: &mut Counter<'_>,
    ) -> Result<()> {
        let order = neighbours(&self.thetas(cases));
        let ordered: Vec<usize> = order.into_iter().map(|place| cases[place]).collect();
        // Few at first: their errors correct the others, and tell whether the expansion is worth its steps.
        let first = (ordered.len() / 3).clamp(LEAST_FIRST, CHAIN).min(ordered.len());
        let (first, rest) = ordered.split_at(first);
        // A search that fails from a prediction may not fail from a neighbour's solution, where a sweep begins.
        let few = self.thetas.len() < FEW;
        let goes_on = |answer: &Result<Answer>| {
            !few && matches!(answer, Err(Error::Solve(SolveError::NotConverged(_))))
        };
        let (mut known, most) = (Vec::new(), Options::default().iterations_per_load);
        for cases in std::iter::once(first).chain(rest.chunks(AT_ONCE)) {
            let chain = |cases: &[usize]| self.chain(cases, guess, &known);
            let mut steps = 0;
            for (answers, defects) in try_in_parallel(cases.chunks(CHAIN), chain)? {
                for (case, answer) in answers {
                    steps += answer.as_ref().map_or(most, |answer| answer.steps);
                    self.answers[case] = Some(answer).filter(|answer| !goes_on(answer));
                }
                known.extend(defects);
            }
            known.truncate(MOST_LEARNED);
            let _ = counter.step(cases.len(), "");
            counter.check()?;
            // A regression of answers learns from all of them.
            let alone = guess.method == Method::Expansion && guess.accuracy == self.accuracy;
            if alone && steps as f64 > SWEPT * cases.len() as f64 {
                break;
            }
        }
        Ok(())
    }

    /// Answers to neighbours, one after the other, and the errors of their predictions.
    fn chain(&self, cases: &[usize], guess: &Guess<'_, '_>, known: &[Defect]) -> Result<Chained> {
        guess.emulator.solvers.with(|solver| {
            let descends = guess.emulator.predictor.newton_steps() > 0.0;
            let (accuracy, pairs) = (guess.accuracy, Pairs::default());
            let mut stepping = Stepping { accuracy, descends, held: None, seen: 0, pairs };
            let (mut found, mut own) = (Vec::with_capacity(cases.len()), Vec::new());
            for &case in cases {
                let (start, theta) = (Instant::now(), &self.thetas[case]);
                let place = place(self.body, theta);
                let predicted = (guess.predict)(theta).ok();
                let predicted = predicted.filter(|u| is_finite(&place) && is_finite(u));
                // Rest in the place of a failed prediction.
                let near = match &predicted {
                    Some(predicted) => corrected(predicted, &place, known.iter().chain(&own)),
                    None => vec![0.0; self.body.prescribed.len()],
                };
                let mut answer = self.stepped(solver, &near, theta, &mut stepping)?;
                if let Ok(answer) = &mut answer {
                    if let Some(predicted) = predicted.filter(|_| guess.learns_from(answer)) {
                        let field = difference(&answer.displacement, &predicted);
                        own.push(Defect { place, field });
                    }
                    if answer.method != Method::Solver {
                        answer.method = guess.method;
                        answer.warnings.extend(extrapolation(self.body, theta));
                    }
                    answer.seconds = start.elapsed().as_secs_f64();
                }
                found.push((case, answer.map(|answer| answer.descended(guess.jumped))));
            }
            Ok((found, own))
        })
    }

    /// Answer by quasi-Newton steps with a neighbour's stiffness, else by the solver from where they end, whose last stiffness leaves the rest
    /// to such steps. With few sets, Newton steps that contract come before, and a far prediction goes to the solver at once.
    fn stepped(
        &self,
        solver: &mut Solver<'_>,
        predicted: &[f64],
        theta: &[f64],
        stepping: &mut Stepping,
    ) -> Result<Result<Answer>> {
        let mut from = predicted.to_vec();
        let most = QUASI_NEWTON[usize::from(solver.unknowns() >= LARGE_SYSTEM)];
        let stop = Stop::within(stepping.accuracy.min(LINEAR), most);
        if let Some(held) = &stepping.held {
            let contracts = stepping.seen > 0 && similar(held, theta);
            let stop = Stop { contracts, ..stop };
            match solver.refine_on(predicted, theta, stop, &mut stepping.pairs) {
                Ok(Refined { displacement, error: Some(error), steps, .. }) => {
                    let fewer = stepping.seen.saturating_sub(1);
                    stepping.seen = if steps >= CHECKED { TRUSTED } else { fewer };
                    return Ok(Ok(Answer::predicted(displacement, error, 0)));
                }
                // Each step lowers the energy.
                Ok(refined) => from = refined.displacement,
                Err(SolveError::Inadmissible { .. }) => {}
                Err(other) => return Err(other.into()),
            }
        }
        (stepping.held, stepping.seen, stepping.pairs) = (None, 0, Pairs::default());
        if self.thetas.len() < FEW {
            let rest = vec![0.0; from.len()];
            if is_far(self.body, &from, theta) {
                return Ok(exact(solver, &rest, theta, 0));
            }
            let (answer, taken) = confirmed(solver, &from, theta, (stepping.accuracy, 1))?;
            stepping.held = answer.as_ref().map(|_| theta.to_vec());
            // A descent has lowered the energy of this body.
            let start = if stepping.descends { &from } else { &rest };
            return Ok(answer.map_or_else(|| exact(solver, start, theta, taken), Ok));
        }
        // Without load steps.
        let options =
            Options { minimum_accuracy: RESIDUAL, least_load_step: 1.0, ..Options::default() };
        let solved = match solver.solve_from(&from, theta, &options) {
            Ok(solved) => solved,
            Err(error) => return Ok(Err(error.into())),
        };
        if solved.is_stable() {
            stepping.held = Some(theta.to_vec());
            let found = solver.refine(&solved.displacement, theta, stop)?;
            if let Some(error) = found.error {
                let answer = Answer::predicted(found.displacement, error, solved.iterations());
                return Ok(Ok(answer.descended(solved.jumped)));
            }
        }
        let found = exact(solver, &solved.displacement, theta, solved.iterations());
        Ok(found.map(|answer| answer.descended(solved.jumped)))
    }

    /// Regression for many sets. It is fitted to accurate answers at some sets, refitted as their number doubles, and
    /// predicts the other sets. For most of these the error estimate is small enough without a step.
    fn grow(&mut self, guess: &Guess<'_, '_>, counter: &mut Counter<'_>) -> Result<()> {
        let guess = Guess { accuracy: (SHARP * guess.accuracy).max(SHARPEST), ..*guess };
        let first = self.spread(FIRST);
        self.confirm(&first, &guess, counter)?;
        let (mut thetas, mut fields) = self.samples(&first, &guess);
        let fitted = PodRegression::fit(&self.body.parameters, &thetas, &fields);
        let Ok(mut regression) = fitted else { return Ok(()) };
        while thetas.len() < MOST_LEARNED {
            let next = self.spread(thetas.len().min(MOST_LEARNED - thetas.len()));
            let predict = |theta: &Vec<f64>| regression.predict(theta);
            let guess = Guess { method: Method::Regression, predict: &predict, ..guess };
            self.confirm(&next, &guess, counter)?;
            let more = self.samples(&next, &guess);
            // Sets without an equilibrium stay open.
            if 2 * more.0.len() <= next.len() {
                break;
            }
            thetas.extend(more.0);
            fields.extend(more.1);
            let Ok(grown) = regression.refitted(&thetas, &fields) else { break };
            regression = grown;
        }
        let predict = |theta: &Vec<f64>| regression.predict(theta);
        let accuracy = self.accuracy;
        let guess = Guess { method: Method::Regression, predict: &predict, accuracy, ..guess };
        self.confirm(&self.open(), &guess, counter)
    }

    /// At most `count` of the open sets, evenly over their order.
    fn spread(&self, count: usize) -> Vec<usize> {
        let open = self.open();
        let count = count.min(open.len());
        (0..count).map(|place| open[place * open.len() / count]).collect()
    }

    /// Parameter sets and displacements of the answers that a guess learns from.
    fn samples(&self, cases: &[usize], guess: &Guess<'_, '_>) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let answers = cases.iter().filter_map(|&case| {
            let answer = self.answers[case].as_ref()?.as_ref().ok()?;
            let usable =
                guess.learns_from(answer) && is_finite(&place(self.body, &self.thetas[case]));
            usable.then(|| (self.thetas[case].clone(), answer.displacement.clone()))
        });
        answers.unzip()
    }

    /// Solves the open sets, neighbours one after the other.
    fn solve(&mut self, counter: &mut Counter<'_>) -> Result<()> {
        for cases in self.open().chunks(AT_ONCE) {
            let solved = sweep(self.body, &self.thetas(cases), &Options::default(), || ())?;
            for (&case, solution) in cases.iter().zip(solved) {
                self.answers[case] = Some(solution.map(Answer::from).map_err(Error::from));
            }
            let _ = counter.step(cases.len(), "");
            counter.check()?;
        }
        Ok(())
    }
}

/// Answer by the solver from a displacement, after so many Newton steps.
fn exact(solver: &mut Solver<'_>, from: &[f64], theta: &[f64], taken: usize) -> Result<Answer> {
    let solved = Answer::from(solver.solve_from(from, theta, &Options::default())?);
    Ok(Answer { steps: solved.steps + taken, ..solved })
}

/// Whether no parameter differs by more than a factor of two: the stiffness of both is then of the same order.
fn similar(a: &[f64], b: &[f64]) -> bool {
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 0.5 * a.abs().max(b.abs());
    a.iter().zip(b).all(close)
}

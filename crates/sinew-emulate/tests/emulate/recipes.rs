//! Recipes: requests that are refused, and the fit that is taken.

use crate::simulations::short_bar;
use crate::to_an_accuracy::bar;
use serde_json::Value;
use sinew_emulate::parts::{Session, root_mean_square};
use sinew_emulate::recipe::{Regression, Taylor};
use sinew_emulate::{Budget, Error, Predictor, Record, TestSet, Train, TrainingOptions};

#[test]
fn budgets_that_admit_nothing_are_refused() {
    let body = bar();
    let refused = |options: TrainingOptions| {
        let error = Taylor.train(&body, &options, &mut ()).map(drop).unwrap_err();
        assert!(matches!(error, Error::Setting { .. }), "{error}");
        error.to_string()
    };
    for budget in [Budget::Effort(0.0), Budget::Seconds(f64::NAN), Budget::Steps(0)] {
        refused(TrainingOptions { budget, ..TrainingOptions::default() });
    }
    let told = refused(TrainingOptions { held_out: 0, ..TrainingOptions::default() });
    assert!(told.contains("held-out"), "{told}");
}

/// Recipe that tells a regression that its first fit, to eight simulations, is all but the truth.
#[derive(Debug)]
struct Early;

impl Train for Early {
    fn key(&self) -> &'static str {
        "early"
    }

    fn settings(&self) -> Value {
        Value::Null
    }

    fn about(&self, _: &Record) -> String {
        "regression that learns from more than it needs".into()
    }

    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>, Error> {
        let recipe = |most| Regression { simulations: 8, most, target: 0.0 };
        let first = recipe(8).predictor(session, held_out, &mut Record::new("first"))?;
        let fields = |predictor: &dyn Predictor| -> Result<Vec<Vec<f64>>, Error> {
            let all = predictor.predict(held_out.body, &held_out.thetas)?;
            Ok(all.chunks(all.len() / held_out.thetas.len()).map(<[f64]>::to_vec).collect())
        };
        let mut truths = fields(&*first)?;
        truths.iter_mut().flatten().for_each(|u| *u *= 1.0 + 1e-10);
        let judged = TestSet { fields: truths, ..held_out.clone() };
        let taken = recipe(16).predictor(session, &judged, record)?;
        let error = record.taken().unwrap().error;
        // What is returned is what was measured.
        assert_eq!(root_mean_square(&judged.cases(&fields(&*taken)?)?), error);
        Ok(taken)
    }
}

#[test]
fn the_best_fit_is_returned_and_not_the_last() {
    let body = short_bar();
    let record = Early.train(&body, &TrainingOptions::default(), &mut ()).unwrap().record;
    let choice = record.choice.unwrap();
    let [first, second] = &choice.candidates[..] else { panic!("{choice}") };
    assert_eq!((first.simulations, second.simulations), (8, 16));
    assert!(second.error > 10.0 * first.error, "{:e} for {:e}", second.error, first.error);
    assert_eq!((choice.taken, record.simulations), (0, 8));
}

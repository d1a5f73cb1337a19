//! Taylor expansion about one solution or several: nothing is trained.

use super::Train;
use crate::estimate::evaluate::TestSet;
use crate::estimate::timing::timed;
use crate::predict::Predictor;
use crate::predict::regressed::Regressed;
use crate::predict::taylor::{self, TaylorExpansion};
use crate::recipe::session::Session;
use crate::store::record::Record;
use crate::{Result, TrainingOptions};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Taylor expansion of second order about the solution at the centre of the parameters' ranges, and further anchors: nothing is trained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Taylor;

impl Train for Taylor {
    fn key(&self) -> &'static str {
        taylor::KEY
    }

    fn settings(&self) -> Value {
        json!({ "recipe": self.key() })
    }

    fn has_anchors(&self) -> bool {
        true
    }

    fn about(&self, record: &Record) -> String {
        taylor::about(record.simulations)
    }

    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        _: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>> {
        let TrainingOptions { anchors, seed, .. } = *session.options;
        let taylor = timed(&mut record.prepare_s, || {
            TaylorExpansion::of(session.body, anchors, seed, session.observer)
        })?;
        session.simulations = anchors;
        Ok(Box::new(Regressed { taylor: Some(taylor), regression: None }))
    }
}

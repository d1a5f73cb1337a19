//! Taylor expansion about one solution: nothing is trained.

use super::Train;
use crate::Result;
use crate::evaluate::TestSet;
use crate::parameters::require_some;
use crate::predictor::Predictor;
use crate::record::Record;
use crate::regressed::Regressed;
use crate::session::Session;
use crate::taylor::{self, TaylorExpansion};
use crate::timing::timed;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Taylor expansion of second order about the solution at the centre of the parameters' ranges: nothing is trained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Taylor;

impl Train for Taylor {
    fn key(&self) -> &'static str {
        taylor::KEY
    }

    fn settings(&self) -> Value {
        json!({ "recipe": self.key() })
    }

    fn about(&self, _: &Record) -> String {
        taylor::ABOUT.into()
    }

    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        _: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<Box<dyn Predictor>> {
        let body = session.body;
        let taylor = timed(&mut record.prepare_s, || {
            require_some(body)?;
            TaylorExpansion::of(body, session.options.seed)
        })?;
        session.simulations = 1;
        Ok(Box::new(Regressed { taylor: Some(taylor), regression: None }))
    }
}

//! Taylor expansion about one solution: nothing is trained.

use super::Train;
use crate::evaluate::TestSet;
use crate::predictor::Predictor;
use crate::record::Record;
use crate::session::Session;
use crate::{Emulator, Result, taylor};
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
        let expanded = Emulator::series(session.body, session.options.seed)?;
        let (predictor, own) = expanded.into_parts();
        record.prepare_s = own.prepare_s;
        session.simulations = own.simulations;
        Ok(predictor)
    }
}

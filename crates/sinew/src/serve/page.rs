//! The page of an emulator that is served: its script asks for the solver's displacement where the sliders rest.

use crate::Emulator;
use crate::viewer::{Surface, viewer};
use sinew_energy::Body;
use std::sync::OnceLock;

/// Script that asks.
const SCRIPT: &str = include_str!("live.js");

/// Page that is made at the first request.
pub(super) struct Page {
    surface: Surface,
    seed: u64,
    html: OnceLock<Result<String, String>>,
}

impl Page {
    /// `None` for a body without a surface.
    pub(super) fn of(body: &Body, seed: u64) -> Option<Self> {
        Some(Self { surface: Surface::of(body)?, seed, html: OnceLock::new() })
    }

    /// The page, or the reason for its absence.
    pub(super) fn html(&self, emulator: &Emulator<'_>) -> Result<String, String> {
        let make = || {
            let page = viewer(emulator, self.seed, &mut ()).map_err(|error| error.to_string())?;
            let script = format!("<script>{SCRIPT}</script></body>");
            Ok(page.to_html().replace("</body>", &script))
        };
        self.html.get_or_init(make).clone()
    }

    /// Displacement of the page's nodes \[length\].
    pub(super) fn displacement(&self, field: &[f64]) -> Vec<f64> {
        self.surface.of_field(field)
    }
}

//! Beams and rates that networks are trained at, and how long.

/// Name on the command line.
pub(crate) const KEY: &str = "learning-rates";
/// Training time by default \[min\].
pub(crate) const MINUTES: f64 =
    SECONDS / 60.0 * (SCENES.len() * (THESIS.len() + OURS.len())) as f64;
/// Time of one network \[s\].
pub(super) const SECONDS: f64 = 20.0;
pub(super) const SCENES: [&str; 4] =
    ["OnceClampedBeam", "TwiceClampedBeam", "TractionBeamHO", "TractionBeamGuccione"];
/// Rates of Adam, kept to the end; with the last the thesis' trainings diverged.
pub(super) const THESIS: [f64; 4] = [1e-5, 5e-5, 1e-4, 5e-4];
/// Peaks of Muon's rates, about the default.
pub(super) const OURS: [f64; 3] = [2e-3, 8e-3, 3.2e-2];

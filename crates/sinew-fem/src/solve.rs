//! Equilibria: Newton's method, load increments, arc-length continuation, sweeps, sensitivities.

pub(crate) mod branch;
pub(crate) mod continuation;
pub(crate) mod frozen_stiffness;
pub(crate) mod history;
pub(crate) mod line_search;
pub(crate) mod loading;
pub(crate) mod newton;
pub(crate) mod newton_step;
pub(crate) mod options;
pub(crate) mod outlook;
pub(crate) mod path;
pub(crate) mod predictor;
pub(crate) mod refine;
pub(crate) mod search;
pub(crate) mod sensitivity;
pub(crate) mod solver;
pub(crate) mod sweep;

pub(crate) use history::{Log, Progress, Watch};
pub(crate) use line_search::{SUFFICIENT, flattens, minds_turned_cells};
pub(crate) use outlook::Outlook;
pub(crate) use path::{FIRST_GRADIENT, FIRST_STEP, ON_THE_WAY, Path};
pub(crate) use predictor::far_turn;
pub(crate) use refine::{Potential, energy_at_rest};
pub(crate) use search::{Equilibrium, Goal, Line, Plane, Point, Search, Watchdog};
pub(crate) use sensitivity::units;

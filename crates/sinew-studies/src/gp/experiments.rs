//! The experiments of §1.7.3 and §4.8, one file for each or for a small family.

mod noisy;
mod poisson;

use crate::gp::experiment::{Experiment, Scale};
use crate::gp::row::Row;
use crate::program;
use anyhow::Result;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use sinew_report::Figure;

/// Names of the experiments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Name {
    /// 1-D Poisson by networks: strong form against energy (§1.7.3, Fig. 1.4)
    Pinn,
    /// Few collocation points: process against network (Fig. 4.3)
    #[value(name = "poisson-1")]
    Poisson1,
    /// A pentagon (Fig. 4.4)
    #[value(name = "poisson-2")]
    Poisson2,
    /// Diffusivity in one dimension (Fig. 4.5)
    #[value(name = "heat-1")]
    Heat1,
    /// Diffusivity in two dimensions (Fig. 4.5)
    #[value(name = "heat-2")]
    Heat2,
    /// Speed of waves between free ends, with the traces of all restarts (Figs. 4.8, 4.9)
    #[value(name = "wave-1")]
    Wave1,
    /// Speed of periodic waves, with the traces of all restarts (Figs. 4.8, 4.9)
    #[value(name = "wave-2")]
    Wave2,
    /// Two parameters from few and many data (Fig. 4.10)
    AdvectionDiffusion,
    /// Mixed conditions on a square (Fig. 4.11)
    Helmholtz,
}

impl Name {
    /// Experiments of a choice of names, each once and in the order given.
    pub(crate) fn chosen(only: &[Self]) -> Vec<Self> {
        let all = if only.is_empty() { Self::value_variants() } else { only };
        let mut distinct = Vec::new();
        for name in all {
            if !distinct.contains(name) {
                distinct.push(*name);
            }
        }
        distinct
    }

    /// Name on the command line and in files.
    pub fn key(self) -> String {
        program::key(self)
    }

    /// The experiment.
    pub fn experiment(self, scale: Scale) -> Result<Experiment> {
        Ok(match self {
            Self::Pinn => poisson::pinn(scale),
            Self::Poisson1 => poisson::experiment(scale)?,
            Self::Poisson2 => poisson::pentagon(scale)?,
            Self::Heat1 => noisy::heat_1(scale)?,
            Self::Heat2 => noisy::heat_2(scale)?,
            Self::Wave1 => noisy::wave_1(scale)?,
            Self::Wave2 => noisy::wave_2(scale)?,
            Self::AdvectionDiffusion => noisy::advection_diffusion(scale)?,
            Self::Helmholtz => noisy::helmholtz(scale)?,
        })
    }

    /// Drawing of the rows, where there is one beside those of single runs.
    pub(crate) fn figure(self, rows: &[Row]) -> Option<Figure> {
        (self == Self::AdvectionDiffusion).then(|| noisy::more_data(rows))
    }
}

//! Following an equilibrium by the volume that its pressure sweeps, through limit points.

use crate::solve::path::{Along, Path};
use crate::solve::watch::Log;
use crate::{Options, Solution, SolveError, Solver};
use sinew_energy::{Magnitude, PressureSurface};
use std::time::Instant;

/// An equilibrium on a path of growing volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeStep {
    /// Volume that the loaded surface has swept along the pressure \[length³\].
    pub swept: f64,
    /// The equilibrium; its load factor is what the volume takes.
    pub solution: Solution,
}

impl Solver<'_> {
    /// Equilibria at which the first pressure's surface has swept the given volumes \[length³\] one after the
    /// other; all loads are scaled by one unknown factor. Passes limit points, where the load that a body
    /// bears has a maximum.
    ///
    /// # Errors
    /// θ that makes no sense, no pressure with a potential, prescribed motions that are not zero, or
    /// [`SolveError::NotConverged`] with the last equilibrium.
    pub fn trace_volume(
        &mut self,
        theta: &[f64],
        volumes: &[f64],
        options: &Options,
    ) -> Result<Vec<VolumeStep>, SolveError> {
        self.system.body.check_theta(theta)?;
        let controlled = self.controlled()?;
        if volumes.iter().any(|volume| !volume.is_finite()) {
            return Err(SolveError::VolumeControl { problem: "a volume asked for is not finite" });
        }
        let mut path = Path::to_load(&mut self.system, theta, options);
        path.along = Along::Volume(controlled);
        let mut trace = Vec::with_capacity(volumes.len());
        let mut reached = 0.0;
        for &swept in volumes {
            let (start, mut history) = (Instant::now(), Log::default());
            let found = path.follow(swept, swept - reached, &mut history)?;
            let history = history.take();
            let solution = Solution::new(path.system, found, theta, history, start);
            trace.push(VolumeStep { swept, solution });
            reached = swept;
        }
        Ok(trace)
    }

    fn controlled(&self) -> Result<PressureSurface, SolveError> {
        let potential = self.system.body;
        if potential.prescribed.iter().flatten().any(|&u| u != 0.0) {
            return Err(SolveError::VolumeControl { problem: "supports prescribe a motion" });
        }
        let Some(first) = potential.pressures.first() else {
            let problem = "no pressure acts on a surface whose rim is held or has a lid";
            return Err(SolveError::VolumeControl { problem });
        };
        Ok(PressureSurface { magnitude: Magnitude::Fixed(1.0), ..first.clone() })
    }
}

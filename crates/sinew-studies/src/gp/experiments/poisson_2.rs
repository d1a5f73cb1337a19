//! Poisson-BVP-2 (§4.8.1): a domain that is not a box.

use crate::gp::experiment::{Experiment, Purpose, Scale, Task};
use crate::gp::inference::{Approach, Inference, Observed};
use crate::gp::pentagon::{Pentagon, corners};
use crate::gp::problems::Setting;
use anyhow::Result;
use sinew_gp::{Domain, Problem, constant};
use std::sync::Arc;

const LOAD: f64 = 4.0;
const COLLOCATION: usize = 100;

/// −Δu = 4 on a pentagon from a hundred collocation points.
pub(super) fn experiment(scale: Scale) -> Result<Experiment> {
    let domain = Domain::polygon(["x", "y"], &corners())?;
    let [dx, dy] = domain.derivatives();
    let reference = Pentagon::solve();
    let problem = Problem::new(domain, -(dx * dx) - dy * dy)?.boundary(constant(0.0))?;
    let setting = Setting::new("Poisson-BVP-2", problem, &[], move |place| reference.value(place));
    let setting = Setting { load: Arc::new(|_| LOAD), ..setting };
    let count = scale.pick(COLLOCATION, COLLOCATION / 4);
    let inference =
        Inference::new(&setting, Approach::Constrained, scale, move |setting, task: &Task| {
            let domain = setting.problem.domain();
            let collocation = domain.sample(count, task.seed_for(Purpose::Collocation))?;
            Ok(Observed::collocated(collocation, vec![LOAD; count]))
        });
    Ok(Experiment {
        title: "Poisson-BVP-2 (§4.8.1, Fig. 4.4)",
        about: "−Δu = 4 on a regular pentagon with corners on the unit circle, u = 0 on its edges. The reference is a \
                sum of harmonic functions whose error is below 1e-8 everywhere; the thesis' is a finite-element \
                solution.",
        cases: vec![inference.case().at(format!("N_f = {count}"))],
    })
}

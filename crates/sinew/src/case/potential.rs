//! Cases without a potential: mixed elements, and pressures whose rim moves freely.

use super::{Case, CaseError, Rim};
use sinew_energy::Body;

impl Case {
    /// The body, if it has a potential.
    pub(super) fn potential(&self, body: Body) -> Result<Body, CaseError> {
        if body.has_potential() {
            return Ok(body);
        }
        let solve = "`sinew solve` and `sinew sample --solve` take it as it is";
        if body.pressure_field.is_some() {
            let reason = format!(
                "mixed elements have no potential, by which emulators learn and answers are refined; {solve}; for other commands \
                 write formulation = \"averaged\" or \"quadratic\""
            );
            return Err(self.source.error(&["formulation"], reason));
        }
        let is_loose = |load: &super::Load| load.rim == Some(Rim::Loose);
        let number = self.loads.iter().position(is_loose).unwrap_or_default();
        let reason = format!(
            "a pressure whose rim moves freely has no potential, by which emulators learn and answers are refined; {solve}; for \
             other commands hold the rim, or write rim = \"closed\" for a lid that moves with it"
        );
        Err(self.source.error(&["loads", &number.to_string(), "rim"], reason))
    }

    /// Refuses pressures without a potential whose loads do not say that their rim is loose.
    pub(super) fn check_rims(&self, body: &Body) -> Result<(), CaseError> {
        let mesh = &body.mesh;
        for (number, load) in self.loads.iter().enumerate() {
            let (None, Some(_), Some(name)) = (load.rim, &load.pressure, &load.facets) else {
                continue;
            };
            let facets = mesh.facet_sets().get(name).into_iter().flatten();
            let nodes: Vec<usize> = facets.flat_map(|&f| mesh.nodes_of_facet(f)).collect();
            let is_loose = body.followers.iter().any(|follower| follower.nodes == nodes);
            self.source.refuse_if(is_loose, &["loads", &number.to_string()], || {
                format!("the rim of `{name}` moves freely; hold it, or {LOOSE}")
            })?;
        }
        Ok(())
    }
}

/// Advice about a pressure whose rim moves freely.
pub(super) const LOOSE: &str = "write rim = \"closed\" beside the pressure for a lid that moves with it, or rim = \"loose\": the \
                                body is then solved by a balance of forces, and no emulator is trained on it";

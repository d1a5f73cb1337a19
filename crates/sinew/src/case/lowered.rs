//! A case as the solver takes it: by a potential, or by a balance of forces that has none.

use super::{Case, CaseError, Formulation};
use sinew_energy::{Body, ForceBalance};
use sinew_fem::Balance;

/// Lowered case.
#[derive(Clone, Debug)]
pub enum Lowered {
    /// A body whose equilibria are minima of its potential: every command takes it.
    Potential(Body),
    /// A balance of forces without a potential: mixed elements, or a pressure whose rim moves freely. It is solved
    /// ([`crate::Solver`]), and nothing is trained on it.
    Balance(ForceBalance),
}

impl Lowered {
    pub(super) fn new(balance: ForceBalance) -> Self {
        match balance.followers.is_empty() && balance.pressure_field.is_none() {
            true => Self::Potential(balance.into_body()),
            false => Self::Balance(balance),
        }
    }

    /// The body; of a balance the part that has a potential.
    pub fn body(&self) -> &Body {
        match self {
            Self::Potential(body) => body,
            Self::Balance(balance) => &balance.body,
        }
    }

    /// The balance of forces to solve.
    pub fn to_solve(&self) -> Balance<'_> {
        match self {
            Self::Potential(body) => body.into(),
            Self::Balance(balance) => balance.into(),
        }
    }

    /// The balance, where there is no potential.
    pub fn balance(&self) -> Option<&ForceBalance> {
        match self {
            Self::Potential(_) => None,
            Self::Balance(balance) => Some(balance),
        }
    }
}

impl Case {
    /// The body of a case that has a potential.
    pub(super) fn potential(&self, lowered: Lowered) -> Result<Body, CaseError> {
        let balance = match lowered {
            Lowered::Potential(body) => return Ok(body),
            Lowered::Balance(balance) => balance,
        };
        let solve = "`sinew solve` and `sinew sample --solve` take it as it is";
        if balance.pressure_field.is_some() {
            let reason = format!(
                "mixed elements have no potential, by which emulators learn and answers are refined; {solve}; for other commands \
                 write formulation = \"averaged\" or \"quadratic\""
            );
            return Err(self.source.error(&["formulation"], reason));
        }
        let number = self.loads.iter().position(|load| load.rim.is_some()).unwrap_or_default();
        let reason = format!(
            "a pressure whose rim moves freely has no potential, by which emulators learn and answers are refined; {solve}; for \
             other commands hold the rim, or write a `traction`"
        );
        Err(self.source.error(&["loads", &number.to_string(), "rim"], reason))
    }

    /// Refuses pressures without a potential whose loads do not say that their rim is loose.
    pub(super) fn check_rims(&self, balance: &ForceBalance) -> Result<(), CaseError> {
        let mesh = &balance.body.mesh;
        for (number, load) in self.loads.iter().enumerate() {
            let (None, Some(_), Some(name)) = (load.rim, &load.pressure, &load.facets) else {
                continue;
            };
            let facets = mesh.facet_sets().get(name).into_iter().flatten();
            let nodes: Vec<usize> = facets.flat_map(|&f| mesh.nodes_of_facet(f)).collect();
            if balance.followers.iter().any(|follower| follower.nodes == nodes) {
                let reason = format!(
                    "the rim of `{name}` moves freely; hold it, close the surface, or {LOOSE}"
                );
                return Err(self.source.error(&["loads", &number.to_string()], reason));
            }
        }
        Ok(())
    }

    /// Whether pressures without a potential are let through to [`Case::check_rims`].
    pub(super) fn allows_loose_rims(&self, formulation: Formulation) -> bool {
        formulation == Formulation::Mixed || self.loads.iter().any(|load| load.rim.is_some())
    }
}

/// Advice about a pressure whose rim moves freely.
pub(super) const LOOSE: &str = "write rim = \"loose\" beside the pressure: the body is then solved by a balance of forces, \
                                and no emulator is trained on it";

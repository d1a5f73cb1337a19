//! The benchmarks, one file each.

mod beam;
mod beam_fixture;
mod cook;
mod cook_linear;
mod cylinder;
mod elastica;
mod homogeneous;
mod land_bar;
mod land_ventricle;
mod limit_point;
mod manufactured;
mod patch;
mod radial;
mod shear;
mod sphere;
mod sphere_locking;
mod stretch;

use crate::case::Case;

/// All benchmarks, in the order of the report.
pub fn all() -> Vec<Box<dyn Case>> {
    vec![
        Box::new(patch::Patch),
        Box::new(shear::Shear),
        Box::new(stretch::Stretch),
        Box::new(manufactured::Compressible),
        Box::new(manufactured::Incompressible),
        Box::new(beam_fixture::BeamFixture),
        Box::new(beam::Beam),
        Box::new(elastica::SlenderCantilever),
        Box::new(cook::Cook),
        Box::new(cook_linear::CookLinear),
        Box::new(sphere::Sphere),
        Box::new(sphere_locking::SphereLocking),
        Box::new(limit_point::SphereLimitPoint),
        Box::new(cylinder::Cylinder),
        Box::new(land_bar::LandBar),
        Box::new(land_ventricle::LandVentricle),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Effort;
    use crate::run::run;
    use std::collections::BTreeSet;

    #[test]
    fn cases_have_names_of_their_own_and_say_where_references_come_from() {
        let cases = all();
        let names: BTreeSet<_> = cases.iter().map(|case| case.name()).collect();
        assert_eq!(names.len(), cases.len());
        for case in &cases {
            assert!(
                case.name()
                    .chars()
                    .all(|c| c.is_ascii_lowercase() || c == '-' || c.is_ascii_digit())
            );
            assert!(!case.title().is_empty() && !case.provenance().is_empty());
        }
    }

    /// The cheap cases, as they run under `--quick`.
    #[test]
    fn cheap_cases_pass() {
        for name in ["patch", "shear", "beam-fixture", "elastica"] {
            let cases = all();
            let case = cases.iter().find(|case| case.name() == name).expect(name);
            let outcome = run(case.as_ref(), Effort::Quick, &mut |_| ());
            assert!(outcome.passes(), "{}", crate::table(&outcome));
        }
    }
}

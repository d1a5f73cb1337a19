//! The benchmarks, by geometry.

mod beam;
mod boxes;
mod cook;
mod elastica;
mod homogeneous;
mod land;
mod manufactured;
mod patch;
mod shells;
mod stretch;

use crate::verify::case::Case;

/// All benchmarks, in the order of the report.
pub static ALL: [Case; 17] = [
    patch::CASE,
    stretch::SHEAR,
    stretch::CASE,
    manufactured::COMPRESSIBLE,
    manufactured::INCOMPRESSIBLE,
    beam::CASE,
    beam::CONTINUUM,
    elastica::CASE,
    cook::CASE,
    cook::SMALL,
    shells::SPHERE,
    shells::LOCKING,
    shells::LIMIT_POINT,
    shells::CYLINDER,
    land::BAR,
    land::VENTRICLE,
    land::ACTIVE,
];

/// The case of a name.
pub fn find(name: &str) -> Option<&'static Case> {
    ALL.iter().find(|case| case.name == name)
}

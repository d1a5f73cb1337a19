//! The benchmarks, one file each.

mod beam;
mod beam_fixture;
mod boxes;
mod cook;
mod cylinder;
mod elastica;
mod homogeneous;
mod land_active;
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

use crate::verify::case::Case;

/// All benchmarks, in the order of the report.
pub static ALL: [Case; 17] = [
    patch::CASE,
    shear::CASE,
    stretch::CASE,
    manufactured::COMPRESSIBLE,
    manufactured::INCOMPRESSIBLE,
    beam_fixture::CASE,
    beam::CASE,
    elastica::CASE,
    cook::CASE,
    cook::SMALL,
    sphere::CASE,
    sphere_locking::CASE,
    limit_point::CASE,
    cylinder::CASE,
    land_bar::CASE,
    land_ventricle::CASE,
    land_active::CASE,
];

/// The case of a name.
pub fn find(name: &str) -> Option<&'static Case> {
    ALL.iter().find(|case| case.name == name)
}

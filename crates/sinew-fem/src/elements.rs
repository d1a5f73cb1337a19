//! Cells, assembly and the discrete system: residual, stiffness, supports.

pub(crate) mod assembled;
pub(crate) mod assembly;
pub(crate) mod cell;
pub(crate) mod check;
pub(crate) mod convex;
pub(crate) mod patch;
pub(crate) mod predicted;
pub(crate) mod pressure_field;
pub(crate) mod system;

pub(crate) use assembled::{Assembly, PointState, add_product, at_points, mean_stress};
pub(crate) use cell::{
    NodalBlocks, Rounding, add_pressure, add_stiffness, complete, inverse, is_short, product,
    tangent_times, turn, turn_square, volume_ratios_along,
};
pub(crate) use check::{
    State, check_fields, check_length, check_potential, check_pressure, check_state, inadmissible,
    load_gradient, worst_cells,
};
pub(crate) use convex::make_convex;
pub(crate) use patch::PatchResponse;
pub(crate) use predicted::{
    PredictedStress, bulk_to_shear, is_nearly_incompressible, replace_stress,
};
pub(crate) use pressure_field::Coupling;
pub(crate) use system::{Followers, Residual, System, Unknowns, held_part, is_moved_rim, place};

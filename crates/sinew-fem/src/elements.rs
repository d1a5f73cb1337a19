//! Cells, assembly and the discrete system: residual, stiffness, supports.

pub(crate) mod assembly;
pub(crate) mod cell;
pub(crate) mod check;
pub(crate) mod followers;
pub(crate) mod moduli;
pub(crate) mod patch;
pub(crate) mod predicted;
pub(crate) mod pressure_field;
pub(crate) mod replaced;
pub(crate) mod shares;
pub(crate) mod state;
pub(crate) mod supports;
pub(crate) mod system;

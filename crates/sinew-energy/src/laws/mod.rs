//! The laws, one file each.

mod neo_hookean;

pub use neo_hookean::NeoHookean;

//! Finite-element Newton solver for hyperelastic bodies

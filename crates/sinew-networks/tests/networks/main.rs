//! Recipes that train networks, damaged and resumed runs.

mod damage;
mod devices;
mod keeping;
mod recipes;
mod support;
mod trust;

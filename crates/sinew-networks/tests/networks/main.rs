//! Recipes that train networks, populations, damaged and resumed runs.

mod damage;
mod devices;
mod keeping;
mod population;
mod recipes;
mod support;
mod trust;

//! Readers, writers, generators and selections; damaged files.

#[path = "../../../../fixtures/organ/ventricles.rs"]
mod ventricles;

mod abaqus;
mod carp;
mod chambers;
mod damage;
mod fixtures;
mod left_out;
mod legacy;
mod modes;
mod mutations;
mod organs;
mod population;
mod refusals;
mod regions;
mod round_trip;
mod selection;
mod surfaces;
mod unread;
mod writers;

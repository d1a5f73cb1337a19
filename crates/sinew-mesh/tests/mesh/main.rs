//! Readers, writers, generators and selections; damaged files.

#[path = "../../../../fixtures/organ/ventricles.rs"]
mod ventricles;

mod abaqus;
mod chambers;
mod damage;
mod fixtures;
mod left_out;
mod modes;
mod mutations;
mod organs;
mod population;
mod refusals;
mod round_trip;
mod selection;
mod surfaces;
mod unread;

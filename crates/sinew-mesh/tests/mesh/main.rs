//! Cells, generators, readers, writers and selections; damaged files.

#[path = "../../../../fixtures/solids/carp.rs"]
mod carp_files;
#[path = "../../../../fixtures/solids/distort.rs"]
mod distort;
#[path = "../../../../fixtures/solids/membrane.rs"]
mod membrane;
#[path = "../../../../fixtures/solids/shells.rs"]
mod shells;
#[path = "../../../../fixtures/organ/ventricles.rs"]
mod ventricles;

mod abaqus;
mod arrays;
mod boundaries;
mod carp;
mod cells;
mod chambers;
mod damage;
mod fixtures;
mod grids;
mod implicit;
mod left_out;
mod legacy;
mod middle_nodes;
mod mixed;
mod mutations;
mod named;
mod organs;
mod refusals;
mod regions;
mod round_trip;
mod selection;
mod surfaces;
mod unread;
mod writers;

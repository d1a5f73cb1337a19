//! The program and its library: case files, mistakes of newcomers, answers, pages, patients.

#[path = "../../../../fixtures/solids/carp.rs"]
mod carp_files;
#[path = "../../../sinew-mesh/tests/mesh/damage.rs"]
mod damage;
#[path = "../../../../fixtures/solids/shells.rs"]
mod shells;

mod answers;
mod campaigns;
mod case_files;
mod command_lines;
mod damaged_cases;
mod directions;
mod doubts;
mod four_chambers;
mod images;
mod keys;
mod land;
mod locking;
#[cfg(feature = "networks")]
mod networks;
mod newcomer;
mod organs;
mod page_numbers;
mod patient_runs;
mod patients;
mod posteriors_of_runs;
mod program;
mod readers;
mod runs;
mod runs_elsewhere;
mod selections;
mod serve;
mod spelling;
mod thetas;
mod viewer;

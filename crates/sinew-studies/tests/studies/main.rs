//! Quick runs of the studies: the same code as the full ones, on small meshes with few steps; the benchmarks' references against each other.

#[path = "../../../../fixtures/solids/distort.rs"]
mod distort;

mod beams;
mod coverage;
mod ecdf;
mod gp;
mod modes;
mod organs;
mod populations;
mod references;
mod shapes;
mod thesis;
mod thesis_figures;
mod ventricle_shape;
mod verify;

// Names that files of the studies take from their crate, where they are compiled into this program.
use sinew_studies::program;

/// The section of a name.
fn section<'r>(report: &'r sinew_report::Report, name: &str) -> &'r sinew_report::Section {
    report.sections.iter().find(|section| section.name == name).expect("a section of that name")
}

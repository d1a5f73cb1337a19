//! Linker flags for macOS, where a library that Python loads leaves Python's own names open.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}

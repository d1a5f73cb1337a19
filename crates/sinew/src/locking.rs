//! Cells that are too stiff, in the words of a case file.

use sinew_fem::LockingWarning;

/// Text of a warning of [`sinew_fem::locking`] for the author of a case file: how much of the displacement is expected
/// to be lost, why, and which key cures it.
///
/// ```
/// use sinew::{Case, locking_in_words};
///
/// let case = Case::parse(sinew::scenes::SCENES[0].text, "beam.toml")?;
/// let warning = sinew_fem::locking_at_centre(&case.body()?)?.expect("linear tetrahedra lock");
/// assert!(locking_in_words(&warning).contains("formulation = \"quadratic\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn locking_in_words(warning: &LockingWarning) -> String {
    let cure = match (warning.element.corners, warning.bulk_to_shear) {
        (8, Some(_)) => "write formulation = \"averaged\" in the case file",
        (8, None) => {
            "divide the body more finely, or take tetrahedra with formulation = \"quadratic\""
        }
        _ => "write formulation = \"quadratic\" in the case file",
    };
    format!("{}; {cure}; `sinew solve --check-mesh` measures what is lost", warning.reason())
}

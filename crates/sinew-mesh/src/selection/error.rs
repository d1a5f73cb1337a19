//! Selections that choose nothing or make no sense.

/// Errors of selections.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SelectionError {
    /// No node is chosen.
    #[error("`{name}` holds nothing: {found}")]
    Empty { name: String, found: String },
    /// A direction without length, or not finite.
    #[error("[{}, {}, {}] is not a direction; give one of some length, such as [0, 0, 1]", direction[0], direction[1], direction[2])]
    Direction { direction: [f64; 3] },
    /// A point that is not finite.
    #[error("[{}, {}, {}] is not a point; give finite coordinates", point[0], point[1], point[2])]
    Point { point: [f64; 3] },
    /// A distance that is negative or not finite.
    #[error("{what} is {value}; give a number that is not negative")]
    Distance { what: &'static str, value: f64 },
    /// An angle that is not between 0 and 180 degrees.
    #[error("{degrees} is not an angle between normals; give 0 to 180 degrees")]
    Angle { degrees: f64 },
    /// A box whose corners are in the wrong order.
    #[error(
        "along {} the box goes from {least} to {most}; give the smaller corner first",
        ["x", "y", "z"][*axis]
    )]
    Corners { axis: usize, least: f64, most: f64 },
    /// A set that the mesh does not have.
    #[error("the mesh has neither node set nor facet set `{name}`, only {}", known.join(", "))]
    UnknownSet { name: String, known: Vec<String> },
    /// Cells that the mesh does not have, with those that it has.
    #[error("the mesh has no set of cells `{name}`, only {}", known.join(", "))]
    UnknownCells { name: String, known: Vec<String> },
    /// A combination of nothing.
    #[error("a combination of no selections; give at least one")]
    NoSelections,
    /// A surface without triangles.
    #[error("a surface without triangles; give one that has some")]
    EmptySurface,
    /// A mesh without cells, or one that breaks its own rules.
    #[error(transparent)]
    Defect(#[from] crate::Defect),
}

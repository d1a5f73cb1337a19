//! How the wall of a chamber is meshed.

/// How a wall is meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallOptions {
    /// How fine.
    pub size: Size,
    /// Layers of cells; where left out as many as make cells about as thick as wide, two at least.
    pub layers: Option<usize>,
    /// Base.
    pub trim: Trim,
}

impl Default for WallOptions {
    fn default() -> Self {
        Self { size: Size::Nodes(1500), layers: None, trim: Trim::Auto }
    }
}

/// How fine a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// About this many nodes.
    Nodes(usize),
    /// Edges about this long \[length\].
    Edge(f64),
}

/// Base of a ventricle: cells beyond it are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trim {
    /// The highest plane across the axis that is below the rims of the endocardium (its valves) and cuts a wall of at least
    /// half of its median thickness; the plane of the rims where they lie in one that is such.
    Auto,
    /// The plane across the axis at this fraction of the way from the apex to the middle of the rims.
    Fraction(f64),
    /// A plane.
    Plane {
        /// A point of it \[length\].
        point: [f64; 3],
        /// Its normal, either way round.
        normal: [f64; 3],
    },
}

//! Options for the mesh of a chamber's wall.

/// Options for the mesh of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallOptions {
    /// Fineness of the mesh.
    pub size: Size,
    /// Layers of cells; by default as many as make cells about as thick as wide, but at least two.
    pub layers: Option<usize>,
    /// Base.
    pub trim: Trim,
}

impl Default for WallOptions {
    fn default() -> Self {
        Self { size: Size::Nodes(1500), layers: None, trim: Trim::Auto }
    }
}

/// Fineness of a mesh, by its nodes or by its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Approximate number of nodes.
    Nodes(usize),
    /// Edges about this long \[length\].
    Edge(f64),
}

/// Base of a ventricle: cells beyond it are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trim {
    /// The highest plane normal to the axis that is below the rims of the endocardium (its valves) and cuts a wall of
    /// at least half its median thickness; the plane of the rims itself if they are plane and it does.
    Auto,
    /// The plane across the axis at this fraction of the way from the apex to the middle of the rims.
    Fraction(f64),
    /// A plane.
    Plane {
        /// A point of it \[length\].
        point: [f64; 3],
        /// Normal of the plane, either way round.
        normal: [f64; 3],
    },
}

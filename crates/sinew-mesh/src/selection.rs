//! Sets of nodes and facets by where they are: planes, boxes, spheres, directions, surfaces, and combinations of them.

mod places;

use crate::tree::SurfaceTree;
use crate::{Mesh, Refusal, TriangleMesh};
use nalgebra::Vector3;
use places::Places;
use std::fmt;
use std::sync::Arc;

/// A choice of nodes and facets by where they are. Lengths are in the unit of the mesh.
///
/// Nodes are chosen by their position. Facets of the boundary are chosen where all their nodes are and, after
/// [`Selection::Facing`], by their normal; then the nodes are those of the chosen facets.
///
/// ```
/// use sinew_mesh::{Selection, box_tetrahedra};
///
/// // A beam whose left end is held, and pressed on the half of its top beyond the middle.
/// let mut beam = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
/// let end = beam.select("end", &Selection::plane([0.0; 3], [1.0, 0.0, 0.0]))?;
/// assert_eq!((end.nodes, end.facets), (9, 8));
/// let top = Selection::Facing([0.0, 0.0, 1.0], 10.0);
/// let half = beam.select("half", &top.and(Selection::HalfSpace([2.0, 0.0, 0.0], [1.0, 0.0, 0.0])))?;
/// assert_eq!((half.facets, beam.facet_sets["half"].len()), (16, 16));
///
/// // An empty selection is an error that says how near the nearest node comes.
/// let error = beam.select("far", &Selection::Sphere([0.0, 0.0, 3.0], 1.0)).unwrap_err();
/// assert!(error.to_string().contains("misses it by 1"), "{error}");
/// # Ok::<(), sinew_mesh::Refusal>(())
/// ```
#[derive(Clone, Debug)]
pub enum Selection {
    /// Within a distance \[length\] of a plane through a point with a normal, on either side.
    Plane([f64; 3], [f64; 3], f64),
    /// Points on the side of a plane through a point that a direction, its normal, points to, with the plane itself.
    HalfSpace([f64; 3], [f64; 3]),
    /// Points in a box along the axes, between its least and its largest corner.
    Box([f64; 3], [f64; 3]),
    /// Points in a ball, by centre and radius \[length\].
    Sphere([f64; 3], f64),
    /// Facets of the boundary whose outward normal is at most so many degrees from a direction.
    Facing([f64; 3], f64),
    /// [`Selection::near`].
    Near(Surfaces, f64),
    /// [`Selection::nearer`].
    Nearer(Surfaces, Surfaces),
    /// The node nearest to a point; several if they are as near.
    Nearest([f64; 3]),
    /// Members of a node set or a facet set that the mesh has.
    Set(String),
    /// [`Selection::between`].
    Between([String; 2]),
    /// Intersection.
    All(Vec<Selection>),
    /// Union.
    Any(Vec<Selection>),
    /// All the others: each node and each facet of the boundary is in a selection or in its opposite.
    Not(Box<Selection>),
}

/// Surfaces that points are near to.
#[derive(Clone)]
pub struct Surfaces(Arc<Vec<SurfaceTree>>);

impl fmt::Debug for Surfaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} surfaces", self.0.len())
    }
}

impl Surfaces {
    fn of<'s>(surfaces: impl IntoIterator<Item = &'s TriangleMesh>) -> Self {
        Self(Arc::new(surfaces.into_iter().map(SurfaceTree::new).collect()))
    }

    fn distance(&self, point: Vector3<f64>) -> f64 {
        self.0.iter().map(|tree| tree.distance(point)).fold(f64::INFINITY, f64::min)
    }
}

/// Numbers of nodes and facets that were chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selected {
    /// Nodes of the set.
    pub nodes: usize,
    /// Facets of the boundary in the set; a selection inside the body has none.
    pub facets: usize,
}

impl Selection {
    /// Points on a plane, within [`crate::SELECTION_TOLERANCE`].
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self::Plane(point, normal, 0.0)
    }

    /// Within a distance of a surface.
    pub fn near(surface: &TriangleMesh, within: f64) -> Self {
        Self::Near(Surfaces::of([surface]), within)
    }

    /// Nearer to a surface than to any of the others, such as to an endocardium than to the epicardium.
    pub fn nearer<'s>(
        surface: &TriangleMesh,
        others: impl IntoIterator<Item = &'s TriangleMesh>,
    ) -> Self {
        Self::Nearer(Surfaces::of([surface]), Surfaces::of(others))
    }

    /// Members of a node set or a facet set that the mesh has.
    pub fn set(name: impl Into<String>) -> Self {
        Self::Set(name.into())
    }

    /// Facets between the cells of two regions, each a set or label that [`Mesh::cells_of`] knows; those of the first, where the
    /// mesh has both. They stay known where [`Mesh::keep`] cuts one of the two away. With `"outside"` in the place of a region: facets
    /// of the other that have no cell behind, nor had one before a cut.
    ///
    /// ```
    /// use sinew_mesh::{Field, Selection, box_tetrahedra};
    ///
    /// let mut bar = box_tetrahedra([3.0, 1.0, 1.0], [3, 1, 1]);
    /// bar.cell_fields.insert("region".into(), Field::labels((0..18).map(|cell| cell / 6).collect()));
    /// bar.keep(&["region:1"])?;
    /// assert_eq!(bar.select("left", &Selection::between("region:1", "region:0"))?.facets, 2);
    /// assert_eq!(bar.select("free", &Selection::between("region:1", "outside"))?.facets, 8);
    /// # Ok::<(), sinew_mesh::Refusal>(())
    /// ```
    pub fn between(one: impl Into<String>, other: impl Into<String>) -> Self {
        Self::Between([one.into(), other.into()])
    }

    /// Intersection of this and the other.
    pub fn and(self, other: Self) -> Self {
        match self {
            Self::All(mut all) => {
                all.push(other);
                Self::All(all)
            }
            one => Self::All(vec![one, other]),
        }
    }

    /// Pairs of regions that it names.
    fn interfaces(&self) -> Vec<&[String; 2]> {
        match self {
            Self::Between(regions) => vec![regions],
            Self::All(all) | Self::Any(all) => all.iter().flat_map(Self::interfaces).collect(),
            Self::Not(inner) => inner.interfaces(),
            _ => Vec::new(),
        }
    }

    /// Whether normals decide, so that nodes inside the body do not belong.
    fn reads_normals(&self) -> bool {
        match self {
            Self::Facing(..) => true,
            Self::All(all) | Self::Any(all) => all.iter().any(Self::reads_normals),
            Self::Not(inner) => inner.reads_normals(),
            _ => false,
        }
    }
}

impl<const N: usize> Mesh<N> {
    /// Names the nodes and the facets that a selection chooses, in place of sets of that name: facets of the boundary, and inner ones
    /// of [`Selection::between`].
    ///
    /// # Errors
    /// A selection without nodes, which says how near the nearest came; lengths, directions and sets that make no sense.
    pub fn select(&mut self, name: &str, choice: &Selection) -> Result<Selected, Refusal> {
        let places = Places::new(self, choice)?;
        let (nodes, facets) = (places.nodes(choice)?, places.facets(choice)?);
        if nodes.is_empty() {
            let found = places.explain(choice)?;
            return Err(Refusal(format!("`{name}` holds nothing: {found}")));
        }
        let selected = Selected { nodes: nodes.len(), facets: facets.len() };
        self.node_sets.insert(name.into(), nodes);
        self.facet_sets.insert(name.into(), facets);
        Ok(selected)
    }
}

/// Names that a mesh has, behind one that it has not.
pub(crate) fn others(known: &[String]) -> String {
    if known.is_empty() { ", and no other".into() } else { format!(", only {}", known.join(", ")) }
}

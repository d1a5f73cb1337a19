//! The choice between a factor and conjugate gradients.

/// Method for the linear systems of a body with a potential, while Newton's method searches for its minimum.
///
/// Both meet the same accuracy of equilibria. The factor counts negative eigenvalues of each stiffness; conjugate gradients leave that to one
/// factor at the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// [`Method::Aggregation`] where the factor has more than 500 entries per unknown, as in compact bodies of some 15 000 nodes, else [`Method::Factor`].
    #[default]
    Automatic,
    /// A sparse Cholesky factor of each stiffness.
    Factor,
    /// Conjugate gradients preconditioned by smoothed aggregation, no more accurate than each Newton step needs (Eisenstat–Walker). A search whose systems
    /// take too many iterations goes on with factors. Bodies without a potential are always factorised.
    #[doc(alias("algebraic multigrid", "AMG", "conjugate gradients"))]
    Aggregation,
}

/// Most entries of a factor \[per unknown\] where it is faster.
const DENSE: usize = 500;
/// Most entries of a factor in single precision: 2 GB.
pub(crate) const MOST_SINGLE: usize = 500_000_000;
/// Most entries of one that is computed at every solution: with 100 000 nodes it would take a quarter of the time and half as much memory again.
pub(crate) const MOST_COUNTED: usize = 250_000_000;

impl Method {
    /// The method for a body whose factor has so many entries.
    pub(crate) fn chosen(self, has_potential: bool, entries: usize, unknowns: usize) -> Self {
        match self {
            _ if !has_potential => Self::Factor,
            Self::Automatic if entries > DENSE * unknowns => Self::Aggregation,
            Self::Automatic => Self::Factor,
            forced => forced,
        }
    }
}

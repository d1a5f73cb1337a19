//! The choice between a factor and conjugate gradients.

/// Method for the linear systems of a body with a potential, while Newton's method searches for its minimum.
///
/// Both meet the same accuracy of equilibria. The factor counts negative eigenvalues of each stiffness; conjugate gradients leave that to one
/// factor at the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// [`Method::Aggregation`] for compact bodies from some 9000 nodes on: 20 000 unknowns, and a factor of more than 400 entries per unknown. Slender
    /// bodies, whose factors are cheap, and those with K/μ above 3000 at rest take [`Method::Factor`].
    #[default]
    Automatic,
    /// A sparse Cholesky factor of each stiffness.
    Factor,
    /// Conjugate gradients preconditioned by smoothed aggregation, no more accurate than each Newton step needs (Eisenstat–Walker). A search whose systems
    /// take too many iterations goes on with factors of up to 4 GB, and fails where they take more ([`crate::Advice::FactorTooLarge`]). Bodies without a potential
    /// are always factorised.
    #[doc(alias("algebraic multigrid", "AMG", "conjugate gradients"))]
    Aggregation,
}

/// Most unknowns where a factor is faster, and its most entries \[per unknown\] there. Seconds by factors and by aggregation: 4.2 and 10.4 for a slender beam of 19 649
/// nodes and 228 entries per unknown, 3.0 and 3.6 for a beam of 10 332 and 558, 5.0 and 2.7 for a ventricle of 9005 and 415.
const SMALL: usize = 20_000;
const SPARSE: usize = 400;
/// Largest K/μ at rest with less than [`crate::linear::aggregation::MOST_ITERATIONS`] iterations.
const MOST_BULK_TO_SHEAR: f64 = 3e3;
/// Most entries of a factor that is taken unasked: 2 GB in single, 4 in double precision.
pub(crate) const MOST_SINGLE: usize = 500_000_000;
/// Most entries of one that is computed at every solution: with 100 000 nodes it would take a quarter of the time and half as much memory again.
pub(crate) const MOST_COUNTED: usize = 250_000_000;

impl Method {
    /// The method for a body whose factor has so many entries.
    pub(crate) fn chosen(
        self,
        has_potential: bool,
        bulk_to_shear: Option<f64>,
        [entries, unknowns]: [usize; 2],
    ) -> Self {
        let large = unknowns > SMALL && entries > SPARSE * unknowns;
        let stiff = bulk_to_shear.is_some_and(|ratio| ratio > MOST_BULK_TO_SHEAR);
        match self {
            _ if !has_potential => Self::Factor,
            Self::Automatic if large && !stiff => Self::Aggregation,
            Self::Automatic => Self::Factor,
            forced => forced,
        }
    }
}

//! Row indices, their inverses, and plans that say which source rows meet in which row.

use sinew_num::cells_of_nodes;
use std::sync::Arc;

/// Targets that entries refer to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Index {
    /// Target of each entry.
    pub targets: Vec<u32>,
    /// Entries that refer to each target, in ascending order.
    pub inverse: Vec<Vec<usize>>,
}

impl Index {
    /// Index of targets below `count`.
    pub(crate) fn new(targets: &[usize], count: usize) -> Self {
        assert!(u32::try_from(count).is_ok(), "{count} nodes do not fit 32-bit indices");
        let inverse = cells_of_nodes(count, targets.iter().map(|&target| [target]));
        Self { targets: targets.iter().map(|&target| target as u32).collect(), inverse }
    }
}

/// Row of the source that each row of the result reads.
#[derive(Clone, Debug)]
pub(crate) enum Gather {
    /// Row `r` reads row `r`.
    Identity,
    /// Row `r` reads row `r mod period`, as in a source repeated as a whole.
    Cyclic { period: usize },
    /// Row `r` reads row `r / times`, as in a source whose rows are each repeated.
    Repeated { times: usize },
    /// Row `r` reads the row that it refers to.
    Indexed(Index),
}

/// Says, for several sources, which of their rows meet in which row of a result.
///
/// Row `r` of the result is the sum over the sources of the row that each assigns to `r`. Built
/// once per graph (or per batch size) and shared.
#[derive(Clone, Debug)]
pub struct GatherPlan {
    /// Rows of the result.
    pub(crate) rows: usize,
    /// The rows of each source that are read, and how many it must have.
    pub(crate) sources: Vec<(Gather, usize)>,
}

impl GatherPlan {
    /// `sources` sources of `rows` rows each, read row by row.
    pub fn identity(rows: usize, sources: usize) -> Arc<Self> {
        Arc::new(Self { rows, sources: vec![(Gather::Identity, rows); sources] })
    }

    /// Every pair of an outer and an inner row, the outer slower: row `b · inner + i` reads row
    /// `i` of the first source and row `b` of the second.
    pub fn outer(outer: usize, inner: usize) -> Arc<Self> {
        let inner_gather =
            if outer == 1 { Gather::Identity } else { Gather::Cyclic { period: inner } };
        Arc::new(Self {
            rows: outer * inner,
            sources: vec![(inner_gather, inner), (Gather::Repeated { times: inner }, outer)],
        })
    }

    /// This plan with one more source, of a single row that every row reads.
    pub fn and_shared(&self) -> Arc<Self> {
        let Self { rows, mut sources } = self.clone();
        sources.push((Gather::Repeated { times: rows.max(1) }, 1));
        Arc::new(Self { rows, sources })
    }
}

impl Gather {
    /// Row of the source that `row` reads.
    #[inline(always)]
    pub(crate) fn source(&self, row: usize) -> usize {
        match self {
            Self::Identity => row,
            Self::Cyclic { period } => row % period,
            Self::Repeated { times } => row / times,
            Self::Indexed(index) => index.targets[row] as usize,
        }
    }
}

//! Row indices, their inverses, and plans that say which source rows meet in which row.

use crate::fused::error::IndexError;
use sinew_num::cells_of_nodes;
use std::sync::Arc;

/// Checks that all of `indices` are below `count` and shortens them.
pub(crate) fn check(indices: &[usize], count: usize) -> Result<Vec<u32>, IndexError> {
    let most = indices.len().max(count);
    u32::try_from(most).map_err(|_| IndexError::TooMany(most))?;
    let narrow = |(position, &index): (usize, &usize)| match index < count {
        true => Ok(index as u32),
        false => Err(IndexError::OutOfRange { position, index, count }),
    };
    indices.iter().enumerate().map(narrow).collect()
}

/// Entries that refer to each target, in ascending order.
pub(crate) fn inverse(indices: &[u32], targets: usize) -> Vec<Vec<usize>> {
    cells_of_nodes(targets, indices.iter().map(|&index| [index as usize]))
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
    /// Row `r` reads row `index[r]`; with the [`inverse`] of the index.
    Indexed { index: Vec<u32>, inverse: Vec<Vec<usize>> },
}

/// Says, for several sources, which of their rows meet in which row of a result.
///
/// Row `r` of the result is the sum over the sources of the row that each assigns to `r`. Built
/// once per graph (or per batch size) and shared.
#[derive(Clone, Debug)]
pub struct GatherPlan {
    /// Rows of the result.
    pub(crate) rows: usize,
    pub(crate) sources: Vec<Gather>,
    /// Rows that each source must have.
    pub(crate) source_rows: Vec<usize>,
}

impl GatherPlan {
    /// `sources` sources of `rows` rows each, read row by row.
    pub fn identity(rows: usize, sources: usize) -> Arc<Self> {
        let source_rows = vec![rows; sources];
        Arc::new(Self { rows, sources: vec![Gather::Identity; sources], source_rows })
    }

    /// Every pair of an outer and an inner row, the outer slower: row `b · inner + i` reads row
    /// `i` of the first source and row `b` of the second.
    pub fn outer(outer: usize, inner: usize) -> Arc<Self> {
        let inner_gather =
            if outer == 1 { Gather::Identity } else { Gather::Cyclic { period: inner } };
        Arc::new(Self {
            rows: outer * inner,
            sources: vec![inner_gather, Gather::Repeated { times: inner }],
            source_rows: vec![inner, outer],
        })
    }

    /// This plan with one more source, of a single row that every row reads.
    pub fn and_shared(&self) -> Arc<Self> {
        let Self { rows, mut sources, mut source_rows } = self.clone();
        sources.push(Gather::Repeated { times: rows.max(1) });
        source_rows.push(1);
        Arc::new(Self { rows, sources, source_rows })
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
            Self::Indexed { index, .. } => index[row] as usize,
        }
    }
}

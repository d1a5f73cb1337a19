//! Simulations that the runs of one case share.

use crate::sample::simulate::{Simulations, stored};
use crate::store::identity::{self, Identity};
use crate::{Body, Result};
use std::path::{Path, PathBuf};

/// Folder of complete simulations that runs of one body and one set of samples share. A set gets there by renaming its
/// folder: two runs at once both solve, and the first that ends leaves what later ones read.
pub(crate) struct Shared {
    place: PathBuf,
    body: Identity,
}

impl Shared {
    /// Within a folder, by body and samples.
    pub(crate) fn new(folder: &Path, body: &Body, thetas: &[Vec<f64>]) -> Self {
        let body = identity::of(body);
        let mut key = crc32fast::Hasher::new();
        key.update(format!("{body:?}").as_bytes());
        thetas.iter().flatten().for_each(|value| key.update(&value.to_le_bytes()));
        let place = folder.join(format!("{}-{:08x}", thetas.len(), key.finalize()));
        Self { place, body }
    }

    /// Simulations that another run has solved.
    ///
    /// # Errors
    /// Files that are damaged.
    pub(crate) fn find(&self, thetas: &[Vec<f64>]) -> Result<Option<Simulations>> {
        let (tried, found) = stored(&self.place, &self.body, thetas)?;
        Ok((tried == thetas.len() && tried > 0).then_some(found))
    }

    /// Leaves a run's own folder of simulations, which is whole, to others.
    pub(crate) fn leave(&self, own: &Path) {
        // A failure does no harm: the run keeps its simulations in its own folder.
        let above = self.place.parent().map_or(Ok(()), std::fs::create_dir_all);
        let _ = above.and_then(|()| std::fs::rename(own, &self.place));
    }
}

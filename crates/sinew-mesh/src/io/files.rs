//! Files as bytes, with their names in errors.

use crate::MeshError;
use std::path::Path;

pub(super) fn load(path: &Path) -> Result<(String, Vec<u8>), MeshError> {
    let failed = |source| MeshError::File { path: path.into(), source };
    Ok((path.display().to_string(), std::fs::read(path).map_err(failed)?))
}

pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), MeshError> {
    let failed = |source| MeshError::File { path: path.into(), source };
    std::fs::write(path, bytes).map_err(failed)
}

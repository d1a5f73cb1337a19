//! Backends and their devices.

use burn::tensor::Device;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Where tensors live.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// Burn's own CPU backend, the default.
    #[default]
    Flex,
    /// The deprecated ndarray backend (cargo feature `ndarray`).
    NdArray,
}

impl Backend {
    /// The backend's device, without automatic differentiation.
    ///
    /// # Errors
    /// [`Error::MissingBackend`] if the build does not contain the backend.
    pub fn device(self) -> Result<Device> {
        match self {
            Self::Flex => Ok(Device::flex()),
            #[cfg(feature = "ndarray")]
            Self::NdArray => Ok(Device::ndarray()),
            #[cfg(not(feature = "ndarray"))]
            Self::NdArray => Err(Error::MissingBackend("ndarray")),
        }
    }

    /// The backends of this build.
    pub fn available() -> Vec<Self> {
        [Self::Flex, Self::NdArray].into_iter().filter(|backend| backend.device().is_ok()).collect()
    }
}

#[cfg(all(test, not(feature = "ndarray")))]
mod tests {
    use super::*;

    #[test]
    fn a_missing_backend_says_how_to_get_it() {
        let message = Backend::NdArray.device().err().map(|error| error.to_string());
        assert!(message.is_some_and(|text| text.contains("cargo feature")));
        assert_eq!(Backend::available(), [Backend::Flex]);
    }
}

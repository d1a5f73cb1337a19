//! Backends and their devices.

use crate::error::{Error, Result};
use burn::tensor::Device;
#[cfg(any(feature = "wgpu", feature = "cuda"))]
use burn::tensor::DeviceType;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Backend of tensors. All but the default are compiled in by the cargo feature of their name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// Burn's own CPU backend, the default.
    #[default]
    Flex,
    /// The deprecated ndarray backend.
    NdArray,
    /// A graphics processor by Vulkan, Metal, DirectX or OpenGL.
    Wgpu,
    /// An NVIDIA graphics processor.
    Cuda,
}

impl Backend {
    /// All of them, whether this build contains them or not.
    pub const ALL: [Self; 4] = [Self::Flex, Self::NdArray, Self::Wgpu, Self::Cuda];

    /// Name, which is also that of its cargo feature.
    pub(crate) fn name(self) -> &'static str {
        ["flex", "ndarray", "wgpu", "cuda"][self as usize]
    }

    /// The backend's device, the best one where there are several, without automatic differentiation.
    ///
    /// ```
    /// use sinew_gnn::Backend;
    ///
    /// assert!(Backend::Flex.device().is_ok());
    /// for backend in Backend::ALL {
    ///     match backend.device() {
    ///         Ok(_) => println!("{backend} can be trained on"),
    ///         Err(reason) => println!("{reason}"),
    ///     }
    /// }
    /// ```
    ///
    /// # Errors
    /// [`Error::MissingBackend`] if the build does not contain the backend, [`Error::NoDevice`] if the machine has no
    /// device for it.
    pub fn device(self) -> Result<Device> {
        match self {
            Self::Flex => Ok(Device::flex()),
            #[cfg(feature = "ndarray")]
            #[expect(deprecated, reason = "it is offered as long as Burn has it")]
            Self::NdArray => Ok(Device::ndarray()),
            #[cfg(feature = "wgpu")]
            Self::Wgpu => self.found(DeviceType::Wgpu, Device::wgpu(Default::default())),
            #[cfg(feature = "cuda")]
            Self::Cuda => self.found(DeviceType::Cuda, Device::cuda(0)),
            #[allow(unreachable_patterns)]
            absent => Err(Error::MissingBackend(absent.name())),
        }
    }

    /// The device where the machine has any of its kind: a device that is absent panics when it is first used.
    #[cfg(any(feature = "wgpu", feature = "cuda"))]
    fn found(self, kind: DeviceType, device: Device) -> Result<Device> {
        match Device::enumerate(kind).into_vec().is_empty() {
            false => Ok(device),
            true => Err(Error::NoDevice(self.name())),
        }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let found = Self::ALL.into_iter().find(|backend| backend.name() == text);
        found.ok_or_else(|| {
            format!("`{text}` is not one of {}", Self::ALL.map(Self::name).join(", "))
        })
    }
}

//! Coordinates of the displacement in which a network learns.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use burn::tensor::{Device, Tensor, TensorData};
use serde::{Deserialize, Serialize};

use crate::error::{Result, require_count, require_finite};

/// Displacements as `u = origin + map · output`, in place of one scale per component.
///
/// A potential energy weighs stiff motions a million times heavier than soft ones, so plain outputs
/// learn the soft ones last. With the map `c |K|^(−½)` of the stiffness K at the origin the energy is
/// round in the outputs, and all motions are learned at one pace.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Packed", into = "Packed")]
pub struct OutputBasis {
    origin: Arc<[f64]>,
    map: Arc<[f32]>,
}

impl OutputBasis {
    /// From the displacement of a zero output \[length\] and a symmetric matrix over all degrees of freedom, row
    /// by row [length per unit of output]. Prescribed degrees of freedom are overwritten, whatever the map says.
    ///
    /// # Errors
    /// A matrix that does not fit the origin, or numbers that are not finite.
    pub fn new(origin: Vec<f64>, map: &[f64]) -> Result<Self> {
        require_count("entries of the output map", map.len(), origin.len() * origin.len())?;
        require_finite("the origin of the outputs", &origin)?;
        require_finite("the output map", map)?;
        let map: Vec<f32> = map.iter().map(|&value| value as f32).collect();
        Ok(Self { origin: origin.into(), map: map.into() })
    }

    /// Displacement of a zero output \[length\].
    pub fn origin(&self) -> &[f64] {
        &self.origin
    }

    /// The map's matrix, with the columns of prescribed degrees of freedom set to zero.
    pub(crate) fn matrix(&self, prescribed: &[Option<f64>], device: &Device) -> Tensor<2> {
        let size = self.origin.len();
        let mut map = self.map.to_vec();
        for row in map.chunks_exact_mut(size.max(1)) {
            row.iter_mut()
                .zip(prescribed)
                .filter(|(_, fixed)| fixed.is_some())
                .for_each(|(m, _)| *m = 0.0);
        }
        Tensor::from_data(TensorData::new(map, [size, size]), device)
    }
}

/// How a basis is stored: the map's little-endian bytes in base64.
#[derive(Serialize, Deserialize)]
struct Packed {
    origin: Vec<f64>,
    map: String,
}

impl From<OutputBasis> for Packed {
    fn from(basis: OutputBasis) -> Self {
        let bytes: Vec<u8> = basis.map.iter().flat_map(|value| value.to_le_bytes()).collect();
        Self { origin: basis.origin.to_vec(), map: STANDARD.encode(bytes) }
    }
}

impl TryFrom<Packed> for OutputBasis {
    type Error = String;

    fn try_from(packed: Packed) -> std::result::Result<Self, String> {
        let bytes = STANDARD.decode(packed.map).map_err(|error| format!("output map: {error}"))?;
        let map: Vec<f64> =
            bytes.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b).into()).collect();
        Self::new(packed.origin, &map).map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_basis_survives_storage_bit_for_bit() {
        let map: Vec<f64> = (0..9).map(|i| f64::from(1.0f32 / (i as f32 + 0.7))).collect();
        let basis = OutputBasis::new(vec![0.1, -2.0, 3e-7], &map).unwrap();
        let text = serde_json::to_string(&basis).unwrap();
        assert_eq!(serde_json::from_str::<OutputBasis>(&text).unwrap(), basis);
        assert!(OutputBasis::new(vec![0.0; 3], &map[..8]).is_err());
        assert!(OutputBasis::new(vec![f64::NAN; 3], &map).is_err());
    }
}

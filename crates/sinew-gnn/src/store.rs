//! Surrogates as directories, which appear whole or not at all.

use crate::optimiser::collect;
use crate::{Error, Geometry, GraphNetwork, GraphNetworkConfig, Result, Scales, Surrogate};
use burn::module::Module;
use burn::tensor::{Device, Tensor};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};

/// Version of the surrogate format.
const VERSION: u32 = 4;
const DESCRIPTION: &str = "surrogate.json";
const WEIGHTS: &str = "weights.bpk";

#[derive(Serialize, Deserialize)]
struct Description {
    version: u32,
    config: GraphNetworkConfig,
    scales: Scales,
    geometries: Vec<Geometry>,
    /// Rows of the embeddings that are weights, layer by layer of every geometry.
    embedded_nodes: Vec<Vec<usize>>,
}

impl Surrogate {
    /// Writes a directory that holds all that prediction needs, replacing what is there at once.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, directory: &Path) -> Result<()> {
        replace_directory(directory, |folder| write_surrogate(self, folder))
    }

    /// Reads a directory that [`Surrogate::save`] or a checkpoint wrote.
    ///
    /// # Errors
    /// A file that is missing, damaged or of another version.
    pub fn load(directory: &Path, device: &Device) -> Result<Self> {
        read_surrogate(&open_directory(directory), device)
    }

    /// Name, shape and numbers, row by row, of all weights; a weight is named by its place in the network, as `decoders.0.layers.2.bias`.
    pub fn weights(&self) -> Vec<(String, Vec<usize>, Vec<f64>)> {
        let weights = collect(&self.emulator, None).into_iter();
        let doubled = |values: Vec<f32>| values.into_iter().map(f64::from).collect();
        weights.map(|weight| (weight.name, weight.shape, doubled(weight.gradient))).collect()
    }
}

pub(crate) fn write_surrogate(surrogate: &Surrogate, folder: &Path) -> Result<()> {
    let description = Description {
        version: VERSION,
        config: surrogate.emulator.config.clone(),
        scales: surrogate.scales.clone(),
        geometries: surrogate.geometries.clone(),
        embedded_nodes: surrogate.emulator.embedded_nodes(),
    };
    write_json(&folder.join(DESCRIPTION), &description)?;
    save_weights(&surrogate.emulator, &folder.join(WEIGHTS))
}

pub(crate) fn read_surrogate(folder: &Path, device: &Device) -> Result<Surrogate> {
    let path = folder.join(DESCRIPTION);
    let Description { config, scales, geometries, embedded_nodes, .. } = read_json(&path, VERSION)?;
    let emulator = GraphNetwork::new(&config, 0, device)?;
    let emulator = load_weights(emulator, &embedded_nodes, &folder.join(WEIGHTS))?;
    Surrogate::assemble(emulator, scales, geometries)
}

pub(crate) fn save_weights(emulator: &GraphNetwork, path: &Path) -> Result<()> {
    emulator.valid().save_file(path).map_err(format_error(path))
}

/// The weights in a file, on the device of `emulator`, with embeddings of so many nodes in the layers of every geometry.
pub(crate) fn load_weights(
    emulator: GraphNetwork,
    embedded_nodes: &[Vec<usize>],
    path: &Path,
) -> Result<GraphNetwork> {
    let (width, device) = (2 * emulator.config.latent, emulator.device());
    let blank = |rows: &usize| Tensor::zeros([*rows, width], &device);
    let blank = embedded_nodes.iter().map(|layers| layers.iter().map(blank).collect());
    emulator.with_embeddings(blank.collect()).try_load_file(path).map_err(format_error(path))
}

fn file_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
    move |source| Error::File { path: path.into(), source }
}

fn format_error<E: ToString>(path: &Path) -> impl FnOnce(E) -> Error + '_ {
    move |error| Error::Format { path: path.into(), reason: error.to_string() }
}

fn sibling(directory: &Path, suffix: &str) -> PathBuf {
    let mut name = directory.file_name().unwrap_or_default().to_os_string();
    name.push(suffix);
    directory.with_file_name(name)
}

/// Writes a directory beside its place and then renames it there. Whenever the process is killed,
/// either `directory` or its sibling `….previous` is whole, and [`open_directory`] finds it.
pub(crate) fn replace_directory(
    directory: &Path,
    write: impl FnOnce(&Path) -> Result<()>,
) -> Result<()> {
    let (fresh, previous) = (sibling(directory, ".new"), sibling(directory, ".previous"));
    let remove = |earlier: &Path| match earlier.exists() {
        true => fs::remove_dir_all(earlier).map_err(file_error(earlier)),
        false => Ok(()),
    };
    remove(&fresh)?;
    fs::create_dir_all(&fresh).map_err(file_error(&fresh))?;
    write(&fresh)?;
    if directory.exists() {
        remove(&previous)?;
        fs::rename(directory, &previous).map_err(file_error(directory))?;
    }
    fs::rename(&fresh, directory).map_err(file_error(&fresh))?;
    remove(&previous)
}

/// The directory, or its predecessor if a kill came between the two renames of [`replace_directory`].
pub(crate) fn open_directory(directory: &Path) -> PathBuf {
    let previous = sibling(directory, ".previous");
    if !directory.exists() && previous.exists() { previous } else { directory.into() }
}

pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_vec(value).map_err(std::io::Error::from);
    text.and_then(|text| fs::write(path, text)).map_err(file_error(path))
}

/// Reads a JSON file; its format version is required before the rest of it is interpreted.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path, expected: u32) -> Result<T> {
    #[derive(Deserialize)]
    struct Versioned {
        version: u32,
    }
    let text = fs::read(path).map_err(file_error(path))?;
    let Versioned { version: found } = serde_json::from_slice(&text).map_err(format_error(path))?;
    match found == expected {
        true => serde_json::from_slice(&text).map_err(format_error(path)),
        false => Err(Error::Version { path: path.into(), found, expected }),
    }
}

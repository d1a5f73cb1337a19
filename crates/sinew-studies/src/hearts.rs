//! Surfaces of a person's heart in the frames of a beat, and the wall between them.

use anyhow::Result;
use sinew_mesh::{Chamber, ChamberWall, Size, TriangleMesh, WallOptions, read_mesh};
use std::path::{Path, PathBuf};

/// Frames of the beat.
pub(crate) const FRAMES: [&str; 7] = ["000", "004", "008", "012", "016", "020", "024"];

fn file(folder: &Path, what: &str, frame: &str) -> PathBuf {
    folder.join(format!("patient1_{what}_{frame}.vtk"))
}

/// Whether a folder has the surfaces of a frame.
pub(crate) fn has(folder: &Path, frame: &str) -> bool {
    file(folder, "LV_ENDOCARDIAL", frame).exists()
}

/// Endocardium, epicardium and, where there is one, septum of a left ventricle.
pub(crate) struct Surfaces {
    pub endocardium: TriangleMesh,
    pub epicardium: TriangleMesh,
    pub septum: Option<TriangleMesh>,
}

impl Surfaces {
    /// Surfaces of a frame from their files.
    pub(crate) fn read(folder: &Path, frame: &str) -> Result<Self> {
        let read = |what| read_mesh::<3>(file(folder, what, frame)).map(|read| read.0);
        let (endocardium, epicardium) = (read("LV_ENDOCARDIAL")?, read("EPICARDIAL")?);
        Ok(Self { endocardium, epicardium, septum: Some(read("RV_ENDOCARDIAL")?) })
    }

    /// The wall between them with about so many nodes.
    pub(crate) fn wall(&self, nodes: usize) -> Result<ChamberWall> {
        let Self { endocardium, epicardium, septum } = self;
        let chamber = Chamber { endocardium, epicardium, septum: septum.as_ref() };
        Ok(chamber.wall(&WallOptions { size: Size::Nodes(nodes), ..WallOptions::default() })?)
    }
}

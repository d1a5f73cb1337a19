//! Surfaces of a person's heart in the frames of a beat, and the wall between them.

use anyhow::Result;
use sinew_mesh::{Chamber, ChamberWall, Size, TriangleMesh, WallOptions, read_mesh};
use std::path::{Path, PathBuf};

/// File of a surface of a frame of the beat.
pub(crate) fn file(folder: &Path, what: &str, frame: &str) -> PathBuf {
    folder.join(format!("patient1_{what}_{frame}.vtk"))
}

/// Endocardium, epicardium and, where there is one, septum of a left ventricle.
pub(crate) struct Surfaces {
    pub endocardium: TriangleMesh,
    pub epicardium: TriangleMesh,
    pub septum: Option<TriangleMesh>,
}

impl Surfaces {
    /// Surfaces from their files by name.
    pub(crate) fn read(file: impl Fn(&str) -> PathBuf) -> Result<Self> {
        let read = |what: &str| read_mesh::<3>(file(what)).map(|read| read.0);
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

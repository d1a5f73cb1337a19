//! Surfaces of a person's heart in the frames of a beat, and the wall between them.

use anyhow::Result;
use sinew_mesh::{Chamber, ChamberWall, Size, WallOptions, read_mesh};
use std::path::{Path, PathBuf};

fn file(folder: &Path, what: &str, frame: &str) -> PathBuf {
    folder.join(format!("patient1_{what}_{frame}.vtk"))
}

/// Whether a folder has the surfaces of a frame.
pub(crate) fn has(folder: &Path, frame: &str) -> bool {
    file(folder, "LV_ENDOCARDIAL", frame).exists()
}

/// Frames of the beat whose surfaces a folder has.
pub(crate) fn frames(folder: &Path) -> impl Iterator<Item = &'static str> {
    let all = ["000", "004", "008", "012", "016", "020", "024"];
    all.into_iter().filter(|frame| has(folder, frame))
}

/// The wall of the left ventricle in a frame, with about so many nodes.
pub(crate) fn wall(folder: &Path, frame: &str, nodes: usize) -> Result<ChamberWall> {
    let read = |what| read_mesh::<3>(file(folder, what, frame)).map(|read| read.0);
    let [endocardium, epicardium, septum] =
        [read("LV_ENDOCARDIAL")?, read("EPICARDIAL")?, read("RV_ENDOCARDIAL")?];
    let chamber =
        Chamber { endocardium: &endocardium, epicardium: &epicardium, septum: Some(&septum) };
    Ok(chamber.wall(&WallOptions { size: Size::Nodes(nodes), ..WallOptions::default() })?)
}

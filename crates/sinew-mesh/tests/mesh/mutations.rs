//! Damaged files: every reader answers with a mesh or an error, never with a panic, and never
//! asks for memory out of proportion to the file.

use crate::damage::damaged;
use crate::legacy::{VtkEncoding, to_vtk};
use proptest::prelude::*;
use sinew_mesh::{Mesh, parse, parse_mesh, parse_npy, to_vtu};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::PathBuf;

/// Most bytes that a single request may ask for while a file of a few kilobytes is read: a
/// zlib array may rightly be a thousand times larger than its file.
const LARGEST_REQUEST: usize = 16 << 20;

/// The system's allocator, which remembers each thread's largest request.
struct Watched;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: all requests are handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.set(LARGEST.get().max(layout.size()));
        // SAFETY: the caller keeps the rules of `GlobalAlloc::alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` comes from `System` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        LARGEST.set(LARGEST.get().max(size));
        // SAFETY: `pointer` comes from `System` with this layout.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;

/// The fixtures with one of the endings.
fn fixtures(endings: &[&str]) -> Vec<Vec<u8>> {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "../../fixtures/mesh"].iter().collect();
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let wanted = |path: &PathBuf| endings.iter().any(|end| path.to_string_lossy().ends_with(end));
    let files: Vec<_> = paths.iter().filter(|path| wanted(path)).collect();
    assert!(files.len() > 3, "no fixtures end with {endings:?}");
    files.into_iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// A mesh that is read from a damaged file is a mesh all the same, and can be written.
fn read_safely(bytes: &[u8]) {
    LARGEST.set(0);
    let answer = parse("damaged", bytes);
    assert!(LARGEST.get() < LARGEST_REQUEST, "asked for {} bytes", LARGEST.get());
    match answer {
        Ok((mesh, _)) => assert_eq!(mesh.check(), Ok(())),
        Err(error) => assert!(error.to_string().starts_with("damaged, "), "{error}"),
    }
}

/// Damaged files tried on each format; together they take about a second.
const CASES: u32 = 10_000;

proptest! {
    #![proptest_config(ProptestConfig { cases: CASES, failure_persistence: None, ..Default::default() })]

    #[test]
    fn damaged_legacy_vtk(bytes in damaged(fixtures(&[".vtk"]))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_vtu(bytes in damaged(fixtures(&[".vtu"]))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_surfaces(bytes in damaged(fixtures(&[".vtp", ".stl"]))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_inp(bytes in damaged(fixtures(&[".inp"]))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_inp_of_keywords(bytes in damaged(shuffled(fixtures(&[".inp"])))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_msh_2(bytes in damaged(fixtures(&["22_ascii.msh", "22_binary.msh"]))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_msh_4(bytes in damaged(fixtures(&["41_ascii.msh", "41_binary.msh"]))) {
        read_safely(&bytes);
    }

    #[test]
    fn damaged_npy(bytes in damaged(fixtures(&[".npy"]))) {
        LARGEST.set(0);
        if let Ok(array) = parse_npy("damaged", &bytes) {
            assert_eq!(array.shape.iter().product::<usize>(), array.values.len());
        }
        assert!(LARGEST.get() < LARGEST_REQUEST);
    }

    #[test]
    fn damaged_files_of_quadratic_tetrahedra(
        bytes in damaged(files_of(&sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]).quadratic()))
    ) {
        read_kind_safely::<10>(&bytes);
    }

    #[test]
    fn damaged_files_of_hexahedra(
        bytes in damaged(files_of(&sinew_mesh::box_hexahedra([1.0; 3], [1; 3])))
    ) {
        read_kind_safely::<8>(&bytes);
    }

    #[test]
    fn damaged_files_of_our_own(bytes in damaged(our_files())) {
        read_safely(&bytes);
    }
}

/// The files and as many with their lines in another order, which a text of keywords survives more often than a flipped bit.
fn shuffled(mut files: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
    for at in 0..files.len() {
        let mut lines: Vec<_> =
            files[at].split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
        let half = lines.len() / 2;
        lines.rotate_left(half);
        files.push(lines.join(&b'\n'));
    }
    files
}

fn our_files() -> Vec<Vec<u8>> {
    let mut mesh = sinew_mesh::box_tetrahedra([1.0; 3], [1; 3]);
    mesh.cell_sets.insert("some".into(), vec![1, 4]);
    files_of(&mesh)
}

fn files_of<const N: usize>(mesh: &Mesh<N>) -> Vec<Vec<u8>> {
    let vtk = |encoding| to_vtk(mesh, encoding);
    vec![vtk(VtkEncoding::Ascii), vtk(VtkEncoding::Binary), to_vtu(mesh).unwrap()]
}

fn read_kind_safely<const N: usize>(bytes: &[u8]) {
    LARGEST.set(0);
    let answer = parse_mesh::<N>("damaged", bytes);
    assert!(LARGEST.get() < LARGEST_REQUEST, "asked for {} bytes", LARGEST.get());
    match answer {
        Ok((mesh, _)) => assert_eq!(mesh.check(), Ok(())),
        Err(error) => assert!(error.to_string().starts_with("damaged, "), "{error}"),
    }
}

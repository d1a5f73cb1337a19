//! Damaged files: every reader answers with a mesh or an error, never with a panic, and never
//! asks for memory out of proportion to the file.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use sinew_mesh::{Mesh, VtkEncoding, parse, parse_mesh, parse_npy, to_vtk, to_vtu};
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

#[derive(Clone, Debug)]
enum Damage {
    Flip(Index, u8),
    Overwrite(Index, Vec<u8>),
    Truncate(Index),
    Remove(Index, usize),
    /// Copies a piece from one place to another.
    Splice(Index, Index, usize),
    /// Replaces a run of digits by another number.
    Number(Index, String),
}

fn damage() -> impl Strategy<Value = Damage> {
    let extremes = prop_oneof![
        Just(i64::MAX.to_be_bytes().to_vec()),
        Just(i64::MAX.to_le_bytes().to_vec()),
        Just(vec![0xff; 8]),
        Just(vec![0; 8]),
        Just(vec![0x7f, 0xff, 0xff, 0xff]),
        vec(any::<u8>(), 1..9),
    ];
    let number = prop_oneof![
        Just("0".to_string()),
        Just("-1".to_string()),
        Just("nan".to_string()),
        Just("inf".to_string()),
        Just("1e400".to_string()),
        Just("4294967295".to_string()),
        Just("9223372036854775807".to_string()),
        Just("18446744073709551615".to_string()),
        Just("99999999999999999999999999".to_string()),
        any::<i32>().prop_map(|n| n.to_string()),
        (0u8..40).prop_map(|n| n.to_string()),
    ];
    let at = any::<Index>;
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(at, bits)| Damage::Flip(at, bits)),
        (at(), extremes).prop_map(|(at, bytes)| Damage::Overwrite(at, bytes)),
        at().prop_map(Damage::Truncate),
        (at(), 1usize..40).prop_map(|(at, length)| Damage::Remove(at, length)),
        (at(), at(), 1usize..200).prop_map(|(from, to, length)| Damage::Splice(from, to, length)),
        (at(), number.clone()).prop_map(|(at, number)| Damage::Number(at, number)),
        (at(), number).prop_map(|(at, number)| Damage::Number(at, number)),
    ]
}

fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    match damage {
        Damage::Flip(at, bits) => bytes[at.index(length)] ^= bits,
        Damage::Overwrite(at, new) => {
            let at = at.index(length);
            bytes[at..].iter_mut().zip(new).for_each(|(byte, &new)| *byte = new);
        }
        Damage::Truncate(at) => bytes.truncate(at.index(length)),
        Damage::Remove(at, count) => {
            let at = at.index(length);
            bytes.drain(at..(at + count).min(length));
        }
        Damage::Splice(from, to, count) => {
            let from = from.index(length);
            let piece = bytes[from..(from + count).min(length)].to_vec();
            let to = to.index(length);
            bytes.splice(to..to, piece);
        }
        Damage::Number(at, number) => {
            let at = at.index(length);
            let is_digit = |byte: &u8| byte.is_ascii_digit();
            let Some(start) = bytes[at..].iter().position(is_digit).map(|n| at + n) else { return };
            let digits = bytes[start..].iter().take_while(|byte| is_digit(byte)).count();
            bytes.splice(start..start + digits, number.bytes());
        }
    }
}

fn damaged(files: Vec<Vec<u8>>) -> impl Strategy<Value = Vec<u8>> {
    (any::<Index>(), vec(damage(), 1..5)).prop_map(move |(file, damages)| {
        let mut bytes = files[file.index(files.len())].clone();
        damages.iter().for_each(|damage| apply(&mut bytes, damage));
        bytes
    })
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
    fn damaged_surfaces(bytes in damaged(fixtures(&[".vtp", ".stl", ".obj"]))) {
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
    let vtk = |encoding| to_vtk(mesh, encoding).unwrap();
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

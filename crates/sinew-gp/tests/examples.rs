//! Runs the examples as a reader would; each asserts its own numbers.

use std::path::PathBuf;
use std::process::Command;

/// Cargo puts examples beside the tests it builds: `deps/this-test` and `examples/name`.
fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a running program has a path");
    let folder = test.ancestors().nth(2).expect("Cargo's folders are nested").join("examples");
    let path = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(path.exists(), "build the examples first: cargo build -p sinew-gp --examples");
    path
}

#[test]
fn examples_keep_their_promises() {
    for name in ["diffusivity", "pentagon", "own_operator", "own_kernel", "stiffening_bed"] {
        let output = Command::new(program(name)).output().expect("the program starts");
        let [printed, complaint] =
            [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
        println!("{name}\n{printed}");
        assert!(output.status.success(), "{name}: {complaint}");
        assert!(printed.contains("error"), "{name} says how far off it is: {printed}");
    }
}

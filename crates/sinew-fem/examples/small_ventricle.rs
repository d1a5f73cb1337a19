//! Writes the ventricle of `fixtures/organ`, by default over itself: `small_ventricle [FILE]`.

#[path = "../tests/fem/support/organ.rs"]
mod organ;

fn main() -> std::io::Result<()> {
    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/organ/ventricle.vtk");
    let path = std::env::args().nth(1).unwrap_or(fixture.into());
    std::fs::write(&path, organ::file())?;
    println!("wrote {path}");
    Ok(())
}

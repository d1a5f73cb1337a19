//! Runnable programs: `cargo run --example NAME`, see the files in `examples/examples`.

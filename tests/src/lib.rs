//! Physics against ground truth across crates; the tests are in `tests/tests`.

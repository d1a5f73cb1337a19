//! Numbers of a page: rows rounded to few bits.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sinew_report::PackedRows;

#[test]
fn integers_of_any_number_of_bits_come_back() {
    let rows = [vec![0.5, -1.0, 0.25, 0.0, 0.9], vec![1e-3, -2e-3, 0.0, 0.0, 5e-4]];
    let mut packed = PackedRows::default();
    let rounded: Vec<_> =
        rows.iter().zip([1e-4, 1e-12]).map(|(row, step)| packed.push(row, step, 44)).collect();
    for ((row, rounded), step) in rows.iter().zip(&rounded).zip([1e-4, 1e-12]) {
        row.iter().zip(rounded).for_each(|(x, y)| assert!((x - y).abs() <= step));
    }
    // As a page reads them.
    let text = serde_json::to_value(packed.packed()).unwrap();
    let decoded = |name: &str| STANDARD.decode(text[name].as_str().unwrap()).unwrap();
    let (steps, bytes) = (decoded("steps"), decoded("integers"));
    let steps = steps.as_chunks::<8>().0.iter().map(|step| f64::from_le_bytes(*step));
    let bits: Vec<u64> = serde_json::from_value(text["bits"].clone()).unwrap();
    assert_eq!((steps.len(), bits.len()), (2, 2));
    let bit = |at: u64| u64::from(bytes[at as usize / 8] >> (at % 8) & 1);
    let mut at = 0;
    for ((bits, step), row) in bits.iter().zip(steps).zip(&rounded) {
        for x in row {
            let integer: u64 = (0..*bits).map(|k| bit(at + k) << k).sum();
            let half = (1u64 << (bits - 1)) - 1;
            assert_eq!((integer as f64 - half as f64) * step, *x);
            at += bits;
        }
    }
    assert!((bytes.len() as u64) * 8 < at + 8);
}

//! Numbers of a page: rows rounded to few bytes.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sinew_report::PackedRow;

#[test]
fn rows_take_as_few_bytes_as_a_step_asks_for() {
    let rows: [&[f64]; 3] = [&[0.5, -1.0, 0.25, 0.0, 0.9], &[1e-3, -2e-3, 0.0], &[0.0, -0.0]];
    for (row, step, most, expected) in [
        (rows[0], 1e-4, 4, 2),
        (rows[0], 0.1, 4, 1),
        (rows[1], 1e-12, 6, 4),
        (rows[0], 1e-15, 7, 7),
        (rows[1], 1e-12, 3, 3),
        (rows[2], 0.0, 4, 1),
    ] {
        let packed = PackedRow::new(row, step, most);
        let text = serde_json::to_value(&packed).unwrap();
        let bytes = STANDARD.decode(text["integers"].as_str().unwrap()).unwrap();
        assert_eq!(bytes.len(), expected * row.len());
        // A row with too few bytes is rounded to what these hold.
        let step = if most == 3 { 2e-3 / 8e6 } else { step };
        let values = packed.values(row.len());
        assert!(values.iter().zip(row).all(|(x, y)| (x - y).abs() <= step), "{values:?}");
    }
}

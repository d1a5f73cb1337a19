//! Colours for values: a scale that reads without colour vision.

/// Viridis (van der Walt and Smith 2015) at equal steps: readable without colour vision.
const COLOURS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];

/// Colour at a position from 0 to 1; NaN and values below 0 are the lowest colour.
pub(crate) fn viridis(position: f64) -> [f64; 3] {
    let last = COLOURS.len() - 1;
    let scaled = position.clamp(0.0, 1.0) * last as f64;
    // `as` turns NaN into 0.
    let below = (scaled as usize).min(last - 1);
    let weight = (scaled - below as f64).max(0.0);
    let mut colour = [0.0; 3];
    for channel in 0..3 {
        let (low, high) = (COLOURS[below][channel], COLOURS[below + 1][channel]);
        colour[channel] = low + weight * (high - low);
    }
    colour
}

/// As CSS writes it.
pub(crate) fn hex([red, green, blue]: [f64; 3]) -> String {
    format!("#{:02x}{:02x}{:02x}", red.round() as u8, green.round() as u8, blue.round() as u8)
}

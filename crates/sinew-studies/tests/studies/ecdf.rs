//! Bands of empirical distribution functions.

use bands::{EcdfBand, RankEcdf};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Deserialize;

/// The file behind reports of posteriors, which hold whether a band is left alone.
#[path = "../../src/calibration/ecdf.rs"]
#[allow(dead_code)]
mod bands;

#[derive(Deserialize)]
struct Fixture {
    bands: Vec<Band>,
}

#[derive(Deserialize)]
struct Band {
    count: u64,
    points: usize,
    lower: Vec<u64>,
    upper: Vec<u64>,
}

#[test]
fn bands_are_those_of_arviz_but_for_a_count() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/chains/diagnostics.json");
    let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(fixture.bands.len(), 3);
    for stored in fixture.bands {
        let found = EcdfBand::new(stored.count, stored.points, 0.95);
        // Both search for a pointwise probability at which whole counts jump.
        let near = |a: &[u64], b: &[u64]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
        assert!(near(&found.lower, &stored.lower), "{:?} {:?}", found.lower, stored.lower);
        assert!(near(&found.upper, &stored.upper), "{:?} {:?}", found.upper, stored.upper);
    }
}

#[test]
fn a_band_holds_as_often_as_it_says() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let inside = (0..2000).filter(|_| {
        let ranks: Vec<f64> = (0..100).map(|_| random.random()).collect();
        RankEcdf { counts: count(&ranks), band: band() }.inside()
    });
    // Counts are whole numbers, so that the band holds a little more often; 2000 trials have a standard deviation of .5 %.
    let share = inside.count() as f64 / 2000.0;
    assert!((0.94..0.985).contains(&share), "{share}");
    let narrow: Vec<f64> = (0..100).map(|i| 0.25 + 0.5 * f64::from(i) / 100.0).collect();
    assert!(!RankEcdf::new(&narrow, 20, 0.95).inside());
}

fn band() -> EcdfBand {
    static BAND: std::sync::OnceLock<EcdfBand> = std::sync::OnceLock::new();
    BAND.get_or_init(|| EcdfBand::new(100, 20, 0.95)).clone()
}

fn count(ranks: &[f64]) -> Vec<u64> {
    let below = |point: &f64| ranks.iter().filter(|rank| *rank <= point).count() as u64;
    band().points.iter().map(below).collect()
}

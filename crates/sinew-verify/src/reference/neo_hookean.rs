//! Homogeneous states of the compressible neo-Hookean solid of thesis eq. (3.1).

use super::{NoSignChange, root};

/// A stretched bar or sheet with free faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Stretch across the load.
    pub across: f64,
    /// First Piola–Kirchhoff stress along the load \[stress\].
    pub stress: f64,
    /// Energy density \[stress\].
    pub energy: f64,
}

/// A bar stretched along one axis; the other two contract alike.
///
/// # Errors
/// [`NoSignChange`] for stretches or parameters that are not positive.
pub fn uniaxial_bar(shear: f64, lame: f64, stretch: f64) -> Result<Bar, NoSignChange> {
    let pull = |t: f64| principal_stress(shear, lame, t, stretch * t * t);
    let across = root(pull, [1e-3, 1e3])?;
    let stretches = [stretch, across, across];
    Ok(bar(shear, lame, stretches, across))
}

/// A sheet stretched alike along two axes.
///
/// # Errors
/// [`NoSignChange`] for stretches or parameters that are not positive.
pub fn equibiaxial_bar(shear: f64, lame: f64, stretch: f64) -> Result<Bar, NoSignChange> {
    let pull = |t: f64| principal_stress(shear, lame, t, stretch * stretch * t);
    let across = root(pull, [1e-3, 1e3])?;
    Ok(bar(shear, lame, [stretch, stretch, across], across))
}

fn bar(shear: f64, lame: f64, stretches: [f64; 3], across: f64) -> Bar {
    let volume: f64 = stretches.iter().product();
    let excess = stretches.iter().map(|s| s * s).sum::<f64>() - 3.0;
    let energy = 0.5 * lame * volume.ln().powi(2) - shear * volume.ln() + 0.5 * shear * excess;
    Bar { across, stress: principal_stress(shear, lame, stretches[0], volume), energy }
}

/// Piola stress along a principal axis: `μ(s − 1/s) + λ ln J / s`.
fn principal_stress(shear: f64, lame: f64, stretch: f64, volume: f64) -> f64 {
    shear * (stretch - 1.0 / stretch) + lame * volume.ln() / stretch
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_agree_with_the_tabulated_ones() {
        // λ, stretch, lateral stretch, stress, energy where tabulated.
        let table = [
            (1.0, 0.5, 1.172528263277, -2.249645056367, Some(0.444891020184)),
            (1.0, 1.2, 0.954435935785, 0.440876703734, None),
            (1.0, 1.5, 0.898820614885, 0.961414334839, Some(0.259212331299)),
            (1.0, 2.0, 0.827693749013, 1.657461528923, Some(0.919742150491)),
            (10.0, 0.5, 1.356111794362, -3.178078397615, None),
            (10.0, 1.5, 0.829341768748, 1.041461487074, None),
            (10.0, 2.0, 0.724124868242, 1.737821587597, None),
        ];
        for (lame, stretch, across, stress, energy) in table {
            let bar = uniaxial_bar(1.0, lame, stretch).unwrap();
            assert!((bar.across - across).abs() < 1e-12, "{bar:?}");
            assert!((bar.stress - stress).abs() < 1e-11, "{bar:?}");
            assert!(energy.is_none_or(|e| (bar.energy - e).abs() < 1e-12), "{bar:?}");
        }
        for (lame, across, stress) in
            [(1.0, 0.820462440727, 0.782185679505), (10.0, 0.628610386962, 0.996037678003)]
        {
            let sheet = equibiaxial_bar(1.0, lame, 1.3).unwrap();
            assert!((sheet.across - across).abs() < 1e-12, "{sheet:?}");
            assert!((sheet.stress - stress).abs() < 1e-12, "{sheet:?}");
        }
    }
}

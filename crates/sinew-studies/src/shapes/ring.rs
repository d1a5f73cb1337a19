//! Rings of random radius, thickness and form: slices of a vessel or of a heart's wall.

use super::checked::{check_cells, padded};
use anyhow::{Result, ensure};
use sinew_mesh::{Field, TriangleMesh, boundary_facets, repair_orientation};
use std::f64::consts::TAU;

/// A plane ring about the origin between two curves: `ln r` of the inner one and `ln` of the thickness are Fourier series in the angle.
///
/// Numbers of mean zero and variance one make the population: half of them radius and its waves, the others the thickness and its waves,
/// `cos k φ` and `sin k φ` with k up to 7. All zeros are a ring of inner radius 25 and thickness 10 \[length\].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RingShape {
    numbers: [f64; Self::NUMBERS],
}

/// Radius and thickness of the round ring \[length\].
const SIZE: [f64; 2] = [25.0, 10.0];
/// Highest wave.
const WAVES: usize = 7;
/// Deviations of the logarithm of radius and thickness: of their mean, and of each wave.
const DEVIATIONS: [[f64; WAVES + 1]; 2] = [
    [0.15, 0.08, 0.06, 0.045, 0.03, 0.02, 0.015, 0.01],
    [0.2, 0.12, 0.09, 0.06, 0.045, 0.03, 0.02, 0.015],
];
/// Ranges of a population \[length\].
const RADIUS: [f64; 2] = [12.0, 50.0];
const THICKNESS: [f64; 2] = [4.0, 25.0];

impl RingShape {
    /// Numbers of a shape.
    pub(crate) const NUMBERS: usize = 2 * (2 * WAVES + 1);

    /// Shape of at most [`Self::NUMBERS`] numbers; those left out are zero.
    pub(crate) fn new(numbers: &[f64]) -> Result<Self> {
        let shape = Self { numbers: padded(numbers)? };
        for k in 0..8 * WAVES {
            let [radius, thickness] = shape.measures(k as f64 / (8 * WAVES) as f64 * TAU);
            within("inner radius", radius, RADIUS)?;
            within("thickness of the wall", thickness, THICKNESS)?;
        }
        Ok(shape)
    }

    /// A mesh with `cells` quadrilaterals around and across, each of two triangles. Its facet sets are `inner` and `outer`; its point
    /// field `fibre` goes around the origin: along circles, not along the waves of the wall.
    pub(crate) fn triangles(&self, cells: [usize; 2]) -> Result<TriangleMesh> {
        let [around, across] = cells;
        check_cells(&cells, around > 2 && across > 0, "three around and one across, or more")?;
        let node = |i: usize, j: usize| (i % around) * (across + 1) + j;
        let mut mesh = TriangleMesh::default();
        let mut fibre = Vec::with_capacity(around * (across + 1));
        for i in 0..around {
            let angle = i as f64 / around as f64 * TAU;
            let ([radius, thickness], (sin, cos)) = (self.measures(angle), angle.sin_cos());
            for j in 0..=across {
                let r = radius + thickness * j as f64 / across as f64;
                mesh.points.push([r * cos, r * sin, 0.0]);
                fibre.push([-sin, cos, 0.0]);
            }
            for j in 0..across {
                let [a, b, c, d] = [node(i, j), node(i, j + 1), node(i + 1, j + 1), node(i + 1, j)];
                mesh.cells.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh.point_fields.insert("fibre".into(), Field::vectors(&fibre));
        repair_orientation(&mut mesh);
        // Radii grow outwards at every angle, so that no cell is folded.
        for (name, j) in [("inner", 0), ("outer", across)] {
            let mut facets = boundary_facets(&mesh);
            facets.retain(|facet| mesh.nodes_of_facet(*facet).all(|n| n % (across + 1) == j));
            mesh.facet_sets.insert(name.into(), facets);
        }
        Ok(mesh)
    }

    /// Inner radius and thickness at an angle.
    fn measures(&self, angle: f64) -> [f64; 2] {
        let halves = self.numbers.split_at(Self::NUMBERS / 2);
        let of = |numbers: &[f64], deviations: &[f64; WAVES + 1]| {
            let waves = numbers[1..].chunks_exact(2).zip(&deviations[1..]).enumerate();
            let waves = waves.map(|(k, (pair, deviation))| {
                let (sin, cos) = ((k + 1) as f64 * angle).sin_cos();
                deviation * (pair[0] * cos + pair[1] * sin)
            });
            (deviations[0] * numbers[0] + waves.sum::<f64>()).exp()
        };
        [SIZE[0] * of(halves.0, &DEVIATIONS[0]), SIZE[1] * of(halves.1, &DEVIATIONS[1])]
    }
}

fn within(what: &str, value: f64, [least, most]: [f64; 2]) -> Result<()> {
    ensure!(
        (least..=most).contains(&value),
        "the {what} of {value:.3} is not between {least} and {most}: draw other numbers"
    );
    Ok(())
}

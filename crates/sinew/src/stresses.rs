//! Stress, strain and fibres as fields of a mesh and as arrays.

use sinew_energy::Body;
use sinew_fem::{CellStress, Fibre, principal_stretches, principal_values};
use sinew_mesh::{AnyMesh, Field, FieldValues};

/// A field of the cells of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct StressField {
    /// Name, without spaces.
    pub name: &'static str,
    /// Numbers of a cell: 9 of a tensor, row by row.
    pub components: usize,
    /// Numbers, cell by cell.
    pub values: Vec<f64>,
}

impl StressField {
    /// Shape of the numbers of a cell.
    pub fn shape(&self) -> Vec<usize> {
        match self.components {
            1 => vec![],
            9 => vec![3, 3],
            count => vec![count],
        }
    }
}

/// The fields of stress, strain and fibres; those of fibres only where the law has some. Stresses and strains are means over the
/// quadrature points of a cell by their volumes in the reference configuration, principal values those of these means; `volume` is that of the cell in the current configuration \[length³\], `volume_ratio` is J.
pub fn stress_fields(cells: &[CellStress]) -> Vec<StressField> {
    let fibres: Option<Vec<Fibre>> = cells.iter().map(|cell| cell.fibre).collect();
    let field = |name, components, values| StressField { name, components, values };
    let tensor = |name, of: fn(&CellStress) -> &[[f64; 3]; 3]| {
        field(name, 9, cells.iter().flat_map(|cell| of(cell).as_flattened().to_vec()).collect())
    };
    let triple =
        |name, of: fn(&CellStress) -> [f64; 3]| field(name, 3, cells.iter().flat_map(of).collect());
    let single = |name, of: fn(&CellStress) -> f64| field(name, 1, cells.iter().map(of).collect());
    let mut fields = vec![
        tensor("cauchy_stress", |cell| &cell.cauchy),
        tensor("green_lagrange_strain", |cell| &cell.green_lagrange),
        triple(STRESSES, |cell| cell.principal_stresses),
        triple(STRETCHES, |cell| cell.principal_stretches),
        single(VOLUME, |cell| cell.volume),
        single("volume_ratio", |cell| cell.volume_ratio),
    ];
    if let Some(fibres) = fibres {
        let directions = fibres.iter().flat_map(|fibre| fibre.direction).collect();
        fields.push(field(FIBRE, 3, directions));
        fields.push(field("fibre_stretch", 1, fibres.iter().map(|f| f.stretch).collect()));
        fields.push(field("fibre_stress", 1, fibres.iter().map(|f| f.stress).collect()));
    }
    fields
}

/// Fields of principal values, of which the tensors come first.
const STRESSES: &str = "principal_stresses";
const STRETCHES: &str = "principal_stretches";
/// Field of directions, which is not averaged: a direction and its opposite are one fibre.
const FIBRE: &str = "fibre";
/// Field of cell volumes, which is not averaged: volumes add up.
const VOLUME: &str = "volume";

/// Adds stress, strain and fibres to a mesh, at its cells and averaged to its nodes by their volumes in the reference configuration. Principal
/// values at nodes are those of the averaged tensors.
pub fn add_stresses(mesh: &mut AnyMesh, body: &Body, cells: &[CellStress]) {
    type Values = fn(&[[f64; 3]; 3]) -> [f64; 3];
    // Stress and strain at nodes.
    let mut tensors: Vec<Vec<f64>> = Vec::new();
    let principal = |averaged: &[f64], values: Values| -> Vec<f64> {
        averaged.as_chunks::<3>().0.as_chunks::<3>().0.iter().flat_map(values).collect()
    };
    for StressField { name, components, values } in stress_fields(cells) {
        if ![FIBRE, VOLUME].contains(&name) {
            let averaged = match name {
                STRESSES => principal(&tensors[0], principal_values),
                STRETCHES => principal(&tensors[1], principal_stretches),
                _ => at_nodes(body, components, &values),
            };
            if components == 9 {
                tensors.push(averaged.clone());
            }
            let values = FieldValues::Float(averaged);
            mesh.point_fields_mut().insert(name.into(), Field { components, values });
        }
        let values = FieldValues::Float(values);
        mesh.cell_fields_mut().insert(name.into(), Field { components, values });
    }
}

/// Volumes of the cells in the reference configuration \[length³\].
pub(crate) fn volumes_at_rest(body: &Body) -> impl Iterator<Item = f64> {
    body.volumes.chunks(body.points_per_cell).map(|of| of.iter().sum::<f64>())
}

/// Values of cells averaged to nodes by the volumes of the cells.
pub(crate) fn at_nodes(body: &Body, components: usize, values: &[f64]) -> Vec<f64> {
    let (mut sums, mut weights) = (vec![0.0; components * body.nodes], vec![0.0; body.nodes]);
    let cells = body.cell_nodes().zip(volumes_at_rest(body)).zip(values.chunks(components));
    for ((nodes, volume), row) in cells {
        for &node in nodes {
            weights[node] += volume;
            let sums = &mut sums[components * node..][..components];
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += volume * value);
        }
    }
    sums.chunks_mut(components).zip(&weights).for_each(|(row, weight)| {
        row.iter_mut().for_each(|value| *value /= weight.max(f64::MIN_POSITIVE));
    });
    sums
}

//! Tables of results: a row per case.

use super::{Quality, Results, Row, least_and_largest_ratio, mean_and_largest, shown};
use crate::theta::{heads, outside};
use sinew_energy::{Body, Units};
use sinew_fem::{energy_and_reactions, held_sets};
use sinew_num::in_parallel;

/// Head of the column of residuals.
pub(super) const RESIDUAL: &str = "residual relative to the forces";

/// A cell below its head.
type Cell = (String, String);

impl Results<'_> {
    /// A row per case: its number, θ, then for each way to find it the mean and the largest nodal displacement, the total
    /// potential energy, empty where there is no potential, the volumes of cavities, the least and the largest J, and the reactions of supports; how good it is; parameters outside their ranges; warnings; why it failed.
    pub(super) fn table(&self) -> String {
        let judged = self.rows.iter().any(|row| row.quality.is_some());
        let heads = self.cells(0, &Row::default(), judged);
        let heads: Vec<String> = heads.into_iter().map(|(head, _)| head).collect();
        csv_line(&heads) + &self.lines(0, judged).concat()
    }

    /// Lines of the rows, numbered from the first on.
    pub(super) fn lines(&self, first: usize, judged: bool) -> Vec<String> {
        let line = |(case, row): (usize, &Row<'_>)| {
            let cells = self.cells(first + case, row, judged).into_iter();
            csv_line(&cells.map(|(_, cell)| cell).collect::<Vec<_>>())
        };
        in_parallel(self.rows.iter().enumerate(), line)
    }

    /// Displacements and volumes of cavities against a parameter.
    pub(super) fn curve(&self, parameter: usize) -> String {
        let body = self.body;
        let along = vec![heads(&body.parameters).swap_remove(parameter)];
        let mut text = csv_line(&[along, motion_heads(body).into(), volume_heads(body)].concat());
        for (case, row) in self.rows.iter().enumerate() {
            let Some(field) = row.fields.first() else { continue };
            let (value, moved) = (self.along(parameter, case), mean_and_largest(field));
            text += &csv_line(&[&[value], &moved[..], &body.cavity_volumes(field)].concat());
        }
        text
    }

    /// Cells of a row with their heads; empty where the row has no such values.
    fn cells(&self, case: usize, row: &Row<'_>, judged: bool) -> Vec<Cell> {
        let (body, Units { length, stress }) = (self.body, &self.body.units);
        let theta = (!row.theta.is_empty()).then(|| shown(body, &row.theta));
        let mut cells = vec![("case".to_string(), case.to_string())];
        cells.extend(below(heads(&body.parameters), theta));
        for (place, name) in self.names.iter().enumerate() {
            let field = row.fields.get(place).copied();
            let mut add = |heads: Vec<String>, values: Option<Vec<f64>>| {
                let heads = heads.iter().map(|head| format!("{name} {head}")).collect();
                cells.extend(below(heads, values));
            };
            add(motion_heads(body).into(), field.map(|u| mean_and_largest(u).into()));
            // Mixed elements without their pressures have no reactions.
            let found = field
                .and_then(|u| energy_and_reactions(body, u, row.pressure, &row.theta).ok())
                .unzip();
            let energy = found.0.filter(|_| body.has_potential()).map(|energy| vec![energy]);
            add(vec![format!("energy [{stress} {length}3]")], energy);
            add(volume_heads(body), field.map(|u| body.cavity_volumes(u)));
            let ratios = field.map(|u| least_and_largest_ratio(body, u).into());
            add(["least J", "largest J"].map(String::from).into(), ratios);
            let forces = held_sets(body).flat_map(|(set, _)| {
                ["x", "y", "z"].map(|axis| format!("reaction {axis} at {set} [{stress} {length}2]"))
            });
            add(forces.collect(), found.1.map(|forces| forces.concat()));
        }
        if judged {
            let Quality { mean, largest, energy_norm, kind, residual } =
                row.quality.clone().unwrap_or_default();
            let number = |value: Option<f64>| value.map_or(String::new(), |x| x.to_string());
            cells.extend([
                (format!("estimated mean error [{length}]"), number(mean)),
                (format!("estimated largest error [{length}]"), number(largest)),
                ("estimated error in the energy norm [%]".into(), number(energy_norm)),
                ("estimate".into(), kind),
                (RESIDUAL.into(), number(residual)),
            ]);
        }
        let outside = outside(&body.parameters, &row.theta);
        cells.extend([
            ("outside their ranges".into(), outside.join("; ")),
            ("warnings".into(), row.warnings.join("; ")),
            ("failure".into(), row.failure.clone().unwrap_or_default()),
        ]);
        cells
    }
}

/// Cells below heads, empty where there are no values.
fn below(heads: Vec<String>, values: Option<Vec<f64>>) -> impl Iterator<Item = Cell> {
    let mut values = values.into_iter().flatten();
    let cell = move || values.next().map_or(String::new(), |value| value.to_string());
    heads.into_iter().zip(std::iter::repeat_with(cell))
}

/// Heads of the mean and the largest nodal displacement.
pub(crate) fn motion_heads(body: &Body) -> [String; 2] {
    ["mean", "largest"].map(|of| format!("{of} u [{}]", body.units.length))
}

/// Heads of the volumes of cavities.
pub(crate) fn volume_heads(body: &Body) -> Vec<String> {
    let length = &body.units.length;
    body.cavities.iter().map(|cavity| format!("volume of {} [{length}3]", cavity.name)).collect()
}

/// A line of a CSV table, its cells in quotes where they need to be.
pub fn csv_line<T: ToString>(cells: &[T]) -> String {
    let quoted = |cell: &T| match cell.to_string() {
        text if text.contains([',', '"', '\n']) => {
            format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " "))
        }
        text => text,
    };
    cells.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

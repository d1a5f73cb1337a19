//! The report as text.

use super::{Reaction, SolutionReport};
use crate::CellValue;
use std::fmt;

impl fmt::Display for SolutionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [reference, deformed] = self.volume;
        let change = 100.0 * (deformed / reference - 1.0);
        writeln!(f, "residual          {:.2e} of the forces", self.relative_residual)?;
        writeln!(
            f,
            "energy            {:.7e} = stored {:.7e} - work of loads {:.7e}",
            self.energy, self.strain_energy, self.external_work
        )?;
        writeln!(f, "volume            {reference:.6e} -> {deformed:.6e} ({change:+.3} %)")?;
        cells(f, "least J", &self.least_volume_ratios)?;
        writeln!(f, "largest J         {}", self.largest_volume_ratio)?;
        writeln!(f, "largest stretch   {}", self.largest_stretch)?;
        cells(f, "mean ratio, rest", &self.worst_reference_shapes)?;
        cells(f, "… deformed", &self.worst_deformed_shapes)?;
        writeln!(f, "loads             {}", vector(&self.loads))?;
        if self.elastic_supports != [0.0; 3] {
            writeln!(f, "elastic supports  {}", vector(&self.elastic_supports))?;
        }
        for Reaction { nodes, centre, force, moment } in &self.reactions {
            let (count, force, moment) = (nodes.len(), vector(force), vector(moment));
            writeln!(
                f,
                "reaction          {force}, moment {moment} at {centre:.3?} ({count} nodes)"
            )?;
        }
        writeln!(f, "unbalanced        {}", vector(&self.imbalance()))?;
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}

fn cells(f: &mut fmt::Formatter<'_>, name: &str, cells: &[CellValue]) -> fmt::Result {
    let list: Vec<_> = cells.iter().map(ToString::to_string).collect();
    writeln!(f, "{name:<18}{}", list.join(", "))
}

fn vector(v: &[f64; 3]) -> String {
    // Adding zero turns −0 into 0.
    let [x, y, z] = v.map(|component| component + 0.0);
    format!("[{x:.4e}, {y:.4e}, {z:.4e}]")
}

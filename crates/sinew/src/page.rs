//! A comparison as a report.

use crate::comparison::{Comparison, Method};
use sinew_emulate::{Errors, Evaluation, METRICS, Metric, Quantiles};
use sinew_report::{
    Block, Cell, Chart, Column, Provenance, Report, ReportError, Row, Section, Table,
};

impl Comparison {
    /// A page with one table, errors beside times, and a chart of time against error.
    ///
    /// # Errors
    /// An error or a time that is no finite number.
    pub fn report(&self) -> Result<Report, ReportError> {
        let table = self.table()?;
        let chart = Chart::speed_against_error(&table, 0);
        let provenance = Provenance::of_this_run("sinew report", ".");
        let about = format!(
            "{} nodes, {} unknowns; the nodes of the test cases move {:.2} {unit} in the mean and {:.2} {unit} at most",
            self.nodes,
            self.unknowns,
            self.displacement.mean,
            self.displacement.max,
            unit = self.length_unit
        );
        let mut report = Report::new(self.scene.clone(), about, provenance);
        let mut blocks = vec![Block::Table(table), Block::charts("Speed", "", [chart])];
        blocks.extend(self.methods.iter().filter_map(remarks).map(Block::Text));
        report.sections.push(Section {
            name: "errors".into(),
            title: "Errors and times".into(),
            blocks,
        });
        Ok(report)
    }

    fn table(&self) -> Result<Table, ReportError> {
        let volumes = self.methods.iter().any(|method| method.evaluation.raw.err_volume.is_some());
        let column = |metric: &Metric| {
            Column::new(metric.name, metric.unit(&self.length_unit)).about(metric.about)
        };
        let mut errors: Vec<Column> = METRICS.iter().map(column).collect();
        errors.extend(
            volumes.then(|| Column::new("err_V", "%").about("|V − V̂| / V of every cavity")),
        );
        let times = [
            Column::new("predict", "s")
                .about("one parameter set on the known geometry, with its Newton steps"),
            Column::new("simulate + train", "s").once(),
        ];
        let others = [
            Column::new("simulations", ""),
            Column::new("estimates", "%").about("share of the cases whose energy-norm error is within a factor of two of its estimate"),
        ];
        let mut table = Table::new(errors, times, others);
        for method in &self.methods {
            let (own, times) = (&method.evaluation, &method.evaluation.times);
            table.push(row(method, method.name.clone(), &own.raw, times.predict_decoder_s)?)?;
            for after in &own.corrected {
                let name = format!("{} + {} Newton", method.name, after.steps);
                let seconds = times.predict_decoder_s + after.steps as f64 * times.correction_s;
                table.push(row(method, name, &after.errors, seconds)?)?;
            }
        }
        Ok(table)
    }
}

fn row(method: &Method, name: String, errors: &Errors, seconds: f64) -> Result<Row, ReportError> {
    let mut row = Row::new(name, cell(&errors.err_u), seconds)?
        .error(cell(&errors.err_f))
        .error(cell(&errors.err_i1))
        .error(cell(&errors.err_pi));
    if let Some(volume) = &errors.err_volume {
        row = row.error(cell(volume));
    }
    let Evaluation { within_two, times, .. } = &method.evaluation;
    Ok(row
        .time(times.simulate_s + times.prepare_s + times.train_s)
        .other(method.simulations as f64)
        .other(100.0 * within_two))
}

/// The median, with the largest below it.
fn cell(of: &Quantiles) -> Cell {
    Cell { note: format!("largest {:.1e}", of.max), ..Cell::from(of.q50) }
}

fn remarks(method: &Method) -> Option<String> {
    let said: Vec<String> = method.warnings.iter().map(ToString::to_string).collect();
    (!said.is_empty()).then(|| format!("{}: {}.", method.name, said.join("; ")))
}

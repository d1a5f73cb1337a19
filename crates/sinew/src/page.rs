//! A comparison as a report.

use crate::comparison::{Comparison, Method, SOLVER};
use sinew_emulate::{Calibration, CurvePoint, Errors, Evaluation, METRICS, Metric, Quantiles};
use sinew_report::format::{count as spaced, digits, rounded, seconds as duration};
use sinew_report::{
    Block, Cell, Chart, Column, Distribution, Level, Provenance, Report, ReportError, Row, Section,
    Series, Style, Table,
};

impl Comparison {
    /// A page with one table, errors beside times, charts and pictures of the body.
    ///
    /// # Errors
    /// An error or a time that is not finite.
    pub fn report(&self) -> Result<Report, ReportError> {
        let mut provenance = Provenance::of_this_run("sinew", ".");
        (provenance.seed, provenance.config) = (self.seed, self.configuration());
        let Self { nodes, unknowns, displacement, length_unit: unit, .. } = self;
        let about = format!(
            "{nodes} nodes, {unknowns} unknowns; the nodes of the test cases move {:.2} {unit} in the mean and {:.2} {unit} at most",
            displacement.mean, displacement.max
        );
        let mut report = Report::new(self.scene.clone(), about, provenance);
        let mut section = self.section("errors", "Errors and times")?;
        // On a page of one section its sentences stand at the head.
        let sentences = section.blocks.extract_if(.., |block| matches!(block, Block::List(_)));
        for block in sentences {
            let Block::List(sentences) = block else { continue };
            report.notes.extend(sentences);
        }
        report.headline = self.headline();
        report.sections.push(section);
        Ok(report)
    }

    /// The method with the lowest median error, and its largest errors.
    fn headline(&self) -> String {
        let median = |method: &&Method| method.evaluation.raw.err_u.q50;
        let Some(best) = self.methods.iter().min_by(|a, b| median(a).total_cmp(&median(b))) else {
            return String::new();
        };
        let (errors, unit) = (best.evaluation.raw.err_u, &self.length_unit);
        let [half, most, largest, moved] =
            [errors.q50, errors.q95, errors.max, self.displacement.mean].map(|x| digits(x, 2));
        format!(
            "{} is the most accurate: half of the free nodes are within {half} {unit}, 95 % within {most} {unit}, all within \
             {largest} {unit}, where they move {moved} {unit} in the mean.",
            best.name
        )
    }

    /// The case file, then recipe and options of each method.
    fn configuration(&self) -> String {
        let own = self.methods.iter().filter(|method| !method.options.is_empty());
        let own = own.map(|method| format!("# training of {}\n{}", method.name, method.options));
        let case = Some(self.case.trim_end().to_string()).filter(|case| !case.is_empty());
        case.into_iter().chain(own).collect::<Vec<_>>().join("\n\n")
    }

    /// The part of a page that is about this scene.
    ///
    /// # Errors
    /// An error or a time that is not finite.
    pub fn section(&self, name: &str, title: &str) -> Result<Section, ReportError> {
        let table = self.table(true)?;
        let speed = Chart::speed_against_error(&table, 0);
        let mut blocks = vec![
            Block::Facts(self.facts()),
            Block::List(self.table(false)?.summary()),
            Block::Table(table),
            Block::charts(
                "Speed against error",
                "Median displacement error and time of one prediction, raw and after Newton steps. Lower left is better.",
                [speed],
            ),
            Block::charts(
                "Error densities",
                "Kernel densities of log₁₀ of all test errors. Dashed lines are medians, dotted ones published figures.",
                (0..self.errors().len()).map(|error| self.densities(error)),
            ),
        ];
        if self.methods.iter().any(|method| !method.record.history.is_empty()) {
            blocks.push(Block::charts(
                "Error over training time",
                "Medians over the held-out cases. Time is that of training, without simulations and evaluations. Dotted lines are \
                 published figures, single markers methods without training steps. The energy is above that of the solution, which \
                 is a minimum.",
                self.curves(),
            ));
        }
        if !self.doubts.is_empty() {
            blocks.insert(0, Block::List(self.doubts.clone()));
        }
        blocks.push(self.times_to_accuracies());
        blocks.push(self.sensitivities());
        blocks.push(Block::Surfaces(self.motion.clone()));
        blocks.push(Block::Surfaces(self.surfaces.clone()));
        Ok(Section { name: name.into(), title: title.into(), blocks })
    }

    /// Names and units of the errors that this body has.
    fn errors(&self) -> Vec<Column> {
        let column = |metric: &Metric| {
            Column::new(metric.name, metric.unit(&self.length_unit)).about(metric.about)
        };
        let volume = Column::new("err_V", "%").about("|V − V̂| / V of every cavity");
        let volumes = self.methods.iter().any(|method| method.evaluation.raw.err_volume.is_some());
        METRICS.iter().map(column).chain(volumes.then_some(volume)).collect()
    }

    /// Errors beside times, of corrected predictions too or of raw ones only.
    fn table(&self, corrected: bool) -> Result<Table, ReportError> {
        let times = [
            Column::new("in full", "s").about(
                "one parameter set, with the message passing of a network; the solver from rest",
            ),
            Column::new("predict", "s")
                .about("the same on the known geometry; the solver from a neighbour's solution"),
            Column::new("in a batch", "s").about("one of 200 parameter sets"),
            Column::new("simulate + train", "s").once(),
        ];
        let others = [
            Column::new("learned from", "")
                .about("simulations that a method learned from, and steps of its optimiser"),
            Column::new("estimates", "%")
                .about("share of the estimates that are within a factor of two of the error, in the energy norm and in the mean"),
            Column::new("refused", "")
                .about("cases without an estimate, for they are not near an equilibrium; a cell that is inverted is one reason"),
            Column::new("hurt", "")
                .about("cases that Newton steps take farther from the truth than the prediction was"),
        ];
        let errors = self.errors();
        let count = errors.len();
        let mut table = Table::new(errors, times, others);
        for method in &self.methods {
            let (own, times) = (&method.evaluation, &method.evaluation.times);
            let times =
                [times.predict_full_s, times.predict_decoder_s, times.predict_batch_per_theta_s];
            let mut raw = row(method, method.name.clone(), &own.raw, times, count)?;
            raw.others.extend(standing(method));
            raw.about.clone_from(&method.record.about);
            raw.warnings = method.record.warnings.iter().map(ToString::to_string).collect();
            table.push(raw)?;
            for after in own.corrected.iter().filter(|_| corrected) {
                let name = format!("{} + {} Newton", method.name, after.steps);
                let steps = after.steps as f64 * own.times.correction_s;
                let mut row = row(method, name, &after.errors, times.map(|t| t + steps), count)?;
                row.others.resize(3, Cell::default());
                table.push(row.other(of(after.hurt, own.calibration.cases)))?;
            }
        }
        if let Some(times) = self.methods.first().map(|method| method.evaluation.times) {
            table.push(solver(times.solver_cold_s, times.solver_warm_s, count)?)?;
            table.baseline = Some(SOLVER.into());
        }
        Ok(table)
    }

    fn facts(&self) -> Vec<(String, String)> {
        let Self { nodes, cells, unknowns, displacement, length_unit: unit, .. } = self;
        let size =
            format!("mean {:.3} {unit}, largest {:.3} {unit}", displacement.mean, displacement.max);
        let fact = |name: &str, value: String| (name.to_string(), value);
        vec![
            fact("mesh", format!("{nodes} nodes, {cells} elements, {unknowns} unknowns")),
            fact("parameters", self.parameters.join(", ")),
            fact("displacement", size),
            fact(
                "test cases",
                self.methods.first().map_or(0, |m| m.evaluation.calibration.cases).to_string(),
            ),
        ]
    }

    /// Seconds to some accuracies for some numbers of parameter sets.
    fn times_to_accuracies(&self) -> Block {
        let head = Evaluation::ACCURACIES.map(|accuracy| format!("to {accuracy:e}"));
        let named = ["parameter sets", "method"].map(String::from);
        let row = |(name, sets, seconds): (&str, usize, [f64; Evaluation::ACCURACIES.len()])| {
            let seconds = seconds.map(|seconds| Cell::from(duration(seconds)));
            let named = [Cell::from(spaced(sets as u64)), Cell::from(name)];
            named.into_iter().chain(seconds).collect()
        };
        Block::listing(
            "Time to an accuracy (mean nodal error relative to the mean nodal displacement), one thread. Derived: simulations, \
                    preparation and training, and for each parameter set a prediction and the cheapest of no steps, quasi-Newton steps and \
                    Newton steps after which the true error of a test case was within the accuracy; where none was, the dearest of them \
                    and a solve. The solver: one solve from rest, the others from a neighbour's solution. Checks of the error are not in it.",
            named.into_iter().chain(head),
            self.seconds().into_iter().map(row),
        )
    }

    /// Table of the errors of derivatives in the parameters.
    fn sensitivities(&self) -> Block {
        let names = self.parameters.iter().filter_map(|parameter| parameter.split(' ').next());
        let row = |method: &Method| {
            let errors =
                method.evaluation.sensitivity_errors.iter().map(|&e| Cell::from(rounded(e, 2)));
            std::iter::once(Cell::from(method.name.as_str())).chain(errors).collect()
        };
        Block::listing(
            "Error of ∂û/∂θ [%], medians: ‖∂û/∂θ − ∂u/∂θ‖ / ‖∂u/∂θ‖",
            std::iter::once("method").chain(names),
            self.methods.iter().map(row),
        )
    }

    fn densities(&self, error: usize) -> Chart {
        let column = &self.errors()[error];
        let title = format!("Density of {}", column.name);
        let axes = [&*column.head(), "density per decade"];
        let mut chart = Chart::new(title, axes, [true, false]);
        for method in &self.methods {
            let points = method.densities.get(error).into_iter().flatten().copied();
            chart.series.push(Series::new(&method.name, Style::Area, points));
            let medians = medians(&method.evaluation.raw);
            chart.levels.extend(medians.get(error).map(|&value| Level {
                name: method.name.clone(),
                value,
                upright: true,
                published: false,
            }));
        }
        chart
    }

    /// Errors, and the energy above that of the solution, over training time.
    fn curves(&self) -> Vec<Chart> {
        let time = "training time [s]";
        let positive =
            self.methods.iter().flat_map(|m| &m.record.history).all(|point| point.loss > 0.0);
        let lines = |chart: Chart, value: &dyn Fn(&CurvePoint) -> Option<f64>| {
            let trained = self.methods.iter().filter(|method| !method.record.history.is_empty());
            trained.fold(chart, |chart, method| {
                let point = |p: &CurvePoint| [p.train_s, value(p).unwrap_or(f64::NAN)];
                let points = method.record.history.iter().map(point);
                chart.with(Series::new(&method.name, Style::Line, points))
            })
        };
        let chart = |(number, (metric, column)): (usize, (&Metric, Column))| {
            let (title, name) =
                (format!("Error in {}", metric.quantity), format!("median {}", column.head()));
            let mut chart = lines(Chart::new(title, [time, &name], [true; 2]), &|p| {
                p.medians.map(|medians| medians[number])
            });
            for method in self.methods.iter().filter(|method| method.record.history.is_empty()) {
                let Evaluation { raw, times, .. } = &method.evaluation;
                let point = [times.train_s, medians(raw)[number]];
                chart.series.push(Series::new(&method.name, Style::Points, [point]));
            }
            chart
        };
        let axes = [time, "mean energy above the solution's [%]"];
        let energy = Chart::new("Energy above the minimum", axes, [true; 2]);
        let energy = lines(energy, &|p| p.energy_excess_pct);
        let axes = [time, "mean training loss"];
        let loss = Chart::new("Training loss", axes, [true, positive]);
        let loss = lines(loss, &|p| Some(p.loss));
        METRICS.iter().zip(self.errors()).enumerate().map(chart).chain([energy, loss]).collect()
    }
}

/// Medians in the order of [`METRICS`], then err_V.
fn medians(errors: &Errors) -> Vec<f64> {
    quantiles(errors).iter().map(|of| of.q50).collect()
}

fn quantiles(errors: &Errors) -> Vec<Quantiles> {
    let Errors { err_u, err_f, err_i1, err_pi, err_volume, .. } = errors;
    let all = [Some(*err_u), Some(*err_f), Some(*err_i1), Some(*err_pi), *err_volume];
    all.into_iter().flatten().collect()
}

/// A method raw or corrected; nothing where one of the `count` errors is not of its body.
fn row(
    method: &Method,
    name: String,
    errors: &Errors,
    [full, decoder, batch]: [f64; 3],
    count: usize,
) -> Result<Row, ReportError> {
    let quantiles = quantiles(errors);
    let mut row = Row::new(name, cell(&quantiles[0]), full)?.time(decoder).time(batch);
    row.errors.extend(quantiles[1..].iter().map(cell));
    row.errors.resize(count, Cell::default());
    let times = &method.evaluation.times;
    Ok(row.time(times.simulate_s + times.prepare_s + times.train_s))
}

/// Simulations of a method, calibration and absence of its estimates, and corrections that hurt.
fn standing(method: &Method) -> [Cell; 4] {
    let Calibration { within_two, refused, inverted, cases } = method.evaluation.calibration;
    let steps = match method.record.steps {
        0 => String::new(),
        steps => format!("{} steps", spaced(steps)),
    };
    let cells = if inverted > 0 { format!("{inverted} invert a cell") } else { String::new() };
    let held = (refused < cases).then(|| rounded(100.0 * within_two, 3));
    [
        Cell { note: steps, ..Cell::from(method.record.simulations as f64) },
        held.into(),
        Cell { note: cells, ..of(refused, cases).into() },
        Cell::default(),
    ]
}

/// `3 of 100`
fn of(count: usize, cases: usize) -> String {
    format!("{count} of {cases}")
}

/// The solver. Its solutions are the reference of the errors, so it is not ranked.
fn solver(cold: f64, warm: f64, count: usize) -> Result<Row, ReportError> {
    let reference = "the truth of this table".into();
    let mut row = Row { reference, ..Row::new(SOLVER, 0.0, cold)? };
    row.errors.resize(count, Cell::default());
    row.times.extend([warm.into(), Cell::default(), Cell::default()]);
    row.others.resize(4, Cell::default());
    Ok(row)
}

/// All quantiles, with that of 95 % and the largest below the median; the median alone where some error is not finite.
fn cell(of: &Quantiles) -> Cell {
    let [most, largest] = [of.q95, of.max].map(|value| digits(value, 2));
    // Broken between the two, not within.
    let note = format!("95\u{a0}%\u{a0}{most}, largest\u{a0}{largest}");
    let Quantiles { min, q02_5, q25, q50, q75, q97_5, max, mean, .. } = *of;
    if max.is_nan() || max == f64::MAX {
        return Cell { note, ..Cell::from(q50) };
    }
    let density = Vec::new();
    let [q0, q2_5, q100] = [min, q02_5, max];
    let all = Distribution { q0, q2_5, q25, q50, q75, q97_5, q100, mean, density };
    Cell { note, ..Cell::from(all) }
}

//! Requested rows of θ with their results. A failed row does not stop the others.

use super::{MOST_WARNINGS, Usage, refuse, refuse_if, warn, warn_of_locking};
use anyhow::{Context, Result};
use clap::Args;
use sinew::case::{doubtful_displacements, locking_at_most, moved_most};
use sinew::output::{self, MOST_BYTES, Results, Row};
use sinew::{
    Body, Parameter, admissible, outside, parse_theta, parse_theta_but, read_rows, read_thetas,
    theta_in_words,
};
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

/// θ of one or many cases.
#[derive(Debug, Args)]
pub(crate) struct ThetaArguments {
    /// Parameters: name=value,name=value, or a CSV table with their names in its first line; may be given several times. A
    /// number has the unit that the case file gives the parameter, unless it names its own (p=7mmHg, or a column p [mmHg])
    /// [default: the middle of the ranges]
    #[arg(long, value_name = "THETA|CSV")]
    theta: Vec<String>,
}

/// Amount of output.
#[derive(Debug, Args)]
pub(crate) struct Written {
    /// Largest number of cases written for ParaView
    #[arg(long, value_name = "COUNT", default_value_t = 20)]
    pub(super) pictures: usize,
    /// Write cases.npz with all fields even where it takes more than 64 MB
    #[arg(long)]
    arrays: bool,
    /// Write stress, strain, volumes and fibres too: for ParaView at cells and averaged to nodes, and at cells into cases.npz
    #[arg(long)]
    pub(crate) fields: bool,
}

/// Rows that were asked for, in their order.
pub(crate) struct Batch<'b> {
    body: &'b Body,
    rows: Vec<Row<'b>>,
    /// Rows of the parts before this one.
    before: usize,
    /// Number of rows that could not be read or are invalid.
    wrong: usize,
    told: usize,
    /// State that moves the body most, of all parts so far.
    most: Rc<RefCell<Option<State>>>,
}

/// θ and displacement.
type State = (Vec<f64>, Vec<f64>);

/// Bytes of the fields that are in memory together.
const PART: usize = 512 << 20;
/// Rows that a line each is printed for; the others are in the table.
pub(super) const MOST_LINES: usize = 100;

impl ThetaArguments {
    /// All of them, without a body. Results of an earlier run in the folder go with a table that is refused.
    ///
    /// # Errors
    /// None at all, a text or a row of a table that cannot be read.
    pub(crate) fn of(&self, parameters: &[Parameter], folder: &Path) -> Result<Vec<Vec<f64>>> {
        let mut thetas = Vec::new();
        for text in &self.theta {
            match text.contains('=') {
                true => thetas.push(parse_theta(text, parameters)?),
                false => match read_thetas(Path::new(text), parameters) {
                    Ok(found) => thetas.extend(found),
                    Err(error) => {
                        clear(Some(folder))?;
                        return Err(error.into());
                    }
                },
            }
        }
        let reason = "--theta is missing; give name=value,name=value, or a CSV table";
        refuse_if(thetas.is_empty(), || reason)?;
        Ok(thetas)
    }

    /// All of them. Rows of tables that cannot be read or make no sense, and values outside their ranges, are told on
    /// standard error. Pairs may lack the parameter at the place `spare`, which has the middle of its range then. Results of an
    /// earlier run in the folder go with tables that are refused.
    ///
    /// # Errors
    /// θ on the command line that cannot be read or makes no sense, a table without one row that can.
    pub(crate) fn read<'b>(
        &self,
        body: &'b Body,
        spare: Option<usize>,
        folder: Option<&Path>,
    ) -> Result<Batch<'b>> {
        let spare = spare.map(|index| (index, body.centre()[index]));
        let (rows, most) = (Vec::new(), Rc::default());
        let mut batch = Batch { body, rows, before: 0, wrong: 0, told: 0, most };
        for text in &self.theta {
            if text.contains('=') {
                let theta = parse_theta_but(text, &body.parameters, spare)?;
                admissible(body, &theta).map_err(|why| Usage(format!("--theta {text}: {why}")))?;
                batch.rows.push(Row { theta, ..Row::default() });
            } else {
                batch.read_table(text)?;
            }
        }
        if self.theta.is_empty() {
            batch.rows.push(Row { theta: body.centre(), ..Row::default() });
        }
        if batch.wrong == batch.rows.len() {
            clear(folder)?;
            let first = batch.rows[0].failure.as_deref().unwrap_or_default();
            return refuse(format!("there is no row that can be computed; the first: {first}"));
        }
        tell_outside(&body.parameters, &batch.thetas());
        Ok(batch)
    }
}

impl<'b> Batch<'b> {
    fn read_table(&mut self, file: &str) -> Result<()> {
        for (line, found) in read_rows(Path::new(file), &self.body.parameters)? {
            let (theta, failure) = match found {
                Ok(theta) => {
                    let wrong = admissible(self.body, &theta).err();
                    (theta, wrong.map(|why| format!("{file}, line {line}: {why}")))
                }
                Err(error) => (Vec::new(), Some(error.to_string())),
            };
            if let Some(reason) = &failure {
                self.wrong += 1;
                tell_left_out(&mut self.told, reason);
            }
            self.rows.push(Row { theta, failure, ..Row::default() });
        }
        Ok(())
    }

    /// Rows that nothing is wrong with so far.
    fn open(&self) -> impl Iterator<Item = &Row<'b>> {
        self.rows.iter().filter(|row| row.failure.is_none())
    }

    /// θ of the open rows.
    pub(crate) fn thetas(&self) -> Vec<Vec<f64>> {
        self.open().map(|row| row.theta.clone()).collect()
    }

    /// Whether no part came before.
    pub(crate) fn is_first(&self) -> bool {
        self.before == 0
    }

    /// Computes and writes the rows in parts whose fields fit in memory together; with --arrays all at once.
    ///
    /// # Errors
    /// Those of a part; after all are written, that rows failed.
    pub(crate) fn in_parts(
        mut self,
        written: &Written,
        mut compute: impl FnMut(Self) -> Result<usize>,
    ) -> Result<()> {
        let all = self.rows.len();
        let fit = PART / size_of_val(&self.body.prescribed[..]);
        let most = if written.arrays { all } else { fit.max(written.pictures).max(1) };
        let mut failed = 0;
        for before in (0..all).step_by(most) {
            if most < all {
                eprintln!("rows {} to {} of {all}", before, all.min(before + most) - 1);
            }
            let rows = self.rows.drain(..most.min(self.rows.len())).collect();
            failed += compute(Self { rows, before, most: self.most.clone(), ..self })?;
        }
        let most = self.most.take();
        let most = most.iter().map(|(theta, field)| (theta, &field[..]));
        warn_of_locking(locking_at_most(self.body, most));
        outcome(failed, all, self.wrong)
    }

    /// Tells what to doubt of states; that cells are too stiff is told after the last part.
    pub(crate) fn tell_states<'a>(
        &self,
        thetas: &'a [Vec<f64>],
        fields: impl Iterator<Item = &'a [f64]>,
    ) {
        let (fields, before): (Vec<_>, _) = (fields.collect(), self.most.take());
        warn(doubtful_displacements(self.body, &fields));
        let mut states: Vec<_> = thetas.iter().zip(fields).collect();
        states.extend(before.as_ref().map(|(theta, field)| (theta, &field[..])));
        let most = moved_most(self.body, states);
        *self.most.borrow_mut() = most.map(|(theta, field)| (theta.clone(), field.to_vec()));
    }

    /// Answers to these θ in their order; a row that has none is left out, with the reason.
    pub(crate) fn answered<T>(
        &mut self,
        found: impl IntoIterator<Item = Result<T, String>>,
    ) -> Vec<T> {
        let asked = self.rows.iter_mut().filter(|row| row.failure.is_none());
        let mut answers = Vec::new();
        for (row, found) in asked.zip(found) {
            match found {
                Ok(answer) => answers.push(answer),
                Err(reason) => {
                    let at = theta_in_words(self.body, &row.theta);
                    tell_left_out(&mut self.told, &format!("{at}: {reason}"));
                    row.failure = Some(reason);
                }
            }
        }
        answers
    }

    /// Prints a line for each of the first answered rows, with what is to be said of it by its place among them.
    pub(crate) fn print(&self, said: impl Fn(usize) -> String) {
        let lines = MOST_LINES.saturating_sub(self.before);
        for (place, row) in self.open().enumerate().take(lines) {
            println!("{}{}", theta_in_words(self.body, &row.theta), said(place));
        }
        if lines > 0
            && let Some(more @ 1..) = self.open().count().checked_sub(lines)
        {
            println!("{more} more are in cases.csv");
        }
    }

    /// Writes all rows, with what was found for the answered ones, and says where; returns how many failed.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn write<'a>(
        self,
        names: &[&'a str],
        found: impl IntoIterator<Item = Row<'a>>,
        written: &Written,
        folder: &Path,
    ) -> Result<usize>
    where
        'b: 'a,
    {
        let (body, failed) = (self.body, self.rows.len() - self.open().count());
        let mut rows: Vec<Row<'a>> = self.rows;
        for (row, found) in rows.iter_mut().filter(|row| row.failure.is_none()).zip(found) {
            *row = Row { theta: std::mem::take(&mut row.theta), ..found };
        }
        let names = names.to_vec();
        let results = Results { body, names, rows, stresses: written.fields };
        if self.before > 0 {
            results.append(folder, self.before)?;
            return Ok(failed);
        }
        let left_out = results.write(folder, written.pictures, written.arrays)?;
        println!("written: {}", folder.display());
        if let Some(bytes) = left_out {
            let [bytes, most] = [bytes, MOST_BYTES].map(|bytes| bytes >> 20);
            println!(
                "cases.npz is left out: its fields take {bytes} MB or more, more than {most} MB; --arrays writes it"
            );
        }
        Ok(failed)
    }
}

/// Tells values outside their ranges on standard error.
pub(super) fn tell_outside(parameters: &[Parameter], thetas: &[Vec<f64>]) {
    let said: Vec<_> = thetas.iter().flat_map(|theta| outside(parameters, theta)).collect();
    warn(said.iter().take(MOST_WARNINGS));
    if let Some(more @ 1..) = said.len().checked_sub(MOST_WARNINGS) {
        eprintln!("warning: {more} more values are outside their ranges");
    }
}

/// Error that names the number of failed rows, if any; `wrong` of them were so as they were given.
fn outcome(failed: usize, all: usize, wrong: usize) -> Result<()> {
    let others = if failed < all { ", the others were computed" } else { "" };
    let advice = "the column `failure` of cases.csv says why";
    let reason = format!("{failed} of {all} rows failed{others}; {advice}");
    match (failed, wrong) {
        (0, _) => Ok(()),
        (_, 0) => Err(anyhow::anyhow!(reason)),
        _ => refuse(reason),
    }
}

/// Removes results of an earlier run, which are not those of a table that is refused.
fn clear(folder: Option<&Path>) -> Result<()> {
    let mut there = folder.into_iter().filter(|folder| folder.exists());
    there.try_for_each(|folder| output::clear(folder).with_context(|| folder.display().to_string()))
}

/// Tells why a row is left out, if few others were told.
fn tell_left_out(told: &mut usize, reason: &str) {
    *told += 1;
    if *told <= MOST_WARNINGS {
        eprintln!("left out: {reason}");
    }
}

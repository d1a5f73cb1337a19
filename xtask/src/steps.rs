//! Steps of continuous integration, with their seconds.

use anyhow::{Context, Result};
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// A finished step.
struct Step {
    name: &'static str,
    /// Wall and CPU time \[s\]; none where the system does not tell the second.
    wall: f64,
    cpu: Option<f64>,
}

/// Steps so far.
#[derive(Default)]
pub(crate) struct Steps(Vec<Step>);

impl Steps {
    /// Takes a step; what it started counts, and whether it failed is passed on.
    pub(crate) fn take(
        &mut self,
        name: &'static str,
        step: impl FnOnce() -> Result<()>,
    ) -> Result<()> {
        let (start, before) = (Instant::now(), children());
        let done = step().with_context(|| format!("{name} failed"));
        let wall = start.elapsed().as_secs_f64();
        let cpu = children().zip(before).map(|(after, before)| after - before);
        self.0.push(Step { name, wall, cpu });
        eprintln!("-- {name}: {wall:.0} s\n");
        done
    }

    /// Prints the table and writes it to a file.
    pub(crate) fn report(&self, file: &Path) -> Result<()> {
        let mut table = String::from("| step | wall s | CPU s |\n|---|---:|---:|\n");
        let mut row = |name: &str, wall: f64, cpu: Option<f64>| {
            let cpu = cpu.map_or("–".into(), |cpu| format!("{cpu:.0}"));
            writeln!(table, "| {name} | {wall:.0} | {cpu} |")
        };
        for step in &self.0 {
            row(step.name, step.wall, step.cpu)?;
        }
        row("sum", self.0.iter().map(|s| s.wall).sum(), self.0.iter().map(|s| s.cpu).sum())?;
        println!("{table}");
        let unwritable = || format!("{} cannot be written", file.display());
        std::fs::write(file, table).with_context(unwritable)
    }
}

/// CPU time of all ended child processes \[s\], on Linux.
fn children() -> Option<f64> {
    /// The kernel's unit of these times on every architecture.
    const TICKS: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name, which may hold blanks: field 3 on; user and system time of children are 16 and 17.
    let fields: Vec<_> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field - 3)?.parse::<f64>().ok();
    Some((ticks(16)? + ticks(17)?) / TICKS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_of_a_child_count_and_its_failure_is_passed_on() {
        let mut steps = Steps::default();
        let busy = || {
            let work = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done; exit 3";
            let status = std::process::Command::new("sh").args(["-c", work]).status()?;
            anyhow::ensure!(status.success(), "{status}");
            Ok(())
        };
        let error = steps.take("work", busy).unwrap_err();
        assert_eq!(error.to_string(), "work failed");
        let [step] = &steps.0[..] else { panic!("one step") };
        assert!(step.wall > 0.0 && step.cpu.is_none_or(|cpu| cpu > 0.0), "{:?}", step.cpu);
    }
}

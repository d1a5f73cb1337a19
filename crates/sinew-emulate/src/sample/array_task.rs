//! Shards by the tasks of a job array: what schedulers tell a task about itself.

use crate::Shard;
use std::str::FromStr;

/// Environment variables of a scheduler.
struct Scheduler {
    name: &'static str,
    task: &'static str,
    /// First and last task of the array, and the step between two, where the scheduler tells.
    array: Option<[&'static str; 3]>,
    /// Number of tasks, where the scheduler tells.
    count: Option<&'static str>,
}

const SCHEDULERS: [Scheduler; 5] = [
    Scheduler {
        name: "Slurm",
        task: "SLURM_ARRAY_TASK_ID",
        array: Some(["SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX", "SLURM_ARRAY_TASK_STEP"]),
        count: Some("SLURM_ARRAY_TASK_COUNT"),
    },
    Scheduler {
        name: "Grid Engine",
        task: "SGE_TASK_ID",
        array: Some(["SGE_TASK_FIRST", "SGE_TASK_LAST", "SGE_TASK_STEPSIZE"]),
        count: None,
    },
    Scheduler { name: "PBS", task: "PBS_ARRAY_INDEX", array: None, count: None },
    Scheduler { name: "Torque", task: "PBS_ARRAYID", array: None, count: None },
    Scheduler { name: "LSF", task: "LSB_JOBINDEX", array: None, count: None },
];

impl Shard {
    /// Shard by its name: `3/16`; `auto` for the task of the job array that this process is; or `auto:0-15`, which also says the first and
    /// the last task of the whole array. That is needed where the scheduler does not tell, as PBS, and where some tasks are submitted again.
    /// `variable` reads the environment.
    ///
    /// ```
    /// use sinew_emulate::Shard;
    /// let task = |name: &str| (name == "PBS_ARRAY_INDEX").then(|| "2".to_string());
    /// assert_eq!(Shard::named("auto:0-15", task)?.to_string(), "3/16");
    /// assert_eq!(Shard::named("auto:1-16", task)?.to_string(), "2/16");
    /// assert!(Shard::named("auto", task).unwrap_err().contains("auto:1-16"));
    /// # Ok::<(), String>(())
    /// ```
    ///
    /// # Errors
    /// Another text, no task of an array, a task outside of its array, or an array whose tasks have gaps, in words.
    pub fn named(text: &str, variable: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let Some(range) = text.strip_prefix("auto") else { return text.parse() };
        let number =
            |name: &str| variable(name).and_then(|value| value.trim().parse::<usize>().ok());
        let found = SCHEDULERS.iter().find_map(|own| Some((own, number(own.task)?)));
        let Some((scheduler, task)) = found else {
            let names = SCHEDULERS.map(|scheduler| scheduler.task).join(", ");
            return Err(format!(
                "this process is not a task of a job array: none of {names} is a number; submit an array, or give INDEX/COUNT such as 3/16"
            ));
        };
        let [first, last, step] = match (range.strip_prefix(':'), scheduler.array) {
            (Some(range), _) => given(text, range)?,
            (None, Some(names)) if range.is_empty() => {
                let [first, last, step] = names.map(number);
                let array = first.zip(last).map(|(first, last)| [first, last, step.unwrap_or(1)]);
                array.ok_or_else(|| untold(scheduler, task))?
            }
            (None, None) if range.is_empty() => return Err(untold(scheduler, task)),
            _ => return text.parse(),
        };
        let outside =
            || format!("task {task} is not one of an array {first}-{last} by steps of {step}");
        if step == 0 || last < first || task < first || (task - first) % step != 0 {
            return Err(outside());
        }
        let count = (last - first) / step + 1;
        let told = scheduler.count.filter(|_| range.is_empty()).and_then(number);
        if (range.is_empty() && first > 1) || told.is_some_and(|told| told != count) {
            return Err(format!(
                "{} tells of a part of an array only: {first} to {last}; say which tasks the whole has, such as auto:1-16",
                scheduler.name
            ));
        }
        Self::new((task - first) / step + 1, count).ok_or_else(outside)
    }
}

fn untold(scheduler: &Scheduler, task: usize) -> String {
    format!(
        "{} tells task {task} not how many there are; say it, such as auto:1-16 or auto:0-15",
        scheduler.name
    )
}

/// First and last task as the command line gives them.
fn given(text: &str, range: &str) -> Result<[usize; 3], String> {
    let ends = range.split_once('-').and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    let [first, last] = ends.ok_or_else(|| {
        format!("`{text}` is not a shard; write auto:FIRST-LAST, such as auto:1-16")
    })?;
    Ok([first, last, 1])
}

impl FromStr for Shard {
    type Err = String;

    /// ```
    /// use sinew_emulate::Shard;
    /// let shard: Shard = "3/16".parse()?;
    /// assert_eq!(shard.samples(100), 12..18);
    /// assert!("0/4".parse::<Shard>().is_err() && "5/4".parse::<Shard>().is_err());
    /// # Ok::<(), String>(())
    /// ```
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        numbers.and_then(|(index, of)| Self::new(index, of)).ok_or_else(|| {
            format!("`{text}` is not a shard; write INDEX/COUNT counted from 1, such as 3/16")
        })
    }
}

//! Solves of a forward model: remembered, counted, in parallel, kept in a file to go on from.

use crate::fault::Result;
use crate::{CalibrateError, Forward, ForwardError, Observed};
use sinew_emulate::{Observer, Progress};
use sinew_num::in_parallel;
use std::collections::{HashMap, HashSet};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Observables at one θ, or a reason why there are none.
pub type Answer = Result<Observed, ForwardError>;

/// Solves in one call to the thread pool: enough for many cores, few enough to tell of progress.
const AT_ONCE: usize = 16;

/// A forward model whose answers are remembered.
pub struct Solves<'f> {
    pub(crate) forward: &'f dyn Forward,
    found: HashMap<Vec<u64>, Answer>,
    file: Option<Mutex<File>>,
    /// Receives the progress of each stage; where it breaks, the calibration ends with an error.
    pub observer: Option<&'f mut dyn Observer>,
    stopped: bool,
    /// The stage under way, its solves at the start, and when that was.
    stage: (String, usize, Instant),
    started: Instant,
    /// Time after which it ends with an error.
    pub budget: Option<Duration>,
    /// Answers that were asked for, those of a file included.
    asked: HashSet<Vec<u64>>,
}

impl<'f> Solves<'f> {
    /// Empty memory of solves.
    pub fn new(forward: &'f dyn Forward) -> Self {
        let started = Instant::now();
        Self {
            forward,
            found: HashMap::new(),
            file: None,
            observer: None,
            stopped: false,
            stage: (String::new(), 0, started),
            started,
            budget: None,
            asked: HashSet::new(),
        }
    }

    /// Writes each answer with its checksum to a file at once, which no other run may write then. With `resume`, the answers of an
    /// earlier run are read from it; one that is not as it was stored is solved again. `identity` names the inputs: a file with
    /// another identity is refused.
    ///
    /// # Errors
    /// A file that cannot be read or written, is of another patient, or in which another run keeps its solves.
    pub fn kept_in(mut self, path: &Path, identity: &str, resume: bool) -> Result<Self> {
        let store = |why: String| CalibrateError::Store(format!("{}: {why}", path.display()));
        let wrong = |error: std::io::Error| store(error.to_string());
        let mut file = OpenOptions::new();
        let file = file.read(true).write(true).create(true).truncate(false).open(path);
        let mut file = file.map_err(wrong)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let advice = "wait for its end, or name another folder";
            return Err(store(format!("another run keeps its solves here; {advice}")));
        }
        let mut bytes = Vec::new();
        if resume {
            file.read_to_end(&mut bytes).map_err(wrong)?;
        }
        // A line without an end was cut off by a kill.
        bytes.truncate(bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1));
        let text = String::from_utf8_lossy(&bytes);
        let mut lines = text.lines();
        if lines.next().is_some_and(|first| first != identity) {
            let other = "another patient, body or settings";
            return Err(store(format!("these are solves of {other}; --restart starts anew")));
        }
        let shape = (self.forward.parameters(), self.forward.observables());
        self.found.extend(lines.filter_map(|line| read(line, shape)));
        file.set_len(bytes.len() as u64).map_err(wrong)?;
        file.seek(SeekFrom::End(0)).map_err(wrong)?;
        if bytes.is_empty() {
            writeln!(file, "{identity}").map_err(wrong)?;
        }
        self.file = Some(Mutex::new(file));
        Ok(self)
    }

    /// Number of solves that results rest on.
    pub fn count(&self) -> usize {
        self.asked.len()
    }

    /// Solves that have no answer.
    pub fn failed(&self) -> usize {
        self.asked.iter().filter(|key| self.found.get(*key).is_some_and(Result::is_err)).count()
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// All answers so far that have values, by θ in ascending order of their bits: an order that does not depend on threads.
    pub fn answers(&self) -> Vec<(Vec<f64>, &Observed)> {
        let mut keys: Vec<&Vec<u64>> = self.asked.iter().collect();
        keys.sort();
        let theta = |key: &[u64]| key.iter().map(|bits| f64::from_bits(*bits)).collect();
        let with = |key: &Vec<u64>| {
            let observed = self.found.get(key)?.as_ref().ok()?;
            Some((theta(key), observed))
        };
        keys.into_iter().filter_map(with).collect()
    }

    /// Answers at many θ in their order, whatever the number of threads; those that are known as they are.
    ///
    /// # Errors
    /// [`CalibrateError::NoPosterior`] when the time is over or it was stopped.
    pub fn at(
        &mut self,
        stage: &str,
        thetas: &[Vec<f64>],
        derivatives: bool,
    ) -> Result<Vec<Answer>> {
        let key = |theta: &Vec<f64>| theta.iter().map(|x| x.to_bits()).collect();
        let keys: Vec<Vec<u64>> = thetas.iter().map(key).collect();
        let mut seen = HashSet::new();
        let is_new =
            |&place: &usize| !self.found.contains_key(&keys[place]) && seen.insert(&keys[place]);
        let new: Vec<usize> = (0..keys.len()).filter(is_new).collect();
        let mut done = thetas.len() - new.len();
        for chunk in new.chunks(AT_ONCE) {
            self.tell(stage, done, thetas.len());
            self.in_time(stage)?;
            let (forward, file) = (self.forward, self.file.as_ref());
            let solve = |&place: &usize| {
                let answer = checked(forward, &thetas[place], derivatives);
                // If the file can no longer be written, this run goes on; a later run repeats the solves.
                if let Some(Ok(mut file)) = file.map(Mutex::lock) {
                    let _ = file.write_all(line(&thetas[place], &answer).as_bytes());
                }
                (keys[place].clone(), answer)
            };
            self.found.extend(in_parallel(chunk, solve));
            done += chunk.len();
        }
        self.tell(stage, thetas.len(), thetas.len());
        self.asked.extend(keys.iter().cloned());
        Ok(keys.iter().map(|key| self.found[key].clone()).collect())
    }

    fn tell(&mut self, stage: &str, done: usize, of: usize) {
        let Some(observer) = &mut self.observer else { return };
        let (current, first, clock) = &mut self.stage;
        // A stage ends when the next one begins.
        if current != stage {
            if !current.is_empty() {
                observer.finished(current, "done", clock.elapsed().as_secs_f64());
            }
            (*current, *first, *clock) = (stage.into(), done, Instant::now());
        }
        let pace = clock.elapsed().as_secs_f64() / (done - done.min(*first)) as f64;
        let (fraction, seconds_left) = (done as f64 / of.max(1) as f64, pace * (of - done) as f64);
        let progress = Progress { stage, fraction, seconds_left, message: "" };
        self.stopped |= observer.progress(&progress).is_break();
    }

    fn in_time(&self, stage: &str) -> Result<()> {
        let solves = self.count();
        let why = match self.budget {
            _ if self.stopped => format!("interrupted during {stage}, after {solves} solves"),
            Some(budget) if self.started.elapsed() > budget => format!(
                "the budget of {} s is over during {stage}, after {solves} solves; go on with --resume and a larger --budget",
                budget.as_secs_f64()
            ),
            _ => return Ok(()),
        };
        Err(CalibrateError::NoPosterior(why))
    }
}

/// An answer of the right lengths and finite, or an error.
fn checked(forward: &dyn Forward, theta: &[f64], derivatives: bool) -> Answer {
    let observed = forward.observe(theta, derivatives)?;
    let rows = &observed.jacobian;
    let lengths = observed.values.len() == forward.observables()
        && (rows.is_empty() || rows.len() == observed.values.len())
        && rows.iter().all(|row| row.len() == theta.len());
    let finite = observed.values.iter().chain(rows.iter().flatten()).all(|x| x.is_finite());
    match (lengths, finite) {
        (true, true) => Ok(observed),
        (true, false) => Err(ForwardError { reason: "an observable is not finite".into() }),
        (false, _) => Err(ForwardError { reason: "the observables have a wrong length".into() }),
    }
}

/// θ; values; derivatives, each separated by commas; CRC-32 of all that. Decimals are exact: the shortest that give the double back.
fn line(theta: &[f64], answer: &Answer) -> String {
    let list = |values: &mut dyn Iterator<Item = &f64>| -> String {
        values.map(|value| format!("{value:e},")).collect()
    };
    let theta = list(&mut theta.iter());
    let text = match answer {
        Ok(found) => {
            let values = list(&mut found.values.iter());
            format!("{theta};{values};{}", list(&mut found.jacobian.iter().flatten()))
        }
        Err(error) => format!("{theta};!{}", error.reason.replace('\n', " ")),
    };
    format!("{text};{:08x}\n", crc32fast::hash(text.as_bytes()))
}

fn read(line: &str, (parameters, observables): (usize, usize)) -> Option<(Vec<u64>, Answer)> {
    let list = |text: &str| -> Option<Vec<f64>> {
        text.split_terminator(',').map(|value| value.parse().ok()).collect()
    };
    let (text, sum) = line.rsplit_once(';')?;
    if u32::from_str_radix(sum, 16) != Ok(crc32fast::hash(text.as_bytes())) {
        return None;
    }
    let (theta, rest) = text.split_once(';')?;
    let key: Vec<u64> = list(theta)?.iter().map(|x| x.to_bits()).collect();
    if key.len() != parameters {
        return None;
    }
    if let Some(reason) = rest.strip_prefix('!') {
        return Some((key, Err(ForwardError { reason: reason.into() })));
    }
    let (values, slopes) = rest.split_once(';')?;
    let (values, slopes) = (list(values)?, list(slopes)?);
    let whole = slopes.is_empty() || slopes.len() == parameters * observables;
    let jacobian = slopes.chunks(parameters).map(<[f64]>::to_vec).collect();
    (values.len() == observables && whole).then_some((key, Ok(Observed { values, jacobian })))
}

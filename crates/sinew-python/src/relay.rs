//! Computations beside Python: on a thread of their own without the interpreter's lock, with progress and Ctrl-C.

use crate::errors::{Failure, Result, said};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sinew_emulate::{Observer, Progress, Warning};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Time between two looks at signals and progress.
const PAUSE: Duration = Duration::from_millis(100);
/// Time that an interrupted computation has to end by itself. After it, its thread is left to end at its next sign of progress.
const PATIENCE: Duration = Duration::from_millis(500);

/// News of a computation.
#[derive(Debug, Default)]
struct News {
    progress: Option<(String, f64, f64, String)>,
    finished: Vec<(String, String, f64)>,
    warnings: Vec<String>,
}

/// The computation's end of the relay.
#[derive(Debug)]
struct Relay {
    news: Arc<Mutex<News>>,
    stop: Arc<AtomicBool>,
}

impl Relay {
    fn tell(&self, say: impl FnOnce(&mut News)) {
        say(&mut self.news.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Observer for Relay {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let Progress { stage, fraction, seconds_left, message } = *progress;
        self.tell(|news| {
            news.progress = Some((stage.into(), fraction, seconds_left, message.into()));
        });
        match self.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn finished(&mut self, stage: &str, outcome: &str, seconds: f64) {
        self.tell(|news| news.finished.push((stage.into(), outcome.into(), seconds)));
    }

    fn warning(&mut self, warning: &Warning) {
        self.tell(|news| news.warnings.extend(said([warning])));
    }
}

/// The result of `work`, which runs on a thread of its own. `listener` hears of its progress, if it is not None.
///
/// # Errors
/// An exception that a signal or the listener raises, within a second; a panic of the work.
pub(crate) fn run<T: Send + 'static, E: Into<Failure> + Send + 'static>(
    listener: &Bound<'_, PyAny>,
    work: impl FnOnce(&mut dyn Observer) -> Result<T, E> + Send + 'static,
) -> Result<T> {
    let py = listener.py();
    let (news, stop) = (Arc::new(Mutex::new(News::default())), Arc::new(AtomicBool::new(false)));
    let mut relay = Relay { news: news.clone(), stop: stop.clone() };
    let (sender, receiver) = channel();
    // Nobody waits for the result of a computation that was interrupted.
    std::thread::spawn(move || drop(sender.send(work(&mut relay))));
    let receiver = Mutex::new(receiver);
    loop {
        let got = wait(py, &receiver, PAUSE);
        if let Err(raised) = py.check_signals().and_then(|()| deliver(listener, &news)) {
            stop.store(true, Ordering::Relaxed);
            if got.is_err() {
                let _ = wait(py, &receiver, PATIENCE);
            }
            return Err(raised.into());
        }
        match got {
            Ok(found) => return found.map_err(E::into),
            Err(RecvTimeoutError::Timeout) => {}
            // The thread has ended without a result.
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(PANICKED).into());
            }
        }
    }
}

/// Words for a panic, which has said on standard error where it was.
const PANICKED: &str =
    "the computation stopped at a mistake in it; what it said on standard error helps to mend it";

/// Waits for the result without the interpreter's lock.
fn wait<T: Send>(
    py: Python<'_>,
    receiver: &Mutex<Receiver<T>>,
    time: Duration,
) -> Result<T, RecvTimeoutError> {
    py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(time))
}

/// Hands the news to the listener's `finished`, `warning` and `progress`.
fn deliver(listener: &Bound<'_, PyAny>, news: &Mutex<News>) -> PyResult<()> {
    let News { progress, finished, warnings } =
        std::mem::take(&mut *news.lock().unwrap_or_else(PoisonError::into_inner));
    if listener.is_none() {
        return Ok(());
    }
    for end in finished {
        listener.call_method1("finished", end)?;
    }
    for warning in warnings {
        listener.call_method1("warning", (warning,))?;
    }
    if let Some(progress) = progress {
        listener.call_method1("progress", progress)?;
    }
    Ok(())
}

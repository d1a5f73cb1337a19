//! Progress of a run: when an observer is told, and what the terminal shows.

use sinew_emulate::{Counter, Observer, Progress};
use std::ops::ControlFlow;
use std::time::Duration;

struct Told(Vec<(f64, f64, String)>);

impl Observer for Told {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let Progress { fraction, seconds_left, message, .. } = *progress;
        self.0.push((fraction, seconds_left, message.into()));
        ControlFlow::Continue(())
    }
}

#[test]
fn a_piece_under_way_is_told_after_a_quiet_second() {
    let mut told = Told(Vec::new());
    let mut counter = Counter::new(&mut told, "solve", 0, 2);
    let message = || String::from("iteration 3");
    assert!(counter.within(message).is_continue());
    std::thread::sleep(Duration::from_millis(1010));
    assert!(counter.within(message).is_continue());
    assert!(counter.within(message).is_continue());
    assert!(counter.step(1, "").is_continue());
    let [(fraction, left, first), (half, ..)] = &told.0[..] else { panic!("{:?}", told.0) };
    assert_eq!((*fraction, &first[..], *half), (0.0, "iteration 3", 0.5));
    assert!(left.is_infinite(), "{left}: no piece is done");
}

/// Standard error that is no terminal, as in a log file, is that of a process of its own.
#[cfg(feature = "terminal")]
#[test]
fn in_a_log_a_stage_prints_after_every_ten_seconds_and_at_its_end() {
    const NAME: &str = "progress::in_a_log_a_stage_prints_after_every_ten_seconds_and_at_its_end";
    const CHILD: &str = "SINEW_EMULATE_LOG";
    if std::env::var_os(CHILD).is_some() {
        return log();
    }
    let mut command = std::process::Command::new(std::env::current_exe().unwrap());
    let child = command.args(["--exact", NAME, "--nocapture"]).env(CHILD, "1").output().unwrap();
    let text = String::from_utf8(child.stderr).unwrap();
    let lines: Vec<String> =
        text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    assert!(child.status.success(), "{text}");
    assert_eq!(
        lines,
        [
            "solve 50 % 12 s left iteration 3",
            "solve 8 solves in 12 s",
            "train 300 steps in 3 min 05 s",
            "evaluate 20 cases in 0.4 s",
        ]
    );
}

/// A run of three stages, the first of which takes more than ten seconds.
#[cfg(feature = "terminal")]
fn log() {
    let mut terminal = sinew_emulate::Terminal::default();
    let mut show = |stage, fraction| {
        let (seconds_left, message) = (12.3, "iteration 3");
        let progress = Progress { stage, fraction, seconds_left, message };
        assert!(terminal.progress(&progress).is_continue());
    };
    show("solve", 0.1);
    show("solve", 0.2);
    std::thread::sleep(Duration::from_millis(10_010));
    show("solve", 0.5);
    show("solve", 0.6);
    terminal.finished("solve", "8 solves", 12.3);
    // The next stage begins anew.
    for (stage, outcome, seconds) in [("train", "300 steps", 185.0), ("evaluate", "20 cases", 0.42)]
    {
        let progress = Progress { stage, fraction: 0.5, seconds_left: 1.0, message: "" };
        assert!(terminal.progress(&progress).is_continue());
        terminal.finished(stage, outcome, seconds);
    }
}

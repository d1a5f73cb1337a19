//! The page of an emulator as a person meets it: pictures that follow the sliders, keys, widths, times.

use crate::browser::{Browser, SERVED};
use anyhow::Result;
use serde_json::Value;
use std::path::Path;

/// Text that only such a page has.
pub(crate) const MARK: &str = "class=\"viewer-page\"";
/// Sizes of a telephone and of a desktop window \[px\].
pub(crate) const SIZES: [[u32; 2]; 2] = [[400, 860], [1400, 900]];
/// Longest time of a prediction \[ms\].
const MOST_MS: f64 = 2.0;
/// Two frames later, as a picture.
const PICTURE: &str =
    "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
    const { draw, canvas } = sinewViewer.views[0]; draw(); done(canvas.toDataURL()); })))";
/// Least time of a prediction \[ms\]: other programs take their turns in longer ones.
const TIME: &str = "(() => { const { model, state } = sinewViewer.views[0];
    const times = Array.from({ length: 101 }, (_, i) => { const shares = state.shares.map((s) => (s + 0.37 * i) % 1);
        const start = performance.now(); for (let k = 0; k < 5; k++) model(shares); return (performance.now() - start) / 5; });
    return Math.min(...times); })()";

/// Texts that are typed into the fields of the parameters.
const ENTRIES: usize = 1000;
/// Entries that left a number of the page without a value, and how many moved the body: numbers of all sizes and signs, within their
/// range and beyond, and what is no number.
const TYPE: &str = "(() => { const { state, evaluate, draw } = sinewViewer.views[0];
    const fields = [...document.querySelectorAll('.rows input[type=number]')], wrong = [];
    let [seed, moved] = [1, 0]; const start = performance.now(), random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
    for (let i = 0; i < ENTRIES; i++) { const field = fields[Math.floor(random() * fields.length)], before = state.shares.join();
        const text = [() => +field.min + (field.max - field.min) * random(), () => (random() - 0.5) * 10 ** (640 * random() - 320),
            () => ['', '-', '0', '-0', '1e', '1e999', '-1e999', 'NaN', 'Infinity', '1,5', '--1', '5e-324'][Math.floor(12 * random())]][i % 3]();
        field.focus(); field.select(); document.execCommand('delete'); document.execCommand('insertText', false, text); field.blur(); evaluate();
        moved += state.shares.join() !== before; if (i % 500 === 499) draw();
        const numbers = [...state.shares, state.mean, state.largest, ...(state.error ?? []), field.valueAsNumber];
        if (!numbers.every(Number.isFinite) || !state.shares.every((share) => share >= 0 && share <= 1) || document.querySelector('.readings').textContent.includes('NaN')) wrong.push(text); }
    return { moved, wrong: wrong.join(' '), seconds: (performance.now() - start) / 1000 }; })()";

/// Line of the page and its numbers once the solver has answered, or after ten seconds.
const SOLVED: &str = "(async () => { const { data, state, draw } = sinewViewer.views[0];
    for (let i = 0; i < 200 && state.solved?.name !== 'solver'; i++) await new Promise((done) => setTimeout(done, 50));
    draw(); const told = [...document.querySelectorAll('.readings .error')].at(-1).textContent;
    const norms = Array.from({ length: state.solved?.displacement?.length / 3 || 0 }, (_, n) => Math.hypot(...state.solved.displacement.slice(3 * n, 3 * n + 3)));
    const mean = norms.reduce((sum, u) => sum + u, 0) / norms.length;
    return { told, mean: state.solved?.mean, shown: state.error?.[0], apart: Math.abs(mean - state.mean) }; })()";

/// Faults of a page in one window; the time of a prediction is told.
pub(crate) fn faults(browser: &mut Browser, page: &Path) -> Result<Vec<String>> {
    let (mut found, time) = look(browser)?;
    eprintln!("{}: {time:.2} ms a prediction", page.display());
    if page.to_string_lossy().starts_with(SERVED) {
        found.extend(corrected(browser)?);
    }
    Ok(found)
}

/// Faults after random entries into the fields of the parameters.
pub(crate) fn typed(browser: &mut Browser) -> Result<Option<String>> {
    let typed = browser.evaluate(&TYPE.replace("ENTRIES", &ENTRIES.to_string()))?;
    let (wrong, moved) =
        (typed["wrong"].as_str().unwrap_or("all"), typed["moved"].as_u64().unwrap_or(0));
    let seconds = typed["seconds"].as_f64().unwrap_or(f64::NAN);
    eprintln!("{ENTRIES} entries are typed in {seconds:.1} s, {moved} move the body");
    // A third are within their ranges.
    Ok(match wrong {
        "" if moved >= ENTRIES as u64 / 3 => None,
        "" => Some(format!("{moved} of {ENTRIES} entries move the body")),
        wrong => Some(format!("there are no numbers after these were typed: {wrong}")),
    })
}

fn look(browser: &mut Browser) -> Result<(Vec<String>, f64)> {
    let mut found = Vec::new();
    let mut require = |holds: bool, fault: &str| {
        if !holds {
            found.push(fault.to_string());
        }
    };
    let views = browser.evaluate("globalThis.sinewViewer?.views.length ?? 0")?;
    require(views == 1, "nothing is drawn");
    if views != 1 {
        return Ok((found, f64::NAN));
    }
    let parameters = browser.evaluate("sinewViewer.views[0].state.shares.length")?;
    for index in 0..parameters.as_u64().unwrap_or(0) {
        let (before, slider) = (
            browser.evaluate(PICTURE)?,
            format!("document.querySelectorAll('.rows input[type=range]')[{index}]"),
        );
        browser.evaluate(&format!("{slider}.focus()"))?;
        for _ in 0..3 {
            browser.press("PageUp", 33)?;
        }
        for _ in 0..2 {
            browser.press("ArrowRight", 39)?;
        }
        let after = browser.evaluate(PICTURE)?;
        let share = browser.evaluate(&format!("+{slider}.value"))?;
        require(share.as_f64() > Some(0.51), &format!("keys do not move slider {index}"));
        require(before != after, &format!("two values of parameter {index} give the same picture"));
    }
    let before = browser.evaluate(PICTURE)?;
    browser.evaluate("document.querySelector('.viewer canvas').focus()")?;
    browser.press("ArrowLeft", 37)?;
    require(browser.evaluate(PICTURE)? != before, "keys do not turn the body");
    browser.press(" ", 32)?;
    let playing = browser.evaluate("!!sinewViewer.views[0].state.playing")?;
    require(playing == Value::Bool(true), "the space bar does not play");
    browser.press(" ", 32)?;
    let pictures = browser.evaluate(
        "(async () => { const pictures = []; for (const item of document.querySelectorAll('.menu button')) { item.click();
            await new Promise(requestAnimationFrame); sinewViewer.views[0].draw(); pictures.push(sinewViewer.views[0].canvas.toDataURL()); }
            return new Set(pictures).size === pictures.length; })()",
    )?;
    require(pictures == Value::Bool(true), "two quantities give the same picture");
    let time = browser.evaluate(TIME)?.as_f64().unwrap_or(f64::NAN);
    require(time <= MOST_MS, &format!("a prediction takes {time:.1} ms"));
    Ok((found, time))
}

/// Faults of a page that is served: the solver's body and the true error have to follow the sliders.
fn corrected(browser: &mut Browser) -> Result<Vec<String>> {
    let mut found = Vec::new();
    let mut pictures = Vec::new();
    for share in ["0.2", "0.8"] {
        browser.evaluate(&format!(
            "sinewViewer.views[0].setShare(sinewViewer.views[0].state.active, {share})"
        ))?;
        let seen = browser.evaluate(SOLVED)?;
        let [mean, shown, apart] = ["mean", "shown", "apart"].map(|name| seen[name].as_f64());
        let told = seen["told"].as_str().unwrap_or_default();
        if !(told.starts_with("true error") && mean > Some(0.0)) {
            found.push(format!("the solver does not answer: {told}"));
        }
        // The page's own error is right within a factor of three in nine of ten cases.
        let ratio = mean.zip(shown).map_or(f64::NAN, |(mean, shown)| mean / shown);
        if !(0.1..=10.0).contains(&ratio) {
            found.push(format!("the true error is {ratio:.1} times the shown one"));
        }
        if apart != Some(0.0) {
            found.push("the body is not where the solver says".into());
        }
        eprintln!("share {share}: {told}; {ratio:.2} of the shown one");
        pictures.push(browser.evaluate(PICTURE)?);
    }
    if pictures[0] == pictures[1] {
        found.push("two corrected bodies give the same picture".into());
    }
    Ok(found)
}

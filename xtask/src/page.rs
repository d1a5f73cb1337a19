//! A report as a browser shows it: errors, labels that overlap or leave their drawing, contrast, anything loaded.

use crate::browser::{Browser, SERVED};
use crate::viewer;
use anyhow::{Context, Result, ensure};
use std::path::PathBuf;
use std::process::Command;

const SCRIPT: &str = include_str!("page.js");
/// Sizes of a desktop window and of a telephone for reports \[px\].
const SIZES: [[u32; 2]; 2] = [[1280, 900], [500, 900]];

/// Opens each page in a headless Chromium, light and dark, wide and narrow; fails with what is wrong.
pub(crate) fn check(pages: &[PathBuf]) -> Result<()> {
    ensure!(!pages.is_empty(), "name at least one page, such as out/reproduce-beam/report.html");
    let program = program().context(
        "no Chromium was found, so nothing is checked: install chromium, or set CHROMIUM to the program",
    )?;
    let mut wrong = Vec::new();
    for page in pages {
        let is_viewer = page.to_string_lossy().starts_with(SERVED)
            || std::fs::read_to_string(page).is_ok_and(|text| text.contains(viewer::MARK));
        let mut browser = Browser::start(&program)?;
        for size in if is_viewer { viewer::SIZES } else { SIZES } {
            for (dark, scheme) in [(false, "light"), (true, "dark")] {
                let mode = format!("{} ({} px, {scheme})", page.display(), size[0]);
                browser.open(page, size, dark).with_context(|| mode.clone())?;
                let mut found = Vec::new();
                if is_viewer {
                    found.extend(viewer::faults(&mut browser, page)?);
                    // They are the same in every window.
                    if size == viewer::SIZES[0] && !dark {
                        found.extend(viewer::typed(&mut browser)?);
                    }
                }
                found.extend(seen(&mut browser, dark).with_context(|| mode.clone())?);
                found.extend(browser.faults());
                eprintln!("{mode}: {}", if found.is_empty() { "nothing wrong" } else { "faults" });
                wrong.extend(found.into_iter().map(|fault| format!("{mode}: {fault}")));
            }
        }
    }
    ensure!(wrong.is_empty(), "{} faults\n  {}", wrong.len(), wrong.join("\n  "));
    Ok(())
}

fn program() -> Option<PathBuf> {
    let chosen = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let known = ["chromium", "chromium-browser", "google-chrome", "chrome"].map(PathBuf::from);
    let runs = |program: &PathBuf| {
        Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    chosen.into_iter().chain(known).find(runs)
}

/// Faults that the script finds in the page as it is shown.
fn seen(browser: &mut Browser, dark: bool) -> Result<Vec<String>> {
    #[derive(serde::Deserialize)]
    struct Seen {
        dark: bool,
        found: Vec<String>,
    }
    browser.evaluate(&format!("{{ {SCRIPT} }}"))?;
    let text = browser.evaluate("document.getElementById('page-check').textContent")?;
    let seen: Seen = serde_json::from_str(text.as_str().unwrap_or_default())
        .context("the browser's result cannot be read")?;
    ensure!(seen.dark == dark, "the browser did not take the colour scheme");
    Ok(seen.found)
}

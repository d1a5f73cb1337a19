//! A report as a browser shows it: errors, labels that overlap or leave their drawing, contrast, anything loaded.

use crate::browser::SERVED;
use crate::viewer;
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

const SCRIPT: &str = include_str!("page.js");
/// Widths of a desktop window and of a telephone \[px\]; narrower ones than 500 px are not given by every Chromium.
const WIDTHS: [u32; 2] = [1280, 500];

/// Opens each page in a headless Chromium, light and dark, wide and narrow; fails with what is wrong.
pub(crate) fn check(pages: &[PathBuf]) -> Result<()> {
    ensure!(!pages.is_empty(), "name at least one page, such as out/reproduce-beam/report.html");
    let browser = browser().context(
        "no Chromium was found, so nothing is checked: install chromium, or set CHROMIUM to the program",
    )?;
    let mut wrong = Vec::new();
    for page in pages {
        if page.to_string_lossy().starts_with(SERVED)
            || std::fs::read_to_string(page).is_ok_and(|text| text.contains(viewer::MARK))
        {
            wrong.extend(viewer::check(&browser, page, SCRIPT)?);
            continue;
        }
        for width in WIDTHS {
            for dark in [false, true] {
                let mode = format!(
                    "{} ({width} px, {})",
                    page.display(),
                    if dark { "dark" } else { "light" }
                );
                let found = look(&browser, page, width, dark).with_context(|| mode.clone())?;
                eprintln!("{mode}: {}", if found.is_empty() { "nothing wrong" } else { "faults" });
                wrong.extend(found.into_iter().map(|fault| format!("{mode}: {fault}")));
            }
        }
    }
    if !wrong.is_empty() {
        bail!("{} faults\n  {}", wrong.len(), wrong.join("\n  "));
    }
    Ok(())
}

fn browser() -> Option<PathBuf> {
    let chosen = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let known = ["chromium", "chromium-browser", "google-chrome", "chrome"].map(PathBuf::from);
    let runs = |program: &PathBuf| {
        Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
    };
    chosen.into_iter().chain(known).find(runs)
}

/// Faults of one page in one window.
fn look(browser: &Path, page: &Path, width: u32, dark: bool) -> Result<Vec<String>> {
    let text = std::fs::read_to_string(page).context("the page cannot be read")?;
    let (body, end) = text.rsplit_once("</body>").context("the page has no end")?;
    let folder =
        std::env::temp_dir().join(format!("sinew-page-{}-{width}-{dark}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let copy = folder.join("page.html");
    std::fs::write(&copy, format!("{body}<script>{SCRIPT}</script></body>{end}"))?;
    let output = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--dump-dom",
            "--enable-logging=stderr",
        ])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("--window-size={width},900"))
        .arg(format!("--blink-settings=preferredColorScheme={}", if dark { 0 } else { 1 }))
        .arg(format!("file://{}", copy.display()))
        .output()?;
    std::fs::remove_dir_all(&folder)?;
    let [dom, log] =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let mut found: Vec<String> =
        log.lines().filter(|line| line.contains("CONSOLE")).map(String::from).collect();
    let result =
        dom.split_once("<pre id=\"page-check\">").and_then(|parts| parts.1.split_once("</pre>"));
    let (result, _) = result.with_context(|| format!("the browser gave no result:\n{log}"))?;
    // The browser escapes the text of an element as it writes the page.
    let json = result
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&nbsp;", " ")
        .replace("&amp;", "&");
    #[derive(serde::Deserialize)]
    struct Seen {
        dark: bool,
        found: Vec<String>,
    }
    let seen: Seen = serde_json::from_str(&json).context("the browser's result cannot be read")?;
    ensure!(seen.dark == dark, "the browser did not take the colour scheme");
    found.extend(seen.found);
    Ok(found)
}

//! What all reports share: head of the page, facts, configuration and versions.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::format::escape;

const STYLE: &str = include_str!("style.css");

/// Ends what [`start`] began.
pub(crate) const END: &str = "</main></body></html>\n";

/// The page up to its first section; `title` is markup, `style` comes after the common style.
pub(crate) fn start(title: &str, style: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\"><title>{title}</title><style>{STYLE}{style}</style></head><body><main>"
    )
}

/// Names with values, side by side.
pub(crate) fn push_facts(html: &mut String, facts: &[(&str, String)]) {
    html.push_str("<dl class=\"facts\">");
    for (name, value) in facts {
        let _ = write!(html, "<div><dt>{name}</dt><dd>{}</dd></div>", escape(value));
    }
    html.push_str("</dl>");
}

/// Configuration and versions, folded.
pub(crate) fn push_configuration(
    html: &mut String,
    config: &str,
    versions: &BTreeMap<String, String>,
) {
    if !config.is_empty() {
        let _ = write!(
            html,
            "<details><summary>Configuration</summary><pre><code>{}</code></pre></details>",
            escape(config)
        );
    }
    if !versions.is_empty() {
        html.push_str("<details><summary>Versions</summary><table class=\"versions\"><tbody>");
        for (name, version) in versions {
            let _ = write!(
                html,
                "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
                escape(name),
                escape(version)
            );
        }
        html.push_str("</tbody></table></details>");
    }
}

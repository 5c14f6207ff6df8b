//! A record as one HTML page that opens offline: filters, a summary, plots, and all results.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::record::Record;
use super::{table, views};
use crate::figures::distinct;
use xtask_common::Failure;

const STYLE: &str = include_str!("page/page.css");
const SCRIPT: &str = include_str!("page/page.js");

/// The page of a record. Links lead to the views that are beside the page, in `folder`.
pub(super) fn page(rows: &[Record], folder: &Path) -> Result<String, Failure> {
    let data = serde_json::to_string(&data(rows, folder)).map_err(Failure::numbers)?;
    // Otherwise a name could end the element.
    let data = data.replace('<', "\\u003c");
    let facts = escaped(&facts(rows));
    let [script, style] = [SCRIPT, STYLE].map(hash);
    Ok(format!(
        r#"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src '{script}'; style-src '{style}'; base-uri 'none'; form-action 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="referrer" content="no-referrer">
<title>Simplification compared</title>
<style>{STYLE}</style>
</head>
<body>
<main>
<h1>Simplification compared</h1>
<p class="note">{facts}</p>
<div id="controls"></div>
<noscript><p>The page needs JavaScript. Nothing is loaded from anywhere.</p></noscript>
<h2>Plots</h2>
<p class="note">Each point is a run. A click shows it in the table of all runs. Runs with another number of faces than asked for are not in the first plot.</p>
<div class="plots">
<figure><figcaption>Time against error</figcaption><svg class="plot" id="by-time" viewBox="0 0 560 380" role="img" aria-label="Time against error"></svg></figure>
<figure><figcaption>Faces reached against error</figcaption><svg class="plot" id="by-faces" viewBox="0 0 560 380" role="img" aria-label="Faces reached against error"></svg></figure>
<figure><figcaption>Runs with something wrong</figcaption><div class="key">{key}</div><svg class="plot" id="failures" viewBox="0 0 560 380" role="img" aria-label="Runs with something wrong"></svg></figure>
</div>
<h2>Summary</h2>
<p class="note">Time, distances and normals are geometric means of ratios, over the runs that the filters leave and in which both tools reached the number of faces. Lower is better. Defects are those that the input did not have.</p>
<div class="scroll" tabindex="0" role="group" aria-label="Summary"><table id="summary"></table></div>
<h2>All runs</h2>
<p class="note">Distances are in percent of the diagonal of the bounding box.</p>
<div class="scroll" tabindex="0" role="group" aria-label="All runs"><table id="cells"></table></div>
</main>
<script type="application/json" id="data">{data}</script>
<script>{SCRIPT}</script>
</body>
</html>
"#,
        key = ["failed", "missed", "defect"]
            .map(|class| {
                let name = match class {
                    "failed" => "failed",
                    "missed" => "other number of faces",
                    _ => "new defects",
                };
                format!(
                    r#"<span><svg width="10" height="10"><rect class="{class}" width="10" height="10"/></svg> {name}</span>"#
                )
            })
            .concat(),
    ))
}

/// What holds for all rows, in a sentence each.
fn facts(rows: &[Record]) -> String {
    let machines = distinct(rows, |row| row.machine.to_string());
    let threads = distinct(rows, |row| row.threads.to_string());
    let load = rows.iter().filter_map(|row| row.load).fold(0.0, f64::max);
    let is_cpu = rows.iter().any(Record::is_told_by_cores);
    let mut text = format!("{}. Threads: {}.", machines.join("; "), threads.join(", "));
    if load > 0.0 {
        text += &format!(" Load before a run: up to {load:.1}.");
    }
    text +=
        if is_cpu { " Times are CPU times of one core." } else { " Times are wall-clock times." };
    text
}

fn data(rows: &[Record], folder: &Path) -> Value {
    let names = distinct(rows, |row| row.name.clone());
    let first = |name: &String| rows.iter().find(|row| row.name == *name);
    let tools = names
        .iter()
        .filter_map(first)
        .map(|row| json!({ "name": row.name, "version": row.version, "ours": row.is_ours() }));
    let titles: Vec<&str> = rows
        .iter()
        .find_map(|row| row.outcome.as_ref())
        .map(|outcome| outcome.validity.new_defects().map(|(title, _)| title).to_vec())
        .unwrap_or_default();
    json!({
        "base": table::usual_base(rows),
        "tools": tools.collect::<Vec<Value>>(),
        "defects": titles,
        "rows": rows.iter().map(|row| line(row, folder)).collect::<Vec<Value>>(),
    })
}

fn line(row: &Record, folder: &Path) -> Value {
    let view = views::path(row);
    let view = folder.join(&view).is_file().then_some(view);
    let outcome = row.outcome.as_ref();
    let value = |index: usize| row.values().map(|values| values[index]);
    let failure = outcome.is_none().then(|| row.failure.as_deref().unwrap_or("it failed"));
    json!({
        "tool": row.name, "mesh": row.mesh, "class": row.class, "target": row.target,
        "wanted": row.wanted, "comparable": row.is_comparable(), "missed": row.has_missed(),
        "failure": failure, "view": view,
        "time": row.time(), "bytes": row.bytes_per_face(),
        "faces": outcome.map(|o| o.faces),
        "mean": value(1), "rms": value(2), "max": value(3), "normals": outcome.map(|o| o.errors.normals),
        "area": outcome.map(|o| o.validity.area), "volume": outcome.and_then(|o| o.validity.volume),
        "defects": outcome.map(|o| o.validity.new_defects().map(|(_, count)| count)),
    })
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// The identifier of a script or a style in a content security policy.
fn hash(text: &str) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(text.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peers::record::tests::record;

    /// Otherwise the element would end early, or the hash in the policy would not match.
    #[test]
    fn script_and_style_can_stand_in_a_page() {
        for text in [STYLE, SCRIPT] {
            assert!(!text.contains("</") && !text.contains("<!--") && !text.contains('\r'));
        }
        // The only address is the namespace of SVG.
        assert_eq!(SCRIPT.matches("http").count(), 1);
        for forbidden in ["innerHTML", "insertAdjacentHTML", "eval(", "fetch(", "document.write"] {
            assert!(!SCRIPT.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn names_cannot_leave_the_data() {
        let mut row = record("fast", 100, 1.0, 3.0);
        row.mesh = "</script><b>".into();
        let text = page(&[row], Path::new("no such folder")).unwrap();
        assert!(!text.contains("<b>") && text.contains("\\u003c/script>\\u003cb>"), "{text}");
    }
}

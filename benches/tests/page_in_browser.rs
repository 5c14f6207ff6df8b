//! The page of a record in headless Chromium: its figures are those of the tables, it sorts and filters, and it makes
//! no request. Skipped with a printed reason where there is no Chromium.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, clippy::print_stderr)]

#[path = "../../crates/mesh-view/tests/browser/mod.rs"]
mod browser;

use std::path::{Path, PathBuf};
use std::process::Command;

use browser::Browser;
use serde_json::Value;

fn benches(arguments: &[&Path]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_benches"));
    let output = command.arg("peers").args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn record() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recorded/peers.jsonl")
}

/// The rows of the record.
fn rows() -> Vec<Value> {
    let text = std::fs::read_to_string(record()).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The cells of a table of ratios to a tool, made by the program.
fn ratios(folder: &Path, base: &str) -> Vec<Vec<String>> {
    let page = folder.join("page.md");
    let text = format!("<!-- peers: distances, ratios to {base} -->\n<!-- peers: end -->\n");
    std::fs::write(&page, text).unwrap();
    benches(&["--from".as_ref(), &record(), "--pages".as_ref(), &page]);
    let text = std::fs::read_to_string(page).unwrap();
    let lines = text.lines().filter(|line| line.starts_with("| ")).skip(1);
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect();
    lines.map(cells).collect()
}

#[test]
fn the_page_sorts_filters_and_agrees_with_the_tables() {
    let rows = rows();
    let folder = tempfile::tempdir().unwrap();
    // One run has a view beside the page.
    std::fs::create_dir(folder.path().join("views")).unwrap();
    let [mesh, target, name] =
        ["mesh", "target", "name"].map(|key| rows[0][key].as_str().unwrap().to_owned());
    let view = format!("views/{mesh}_{}_{name}.html", target.replace(" %", "-"));
    std::fs::write(folder.path().join(&view), "a view").unwrap();
    let page = folder.path().join("peers.html");
    benches(&["--from".as_ref(), &record(), "--html".as_ref(), &page]);
    let Some(mut browser) = Browser::start([1500, 1000]) else { return };
    browser.open(&page, "window.ready === true");
    let size = rows.len() as f64;
    assert_eq!(browser.number("document.querySelectorAll('#cells tbody tr').length"), size);
    assert_eq!(browser.number("document.querySelectorAll('#cells a').length"), 1.0);
    assert_eq!(browser.text("document.querySelector('#cells a').getAttribute('href')"), view);

    // The summary and the table, which other code computes, have the same ratios.
    let base = "fast-simplification";
    browser.set("base", base);
    let tables = ratios(folder.path(), base);
    let lines = browser.eval(
        "[...document.querySelectorAll('#summary tbody tr')].map(line => [...line.cells].map(cell => cell.textContent))",
    );
    let lines: Vec<Vec<String>> = serde_json::from_value(lines).unwrap();
    assert_eq!(lines.len(), tables.len());
    let mut compared = 0;
    for (line, table) in lines.iter().zip(&tables) {
        for (ours, theirs) in line[5..9].iter().zip(&table[2..6]) {
            let (Ok(ours), Ok(theirs)) = (ours.parse::<f64>(), theirs.parse::<f64>()) else {
                assert_eq!(ours, theirs);
                continue;
            };
            assert!((ours - theirs).abs() <= 0.0051 * theirs.max(1.0), "{line:?} {table:?}");
            compared += 1;
        }
    }
    assert!(compared >= 4 * 3, "{compared}");

    // A point is at the figures of its row.
    browser.set("relative", "off");
    let at = "(([p]) => [p.dataset.row, p.dataset.x, p.dataset.y].join())(document.querySelectorAll('#by-faces .point'))";
    let found: Vec<f64> = browser.text(at).split(',').map(|x| x.parse().unwrap()).collect();
    let outcome = &rows[found[0] as usize]["outcome"];
    assert_eq!(found[1], outcome["faces"].as_f64().unwrap());
    assert!((found[2] - 100.0 * outcome["errors"]["mean"].as_f64().unwrap()).abs() < 1e-9);
    browser.picture(None).keep("peers.png");

    // Filters.
    browser.set("mesh", &mesh);
    let of_mesh = rows.iter().filter(|row| row["mesh"] == *mesh).count() as f64;
    assert_eq!(browser.number("document.querySelectorAll('#cells tbody tr').length"), of_mesh);
    browser.set(&format!("tool-{name}"), "off");
    let others =
        rows.iter().filter(|row| row["mesh"] == *mesh && row["name"] != *name).count() as f64;
    assert_eq!(browser.number("document.querySelectorAll('#cells tbody tr').length"), others);
    browser.set("mesh", "");
    browser.set("bad", "on");
    let bad = browser.number("document.querySelectorAll('#cells tbody tr').length");
    assert!(bad > 0.0 && bad < size, "{bad}");
    assert_eq!(browser.eval("left().every(is_bad)"), true);
    browser.set("bad", "off");

    // Sorting, both ways.
    let mean = "[...document.querySelectorAll('#cells tbody tr')].map(line => rows[line.dataset.row].mean)";
    for sign in [1, -1] {
        browser.eval("[...document.querySelectorAll('#cells thead button')].find(b => b.textContent.startsWith('mean')).click(); 1");
        let in_order = format!(
            "{mean}.filter(x => x !== null).every((x, i, all) => !i || {sign} * (x - all[i - 1]) >= 0)"
        );
        assert_eq!(browser.eval(&in_order), true);
    }

    // A click on a point shows its row.
    browser.eval(
        "document.querySelector('#by-time .point').dispatchEvent(new MouseEvent('click')); 1",
    );
    assert_eq!(browser.number("document.querySelectorAll('#cells .chosen').length"), 1.0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

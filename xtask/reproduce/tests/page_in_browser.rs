//! The reproduction page in headless Chromium: each picture opens to the model that turns. Skipped
//! with a printed reason where there is no Chromium.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

#[path = "../../../crates/mesh-view/tests/browser/mod.rs"]
mod browser;

use std::process::Command;

use browser::Browser;

#[test]
fn pictures_open_to_turning_models() {
    let folder = tempfile::tempdir().unwrap();
    for embed in [false, true] {
        let out = folder.path().join(if embed { "embedded" } else { "beside" });
        let mut command = Command::new(env!("CARGO_BIN_EXE_reproduce"));
        command.args(["BAR06", "--quick", "--out"]).arg(&out).env_remove("CURVMESH_MODELS");
        if embed {
            command.arg("--embed");
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let page = out.join("index.html");
        assert!(std::fs::metadata(&page).unwrap().len() < 20_000_000);
        let Some(mut browser) = Browser::start([1300, 900]) else { return };
        browser.open(&page, "document.querySelectorAll('[data-view]').length > 0");
        let before = browser.picture(None);
        assert!(before.inked() > 0.02);
        browser.eval("document.querySelector('[data-view]').click(); 1");
        browser.wait_for("document.getElementById('turning').open");
        // The model is another document, which only the picture tells of.
        let mut colored = 0.0;
        for _ in 0..100 {
            std::thread::sleep(std::time::Duration::from_millis(200));
            let shown = browser.picture(Some([150.0, 200.0, 600.0, 500.0]));
            colored = shown.inked();
            if colored > 0.1 {
                break;
            }
        }
        assert!(colored > 0.1, "{colored}");
        browser.picture(None).keep(if embed { "embedded.png" } else { "beside.png" });
        // Pictures in the page are no requests.
        let is_foreign = |c: &String| !c.contains(".html") && !c.starts_with("request for data:");
        let complaints: Vec<String> = browser.complaints().into_iter().filter(is_foreign).collect();
        assert_eq!(complaints, Vec::<String>::new());
        browser.eval("document.querySelector('dialog button').click(); 1");
        browser.wait_for("!document.getElementById('turning').open");
    }
}
